"""Scenes of the benchmark from one observed frame, by the published rule."""

from types import SimpleNamespace

from job import job

from snowsim.io.frames import read_frame, scenes_of_frame
from snowsim.io.scenes import write_scenes

with job(snakemake) as log:
    name = snakemake.params.name
    reading = snakemake.params.reading
    files = {"echogram": snakemake.input.echogram, "layers": snakemake.input.layers}
    row = SimpleNamespace(frame=name, **files)
    observed, picked = read_frame(row, **reading)
    cut, skipped = scenes_of_frame(row, observed, picked)
    for block, reason in skipped.items():
        log.info("%s is no scene: %s", block, reason)
    attributes = {"frame": name, "source": reading["source"], "synthetic": "no"}
    write_scenes(snakemake.output.scenes, cut, attributes)
