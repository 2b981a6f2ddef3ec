"""Render one shard of scenes with PHY."""

import dataclasses

from job import progress, run

from snowsim.echogram import to_uint8
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.phy import plan, render_plan, scene_parameters
from snowsim.seeding import random_stream


def render_scene(scene, statistics, phy, rng):
    """The scene of some layers as PHY renders it, with what its plan left out."""
    drawn = {key: phy[key] for key in ("width", "width_bounds", "n_looks", "speckle_correlation", "background")}
    layer_bins, parameters = scene_parameters(scene, statistics, **drawn, rng=rng)
    options = {key: phy[key] for key in ("tolerance_db", "speckle", "normalise", "align")}
    scene_plan = plan(layer_bins, parameters, scene.n_range_bins, **options)
    image, noise_floor_db, maximum_db = to_uint8(render_plan(scene_plan, rng=rng))
    return dataclasses.replace(
        scene,
        image=image,
        noise_floor_db=noise_floor_db,
        maximum_db=maximum_db,
        complete_layer_bins=None,
        peak_power=None,
        notes=scene.notes | scene_plan.notes(),
    )


def render_shard(layers, statistics, scenes, *, phy, seed):
    flight = read_dataset(statistics)
    with SceneSet(layers) as drawn:
        rendered = (
            # By scene, never by shard: how scenes are divided must not change them.
            render_scene(scene, flight, phy, rng=random_stream(seed, "render_phy", scene.name))
            for scene in progress(drawn, "PHY")
        )
        write_scenes(scenes, rendered, {"method": "PHY", "synthetic": flight.attrs["synthetic"]})


run(render_shard)
