"""The flight and the benchmark beside what is published of real echograms, and the curves of its figure."""

import pandas as pd
from job import progress, run

from lib.diagnostics.realism import (
    OTHER_BAND,
    curve_table,
    describe_benchmark,
    describe_flight,
    describe_frame,
    describe_image,
    describe_physics,
    realism_table,
    thickness_curves,
)
from snowsim.io.files import read_dataset, write_table
from snowsim.io.images import read_image
from snowsim.io.scenes import SceneSet
from snowsim.reference import checked_settings
from snowsim.seeding import random_stream


def tabulate_realism(echograms, layers, statistics, train, test, other_band, table, curves, *, reference, source, seed):
    pairs = progress(list(zip(echograms, layers, strict=True)), "realism")
    frames = [describe_frame(read_dataset(echogram), read_dataset(picks)) for echogram, picks in pairs]
    others = [describe_image(read_image(path)[0]) for path in other_band]
    flight = read_dataset(statistics)
    rng = random_stream(seed, "tabulate_realism")
    of_flight = describe_flight(flight) | describe_physics(checked_settings(reference), rng=rng)
    with SceneSet(train) as train_scenes, SceneSet(test) as test_scenes:
        of_flight |= describe_benchmark(train_scenes, test_scenes)
    numbers, of_others = ([found for found, _ in described] for described in (frames, others))
    write_table(table, realism_table(numbers, of_flight, of_others).assign(data=source))
    drawn = [curve_table([found for _, found in frames]), curve_table(thickness_curves(flight))]
    drawn = [pd.concat(drawn).assign(data=source)]
    if others:
        drawn.append(curve_table([found for _, found in others]).assign(data=OTHER_BAND))
    write_table(curves, pd.concat(drawn))


run(tabulate_realism)
