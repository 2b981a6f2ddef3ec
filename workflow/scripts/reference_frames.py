"""Frames of the synthetic reference flight; one shard also has its complex segment."""

from job import job, progress

from reference import checked_settings, draw_climate, draw_complex_segment, draw_frame
from snowsim.io.files import write_dataset
from snowsim.seeding import random_stream

with job(snakemake):
    seed = snakemake.params.seed
    frames = snakemake.params.frames
    settings = checked_settings(snakemake.params.reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    flight = {
        "n_frames": snakemake.params.n_frames,
        "n_range_lines": snakemake.params.n_range_lines,
    }
    common = {**flight, "climate": climate, "settings": settings}
    files = zip(frames, snakemake.output.echograms, snakemake.output.layers, strict=True)
    for frame, path_to_echogram, path_to_layers in progress(files, "frames", total=len(frames)):
        rng = random_stream(seed, "reference_frame", frame)
        echogram, picked = draw_frame(frame, **common, rng=rng)
        write_dataset(path_to_echogram, echogram)
        write_dataset(path_to_layers, picked)
    for path in snakemake.output.segment:
        rng = random_stream(seed, "reference_segment")
        drawn = draw_complex_segment(climate=climate, settings=settings, rng=rng)
        write_dataset(path, drawn)
