"""Scenes of some variants: of the flight's statistics, other climates and radars, or clean firn."""

from job import job, progress

from pretrained.scenes import training_scenes
from snowsim.io.files import read_dataset
from snowsim.io.scenes import write_scenes

with job(snakemake):
    flight = read_dataset(snakemake.input.statistics)
    variants = range(*snakemake.params.variants)
    n_scenes = snakemake.params.n_scenes
    drawn = training_scenes(
        flight,
        variants,
        n_scenes,
        n_varied=snakemake.params.n_varied,
        n_range_lines=snakemake.params.n_range_lines,
        phy=snakemake.params.phy,
        seed=snakemake.params.seed,
    )
    drawn = progress(drawn, "varied scenes", total=n_scenes * len(variants))
    attributes = {"method": "PHY", "synthetic": flight.attrs["synthetic"]}
    write_scenes(snakemake.output.scenes, drawn, attributes)
