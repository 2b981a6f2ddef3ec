"""Renders of the test masks: where layers lie, texture, what bounds their similarity."""

from functools import partial

import pandas as pd
from main_path import progress, run
from render_cgan import scene_renderer

from evaluation.lib import similarity
from evaluation.lib.renders import air_texture, position_errors, shape_edges, texture_by_region
from lib.cgan_training import held_out
from lib.phy_renders import render_by_phy
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream


def compare_renders(
    observed,
    cgan,
    phy,
    train,
    generator,
    statistics,
    positions,
    textures,
    air,
    bounds,
    parts,
    *,
    seed,
    n_looks,
    conventions,
    n_held,
    device,
):
    layers_and_texture({"observed": observed, "cgan": cgan, "phy": phy}, positions, textures, air)
    stream = partial(random_stream, seed, "explain_similarity")
    rows = []
    of_errors = []
    with SceneSet(observed) as test, SceneSet(cgan) as by_cgan, SceneSet(phy) as by_phy:
        scenes = zip(test, by_cgan, by_phy, strict=True)
        for truth, of_cgan, of_phy in progress(scenes, "bounds", total=len(test)):
            rendered = {"cgan": of_cgan, "phy": of_phy}
            rows += similarity.explain_scene(truth, rendered, n_looks, rng=stream(truth.name))
            of_errors += similarity.explain_errors(truth, rendered)
    flight = read_dataset(statistics)
    render_by_cgan, _ = scene_renderer(generator, flight, device)

    def image_by_phy(scene):
        return render_by_phy(scene, flight, conventions, rng=stream("phy", scene.name)).image

    def image_by_cgan(scene):
        return render_by_cgan(scene, stream("cgan", scene.name))

    renderers = {"cgan": image_by_cgan, "phy": image_by_phy}
    with SceneSet(train) as scenes:
        _, numbers = held_out(len(scenes), n_held, seed=seed)
        for number in progress(numbers, "annotation"):
            rows += similarity.explain_annotation(scenes[number], renderers)
    write_table(bounds, similarity.mean_similarity(rows))
    write_table(parts, similarity.mean_errors(of_errors))


def layers_and_texture(sets, positions, textures, air):
    """Tables of where layers lie in scenes of each method, and of their texture."""
    with SceneSet(sets["observed"]) as test:
        edges = shape_edges(scene.layer_bins for scene in test)
    errors = []
    by_region = []
    in_air = []
    for method, paths in sets.items():
        with SceneSet(sets["observed"]) as test, SceneSet(paths) as scenes:
            pairs = zip(test, scenes, strict=True)
            for truth, scene in progress(pairs, f"{method} scenes", total=len(scenes)):
                if truth.name != scene.name:
                    msg = f"{method}: expected scene {truth.name}, got {scene.name}"
                    raise ValueError(msg)
                # Renders were given the annotated layers: these are where their peaks should lie.
                error = position_errors(scene.image, truth.layer_bins, edges)
                texture = texture_by_region(scene.image, truth.image, truth.layer_bins)
                errors.append(with_keys(error, scene.name, method))
                by_region.append(with_keys(texture, scene.name, method))
                above = pd.Series(air_texture(scene.image, scene.layer_bins), name="value")
                in_air.append(above.rename_axis("quantity").reset_index().assign(method=method))
    write_table(positions, pd.concat(errors))
    write_table(textures, pd.concat(by_region))
    groups = pd.concat(in_air).groupby(["quantity", "method"], sort=False)["value"]
    levels = groups.agg(["min", "mean", "max"]).assign(n_scenes=groups.size())
    write_table(air, levels.reset_index())


def with_keys(table, scene, method):
    table.insert(0, "scene", scene)
    table.insert(1, "method", method)
    return table


run(compare_renders)
