"""Render one shard of scenes with PHY."""

import dataclasses

from job import progress, run

from lib.phy_renders import render_by_phy
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.labels import Dress, redress
from snowsim.seeding import random_stream


def render_shard(layers, statistics, scenes, *, phy, by_other_statistics, seed):
    flight = read_dataset(statistics)
    choices, _ = Dress.split(phy)

    def rendered(scene):
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(seed, "render_phy", scene.name)
        if by_other_statistics:
            echoes = redress(scene, flight, choices, rng=rng)
            scene = dataclasses.replace(scene, echoes=echoes)
        return render_by_phy(scene, flight, phy, rng=rng)

    attributes = {"method": "PHY", "synthetic": flight.attrs["synthetic"]}
    with SceneSet(layers) as drawn:
        write_scenes(scenes, map(rendered, progress(drawn, "PHY")), attributes)


run(render_shard)
