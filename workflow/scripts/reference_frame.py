"""One frame of the synthetic reference flight."""

from job import job

from snowsim.io.files import write_dataset
from snowsim.reference import checked_settings, draw_climate, draw_frame
from snowsim.seeding import random_stream


def draw(path_to_echogram, path_to_layers, frame, flight, reference, seed):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    echogram, layers = draw_frame(
        frame, **flight, climate=climate, settings=settings, rng=random_stream(seed, "reference_frame", frame)
    )
    write_dataset(path_to_echogram, echogram)
    write_dataset(path_to_layers, layers)


if __name__ == "__main__":
    with job(snakemake):
        draw(*snakemake.output, frame=int(snakemake.wildcards.frame), **snakemake.params)
