"""One shard of the synthetic benchmark."""

from job import progress, run

from snowsim.io.scenes import write_scenes
from snowsim.reference import checked_settings, draw_climate, draw_scene
from snowsim.seeding import random_stream


def draw_shard(scenes, *, split, span, n_looks, reference, source, seed):
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))

    def drawn():
        for scene in progress(range(*span), f"{split} scenes"):
            # By scene, never by shard: how scenes are divided must not change them.
            rng = random_stream(seed, "reference_scenes", split, scene)
            yield draw_scene(
                scene, split, climate=climate, settings=settings, n_looks=n_looks, rng=rng
            )

    write_scenes(scenes, drawn(), {"synthetic": source})


run(draw_shard)
