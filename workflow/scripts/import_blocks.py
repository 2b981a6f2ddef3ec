"""Scenes of the benchmark from one observed frame, by the published rule."""

from types import SimpleNamespace

from job import logger, run

from snowsim.io.frame_table import read_frame, scenes_of_frame
from snowsim.io.scenes import write_scenes


def import_blocks(echogram, layers, scenes, *, name, reading):
    row = SimpleNamespace(frame=name, echogram=echogram, layers=layers)
    observed, picked = read_frame(row, **reading)
    cut, skipped = scenes_of_frame(row, observed, picked)
    for block, reason in skipped.items():
        logger.info("%s is no scene: %s", block, reason)
    write_scenes(scenes, cut, {"frame": name, "source": reading["source"], "synthetic": "no"})


run(import_blocks)
