"""Speed against accuracy of PHY: raw seconds and error of every way of computing a part or a whole scene."""

from functools import partial

import numpy as np
import pandas as pd
import torch

from lib.diagnostics import phy_alternatives as ways
from lib.diagnostics import phy_errors
from lib.machine import device_name, time_rounds
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
CORRELATION = (
    1,
    0.16,
    0.02,
)  # down range, of bins somewhat finer than a range response; others cost the same
MOVEMENTS_DB = (1.0, 3.0, 6.0, 10.0, 20.0)
TIMED_MOVEMENT_DB = 6.0  # the time does not depend on how far the mean moves
DISTANCE = dict.fromkeys(("looks", "gamma"), lambda n_looks: 0.0)
DISTANCE |= {"cube": phy_errors.cube_distance, "quantile": phy_errors.quantile_distance}
SCATTERER_LINES = 4  # of the scatterers' scene: its cost is the same for every range line
RANGE_LINES = (16, 64, 256, 1024, 4096)
LAYERS = (1, 2, 5, 10, 20, 40, 80)
FLOOR = ("floor", "float32 normal")  # one normal a pixel, for scale
PLANNED = ("plan_share", "plan_cost_normals", "plan_bound_db")
COLUMNS = ["setting", "method", "repeat", "seconds", "n_pixels", "error_db", "device"]


def runs_table(runs, about, columns, **same):
    """A row a run of `time_rounds`, whose names begin with a setting and end with a method, and what is known of it."""
    rows = [
        {
            "setting": name[0],
            "method": name[-1],
            "repeat": repeat,
            "seconds": seconds,
            **same,
            **about.get(name, {}),
        }
        for name, repeat, seconds in runs
    ]
    return pd.DataFrame(rows, columns=columns).assign(device=device_name())


def time_waveforms(n_layers, n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds and largest error [dB] of mean power by every way."""
    layer_bins, parameters = phy_errors.planted_scene(n_layers, n_range_lines, n_range_bins)
    waveforms = ways.waveforms_of(layer_bins, parameters, n_range_bins, "peak", "peak")
    exact, noise_power = exact_power(waveforms), parameters["noise_power"]
    works = {
        ("1 sample per bin", "convolved"): partial(ways.convolved_power, waveforms),
        ("4 samples per bin", "convolved"): partial(
            ways.convolved_power, waveforms, samples_per_bin=4
        ),
        ("as usually written", "naive closed form"): partial(ways.naive_power, waveforms),
        ("every row", "closed form"): partial(exact_power, waveforms),
        ("16 per bin", "nearest"): partial(ways.nearest_power, waveforms),
    }
    for tolerance_db in TOLERANCES_DB:
        setting, limits = f"{tolerance_db:g} dB", (waveforms, noise_power, tolerance_db)
        works[setting, "table"] = partial(ways.table_power, *limits)
        if tolerance_db in ALL_WAYS_DB:
            works[setting, "closed form in support"] = partial(ways.power_in_support, *limits)
            for dtype in (np.float32, np.float64):
                name = f"recursive {np.dtype(dtype).name}"
                works[setting, name] = partial(ways.recursive_power, *limits, dtype=dtype)
    about = {
        key: {"error_db": phy_errors.largest_error_db(work(), exact, noise_power)}
        for key, work in works.items()
    }
    works[FLOOR] = partial(rng.standard_normal, exact.shape, dtype=np.float32)
    return runs_table(time_rounds(works, n_rounds), about, COLUMNS, n_pixels=exact.size)


def look_means(movement_db, n_looks):
    """Means that fall evenly in dB from the first look to the last."""
    return 10 ** (-np.linspace(0, movement_db, n_looks) / 10)


def time_speckle(n_range_lines, n_range_bins, n_rounds, *, rng):
    """Seconds of every speckle method, and how far its distribution function lies from that of the sum of looks.

    Where the mean moves within the looks, distances alone but for one movement.
    """
    shape = (n_range_bins, n_range_lines)
    mean_power = np.ones(shape, dtype=np.float32)
    works = {FLOOR: partial(rng.standard_normal, shape, dtype=np.float32)}
    about = {}
    for n_looks in N_LOOKS:
        for method, distance in DISTANCE.items():
            key = (f"M = {n_looks}", method)
            works[key] = partial(draw_speckle, mean_power, n_looks, method=method, rng=rng)
            about[key] = {"distance": distance(n_looks), "n_looks": n_looks}
        key = (f"M = {n_looks}", "quantile, correlated")
        works[key] = partial(
            draw_speckle, mean_power, n_looks, method="quantile", correlation=CORRELATION, rng=rng
        )
        about[key] = {"distance": phy_errors.correlated_distance(n_looks), "n_looks": n_looks}
        for movement_db in MOVEMENTS_DB:
            distance = phy_errors.moving_distance(look_means(movement_db, n_looks))
            key = (f"M = {n_looks}, {movement_db:g} dB", "gamma, moving")
            about[key] = {"distance": distance, "n_looks": n_looks, "movement_db": movement_db}
    n_looks = min(N_LOOKS)
    means = look_means(TIMED_MOVEMENT_DB, n_looks).astype(np.float32)[:, None, None]
    moving = np.broadcast_to(means, (n_looks, *shape))
    setting = f"M = {n_looks}, {TIMED_MOVEMENT_DB:g} dB"
    for method in ("gamma", "looks"):
        works[setting, f"{method}, moving"] = partial(
            ways.draw_moving_speckle, moving, method=method, rng=rng
        )
    about[setting, "looks, moving"] = {
        "distance": 0.0,
        "n_looks": n_looks,
        "movement_db": TIMED_MOVEMENT_DB,
    }
    runs = time_rounds(works, n_rounds)
    runs += [(key, np.nan, np.nan) for key in about if key not in works]
    columns = [
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
    return runs_table(runs, about, columns, n_pixels=mean_power.size)


def eight_bits(draw, *given, **options):
    """Render and scale, as every scene that is written."""
    return to_uint8(draw(*given, **options))


def phy_works(layer_bins, parameters, n_range_bins, rng):
    """Renderers of eq. (1): work and largest error of the mean [dB] by (setting, method)."""
    given, noise_power = (layer_bins, parameters, n_range_bins), parameters["noise_power"]
    waveforms = ways.waveforms_of(*given, "peak", "peak")
    exact = exact_power(waveforms)
    printed, by_phy = (
        (f"M = {parameters['n_looks']}", "as printed"),
        partial(eight_bits, render, *given, rng=rng),
    )
    works = {printed: partial(eight_bits, ways.render_as_printed, *given, rng=rng)}
    works["exact", "PHY exact"] = partial(by_phy, tolerance_db=None)
    means = {printed: ways.convolved_power(waveforms), ("exact", "PHY exact"): exact}
    for tolerance_db in SCENE_TOLERANCES_DB:
        key = (f"{tolerance_db:g} dB", "PHY")
        works[key] = partial(by_phy, tolerance_db=tolerance_db)
        means[key] = ways.table_power(waveforms, noise_power, tolerance_db)
    return works, {
        key: phy_errors.largest_error_db(mean, exact, noise_power) for key, mean in means.items()
    }


def scatterer_work(layer_bins, parameters, n_range_bins, rng):
    """The sum over 100 scatterers per layer and range line, and the largest error of its mean [dB]."""
    given = (layer_bins, parameters, n_range_bins)
    exact = exact_power(ways.waveforms_of(*given, "peak", "peak"))
    scattered = phy_errors.scattered_mean_power(*given, align="peak") - parameters["noise_power"]
    work = partial(eight_bits, ways.render_scatterers, *given, rng=rng, align="peak")
    return work, phy_errors.largest_error_db(scattered, exact, parameters["noise_power"])


def cgan_work(layer_bins, n_range_bins, settings, rng):
    """A generator of the configured size; what it has learned makes no difference to its cost."""
    settings = Settings(**settings)
    generator = networks_of(settings)[0].to(memory_format=torch.channels_last).eval()
    return partial(
        render_cgan, generator, Scene("planted", n_range_bins, layer_bins), settings, rng=rng
    )


def time_scenes(
    n_layers, n_range_lines, n_range_bins, n_rounds, *, reference, climate, cgan, n_looks, stream
):
    """Seconds of whole scenes, 8-bit scaling included, by each model; largest error of the mean [dB] by eq. (1).

    `reference` and `climate` are the reference flight's; `stream` gives the random generator of
    some keys.
    """
    rng = stream()
    layer_bins, parameters = phy_errors.planted_scene(n_layers, n_range_lines, n_range_bins)
    works, errors_db = phy_works(layer_bins, parameters, n_range_bins, rng)
    few = ("100 scatterers", "scatterers")
    works[few], errors_db[few] = scatterer_work(
        layer_bins[:, :SCATTERER_LINES], parameters, n_range_bins, rng
    )
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
    """Seconds of a scene against its range lines and against its layers, and what its plan predicts [ms]."""
    sizes = [("pixels", n_layers, lines, n_range_bins) for lines in RANGE_LINES]
    sizes += [("layers", layers, n_range_lines, 4 * n_range_bins) for layers in LAYERS]
    works, about = {}, {}
    normals = partial(rng.standard_normal, (n_range_bins, n_range_lines), dtype=np.float32)
    seconds = [seconds for _, _, seconds in time_rounds({"normal": normals}, n_rounds)]
    normal_s = min(seconds) / (n_range_bins * n_range_lines)
    for setting, layers, lines, height in sizes:
        layer_bins, parameters = phy_errors.planted_scene(layers, lines, height)
        given = (layer_bins, parameters, height)
        size = {"n_layers": layers, "n_pixels": lines * height}
        key = (setting, layers, lines, "PHY")
        works[key] = partial(eight_bits, render, *given, tolerance_db=GROWTH_TOLERANCE_DB, rng=rng)
        cost = plan(*given, tolerance_db=GROWTH_TOLERANCE_DB).cost_normals
        about[key] = size | {"plan_ms": cost * normal_s * lines * height * 1e3}
        if setting == "pixels" and lines <= n_range_lines:
            key = (setting, layers, lines, "PHY exact")
            works[key] = partial(eight_bits, render, *given, tolerance_db=None, rng=rng)
            about[key] = size | {"plan_ms": np.nan}
    columns = [
        "setting",
        "n_layers",
        "n_pixels",
        "method",
        "plan_ms",
        "repeat",
        "seconds",
        "device",
    ]
    return runs_table(time_rounds(works, 3 * n_rounds), about, columns)


def plan_table(scenes):
    """What the plans of rendered scenes left out, bound and cost, from the notes kept with them: by scene, in short."""
    plans = pd.DataFrame([{"scene": scene.name, **scene.notes} for scene in scenes])
    plans = plans[["scene", *(name for name in plans.columns if name.startswith("plan_"))]]
    in_short = (
        plans[list(PLANNED)].agg(["min", "mean", "max"]).T.rename_axis("quantity").reset_index()
    )
    in_short["n_scenes"] = len(plans)
    # Of all pixels times layers of all scenes together: large scenes weigh more than in the mean of
    # shares.
    in_short["of_all_terms"] = [
        plans["plan_terms"].sum() / plans["plan_terms_full"].sum(),
        None,
        None,
    ]
    return plans, in_short
