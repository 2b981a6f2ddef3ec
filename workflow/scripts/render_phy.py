"""Render one shard of scenes with PHY."""

import dataclasses

from job import job, progress

from snowsim.echogram import to_uint8
from snowsim.io.files import read_dataset
from snowsim.io.scenes import SceneSet, write_scenes
from snowsim.phy import draw_parameters, plan, render
from snowsim.seeding import random_stream


def render_scene(scene, statistics, width, n_looks, speckle, tolerance_db, convention, rng):
    parameters = draw_parameters(statistics, scene.layer_bins.shape[0], width=width, n_looks=n_looks, rng=rng)
    planned = plan(scene.layer_bins, parameters, scene.n_range_bins, tolerance_db=tolerance_db, **convention)
    power = render(
        scene.layer_bins,
        parameters,
        scene.n_range_bins,
        tolerance_db=tolerance_db,
        rng=rng,
        method=speckle,
        **convention,
    )
    image, noise_floor_db, maximum_db = to_uint8(power)
    return dataclasses.replace(
        scene,
        image=image,
        noise_floor_db=noise_floor_db,
        maximum_db=maximum_db,
        complete_layer_bins=None,
        notes={**scene.notes, "plan": planned.as_dict()},
    )


def render_shard(path_to_layers, path_to_statistics, path_to_scenes, phy, seed):
    statistics = read_dataset(path_to_statistics)
    convention = {key: phy[key] for key in ("normalise", "align")}
    settings = {key: phy[key] for key in ("width", "n_looks", "speckle", "tolerance_db")}
    with SceneSet(path_to_layers) as layers:
        scenes = (
            # By scene, never by shard: how scenes are divided must not change them.
            render_scene(
                scene, statistics, convention=convention, rng=random_stream(seed, "render_phy", scene.name), **settings
            )
            for scene in progress(layers, "PHY")
        )
        write_scenes(path_to_scenes, scenes, {"method": "PHY", "synthetic": statistics.attrs["synthetic"]})


if __name__ == "__main__":
    with job(snakemake):
        render_shard(snakemake.input.layers, snakemake.input.statistics, snakemake.output.scenes, **snakemake.params)
