"""Speed and accuracy of PHY's parts and of whole scenes, and what plans of label sets left out."""

from functools import partial

import numpy as np
from main_path import progress, run

from evaluation.lib.phy_charts import (
    plan_table,
    time_growth,
    time_scenes,
    time_speckle,
    time_waveforms,
)
from snowsim.io.files import write_table
from snowsim.io.scenes import SceneSet
from snowsim.reference import checked_settings, draw_climate
from snowsim.seeding import random_stream


def measure_phy(
    rendered, waveforms, speckle, scenes, growth, plans, plan,
    *, n_layers, n_range_lines, n_range_bins, n_rounds, seed, reference, n_looks, cgan,
):  # fmt: skip
    size = (n_range_lines, n_range_bins, n_rounds)
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=random_stream(seed, "climate"))
    models = {"reference": settings, "climate": climate, "cgan": cgan, "n_looks": n_looks}
    stream = partial(random_stream, seed, "measure_scenes")
    write_table(waveforms, time_waveforms(n_layers, *size, rng=np.random.default_rng(seed)))
    write_table(speckle, time_speckle(*size, rng=np.random.default_rng(seed)))
    write_table(scenes, time_scenes(n_layers, *size, **models, stream=stream))
    write_table(growth, time_growth(n_layers, *size, rng=random_stream(seed, "measure_growth")))
    with SceneSet(rendered) as held:
        by_scene, in_short = plan_table(progress(held, "plans"))
    write_table(plans, by_scene)
    write_table(plan, in_short)


run(measure_phy)
