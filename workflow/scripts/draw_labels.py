"""Draw one shard of synthetic layer sets from the flight statistics."""

from job import job

from lib.label_sets import draw_sets
from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes

with job(snakemake):
    flight = read_dataset(snakemake.input.statistics)
    drawn = draw_sets(
        flight, snakemake.params.labels,
        span=snakemake.params.span, seed=snakemake.params.seed,
    )  # fmt: skip
    write_scenes(snakemake.output.labels, drawn, {"synthetic": flight.attrs["synthetic"]})
