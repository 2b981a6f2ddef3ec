"""The complex segment of the synthetic reference flight."""

from job import job

from snowsim.io.files import write_dataset
from snowsim.reference import checked_settings, draw_climate, draw_complex_segment
from snowsim.seeding import random_stream


def draw(path_to_segment, reference, seed):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    rng = random_stream(seed, "reference_segment")
    write_dataset(path_to_segment, draw_complex_segment(climate=climate, settings=settings, rng=rng))


if __name__ == "__main__":
    with job(snakemake):
        draw(*snakemake.output, **snakemake.params)
