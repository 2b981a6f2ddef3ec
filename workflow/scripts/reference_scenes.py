"""One shard of the synthetic benchmark."""

from dataclasses import replace

from job import job, progress

from reference import checked_settings, draw_climate, draw_scene
from snowsim.io.scenes import write_scenes
from snowsim.seeding import random_stream

with job(snakemake):
    scene_seed = snakemake.params.scene_seed
    split = snakemake.wildcards.split
    settings = checked_settings(snakemake.params.reference)
    climate, own = (
        draw_climate(settings, rng=random_stream(seed, "climate"))
        for seed in (snakemake.params.seed, scene_seed)
    )
    # Years are the flight's; undulations, which differ from track to track, are the scenes' own.
    climate = replace(climate, track_seed=own.track_seed)
    common = {"climate": climate, "settings": settings, "n_looks": snakemake.params.n_looks}

    def drawn(scene):
        """A scene of the split by its number."""
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(scene_seed, "reference_scenes", split, scene)
        return draw_scene(scene, split, **common, rng=rng)

    scenes = map(drawn, progress(range(*snakemake.params.span), f"{split} scenes"))
    write_scenes(snakemake.output.scenes, scenes, {"synthetic": snakemake.params.source})
