"""The flight and the benchmark beside what is published of real echograms, and the curves of its figure."""

import pandas as pd
from job import progress, run

from lib.diagnostics import realism
from snowsim.io.files import read_dataset, write_table
from snowsim.io.images import read_image
from snowsim.io.scenes import SceneSet
from snowsim.reference import checked_settings
from snowsim.seeding import random_stream


def tabulate_realism(echograms, layers, statistics, train, test, other_band, table, curves, *, reference, source, seed):
    pairs = progress(list(zip(echograms, layers, strict=True)), "realism")
    frames = [realism.describe_frame(read_dataset(echogram), read_dataset(picks)) for echogram, picks in pairs]
    others = [realism.describe_image(read_image(path)[0]) for path in other_band]
    flight = read_dataset(statistics)
    physics = realism.describe_physics(checked_settings(reference), rng=random_stream(seed, "tabulate_realism"))
    with SceneSet(train) as train_scenes, SceneSet(test) as test_scenes:
        benchmark = realism.describe_benchmark(train_scenes, test_scenes)
    of_flight = realism.describe_flight(flight) | benchmark | physics
    of_frames, of_others = ([numbers for numbers, _ in described] for described in (frames, others))
    write_table(table, realism.realism_table(of_frames, of_flight, of_others).assign(data=source))
    drawn = [realism.curve_table([found for _, found in frames], realism.thickness_curves(flight)).assign(data=source)]
    if others:
        drawn.append(realism.curve_table([found for _, found in others]).assign(data=realism.OTHER_BAND))
    write_table(curves, pd.concat(drawn))


run(tabulate_realism)
