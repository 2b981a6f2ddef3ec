"""Scenes of the benchmark from one observed frame, by the published rule."""

from types import SimpleNamespace

from job import job

from snowsim.io.frame_table import read_frame, scenes_of_frame
from snowsim.io.scenes import write_scenes


def import_blocks(path_to_frame, path_to_layers, path_to_scenes, name, reading, log):
    row = SimpleNamespace(frame=name, echogram=path_to_frame, layers=path_to_layers)
    scenes, skipped = scenes_of_frame(row, *read_frame(row, **reading))
    for block, reason in skipped.items():
        log.info("%s is no scene: %s", block, reason)
    write_scenes(path_to_scenes, scenes, {"frame": name, "source": reading["source"], "synthetic": "no"})


if __name__ == "__main__":
    with job(snakemake) as logger:
        import_blocks(
            snakemake.input.echogram, snakemake.input.layers, *snakemake.output, log=logger, **snakemake.params
        )
