"""The flight beside real Snow Radar, measured where its folder is given, else as recorded."""

from pathlib import Path

import yaml
from main_path import logger, progress, run

from evaluation.lib import realism_sides as sides
from evaluation.lib.pictures import flight_picture, response_picture
from evaluation.lib.realism_firn import describe_power
from evaluation.lib.realism_table import realism_table, summary
from evaluation.lib.two_sample import compare, crops_dataset
from snowsim.io.files import read_dataset, read_table, write_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.reference import checked_settings, draw_climate
from snowsim.seeding import random_stream


def tabulate_realism(
    echograms, layers, statistics, train, test, record, rows, table, real, crops=None,
    *, folder, reference, source, seed,
):  # fmt: skip
    settings = checked_settings(reference)
    numbers = []
    powers = []
    of_flight = []
    frames = list(zip(echograms, layers, strict=True))
    for frame, (echogram, picks) in enumerate(progress(frames, "realism")):
        noise = response_picture(settings.radar, rng=random_stream(seed, "tabulate_realism", frame))
        frame_files = read_dataset(echogram), read_dataset(picks)
        of_frame, crops_of_frame = sides.describe_frame(*frame_files, noise)
        powers.append(describe_power(flight_picture(*frame_files)))
        numbers.append(of_frame)
        of_flight.append(crops_of_frame)
    rng = random_stream(seed, "tabulate_realism")
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    with SceneSet(train) as train_scenes, SceneSet(test) as test_scenes:
        scenes = list(train_scenes), list(test_scenes)
    flight = sides.describe_flight(
        numbers, scenes, read_dataset(statistics), settings, climate, rng=rng
    )
    rng_of_firn = random_stream(seed, "tabulate_realism", "firn")
    flight |= sides.describe_firn(powers, scenes[0], settings, climate, rng=rng_of_firn)
    if folder is None:
        measured = read_table(record)
    else:
        measured, of_real = sides.describe_real(folder)
        measured = sides.with_classifier(measured, compare(of_flight, of_real, rng=rng))
        write_dataset(crops, crops_dataset(of_flight, of_real))
    write_table(real, measured)
    decided, measured = sides.without_flight(measured)
    known = yaml.safe_load(Path(rows).read_text(encoding="utf-8"))
    found = realism_table(flight | decided, measured, known)
    logger.info(summary(found))
    write_table(table, found.assign(data=source))


run(tabulate_realism)
