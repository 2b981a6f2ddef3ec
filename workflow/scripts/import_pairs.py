"""One shard of the scenes of a list, from images to a scene file."""

from job import progress, run

from snowsim.io.png_pairs import PairSet
from snowsim.io.scenes import write_scenes


def import_pairs(listing, scenes, *, split, span, data_scale):
    pairs = PairSet(listing, data_scale=data_scale)
    chosen = (pairs[item] for item in progress(range(*span), f"{split} scenes"))
    write_scenes(scenes, chosen, {"source": "png_pairs", "synthetic": "no"})


run(import_pairs)
