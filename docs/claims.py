"""The paper's claims on the default run's tables and test scenes: verdicts and numbers.

Confirmed, or contradicted: by a test over the flights of their study that was named before these
were scored, see `evaluation.lib.flight_scores`. Indicated: the 95 % interval of a difference on the
default flight lies on one side of zero. Open: it holds zero. Differences of renders are paired over
test scenes (bootstrap), those of trackers are of `table3_intervals.csv`.
"""

from pathlib import Path

import numpy as np
import pandas as pd

from evaluation.lib.flight_scores import LEVEL, worth_table
from evaluation.lib.studied import studied_set
from snowsim.echogram import SURFACE_ROW
from snowsim.io.scenes import SceneSet

MEASURED_FLIGHTS = Path(__file__).parents[1] / "workflow/evaluation/measured_flights.csv"
N_BOOTSTRAP = 2000
METHODS = ("cgan", "phy")
BENT_SHARE = 0.75  # pixels of layers above this quantile of curvature count as bent
SEARCHED_ROWS = 5  # of the brightest pixel about a layer
SPECTRUM_ROWS = 192  # below the surface; scenes have at least 300 rows
SPECTRUM_BANDS = 24


def verdict(low, high):
    """What an interval of a difference that is claimed to be positive indicates."""
    if low > 0:
        return "indicated"
    return "the opposite is indicated" if high < 0 else "open"


def interval(difference):
    """95 % interval of the mean of paired differences, by bootstrap over scenes."""
    rng = np.random.default_rng(1)
    drawn = rng.choice(difference, (N_BOOTSTRAP, len(difference))).mean(axis=1)
    return np.percentile(drawn, [2.5, 97.5])


def row_of(claim, better, worse, text):
    """Row of a claim that `better` (scene,) exceeds `worse`."""
    low, high = interval(np.asarray(better) - np.asarray(worse))
    return [claim, verdict(low, high), f"{text}; difference [{low:+.3g}, {high:+.3g}]"]


def off_where_bent(scene, image):
    """Mean distance [bins] of the brightest pixel from layers, where these bend most."""
    below = scene.complete_layer_bins[1:]
    if not below.size:
        return np.nan
    curvature = np.abs(np.diff(below, n=2, axis=1, prepend=np.nan, append=np.nan))
    is_bent = curvature >= np.nanquantile(curvature, BENT_SHARE)
    row = np.rint(below[is_bent]).astype(int)
    _, line = np.nonzero(is_bent)
    window = np.arange(-SEARCHED_ROWS, SEARCHED_ROWS + 1)
    rows = np.clip(row[:, None] + window, 0, len(image) - 1)
    return np.abs(window[image[rows, line[:, None]].argmax(axis=1)]).mean()


def radial_spectrum_db(image):
    """Power [dB] by distance from zero in the plane of wavenumbers, (band,)."""
    part = image[SURFACE_ROW : SURFACE_ROW + SPECTRUM_ROWS].astype(float)
    power = np.abs(np.fft.fft2(part - part.mean())) ** 2
    radius = np.hypot(*np.meshgrid(*map(np.fft.fftfreq, part.shape), indexing="ij"))
    band = np.minimum((radius / 0.5 * SPECTRUM_BANDS).astype(int), SPECTRUM_BANDS)
    sums = np.bincount(band.ravel(), power.ravel())[1:SPECTRUM_BANDS]
    return 10 * np.log10(sums / np.bincount(band.ravel())[1:SPECTRUM_BANDS])


def of_scenes(results):
    """Measures of every test scene and method, one row a scene: curvature, texture, contrast."""
    sets = {"observed": SceneSet(sorted((results / "benchmark/test").glob("*.nc")))}
    for method in METHODS:
        sets[method] = SceneSet(sorted((results / method / "test").glob("*.nc")))
    rows = []
    for scenes in zip(*sets.values(), strict=True):
        observed, *renders = scenes
        spectrum_db = radial_spectrum_db(observed.image)
        row = {"observed_contrast": observed.image.std()}
        for method, render in zip(METHODS, renders, strict=True):
            off_db = radial_spectrum_db(render.image) - spectrum_db
            row[f"{method}_bent"] = off_where_bent(observed, render.image)
            row[f"{method}_texture_db"] = np.sqrt(np.mean(off_db**2))
            row[f"{method}_contrast"] = render.image.std()
        rows.append(row)
    return pd.DataFrame(rows).dropna()


def claims_of_renders(results):
    """Rows of claims on renders of the test scenes' layers."""
    scenes = of_scenes(results)
    mean = scenes.mean()
    images = pd.read_csv(results / "similarity.csv").pivot(index="scene", columns="method")
    score = images.mean()
    off = {
        name: (scenes[f"{name}_contrast"] - scenes["observed_contrast"]).abs() for name in METHODS
    }
    pair = "cGAN {0[cgan]:.3g}, PHY {0[phy]:.3g}"
    return [
        row_of(
            "PHY follows the curvature of layers better",
            scenes["cgan_bent"],
            scenes["phy_bent"],
            f"brightest pixel where layers bend most: cGAN {mean['cgan_bent']:.2f} bins off, "
            f"PHY {mean['phy_bent']:.2f}",
        ),
        row_of(
            "The cGAN has the better texture",
            scenes["phy_texture_db"],
            scenes["cgan_texture_db"],
            f"radial spectrum: cGAN {mean['cgan_texture_db']:.2f} dB from the observed, "
            f"PHY {mean['phy_texture_db']:.2f}",
        ),
        row_of(
            "The cGAN has the better contrast",
            off["phy"],
            off["cgan"],
            f"s.d. of grey levels: observed {mean['observed_contrast']:.1f}, "
            f"cGAN {mean['cgan_contrast']:.1f}, PHY {mean['phy_contrast']:.1f}",
        ),
        row_of(
            "The cGAN has the better SSIM",
            images["ssim"]["cgan"],
            images["ssim"]["phy"],
            pair.format(score["ssim"]),
        ),
        row_of(
            "The cGAN has the better PSNR",
            images["psnr"]["cgan"],
            images["psnr"]["phy"],
            pair.format(score["psnr"]) + " dB",
        ),
        row_of(
            "The cGAN has the better RMSE",
            images["rmse"]["phy"],
            images["rmse"]["cgan"],
            pair.format(score["rmse"]),
        ),
    ]


def claims_of_trackers(intervals):
    """Rows of claims on scores of trackers, of `table3_intervals.csv`."""
    of = intervals.set_index(["output", "metric", "training_set"])
    added = {"rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}

    def difference(name, output="fuse"):
        row = of.loc[(output, "ods", name)]
        low, high = row["difference_low"], row["difference_high"]
        return low, high, f"{added[name]} {row['difference']:+.3f} [{low:+.3f}, {high:+.3f}]"

    rows = []
    for name in ("rd_gd", "rd_pd"):
        low, high, text = difference(name)
        rows.append([f"{added[name]} raises the fused ODS", verdict(low, high), text])
    fused = {name: of.loc[("fuse", "ods", name), "mean"] for name in ("rd", *added)}
    best = max(fused, key=fused.get)
    text = ", ".join(f"{label} {fused[name]:.3f}" for name, label in added.items())
    outcome = "order holds" if best == "rd_pd" else "order does not hold"
    rows.append(["RD+PD gives the best fused ODS", f"{outcome}, no interval", text])
    sides = intervals[intervals["output"].str.startswith("side_") & (intervals["metric"] != "f")]
    best = sides.loc[sides.groupby(["output", "metric"])["mean"].idxmax(), "training_set"]
    n_best = int((best == "rd_gd").sum())
    outcome = "order holds" if 2 * n_best > len(best) else "order does not hold"
    text = f"in {n_best} of {len(best)} scores; in the paper's own table in 7"
    rows.append(["RD+GD gives the best side outputs", f"{outcome}, no interval", text])
    low, high, text = difference("rd_pd", "side_5")
    rows.append(["Side output 5 gets worse with PHY's scenes", verdict(-high, -low), text])
    return rows


def claims_of_flights(worth):
    """Rows of the tests over flights that were named before, of a `worth_table`."""
    tested = worth[worth["p"].notna() & (worth["metric"] == "ods")]
    rows = []
    for row in tested.itertuples():
        p = row.p if row.role == "endpoint" else row.p_holm
        outcome = "open"
        if p < LEVEL:
            outcome = "confirmed" if row.mean > 0 else "contradicted"
        better, base = (studied_set(name).about for name in (row.training_set, row.base))
        text = f"{row.mean:+.3f} [{row.low:+.3f}, {row.high:+.3f}], p = {p:.3f}, {row.role}"
        rows.append([f"{better} has a higher fused ODS than {base}, over flights", outcome, text])
    return rows


def claims(results):
    """Rows of the table of claims: claim, verdict, numbers."""
    intervals = pd.read_csv(results / "tables/table3_intervals.csv")
    rows = claims_of_renders(results) + claims_of_trackers(intervals)
    return rows + claims_of_flights(worth_table(pd.read_csv(MEASURED_FLIGHTS)))
