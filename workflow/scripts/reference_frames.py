"""Frames of the synthetic reference flight."""

from job import job, progress

from snowsim.io.files import write_dataset
from snowsim.reference import checked_settings, draw_climate, draw_frame
from snowsim.seeding import random_stream


def draw(paths_to_echograms, paths_to_layers, frames, flight, reference, seed):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    paths = zip(frames, paths_to_echograms, paths_to_layers, strict=True)
    for frame, path_to_echogram, path_to_layers in progress(paths, "frames", total=len(frames)):
        echogram, layers = draw_frame(
            frame, **flight, climate=climate, settings=settings, rng=random_stream(seed, "reference_frame", frame)
        )
        write_dataset(path_to_echogram, echogram)
        write_dataset(path_to_layers, layers)


if __name__ == "__main__":
    with job(snakemake):
        draw(snakemake.output.echograms, snakemake.output.layers, **snakemake.params)
