"""Annotated blocks of the sample flight as scenes, cut by the published rule."""

from pathlib import Path

from main_path import logger, run

from snowsim.frames import cut_blocks
from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes


def cut_flight(echograms, layers, scenes):
    cut = []
    for path, path_to_layers in zip(echograms, layers, strict=True):
        echogram = read_dataset(path)
        name = f"flight_{Path(path).stem}"
        found, skipped = cut_blocks(echogram, read_dataset(path_to_layers), name=name)
        cut += found
        for block, reason in skipped.items():
            logger.info("%s is no scene: %s", block, reason)
    write_scenes(scenes, cut, {"synthetic": echogram.attrs["synthetic"]})


run(cut_flight)
