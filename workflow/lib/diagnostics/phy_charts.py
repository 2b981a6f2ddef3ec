"""PHY's parts by every way of computing them, raw seconds and distance from the exact one; what its plans leave out."""

from functools import partial

import numpy as np
import pandas as pd

from lib.diagnostics.phy_alternatives import (
    convolved_power,
    draw_moving_speckle,
    mean_power_by,
    naive_power,
    nearest_power,
    waveforms_of,
)
from lib.diagnostics.phy_errors import (
    cube_distance,
    largest_error_db,
    moving_distance,
    planted_scene,
    quantile_distance,
)
from lib.timing import device_name, time_rounds
from snowsim.phy import draw_speckle

TOLERANCES_DB = (0.5, 0.1, 0.05, 0.01, 1e-3, 1e-6)
ALL_WAYS_DB = (0.5, 0.05, 1e-3)  # tolerances at which slower ways are timed, too
N_LOOKS = (16, 100)
MOVEMENTS_DB = (1.0, 3.0, 6.0, 10.0, 20.0)
TIMED_MOVEMENT_DB = 6.0  # the time does not depend on how far the mean moves
DISTANCE = {
    "looks": lambda n_looks: 0.0,
    "gamma": lambda n_looks: 0.0,
    "cube": cube_distance,
    "quantile": quantile_distance,
}
PLANNED = ("plan_share", "plan_cost_normals", "plan_bound_db")


def runs_table(runs, about, columns, **same):
    """A row a run of `time_rounds`, whose names begin with a setting and end with a method, and what is known of it."""
    rows = [
        {"setting": name[0], "method": name[-1], "repeat": repeat, "seconds": seconds, **same, **about.get(name, {})}
        for name, repeat, seconds in runs
    ]
    return pd.DataFrame(rows, columns=columns).assign(device=device_name())


def waveform_works(layer_bins, parameters, n_range_bins):
    """Every way of computing mean power, by (setting, method)."""
    noise_power = parameters["noise_power"]
    waveforms = waveforms_of(layer_bins, parameters, n_range_bins, "peak", "peak")
    by = partial(mean_power_by, waveforms=waveforms, noise_power=noise_power)
    works = {
        ("1 sample per bin", "convolved"): partial(convolved_power, waveforms),
        ("4 samples per bin", "convolved"): partial(convolved_power, waveforms, samples_per_bin=4),
        ("as usually written", "naive closed form"): partial(naive_power, waveforms),
        ("every row", "closed form"): partial(by, "closed_form", tolerance_db=None),
        ("16 per bin", "nearest"): partial(nearest_power, waveforms),
    }
    for tolerance_db in TOLERANCES_DB:
        setting = f"{tolerance_db:g} dB"
        works[setting, "table"] = partial(by, "table", tolerance_db=tolerance_db)
        if tolerance_db in ALL_WAYS_DB:
            works[setting, "closed form in support"] = partial(by, "closed_form_in_support", tolerance_db=tolerance_db)
            for dtype in (np.float32, np.float64):
                name = f"recursive {np.dtype(dtype).name}"
                works[setting, name] = partial(by, "recursive", tolerance_db=tolerance_db, dtype=dtype)
    return works


def time_waveforms(n_layers, n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds and largest error [dB] of mean power by every way, and of one float32 normal a pixel for scale."""
    layer_bins, parameters = planted_scene(n_layers, n_range_lines, n_range_bins)
    works = waveform_works(layer_bins, parameters, n_range_bins)
    exact = works["every row", "closed form"]()
    noise_power = parameters["noise_power"]
    about = {key: {"error_db": largest_error_db(work(), exact, noise_power)} for key, work in works.items()}
    works["floor", "float32 normal"] = partial(rng.standard_normal, exact.shape, dtype=np.float32)
    columns = ["setting", "method", "repeat", "seconds", "n_pixels", "error_db", "device"]
    return runs_table(time_rounds(works, n_rounds), about, columns, n_pixels=exact.size)


def look_means(movement_db, n_looks):
    """Means that fall evenly in dB from the first look to the last."""
    return 10 ** (-np.linspace(0, movement_db, n_looks) / 10)


def time_speckle(n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds of every speckle method, and how far its distribution function lies from that of the literal sum.

    Where the mean moves within the looks, distances alone but for one movement.
    """
    shape = (n_range_bins, n_range_lines)
    mean_power = np.ones(shape, dtype=np.float32)
    works = {("floor", "float32 normal"): partial(rng.standard_normal, shape, dtype=np.float32)}
    about = {}
    for n_looks in N_LOOKS:
        for method, distance in DISTANCE.items():
            key = (f"M = {n_looks}", method)
            works[key] = partial(draw_speckle, mean_power, n_looks, method=method, rng=rng)
            about[key] = {"distance": distance(n_looks), "n_looks": n_looks}
        for movement_db in MOVEMENTS_DB:
            distance = moving_distance(look_means(movement_db, n_looks))
            key = (f"M = {n_looks}, {movement_db:g} dB", "gamma, moving")
            about[key] = {"distance": distance, "n_looks": n_looks, "movement_db": movement_db}
    n_looks = min(N_LOOKS)
    means = look_means(TIMED_MOVEMENT_DB, n_looks).astype(np.float32)[:, None, None]
    moving = np.broadcast_to(means, (n_looks, *shape))
    setting = f"M = {n_looks}, {TIMED_MOVEMENT_DB:g} dB"
    for method in ("gamma", "looks"):
        works[setting, f"{method}, moving"] = partial(draw_moving_speckle, moving, method=method, rng=rng)
    about[setting, "looks, moving"] = {"distance": 0.0, "n_looks": n_looks, "movement_db": TIMED_MOVEMENT_DB}
    runs = time_rounds(works, n_rounds)
    runs += [(key, np.nan, np.nan) for key in about if key not in works]
    columns = ["setting", "method", "repeat", "seconds", "n_pixels", "device", "distance", "n_looks", "movement_db"]
    return runs_table(runs, about, columns, n_pixels=mean_power.size)


def plan_table(scenes):
    """What the plans of rendered scenes left out, bound and cost, from the notes kept with them: by scene, in short."""
    plans = pd.DataFrame([{"scene": scene.name, **scene.notes} for scene in scenes])
    plans = plans[["scene", *(name for name in plans.columns if name.startswith("plan_"))]]
    in_short = plans[list(PLANNED)].agg(["min", "mean", "max"]).T.rename_axis("quantity").reset_index()
    in_short["n_scenes"] = len(plans)
    # Of all pixels times layers of all scenes together: large scenes weigh more than in the mean of shares.
    in_short["of_all_terms"] = [plans["plan_terms"].sum() / plans["plan_terms_full"].sum(), None, None]
    return plans, in_short
