"""Annotated blocks of the sample flight as scenes, cut by the published rule."""

from pathlib import Path

from main_path import job

from snowsim.alignment import cut_blocks
from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes

with job(snakemake) as logger:
    cut = []
    for path, layers in zip(snakemake.input.echograms, snakemake.input.layers, strict=True):
        name = f"flight_{Path(path).stem}"
        found, skipped = cut_blocks(read_dataset(path), read_dataset(layers), name=name)
        cut += found
        for block, reason in skipped.items():
            logger.info("%s is no scene: %s", block, reason)
    write_scenes(snakemake.output.scenes, cut, {"synthetic": snakemake.params.source})
