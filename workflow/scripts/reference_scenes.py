"""One shard of the synthetic benchmark."""

from job import job, progress

from reference import checked_settings, draw_climate, draw_scene
from snowsim.io.scenes import write_scenes
from snowsim.seeding import random_stream

with job(snakemake):
    seed = snakemake.params.seed
    split = snakemake.wildcards.split
    settings = checked_settings(snakemake.params.reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    common = {"climate": climate, "settings": settings, "n_looks": snakemake.params.n_looks}

    def drawn(scene):
        """A scene of the split by its number."""
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(seed, "reference_scenes", split, scene)
        return draw_scene(scene, split, **common, rng=rng)

    scenes = map(drawn, progress(range(*snakemake.params.span), f"{split} scenes"))
    write_scenes(snakemake.output.scenes, scenes, {"synthetic": snakemake.params.source})
