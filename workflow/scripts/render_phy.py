"""Render one shard of scenes with PHY."""

from job import progress, run

from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.labels import Dress, dress, redress
from snowsim.phy import render_scene
from snowsim.seeding import random_stream


def render_shard(layers, statistics, scenes, *, phy, by_other_statistics, seed):
    flight = read_dataset(statistics)
    choices, options = Dress.split(phy)

    def rendered(scene):
        # By scene, never by shard: how scenes are divided must not change them.
        rng = random_stream(seed, "render_phy", scene.name)
        echoes = scene.echoes
        if by_other_statistics:
            echoes = redress(scene, flight, choices, rng=rng)
        elif echoes is None:
            echoes = dress(scene.layer_bins, flight, choices, rng=rng)
        return render_scene(scene, echoes=echoes, rng=rng, **options)

    attributes = {"method": "PHY", "synthetic": flight.attrs["synthetic"]}
    with SceneSet(layers) as drawn:
        write_scenes(scenes, map(rendered, progress(drawn, "PHY")), attributes)


run(render_shard)
