"""Speed against accuracy of PHY: raw seconds and error of every way to a part or a whole scene."""

from functools import partial

import numpy as np
import pandas as pd
import torch

from evaluation.lib import phy_alternatives as ways
from evaluation.lib import phy_errors
from evaluation.lib.machine import device_name, time_rounds
from snowsim.cgan import Settings, networks_of
from snowsim.cgan import render as render_cgan
from snowsim.echogram import Scene, to_uint8
from snowsim.phy import draw_speckle, plan, render
from snowsim.phy.power import exact_power
from snowsim.reference import draw_scene

TOLERANCES_DB = (0.5, 0.1, 0.05, 0.01, 1e-3, 1e-6)
ALL_WAYS_DB = (0.5, 0.05, 1e-3)  # tolerances at which slower ways are timed, too
SCENE_TOLERANCES_DB = (0.5, 0.1, 0.05, 0.01)
GROWTH_TOLERANCE_DB = 0.05
N_LOOKS = (16, 100)
# Down range, of bins somewhat finer than a range response; others cost the same.
CORRELATION = (1, 0.16, 0.02)
MOVEMENTS_DB = (1.0, 3.0, 6.0, 10.0, 20.0)
TIMED_MOVEMENT_DB = 6.0  # the time does not depend on how far the mean moves
DISTANCE = {
    "looks": lambda n_looks: 0.0,
    "gamma": lambda n_looks: 0.0,
    "cube": phy_errors.cube_distance,
    "quantile": phy_errors.quantile_distance,
}
SCATTERER_LINES = 4  # of the scatterers' scene: its cost is the same for every range line
RANGE_LINES = (16, 64, 256, 1024, 4096)
LAYERS = (1, 2, 5, 10, 20, 40, 80)
FLOOR = ("floor", "float32 normal")  # one normal a pixel, for scale
PLANNED = ["plan_share", "plan_cost_normals", "plan_bound_db"]
COLUMNS = ["setting", "method", "repeat", "seconds", "n_pixels", "error_db", "device"]
SPECKLE_COLUMNS = [
    "setting",
    "method",
    "repeat",
    "seconds",
    "n_pixels",
    "device",
    "distance",
    "n_looks",
    "movement_db",
]
GROWTH_COLUMNS = [
    "setting",
    "n_layers",
    "n_pixels",
    "method",
    "plan_ms",
    "repeat",
    "seconds",
    "device",
]


def runs_table(runs, about, columns, **same):
    """A row a run of `time_rounds`, and what is known of it by its name, or the same of all.

    Names begin with a setting and end with a method.
    """
    rows = []
    for name, repeat, seconds in runs:
        row = {"setting": name[0], "method": name[-1], "repeat": repeat, "seconds": seconds}
        row.update(same)
        row.update(about.get(name, {}))
        rows.append(row)
    return pd.DataFrame(rows, columns=columns).assign(device=device_name())


def time_waveforms(n_layers, n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds and largest error [dB] of mean power by every way."""
    layer_bins, parameters = phy_errors.planted_scene(n_layers, n_range_lines, n_range_bins)
    waveforms = ways.waveforms_of(layer_bins, parameters, n_range_bins)
    noise_power = parameters["noise_power"]
    exact = exact_power(waveforms)
    finer = partial(ways.convolved_power, samples_per_bin=4)
    works = {
        ("1 sample per bin", "convolved"): partial(ways.convolved_power, waveforms),
        ("4 samples per bin", "convolved"): partial(finer, waveforms),
        ("as usually written", "naive closed form"): partial(ways.naive_power, waveforms),
        ("every row", "closed form"): partial(exact_power, waveforms),
        ("16 per bin", "nearest"): partial(ways.nearest_power, waveforms),
    }
    for tolerance_db in TOLERANCES_DB:
        setting = f"{tolerance_db:g} dB"
        limits = (waveforms, noise_power, tolerance_db)
        works[setting, "table"] = partial(ways.table_power, *limits)
        if tolerance_db in ALL_WAYS_DB:
            works[setting, "closed form in support"] = partial(ways.power_in_support, *limits)
            for dtype in ("float32", "float64"):
                work = partial(ways.recursive_power, *limits, dtype=dtype)
                works[setting, f"recursive {dtype}"] = work
    about = {}
    for key, work in works.items():
        about[key] = {"error_db": phy_errors.largest_error_db(work(), exact, noise_power)}
    works[FLOOR] = partial(rng.standard_normal, exact.shape, dtype=np.float32)
    return runs_table(time_rounds(works, n_rounds), about, COLUMNS, n_pixels=exact.size)


def look_means(movement_db, n_looks):
    """Means that fall evenly in dB from the first look to the last."""
    return 10 ** (-np.linspace(0, movement_db, n_looks) / 10)


def time_speckle(n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds of every speckle method, and the distance of its law from that of the sum of looks.

    Where the mean moves within the looks, distances alone but for one movement.
    """
    shape = (n_range_bins, n_range_lines)
    mean_power = np.ones(shape, dtype=np.float32)
    works = {FLOOR: partial(rng.standard_normal, shape, dtype=np.float32)}
    about = {}
    for n_looks in N_LOOKS:
        setting = f"M = {n_looks}"
        draw = partial(draw_speckle, mean_power, n_looks, rng=rng)
        for method, distance in DISTANCE.items():
            works[setting, method] = partial(draw, method=method)
            about[setting, method] = {"distance": distance(n_looks), "n_looks": n_looks}
        key = (setting, "quantile, correlated")
        works[key] = partial(draw, method="quantile", correlation=CORRELATION)
        about[key] = {"distance": phy_errors.correlated_distance(n_looks), "n_looks": n_looks}
        for movement_db in MOVEMENTS_DB:
            about[_moving(n_looks, movement_db, "gamma")] = {
                "distance": phy_errors.moving_distance(look_means(movement_db, n_looks)),
                "n_looks": n_looks,
                "movement_db": movement_db,
            }
    n_looks = min(N_LOOKS)
    means = look_means(TIMED_MOVEMENT_DB, n_looks).astype(np.float32)
    moving = np.broadcast_to(means[:, None, None], (n_looks, *shape))
    for method in ("gamma", "looks"):
        work = partial(ways.draw_moving_speckle, moving, method=method, rng=rng)
        works[_moving(n_looks, TIMED_MOVEMENT_DB, method)] = work
    about[_moving(n_looks, TIMED_MOVEMENT_DB, "looks")] = {
        "distance": 0.0,
        "n_looks": n_looks,
        "movement_db": TIMED_MOVEMENT_DB,
    }
    runs = time_rounds(works, n_rounds)
    runs += [(key, np.nan, np.nan) for key in about if key not in works]
    return runs_table(runs, about, SPECKLE_COLUMNS, n_pixels=mean_power.size)


def _moving(n_looks, movement_db, method):
    """Setting and method where the mean moves within the looks."""
    return f"M = {n_looks}, {movement_db:g} dB", f"{method}, moving"


def eight_bits(draw, *given, **options):
    """Render and scale, as every scene that is written."""
    return to_uint8(draw(*given, **options))


def phy_works(layer_bins, parameters, n_range_bins, rng):
    """Renderers of eq. (1): work and largest error of the mean [dB] by (setting, method)."""
    given = (layer_bins, parameters, n_range_bins)
    noise_power = parameters["noise_power"]
    waveforms = ways.waveforms_of(*given)
    exact = exact_power(waveforms)
    printed = (f"M = {parameters['n_looks']}", "as printed")
    unplanned = ("exact", "PHY exact")
    by_phy = partial(eight_bits, render, *given, rng=rng)
    works = {
        printed: partial(eight_bits, ways.render_as_printed, *given, rng=rng),
        unplanned: partial(by_phy, tolerance_db=None),
    }
    means = {printed: ways.convolved_power(waveforms), unplanned: exact}
    for tolerance_db in SCENE_TOLERANCES_DB:
        key = (f"{tolerance_db:g} dB", "PHY")
        works[key] = partial(by_phy, tolerance_db=tolerance_db)
        means[key] = ways.table_power(waveforms, noise_power, tolerance_db)
    errors_db = {
        key: phy_errors.largest_error_db(mean, exact, noise_power) for key, mean in means.items()
    }
    return works, errors_db


def scatterer_work(layer_bins, parameters, n_range_bins, rng):
    """The sum over 100 scatterers a layer and range line, and the error of its mean [dB]."""
    given = (layer_bins, parameters, n_range_bins)
    noise_power = parameters["noise_power"]
    exact = exact_power(ways.waveforms_of(*given))
    scattered = phy_errors.scattered_mean_power(*given) - noise_power
    work = partial(eight_bits, ways.render_scatterers, *given, rng=rng)
    return work, phy_errors.largest_error_db(scattered, exact, noise_power)


def cgan_work(layer_bins, n_range_bins, settings, rng):
    """A generator of the configured size; what it has learned makes no difference to its cost."""
    settings = Settings(**settings)
    generator = networks_of(settings)[0].to(memory_format=torch.channels_last).eval()
    scene = Scene("planted", n_range_bins, layer_bins)
    return partial(render_cgan, generator, scene, settings, rng=rng)


def time_scenes(
    n_layers, n_range_lines, n_range_bins, n_rounds, *, reference, climate, cgan, n_looks, stream
):
    """Seconds of whole scenes, 8-bit scaling included, by each model.

    And largest error of the mean [dB] of those by eq. (1). `reference` and `climate` are the
    reference flight's; `stream` gives the random generator of some keys.
    """
    rng = stream()
    layer_bins, parameters = phy_errors.planted_scene(n_layers, n_range_lines, n_range_bins)
    works, errors_db = phy_works(layer_bins, parameters, n_range_bins, rng)
    few = ("100 scatterers", "scatterers")
    few_lines = layer_bins[:, :SCATTERER_LINES]
    works[few], errors_db[few] = scatterer_work(few_lines, parameters, n_range_bins, rng)
    works[f"width {cgan['width']}", "cGAN"] = cgan_work(layer_bins, n_range_bins, cgan, rng)
    works[FLOOR] = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    runs = time_rounds(works, n_rounds)

    draw = partial(draw_scene, 0, "test", climate=climate, settings=reference, n_looks=n_looks)
    nature = (f"{n_looks} looks", "nature run")
    scene = draw(rng=stream("reference"))
    # Drawn once already: no warm-up. Its scenes take much longer than the others.
    runs += time_rounds({nature: partial(draw, rng=stream("timed"))}, 2, n_warm_up=0)
    about = {key: {"error_db": error_db} for key, error_db in errors_db.items()}
    about[few]["n_pixels"] = n_range_bins * SCATTERER_LINES
    about[nature] = {"n_pixels": scene.image.size}
    return runs_table(runs, about, COLUMNS, n_pixels=n_range_bins * n_range_lines)


def time_growth(n_layers, n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds of a scene by range lines and by layers, and what its plan predicts [ms]."""
    sizes = [("pixels", n_layers, lines, n_range_bins) for lines in RANGE_LINES]
    sizes += [("layers", layers, n_range_lines, 4 * n_range_bins) for layers in LAYERS]
    normals = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    seconds = [seconds for _, _, seconds in time_rounds({"normal": normals}, n_rounds)]
    normal_s = min(seconds) / (n_range_bins * n_range_lines)
    works = {}
    about = {}
    for setting, layers, lines, height in sizes:
        layer_bins, parameters = phy_errors.planted_scene(layers, lines, height)
        given = (layer_bins, parameters, height)
        draw = partial(eight_bits, render, *given, rng=rng)
        size = {"n_layers": layers, "n_pixels": lines * height}
        key = (setting, layers, lines, "PHY")
        works[key] = partial(draw, tolerance_db=GROWTH_TOLERANCE_DB)
        planned = plan(*given, tolerance_db=GROWTH_TOLERANCE_DB)
        plan_ms = planned.cost_normals * normal_s * lines * height * 1e3
        about[key] = {**size, "plan_ms": plan_ms}
        if setting == "pixels" and lines <= n_range_lines:
            key = (setting, layers, lines, "PHY exact")
            works[key] = partial(draw, tolerance_db=None)
            about[key] = size
    return runs_table(time_rounds(works, 3 * n_rounds), about, GROWTH_COLUMNS)


def plan_table(scenes):
    """What plans of rendered scenes left out, bound and cost, from notes: by scene, in short."""
    plans = pd.DataFrame([{"scene": scene.name, **scene.notes} for scene in scenes])
    plans = plans.set_index("scene").filter(regex="^plan_").reset_index()
    extremes = plans[PLANNED].agg(["min", "mean", "max"]).T
    in_short = extremes.rename_axis("quantity").reset_index()
    in_short["n_scenes"] = len(plans)
    # Of all scenes together: large scenes weigh more than in the mean of shares.
    of_all_terms = plans["plan_terms"].sum() / plans["plan_terms_full"].sum()
    in_short["of_all_terms"] = [of_all_terms, None, None]
    return plans, in_short
