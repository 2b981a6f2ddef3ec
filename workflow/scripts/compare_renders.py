"""Renders of the test masks: where layers lie, texture above and below the surface, what bounds their similarity."""

from functools import partial

import pandas as pd
from job import progress, run
from render_cgan import scene_renderer

from lib.cgan_training import held_out
from lib.diagnostics import similarity
from lib.diagnostics.renders import air_texture, position_errors, shape_edges, texture_by_region
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.phy import render_scene
from snowsim.seeding import random_stream


def compare_renders(
    observed, cgan, phy, train, generator, statistics, positions, textures, air, bounds, parts,
    *, seed, n_looks, conventions, n_held, device,
):  # fmt: skip
    stream = partial(random_stream, seed, "explain_similarity")
    with SceneSet(observed) as test:
        edges = shape_edges(scene.layer_bins for scene in test)
    errors, by_region, in_air = [], [], []
    for method, paths in (("observed", observed), ("cgan", cgan), ("phy", phy)):
        with SceneSet(observed) as test, SceneSet(paths) as scenes:
            for truth, scene in progress(
                zip(test, scenes, strict=True), f"{method} scenes", total=len(scenes)
            ):
                if truth.name != scene.name:
                    msg = f"{method}: expected scene {truth.name}, got {scene.name}"
                    raise ValueError(msg)
                keys = {"scene": scene.name, "method": method}
                # Renders were given the annotated layers: these are where their peaks should lie.
                errors.append(position_errors(scene.image, truth.layer_bins, edges).assign(**keys))
                by_region.append(
                    texture_by_region(scene.image, truth.image, truth.layer_bins).assign(**keys)
                )
                above = air_texture(scene.image, scene.layer_bins)
                in_air += [
                    {"method": method, "quantity": name, "value": value}
                    for name, value in above.items()
                ]
    for path, tables in ((positions, errors), (textures, by_region)):
        table = pd.concat(tables)
        write_table(path, table[["scene", "method", *table.columns.drop(["scene", "method"])]])
    groups = pd.DataFrame(in_air).groupby(["quantity", "method"], sort=False)["value"]
    write_table(
        air, groups.agg(["min", "mean", "max"]).assign(n_scenes=groups.size()).reset_index()
    )

    rows, of_errors = [], []
    with SceneSet(observed) as test, SceneSet(cgan) as by_cgan, SceneSet(phy) as by_phy:
        for truth, *renders in progress(
            zip(test, by_cgan, by_phy, strict=True), "bounds", total=len(test)
        ):
            rendered = dict(zip(("cgan", "phy"), renders, strict=True))
            rows += similarity.explain_scene(truth, rendered, n_looks, rng=stream(truth.name))
            of_errors += similarity.explain_errors(truth, rendered)
    flight = read_dataset(statistics)
    render_by_cgan, _ = scene_renderer(generator, flight, device)
    renderers = {
        "cgan": lambda scene: render_by_cgan(scene, stream("cgan", scene.name)),
        "phy": lambda scene: (
            render_scene(scene, flight, **conventions, rng=stream("phy", scene.name)).image
        ),
    }
    with SceneSet(train) as scenes:
        _, numbers = held_out(len(scenes), n_held, seed=seed)
        for scene in progress([scenes[number] for number in numbers], "annotation"):
            rows += similarity.explain_annotation(scene, renderers)
    write_table(bounds, similarity.mean_similarity(rows))
    write_table(parts, similarity.mean_errors(of_errors))


run(compare_renders)
