"""Where the tracker fails.

Rates, seeds, brightness, odd heights, few and many layers, labels and images of nothing.
"""

import pandas as pd
from main_path import progress, run

from evaluation.lib.tracker_studies import level_scene, tracking_atlas, training_atlas
from lib.phy_renders import render_by_phy
from lib.tracker_scores import read_tracker
from snowsim.io.files import read_dataset, write_table
from snowsim.io.scenes import SceneSet
from snowsim.seeding import random_stream
from snowsim.tracker import Settings


def atlas_tracker(train, scenes, network, statistics, table, *, seed, settings, phy, atlas):
    short = Settings(**settings | {"n_steps": atlas["n_steps"]})
    trained = read_tracker(network)
    precision = trained.settings.precision
    flight = read_dataset(statistics)

    def render_level(n_layers):
        rng = random_stream(seed, "stress_tracker", n_layers)
        scene = render_by_phy(level_scene(n_layers), flight, phy, rng=rng)
        return scene.image, scene.mask()

    with SceneSet(train) as real, SceneSet(scenes) as held_out:
        trainings = training_atlas(real, short, atlas["learning_rates"], atlas["n_seeds"])
        rows = list(progress(trainings, "trainings"))
        pairs = [(scene.image, scene.mask()) for scene in held_out]
    tracked = tracking_atlas(trained.network, precision, pairs, atlas, render_level)
    rows += progress(tracked, "tracking")
    write_table(table, pd.DataFrame(rows))


run(atlas_tracker)
