"""Render one shard of scenes with PHY."""

from job import progress, run

from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.phy import render_scene
from snowsim.seeding import random_stream


def render_shard(layers, statistics, scenes, *, phy, seed):
    flight = read_dataset(statistics)
    with SceneSet(layers) as drawn:
        rendered = (
            # By scene, never by shard: how scenes are divided must not change them.
            render_scene(scene, flight, **phy, rng=random_stream(seed, "render_phy", scene.name))
            for scene in progress(drawn, "PHY")
        )
        write_scenes(scenes, rendered, {"method": "PHY", "synthetic": flight.attrs["synthetic"]})


run(render_shard)
