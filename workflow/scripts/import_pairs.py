"""One shard of the scenes of a list, from images to a scene file."""

from job import job, progress

from snowsim.io.png_pairs import PairSet
from snowsim.io.scenes import write_scenes


def import_pairs(path_to_list, path_to_scenes, split, span, data_scale):
    pairs = PairSet(path_to_list, data_scale=data_scale)
    scenes = (pairs[item] for item in progress(range(*span), f"{split} scenes"))
    write_scenes(path_to_scenes, scenes, {"source": "png_pairs", "synthetic": "no"})


if __name__ == "__main__":
    with job(snakemake):
        import_pairs(snakemake.input.listing, *snakemake.output, split=snakemake.wildcards.split, **snakemake.params)
