"""Every renderer of label sets: cost a pixel beside what its renders are worth, and positions of their layers."""

import dataclasses
from functools import partial

import pandas as pd
from job import progress, run
from render_cgan import scene_renderer

from lib.diagnostics.renderers import position_rows, render_all, worth
from lib.guides import Guides
from lib.scope import outside
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.labels import draw_scene, prepare
from snowsim.phy import render_scene
from snowsim.seeding import random_stream
from snowsim.tracker import Settings


def compare(
    train, validation, labels, statistics, label_model, cgan, guided, l1, costs, positions,
    *, seed, device, phy, n_range_lines, n_layers, drawn, n_drawn, n_trainings, tracker, two_sample,
):  # fmt: skip
    flight = read_dataset(statistics)
    stream = partial(random_stream, seed, "render_phy")
    by_network = {
        "cgan": scene_renderer(cgan, flight, device),
        "guided": scene_renderer(guided, flight, device),
    }
    by_network["l1"] = scene_renderer(l1, flight, device)
    guides = Guides([], flight, phy, seed=seed)

    def by_phy(scene):
        return render_scene(scene, flight, **phy, rng=stream(scene.name)).image

    def by_constant_phy(scene):
        return by_phy(dataclasses.replace(scene, peak_power=None, complete_layer_bins=None))

    def learned(name, scene):
        rng = random_stream(seed, "render_cgan", scene.name)
        return by_network[name][0](guides.of(scene) if name == "guided" else scene, rng)

    renderers = {"phy_constant": by_constant_phy, "phy": by_phy}
    renderers |= {name: partial(learned, name) for name in by_network}
    with SceneSet(train) as scenes, SceneSet(validation) as held, SceneSet(labels) as sets:
        observed, validated, label_sets = list(scenes), list(held), list(sets)
    model = prepare(read_dataset(label_model), n_range_lines, n_layers=tuple(n_layers), **drawn)
    names = [f"uniform_{number:04d}" for number in range(n_drawn)]
    uniform = [
        draw_scene(model, n_range_lines, name=n, rng=random_stream(seed, "uniform", n))
        for n in names
    ]
    settings, scope = Settings(**tracker), by_network["cgan"][1]

    def is_outside(scene):
        return bool(outside(scene, scope))

    rows, tables = [], [position_rows("observed", observed, is_outside)]
    for name, render in progress(renderers.items(), "renderers", total=len(renderers)):
        rendered, seconds = render_all(render, label_sets)
        found = worth(
            name,
            rendered,
            observed,
            validated,
            settings,
            seed=seed,
            n_trainings=n_trainings,
            **two_sample,
        )
        rows += [{**row, "seconds_per_pixel": seconds} for row in found]
        tables.append(position_rows(name, render_all(render, uniform)[0], is_outside))
    write_table(costs, pd.DataFrame(rows))
    write_table(positions, pd.concat(tables))


run(compare)
