"""One shard of the scenes of a list, from images to a scene file."""

from job import job, progress

from snowsim.io.pairs import PairSet
from snowsim.io.scenes import write_scenes

with job(snakemake):
    pairs = PairSet(snakemake.input.listing)
    numbers = progress(range(*snakemake.params.span), f"{snakemake.wildcards.split} scenes")
    chosen = (pairs[number] for number in numbers)
    write_scenes(snakemake.output.scenes, chosen, {"source": "png_pairs", "synthetic": "no"})
