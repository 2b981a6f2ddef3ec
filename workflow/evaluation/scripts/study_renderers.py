"""Every renderer of label sets: cost a pixel, what renders are worth, where their layers lie."""

import dataclasses
from functools import partial

import pandas as pd
from main_path import progress, run
from render_cgan import scene_renderer

from evaluation.lib.renderers import position_rows, render_all, worth
from lib.phy_renders import render_by_phy
from lib.scope import outside
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.labels import Dress, draw_scene, prepare
from snowsim.seeding import random_stream
from snowsim.tracker import Settings


def all_renderers(flight, phy, cgan, l1, *, seed):
    """Functions from a scene to its image, by name; `cgan` and `l1` as `scene_renderer` gives."""

    def by_phy(scene):
        rng = random_stream(seed, "render_phy", scene.name)
        return render_by_phy(scene, flight, phy, rng=rng).image

    def by_constant_phy(scene):
        return by_phy(dataclasses.replace(scene, echoes=None))

    def by_network(render, scene):
        return render(scene, random_stream(seed, "render_cgan", scene.name))

    return {
        "phy_constant": by_constant_phy,
        "phy": by_phy,
        "cgan": partial(by_network, cgan),
        "l1": partial(by_network, l1),
    }


def compare(
    train,
    validation,
    labels,
    statistics,
    cgan,
    l1,
    costs,
    positions,
    *,
    seed,
    device,
    phy,
    n_range_lines,
    n_layers,
    first_slab,
    surface,
    correlation,
    radiometry,
    n_drawn,
    n_trainings,
    tracker,
    two_sample,
):
    flight = read_dataset(statistics)
    render_by_cgan, scope = scene_renderer(cgan, flight, device)
    render_by_l1, _ = scene_renderer(l1, flight, device)
    renderers = all_renderers(flight, phy, render_by_cgan, render_by_l1, seed=seed)
    with SceneSet(train) as scenes, SceneSet(validation) as held, SceneSet(labels) as sets:
        observed = list(scenes)
        validated = list(held)
        label_sets = list(sets)
    model = prepare(
        flight,
        n_range_lines,
        n_layers=tuple(n_layers),
        first_slab=first_slab,
        surface=surface,
        correlation=correlation,
        radiometry=radiometry,
        dress=Dress.split(phy)[0],
    )
    uniform = []
    for number in range(n_drawn):
        name = f"uniform_{number:04d}"
        rng = random_stream(seed, "uniform", name)
        uniform.append(draw_scene(model, n_range_lines, name=name, rng=rng))

    def is_outside(scene):
        return bool(outside(scene, scope))

    rows = []
    tables = [position_rows("observed", observed, is_outside)]
    options = {"seed": seed, "n_trainings": n_trainings, **two_sample}
    for name, render in progress(renderers.items(), "renderers", total=len(renderers)):
        rendered, seconds = render_all(render, label_sets)
        for row in worth(name, rendered, observed, validated, Settings(**tracker), **options):
            rows.append(row | {"seconds_per_pixel": seconds})
        uniform_rendered, _ = render_all(render, uniform)
        tables.append(position_rows(name, uniform_rendered, is_outside))
    write_table(costs, pd.DataFrame(rows))
    write_table(positions, pd.concat(tables))


run(compare)
