"""Reliability of dates: years of simulated firn and of cores, by their stated confidence.

`python benchmarks/bench_years.py all FOLDER CORES TABLE` does all of this, and goes on where it was
stopped: `... cache FOLDER` simulates and tracks firn; `... score FOLDER CORES TABLE` dates it, and
the cores in the folder CORES; `... tabulate TABLE` writes both tables beside this file from which
`docs/fill_tables.py` fills the page, draws its picture, and prints how many cases miss each bound.
Seeds below 100, `... tuning FOLDER`, and every other core chose the constants of
`snowsim.snowpack.dating`; the others only score it.
"""

import pickle
import sys
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt
from scipy.stats import norm

from snowsim import Tracker
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.seeding import random_stream
from snowsim.snowpack import Climate, Radar, Snowpack, accumulation, simulate

RADARS = ("snow-2012", "snow-2-8")
ACCUMULATIONS_M = (0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.8)
N_CRUSTS = (0, 3, 5)
CRUST_KG_M3 = 60.0  # step of density at a crust
N_LINES = 256
TUNING_SEEDS = range(8)
NEAR_S = 4 * 2.886e-10  # of a pick that is the horizon, and within which the tracker separates none
# So many that the share right of a case is known to .1: dates of one simulation are right or wrong
# together, and ten seeds know it to .12.
SCORING_SEEDS = range(200, 230)
FOLDER = Path(__file__).resolve().parent
CASE = ["kind", "radar", "mass_m", "crusts", "missing", "expected"]
SCORED_KINDS = ("tracker", "core")  # of the table by class and of the bounds
SURE = 0.8  # without a flag
GAP = slice(110, 146)  # range lines without layers, behind which their numbers begin anew
CLASSES = (0.5, 0.6, 0.7, 0.8, 0.9)  # of the confidence stated
# Bounds that cases are counted against: of stated less right, of accumulation over the truth less
# 1, and of the share of years within `low` and `high`.
MOST_EXCESS, MOST_BIAS, LEAST_INSIDE = 0.15, 0.1, 0.85


def firn(accumulation_m, n_crusts, spacing_m, rng):
    """`Snowpack` of twenty annual layers, crusts among them, and which of its layers are horizons.

    A crust is a step of density somewhere in the middle of a year, half above the mean and half
    below it.
    """
    snow = Climate(accumulation_m=accumulation_m).draw(N_LINES, spacing_m, rng=rng)
    years = rng.choice(np.arange(len(snow.depth_m) - 1), n_crusts, replace=False)
    share = rng.uniform(0.2, 0.8, n_crusts)[:, None]
    depth_m, density = snow.depth_m, snow.density_kg_m3.copy()
    crust_m = (1 - share) * depth_m[years] + share * depth_m[years + 1]
    below = density[years] - CRUST_KG_M3 / 2
    density[years] += CRUST_KG_M3 / 2
    horizon = np.insert(np.ones(len(depth_m), bool), years + 1, False)
    depth_m = np.insert(depth_m, years + 1, crust_m, axis=0)
    density = np.insert(density, years + 1, below, axis=0)
    return Snowpack(depth_m, density, coherent=False), horizon


def tracked(tracker, radar, accumulation_m, n_crusts, seed):
    """Layers that the tracker picks in simulated firn, and the true ones with `horizon`."""
    rng = random_stream(seed, "bench_years", radar, accumulation_m, n_crusts)
    radar = Radar.preset(radar)
    snow, horizon = firn(accumulation_m, n_crusts, radar.line_spacing_m, rng)
    echogram, truth = simulate(snow, radar, rng=rng)
    return tracker.pick(echogram), truth.assign(horizon=("layer", horizon))


def cache(folder, seeds=SCORING_SEEDS):
    """Simulate and track what is not there."""
    tracker = Tracker.from_pretrained()
    tasks = [
        (radar, mass, crusts, seed)
        for seed in seeds
        for mass in ACCUMULATIONS_M
        for crusts in N_CRUSTS
        for radar in RADARS
    ]
    tasks += [(r, m, 0, s) for s in seeds[:6] for r in RADARS for m in (0.03, 0.05, 0.07)]
    Path(folder).mkdir(parents=True, exist_ok=True)
    for task in tasks:
        path = Path(folder) / ("_".join(map(str, task)) + ".pickle")
        if not path.exists():
            path.write_bytes(pickle.dumps(tracked(tracker, *task)))


def timed(layers, truth):
    """Travel times [s] below the surface of layers and true ones, medians along track, downwards.

    Of the true ones also their age, -1 of crusts, and the mass above them [m w.e.].
    """
    own = (layers["twtt"] - layers["twtt"][0]).median("slow_time").values[1:]
    true = (truth["peak_twtt"] - truth["peak_twtt"][0]).median("slow_time").values
    horizon = truth["horizon"].values
    age = np.where(horizon, np.cumsum(horizon) - 2, -1)
    return own, true, age, truth["water_m"].median("slow_time").values


def scored(found, own, true, age, water_m):
    """A row for each horizon that is dated: whether its year is right, and of the year below it.

    `found` is the dataset of `accumulation` on a range line in the middle, its last autumn 1999.
    """
    known_m, known_s = found["depth_at"].values, found["below_s"].values
    line = found.isel(slow_time=found.sizes["slow_time"] // 2)
    line = line.drop_dims([name for name in ("below_s", "layer") if name in line.dims])
    years = line.to_dataframe().dropna(subset="accumulation_m_we").reset_index()
    if years.empty:
        return years
    top_s = np.interp(years["depth_m"], known_m, known_s)
    base_s = np.interp(years["depth_m"] + years["thickness_m"], known_m, known_s)
    nearest = np.abs(true - top_s[:, None]).argmin(axis=1)
    near = np.abs(true[nearest] - top_s) < NEAR_S
    true_age = np.where(near, age[nearest], -1)
    picked = np.abs(own - top_s[:, None]).min(axis=1) < 2 * NEAR_S / 4
    horizon = age >= 0
    edges_s, edges_m = np.append(0, true[horizon]), np.append(0, water_m[horizon])
    inside = np.searchsorted(edges_s, (top_s + base_s) / 2).clip(1, edges_s.size - 1)
    true_m = np.diff(edges_m)[inside - 1]
    years["true_age"] = true_age
    years["picked"] = picked
    years["right"] = years["year"] == 1999 - true_age
    years["right"] &= true_age >= 0
    years["inside"] = (years["low"] <= true_m) & (true_m <= years["high"])
    # Over the mean of the true years between the ends of what is dated.
    ends = np.interp([top_s[0], base_s[-1]], edges_s, np.arange(edges_s.size))
    mean_m = np.diff(np.interp([top_s[0], base_s[-1]], edges_s, edges_m)) / np.diff(ends)
    years["ratio"] = years["accumulation_m_we"].mean() / float(mean_m[0])
    return years


def with_gap(layers):
    """Layers of a track without the lines of `GAP`, and with other names behind it."""
    before = layers.isel(slow_time=slice(GAP.start))
    behind = layers.isel(slow_time=slice(GAP.stop, None))
    names = [f"snow_{100 + number}" for number in range(1, layers.sizes["layer"])]
    behind = behind.assign_coords(layer=["surface", *names])
    without_pick = {"quality": 1, "type": 2}
    return xr.concat([before, behind], "slow_time", join="outer", fill_value=without_pick)


def dated_firn(path, expected=None, kind="tracker"):
    """Rows of `scored` of a file of the cache.

    `kind` is "tracker", its picks; "gap", these with a gap along track; or "true", true horizons.
    """
    layers, truth = pickle.loads(Path(path).read_bytes())
    radar, mass, crusts, seed = Path(path).stem.rsplit("_", 3)
    timed_layers = timed(layers, truth)
    if kind == "true":
        sure = xr.full_like(truth["twtt"], 0.9)
        names = ["surface", *(f"snow_{n}" for n in range(1, truth.sizes["layer"]))]
        layers = truth[["peak_twtt", "quality", "type", "Latitude"]].assign(confidence=sure)
        layers = layers.rename(peak_twtt="twtt").assign_coords(layer=names)
        timed_layers = timed(layers, truth)
    else:
        layers = (with_gap(layers) if kind == "gap" else layers).assign_attrs(apart_s=NEAR_S)
    options = {}
    if expected is not None:
        rng = random_stream(int(seed), "bench_years", "expected")
        options = {"expected_m": float(mass) * np.exp(expected * rng.standard_normal())}
        options["expected_error"] = expected
    case = {"kind": kind, "radar": radar, "seed": int(seed)}
    case |= {"mass_m": float(mass), "crusts": int(crusts), "expected": expected}
    try:
        found = accumulation(layers, 340.0, temperature_k=243.0, **options)
    except ValueError as error:
        return pd.DataFrame([case | {"refused": str(error)[:60]}])
    rows = scored(found, *timed_layers)
    if rows.empty:
        return pd.DataFrame([case | {"refused": "nothing is dated"}])
    return rows.assign(**case)


def cores(folder):
    """Masses of years [m w.e.], the newest first: 16 cores of GreenTrACS, 7 stretches of GISP2."""
    columns = np.genfromtxt(Path(folder) / "greentracs" / "Accumulation.txt").T[:-1]
    series = [core[np.isfinite(core)][:26] for core in columns]
    gisp2 = np.loadtxt(Path(folder) / "summit" / "gisp2_accum_1939_1743_kgm2.txt") / 1000
    return series + [part[:26] for part in np.split(gisp2[: 7 * 28], 7)]


def dated_core(core, number, missing, seed, expected=None):
    """Rows of `scored` of a core in snow of 400 kg m-3, some of whose horizons are missing."""
    rng = random_stream(seed, "bench_years", "core", number)
    water_m = np.cumsum(np.append(rng.uniform(0.1, 1) * np.median(core), core))
    elapsed = water_m[0] / np.median(core)
    age = np.arange(water_m.size)
    kept = rng.random(age.size) >= missing
    twtt = 2 * 2.5 * water_m * (1 + 0.845e-3 * 400) / SPEED_OF_LIGHT_M_S
    day = np.datetime64("1999-09-01") + np.timedelta64(int(365 * elapsed), "D")
    own = np.append(0, twtt[kept])[:, None]
    on = ("layer", "slow_time")
    held = {"twtt": (on, 3e-6 + own), "confidence": (on, np.where(own > 0, 0.9, 1.0))}
    held |= {name: (on, np.ones(own.shape, np.uint8)) for name in ("quality", "type")}
    names = ["surface", *(f"snow_{n}" for n in range(1, len(own)))]
    times = np.array([day], "datetime64[ns]")
    layers = xr.Dataset(held, {"layer": names, "slow_time": times})
    options = {}
    if expected is not None:
        options = {"expected_m": float(core.mean() * np.exp(expected * rng.standard_normal()))}
        options["expected_error"] = expected
    found = accumulation(layers, 400.0, **options)
    case = {"kind": "core", "missing": missing, "number": number, "seed": seed}
    rows = scored(found, own[1:, 0], twtt, age, water_m)
    return rows.assign(expected=expected, **case)


def score(folder, data, path):
    """Write the table of all horizons of seeds, and of cores, that chose nothing."""
    warnings.simplefilter("ignore")
    files = sorted(Path(folder).glob("snow-*.pickle"))
    new = [file for file in files if int(file.stem.rsplit("_", 1)[1]) >= min(SCORING_SEEDS)]
    clean = [file for file in new if "_0.3_0_" in file.name and "2012" in file.name]
    true = [file for file in new if "2012_0.3_" in file.name or "2012_0.6_" in file.name]
    tables = [dated_firn(file) for file in new]
    tables += [dated_firn(file, expected=0.1) for file in clean]
    tables += [dated_firn(file, kind="true") for file in true]
    uncrusted = [file for file in true if file.stem.rsplit("_", 2)[1] == "0"]
    tables += [dated_firn(file, kind="gap") for file in uncrusted]
    held_back = [*enumerate(cores(data))][1::2]
    for seed in (100, 101, 102):
        for number, core in held_back:
            tables += [dated_core(core, number, missing, seed) for missing in (0, 0.2, 0.4)]
            tables.append(dated_core(core, number, 0, seed, expected=0.1))
    columns = [
        *("kind", "radar", "mass_m", "crusts", "missing", "expected", "number", "seed"),
        *("year", "true_age", "picked", "n_years", "year_confidence", "right", "inside"),
        *("accumulation_m_we", "ratio", "refused"),
    ]
    pd.concat(tables).reindex(columns=columns).to_csv(path, index=False, float_format="%.3g")


def by_case(rows):
    """Table by case: dates of picked horizons, and accumulation over the truth.

    `stated` is the mean probability of a date, `right` the share of dates that are right. `sure` is
    the share of dates stated at .8 or more, `right_of_sure` the share of these that are right.
    `inside` is the share of years whose accumulation lies within `low` and `high`. `accumulation`
    is the median over seeds of the mean over that of the truth. `error` is the standard error of
    `stated` less `right`, from the differences between simulations.
    """
    table = []
    for case, own in rows.groupby(CASE, dropna=False):
        dates = own[own["picked"]]
        sure = dates["year_confidence"] >= SURE
        one_a_seed = own.drop_duplicates(["seed", "number"])
        values = {
            "n": len(dates),
            "stated": dates["year_confidence"].mean(),
            "right": dates["right"].mean(),
            "sure": sure.mean(),
            "right_of_sure": dates["right"][sure].mean(),
            "inside": own["inside"].mean(),
            "accumulation": one_a_seed["ratio"].median(),
            "error": excess_error(dates),
        }
        table.append(dict(zip(CASE, case, strict=True)) | values)
    return pd.DataFrame(table)


def excess_error(dates):
    """Standard error of the mean probability stated less the share right, by simulations."""
    excess = dates["year_confidence"] - dates["right"]
    one_by_one = [dates["seed"].to_numpy(), dates["number"].fillna(-1).to_numpy()]
    of_each = (excess - excess.mean()).groupby(one_by_one).sum()
    few = len(of_each) / max(len(of_each) - 1, 1)
    return np.sqrt((of_each**2).sum() * few) / len(dates)


def misses(cases):
    """Lines on how many cases miss each bound, and how many would by chance alone.

    By chance: if what is stated were right in every case, with the errors that the seeds leave.
    """
    excess = cases["stated"] - cases["right"]
    by_chance = norm.sf(MOST_EXCESS / cases["error"]).sum()
    far = (cases["accumulation"] - 1).abs() > MOST_BIAS
    return [
        f"of {len(cases)} cases, stated exceeds right by more than {MOST_EXCESS:g} in "
        f"{(excess > MOST_EXCESS).sum()}, by chance alone in {by_chance:.1f}; mean "
        f"{excess.mean():.3f}, largest {excess.max():.2f}",
        f"accumulation is off by more than {MOST_BIAS:g} in {far.sum()}",
        f"less than {LEAST_INSIDE:g} lie within low and high in "
        f"{(cases['inside'] < LEAST_INSIDE).sum()}",
    ]


def by_class(rows):
    """Table of dates by classes of the confidence stated; every case has equal weight."""
    n_of_case = rows.groupby(CASE, dropna=False)["right"].transform("size")
    rows = rows.assign(weight=1 / n_of_case, of=np.digitize(rows["year_confidence"], CLASSES))
    table = []
    for _, own in rows.groupby("of"):
        stated, right = (
            np.average(own[name], weights=own["weight"]) for name in ("year_confidence", "right")
        )
        table.append({"stated": stated, "right": right, "n": len(own)})
    return pd.DataFrame(table)


def tabulate(path):
    """Write both tables of a table of `score`, and draw what is right against what is stated."""
    rows = pd.read_csv(path)
    rows = rows[rows["refused"].isna()].astype({"right": float, "inside": float, "picked": bool})
    cases = by_case(rows)
    cases.to_csv(FOLDER / "years_by_case.csv", index=False, float_format="%.3f")
    # Neither with an expectation, nor true horizons, nor a gap, nor what is too thin to be dated.
    chosen = rows[
        rows["expected"].isna() & rows["kind"].isin(SCORED_KINDS) & ~(rows["mass_m"] < 0.1)
    ]
    chosen = chosen[chosen["picked"]]
    classes = by_class(chosen)
    weights = 1 / chosen.groupby(CASE, dropna=False)["right"].transform("size")
    squared = (chosen["year_confidence"] - chosen["right"]) ** 2
    constant = np.average(chosen["right"], weights=weights)
    brier = np.average(squared, weights=weights)
    scores = {"brier": brier, "brier_of_a_constant": constant * (1 - constant)}
    classes = classes.assign(**scores)
    classes.to_csv(FOLDER / "years_by_class.csv", index=False, float_format="%.3f")
    shown = cases[
        cases["expected"].isna() & cases["kind"].isin(SCORED_KINDS) & ~(cases["mass_m"] < 0.1)
    ]
    print(*misses(shown), sep="\n")  # noqa: T201
    figure, ax = plt.subplots(figsize=(4.5, 4.2), layout="constrained")
    ax.plot([0, 1], [0, 1], color="0.6", linewidth=1)
    for kind, colour, name in (("tracker", "C0", "simulated firn"), ("core", "C1", "cores")):
        own = shown[shown["kind"] == kind]
        style = {"color": colour, "marker": "o", "linestyle": "", "markersize": 4}
        ax.plot(own["stated"], own["right"], label=f"{name}, a case", **style)
    ax.plot(classes["stated"], classes["right"], "ks-", markersize=5, label="all cases, by class")
    ax.set(
        xlabel="mean probability stated",
        ylabel="share of years that are right",
        xlim=(0, 1),
        ylim=(0, 1),
        aspect="equal",
    )
    ax.legend(frameon=False, fontsize="small", loc="upper left")
    figure.savefig(FOLDER.parent / "docs/years.png", dpi=130)


def tuning(folder):
    """Simulate and track the firn of the seeds that chose constants."""
    cache(folder, TUNING_SEEDS)


def simulate_score_and_tabulate(folder, data, path):
    """All of it."""
    cache(folder)
    score(folder, data, path)
    tabulate(path)


if __name__ == "__main__":
    commands = {"cache": cache, "tuning": tuning, "score": score, "tabulate": tabulate}
    commands["all"] = simulate_score_and_tabulate
    commands[sys.argv[1]](*sys.argv[2:])
