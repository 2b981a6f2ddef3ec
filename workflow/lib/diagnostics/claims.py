"""Every claim of the paper: the table that bears on it, and the outcome that follows from that table."""

import math
from dataclasses import replace
from functools import partial

import numpy as np

from lib.diagnostics.claim_rules import (
    CONFIRMED,
    CONTRADICTED,
    MISSING,
    OPEN,
    Claim,
    all_of,
    paired_outcome,
    side_of_zero,
    signed,
)

METHODS = {"phy": "PHY", "cgan": "cGAN", "observed": "the observed scene itself"}
SETS = {"rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}
SIDES = [f"side_{side}" for side in range(1, 6)]
MOST_QUANTILE_ERROR = 0.05
MOST_DOPPLER_DB = 3.0
MANY_TIMES = 100
ENOUGH_TRAININGS = 5  # of each set, for intervals to be more than indicative; the study's number
LAYERING_KG_M3 = 50  # detrended near-surface logs: 46-56
SPECKLE_DB = 10 / math.log(10) / math.sqrt(100)  # standard deviation of 100 looks: 0.43 dB
BY_INTERVAL = (
    "Confirmed where the 95 % interval of the mean difference, paired by scene, lies wholly on the claimed side of "
    "zero, contradicted where it lies wholly on the other, else not resolved."
)
BY_BOOTSTRAP = "The interval is the paired bootstrap over trainings and images, or Student's t over both in the study."


def _by_method(table, value):
    """A column of a table by scene, one column per method, NaN where it was not measured; a row a scene and method."""
    return table.pivot(index="scene", columns="method", values=value).reindex(columns=list(METHODS))


def _paired(differences, unit, numbers, caveat=""):
    """Claim of a positive difference, paired by scene, which ends its numbers."""
    outcome, text = paired_outcome(differences, unit)
    return Claim(outcome, f"{numbers} {text}.", BY_INTERVAL, caveat)


def curvature(positions):
    """Position errors where layers bend most."""
    bent = positions[(positions["against"] == "curvature") & (positions["shape_class"] == 3)]
    error = _by_method(bent, "mean_abs_error_bins")
    means = ", ".join(f"{name} {error[key].mean():.2f}" for key, name in METHODS.items())
    words = "Mean distance from a layer to the brightest pixel near it, in the quarter of pixels where layers bend most"
    caveat = (
        "Speckle also moves the brightest pixel near a layer, in the observed scene as in renders."
    )
    words += f": {means} range bins. cGAN less PHY"
    return _paired(error["cgan"] - error["phy"], "range bins", words, caveat)


def texture(textures):
    """Distance of the spectrum below the surface from the observed."""
    distance = _by_method(textures[textures["region"] == "below"], "spectrum_distance_db")
    means = f"cGAN {distance['cgan'].mean():.2f} dB, PHY {distance['phy'].mean():.2f} dB"
    words = f"Distance of the radial spectrum from the observed one, below the surface: {means}. PHY less cGAN"
    return _paired(distance["phy"] - distance["cgan"], "dB", words)


def contrast(textures):
    """Deviation of grey levels below the surface."""
    deviation = _by_method(textures[textures["region"] == "below"], "deviation")
    off = {name: (deviation[name] - deviation["observed"]).abs() for name in ("cgan", "phy")}
    names = {"observed": "observed", "cgan": "cGAN", "phy": "PHY"}
    means = ", ".join(f"{name} {deviation[key].mean():.1f}" for key, name in names.items())
    words = f"Standard deviation of grey levels below the surface: {means}. Distance from the observed, PHY less cGAN"
    return _paired(off["phy"] - off["cgan"], "grey levels", words)


def better_similarity(images, metric, sign, unit):
    """One similarity metric of the cGAN; `sign` is +1 where more is better."""
    values = _by_method(images, metric)
    values = values.where(np.isfinite(values))
    first, second = ("cGAN", "PHY") if sign > 0 else ("PHY", "cGAN")
    means = f"cGAN {values['cgan'].mean():.2f}, PHY {values['phy'].mean():.2f}"
    difference = sign * (values["cgan"] - values["phy"])
    return _paired(difference, unit, f"Mean over scenes: {means}. {first} less {second}")


def better_region(textures, region, better):
    """SSIM in one region is higher for the method `better`."""
    other = "phy" if better == "cgan" else "cgan"
    ssim = _by_method(textures[textures["region"] == region], "ssim")
    means = f"cGAN {ssim['cgan'].mean():.3f}, PHY {ssim['phy'].mean():.3f}"
    words = f"Mean SSIM {region} the surface: {means}. {METHODS[better]} less {METHODS[other]}"
    return _paired(ssim[better] - ssim[other], "", words)


def needless_texture(textures):
    """How much neighbouring range lines above the surface resemble each other."""
    above = textures[textures["region"] == "above"]
    likeness, deviation = _by_method(above, "autocorrelation_line"), _by_method(above, "deviation")
    parts = ", ".join(
        f"{name} {likeness[key].mean():.3f} ({deviation[key].mean():.1f} grey levels of deviation)"
        for key, name in (("observed", "observed"), ("cgan", "cGAN"), ("phy", "PHY"))
    )
    words = (
        f"Autocorrelation of neighbouring range lines above the surface, zero for noise: {parts}"
    )
    return _paired(likeness["cgan"] - likeness["observed"], "", f"{words}. cGAN less observed")


def _scores(intervals, output, metric="ods"):
    """Rows of one score of one output by training set."""
    chosen = intervals[(intervals["output"] == output) & (intervals["metric"] == metric)]
    return {row["training_set"]: row for _, row in chosen.iterrows()}


def _difference(row):
    return f"{signed(row['difference'])} [{signed(row['difference_low'])}, {signed(row['difference_high'])}]"


def augmentation(intervals, metric):
    """Differences of one fused score to RD's."""
    rows = _scores(intervals, "fuse", metric)
    outcomes = {
        name: side_of_zero(rows[name]["difference_low"], rows[name]["difference_high"])
        for name in SETS
    }
    parts = "; ".join(
        f"{SETS[name]} {_difference(rows[name])} ({outcome})" for name, outcome in outcomes.items()
    )
    return Claim(
        all_of(outcomes.values()),
        f"Difference to RD with 95 % interval: {parts}.",
        "Confirmed where all three training sets gain, contradicted where one of them loses, else not resolved. "
        + BY_BOOTSTRAP,
        trainings(rows["rd_gd"]),
    )


def trainings(row):
    """How many trainings a difference rests on, and whether they are too few for more than an indication."""
    n = int(row["n_replicas"])
    few = f": indicative, fewer than {ENOUGH_TRAININGS}" if n < ENOUGH_TRAININGS else ""
    return f"{n} trainings of each set{few}."


def best_fuse(intervals):
    """Differences of fused ODS to RD's, RD+PD's against those of the other sets."""
    rows = _scores(intervals, "fuse")
    ours, others = rows["rd_pd"], [rows[name] for name in SETS if name != "rd_pd"]
    if ours["difference_high"] < 0 or any(
        row["difference_low"] > ours["difference_high"] for row in others
    ):
        outcome = CONTRADICTED
    elif ours["difference_low"] > max(0, *(row["difference_high"] for row in others)):
        outcome = CONFIRMED
    else:
        outcome = OPEN
    means = ", ".join(
        f"{name} {rows[key]['mean']:.3f}" for key, name in {"rd": "RD", **SETS}.items()
    )
    return Claim(
        outcome,
        f"{means}. RD+PD less RD {_difference(ours)}.",
        "Confirmed where the interval of RD+PD less RD lies above zero and above those of the other sets; contradicted "
        "where it lies below zero or below one of them; else not resolved. " + BY_BOOTSTRAP,
        trainings(ours),
    )


def best_sides(intervals):
    """On which side outputs RD+GD has the best ODS."""
    best, gains, losses, parts = 0, 0, 0, []
    for side in SIDES:
        rows = _scores(intervals, side)
        row = rows["rd_gd"]
        leads = max(("rd", *SETS), key=lambda name: rows[name]["mean"]) == "rd_gd"
        best += leads
        gains += leads and row["difference_low"] > 0
        losses += row["difference_high"] < 0 or not leads
        parts.append(f"side {side[-1]} {_difference(row)}{', the best' if leads else ''}")
    return Claim(
        CONFIRMED if gains >= 3 else CONTRADICTED if losses >= 3 else OPEN,
        f"ODS of RD+GD less RD: {'; '.join(parts)}. The best of the four sets on {best} of 5 side outputs.",
        "Confirmed where RD+GD leads on at least 3 of the 5 side outputs with an interval above zero, contradicted "
        "where on 3 or more another set leads, else not resolved. " + BY_BOOTSTRAP,
        trainings(row),
    )


def fifth_side(intervals):
    """Differences of the ODS of side output 5 to RD's."""
    rows = _scores(intervals, "side_5")
    outcomes = [
        side_of_zero(-rows[name]["difference_high"], -rows[name]["difference_low"]) for name in SETS
    ]
    return Claim(
        all_of(outcomes),
        "ODS less RD's: "
        + "; ".join(f"{words} {_difference(rows[name])}" for name, words in SETS.items())
        + ".",
        "Confirmed where all three sets lose, contradicted where one of them gains, else not resolved. "
        + BY_BOOTSTRAP,
        trainings(rows["rd_gd"]),
    )


def chi_square(tracked):
    """Quantiles of tracked peak power against those of the fitted Gamma law."""
    inner = tracked[tracked["probability"].between(0.01, 0.99)]
    error = (inner["tracked"] / inner["gamma"] - 1).abs()
    worst = inner.loc[error.idxmax()]
    return Claim(
        CONFIRMED if error.max() < MOST_QUANTILE_ERROR else CONTRADICTED,
        f"Quantiles of tracked power over its group's mean, against Gamma of {tracked['n_looks'].iloc[0]:.2f} looks: "
        f"off by {100 * error.max():.1f} % at most, at probability {worst['probability']:.2f}.",
        f"Confirmed where quantiles 1 % to 99 % agree within {100 * MOST_QUANTILE_ERROR:.0f} %, else contradicted.",
        "The reference flight sums independent scatterers: any other outcome would be surprising.",
    )


def doppler(realism):
    """Highest over lowest band of the Doppler spectrum."""
    value = realism.loc[realism["quantity"].str.startswith("Doppler spectrum"), "value"].iloc[0]
    rule = f"Confirmed where its bands differ by less than {MOST_DOPPLER_DB:.0f} dB, contradicted where by more."
    if not np.isfinite(value):
        return Claim(OPEN, "There is no complex segment to take a spectrum of.", rule)
    return Claim(
        CONFIRMED if value < MOST_DOPPLER_DB else CONTRADICTED,
        f"Highest over lowest band of the mean spectrum of layers 1 to 15: {value:.2f} dB.",
        rule,
        "Flat by construction of the reference flight.",
    )


def equal_looks(config):
    """Looks of PHY and of the observed scenes, both settings."""
    if config["source"] != "reference":
        return Claim(OPEN, "How many looks the scenes have is not known.", "Compares two settings.")
    ours, observed = config["phy"]["n_looks"], config["benchmark"]["n_looks"]
    outcome, numbers = (
        CONFIRMED if ours == observed else CONTRADICTED,
        f"phy.n_looks is {ours}, benchmark.n_looks",
    )
    return Claim(
        outcome, f"{numbers} {observed}.", "Compares two settings.", "PHY is given this number."
    )


def expensive(convolution):
    """Cost of full-wave scenes, and error of PHY without."""
    scenes = convolution[convolution["part"] == "scene"]
    least = scenes.groupby("method")["seconds"].min()
    scene_db = scenes.loc[scenes["method"] == "PHY", "error_db"].iloc[0]
    layered = convolution[
        (convolution["sweep"] == "fine layering") & (convolution["method"] == "convolution")
    ]
    layering_db = layered.loc[layered["value"] == LAYERING_KG_M3, "error_db"].max()
    error_db = np.fmax(scene_db, layering_db)
    ratio = least["transfer matrix, stack"] / least["PHY"]
    if ratio > MANY_TIMES and error_db < SPECKLE_DB:
        outcome = CONFIRMED
    else:
        outcome = CONTRADICTED if error_db > SPECKLE_DB and ratio < MANY_TIMES else OPEN
    return Claim(
        outcome,
        f"A scene by a coherent solver with all multiples: {least['transfer matrix, stack']:.3g} s, by PHY "
        f"{1e3 * least['PHY']:.2g} ms, {ratio:,.0f} times less. What PHY's convolution leaves out: "
        f"{scene_db:.2f} dB on smooth layers, {layering_db:.2f} dB with fine layering of {LAYERING_KG_M3} kg m-3 as in "
        f"density logs (speckle of 100 looks: {SPECKLE_DB:.2f} dB). What a tracker would gain is not known.",
        f"Confirmed where the solver costs more than {MANY_TIMES} times as much and both errors lie below the speckle "
        "of 100 looks; contradicted where it costs less and one lies above; else not resolved.",
        "The solver is a transfer matrix in one dimension, on stacks of the reference flight's layers: FDTD in two or "
        "three costs more, and sees what this one cannot.",
    )


LOWER_RMSE = partial(better_similarity, metric="rmse", sign=-1, unit="grey levels")
# Claim, table by the name of its file, rule; in the order of the paper.
CLAIMS = (
    ("PHY follows the curvature of layers better than the cGAN.", "render_positions", curvature),
    ("The cGAN has the better texture.", "render_texture", texture),
    ("The cGAN has the better contrast.", "render_texture", contrast),
    (
        "The cGAN has the better PSNR.",
        "similarity",
        partial(better_similarity, metric="psnr", sign=1, unit="dB"),
    ),
    ("The cGAN has the better RMSE.", "similarity", LOWER_RMSE),
    (
        "PHY is better above the surface.",
        "render_texture",
        partial(better_region, region="above", better="phy"),
    ),
    ("The cGAN adds texture above the surface.", "render_texture", needless_texture),
    (
        "The cGAN is better below the surface.",
        "render_texture",
        partial(better_region, region="below", better="cgan"),
    ),
    (
        "Augmentation raises the fused output's ODS.",
        "table3_intervals",
        partial(augmentation, metric="ods"),
    ),
    (
        "Augmentation raises the fused output's OIS.",
        "table3_intervals",
        partial(augmentation, metric="ois"),
    ),
    ("RD+PD gives the best fused ODS.", "table3_intervals", best_fuse),
    ("RD+GD gives the best side outputs.", "table3_intervals", best_sides),
    ("Side output 5 gets worse with synthetic data.", "table3_intervals", fifth_side),
    ("Tracked peak power is chi-square distributed.", "tracked_power", chi_square),
    ("The Doppler spectrum is flat.", "realism", doppler),
    ("PHY's speckle has as many looks as that of observed scenes.", "config", equal_looks),
    (
        "Models of the FDTD class are too expensive for what they add.",
        "convolution_accuracy",
        expensive,
    ),
)


# Confirmed on the reference flight because that was built so; with own data they are claims as any
# other.
BUILT_IN = (chi_square, doppler, equal_looks)


def check_claims(tables, *, synthetic=True):
    """Outcomes of all claims, from tables by the names of their files; "no table" where a table is missing.

    `synthetic`: the run is of the reference flight, which was built to have what some claims say.
    """
    found = []
    for claim, needed, rule_of in CLAIMS:
        if needed in tables:
            outcome = rule_of(tables[needed])
        else:
            outcome = Claim(MISSING, f"Needs {needed}, which this run did not make.", "")
        built_in = synthetic and rule_of in BUILT_IN and outcome.outcome == CONFIRMED
        found.append(replace(outcome, claim=claim, tables=(needed,), by_construction=built_in))
    return found
