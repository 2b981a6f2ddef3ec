"""Every claim of the paper: the table that bears on it, and the outcome that follows from it."""

import math
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from scipy import stats

from evaluation.lib.claim_rules import (
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
from snowsim.constants import OUTPUTS
from snowsim.metrics.comparison import METRICS

RENDERED = {"cgan": "cGAN", "phy": "PHY"}
METHODS = {"observed": "observed"} | RENDERED
SETS = {"rd_gd": "RD+GD", "rd_pd": "RD+PD", "rd_pd_gd": "RD+PD+GD"}
FEW_EXCEPTIONS = 3  # of 15 scores, for "almost all"
SIGNIFICANT = 0.05
MOST_SPECTRUM_DB = 1.0  # to which planted spectra come back
MOST_QUANTILE_ERROR = 0.05
MOST_DOPPLER_DB = 3.0
MANY_TIMES = 100
ENOUGH_TRAININGS = 5  # of each set, for intervals to be more than indicative; the study's number
LAYERING_KG_M3 = 50  # detrended near-surface logs: 46-56
SPECKLE_DB = 10 / math.log(10) / math.sqrt(100)  # standard deviation of 100 looks: 0.43 dB
BY_INTERVAL = (
    "Confirmed where the 95 % interval of the mean difference, paired by scene, lies wholly on the "
    "claimed side of zero, contradicted where it lies wholly on the other, else not resolved."
)
BY_BOOTSTRAP = (
    "The interval is the paired bootstrap over trainings and images, or Student's t over both in "
    "the study."
)


def _by_method(table, value):
    """A column of a table of scenes and methods as (scene, method), NaN where not measured."""
    by_scene = table.pivot(index="scene", columns="method", values=value)
    return by_scene.reindex(columns=list(METHODS))


def _of_region(textures, region, value):
    """A column of the table of textures in one region, (scene, method)."""
    return _by_method(textures[textures["region"] == region], value)


def _means(values, form, methods=RENDERED):
    """Means over scenes by method, as text."""
    return ", ".join(f"{name} {values[key].mean():{form}}" for key, name in methods.items())


def _paired(differences, unit, numbers, caveat=""):
    """Claim of a positive difference, paired by scene, which ends its numbers."""
    outcome, text = paired_outcome(differences, unit)
    return Claim(outcome, f"{numbers} {text}.", BY_INTERVAL, caveat)


def curvature(positions):
    """Position errors where layers bend most."""
    bent = positions.query("against == 'curvature' and shape_class == 3")
    error = _by_method(bent, "mean_abs_error_bins")
    names = {"phy": "PHY", "cgan": "cGAN", "observed": "the observed scene itself"}
    words = (
        "Mean distance from a layer to the brightest pixel near it, in the quarter of pixels "
        f"where layers bend most: {_means(error, '.2f', names)} range bins. cGAN less PHY"
    )
    caveat = (
        "Speckle also moves the brightest pixel near a layer, in the observed scene as in renders."
    )
    return _paired(error["cgan"] - error["phy"], "range bins", words, caveat)


def texture(textures):
    """Distance of the spectrum below the surface from the observed."""
    distance = _of_region(textures, "below", "spectrum_distance_db")
    words = (
        "Distance of the radial spectrum from the observed one, below the surface: "
        f"cGAN {distance['cgan'].mean():.2f} dB, PHY {distance['phy'].mean():.2f} dB. PHY less cGAN"
    )
    return _paired(distance["phy"] - distance["cgan"], "dB", words)


def contrast(textures):
    """Deviation of grey levels below the surface."""
    deviation = _of_region(textures, "below", "deviation")
    words = (
        "Standard deviation of grey levels below the surface: "
        f"{_means(deviation, '.1f', METHODS)}. Distance from the observed, PHY less cGAN"
    )
    off_cgan = (deviation["cgan"] - deviation["observed"]).abs()
    off_phy = (deviation["phy"] - deviation["observed"]).abs()
    return _paired(off_phy - off_cgan, "grey levels", words)


def better_similarity(images, metric, sign, unit):
    """One similarity metric of the cGAN; `sign` is +1 where more is better."""
    values = _by_method(images, metric).replace([np.inf, -np.inf], np.nan)
    order = "cGAN less PHY" if sign > 0 else "PHY less cGAN"
    difference = sign * (values["cgan"] - values["phy"])
    return _paired(difference, unit, f"Mean over scenes: {_means(values, '.3g')}. {order}")


def better_region(textures, region, better):
    """SSIM in one region is higher for the method `better`."""
    other = "phy" if better == "cgan" else "cgan"
    ssim = _of_region(textures, region, "ssim")
    order = f"{METHODS[better]} less {METHODS[other]}"
    words = f"Mean SSIM {region} the surface: {_means(ssim, '.3f')}. {order}"
    return _paired(ssim[better] - ssim[other], "", words)


def needless_texture(textures):
    """How much neighbouring range lines above the surface resemble each other."""
    likeness = _of_region(textures, "above", "autocorrelation_line")
    deviation = _of_region(textures, "above", "deviation")
    parts = []
    for method, name in METHODS.items():
        spread = f"({deviation[method].mean():.1f} grey levels of deviation)"
        parts.append(f"{name} {likeness[method].mean():.3f} {spread}")
    words = (
        "Autocorrelation of neighbouring range lines above the surface, zero for noise: "
        f"{', '.join(parts)}. cGAN less observed"
    )
    return _paired(likeness["cgan"] - likeness["observed"], "", words)


def _scores(intervals, output, metric="ods"):
    """Rows of one score of one output by training set."""
    chosen = intervals[(intervals["output"] == output) & (intervals["metric"] == metric)]
    return chosen.set_index("training_set")


def _difference(row):
    """A difference to RD with its interval, as text."""
    value, low, high = row[["difference", "difference_low", "difference_high"]].map(signed)
    return f"{value} [{low}, {high}]"


def trainings(row):
    """How many trainings a difference rests on, and whether they are too few."""
    n = int(row["n_replicas"])
    few = f": indicative, fewer than {ENOUGH_TRAININGS}" if n < ENOUGH_TRAININGS else ""
    return f"{n} trainings of each set{few}."


def augmentation(intervals, metric):
    """Differences of one fused score to RD's."""
    rows = _scores(intervals, "fuse", metric)
    outcomes = []
    parts = []
    for key, name in SETS.items():
        row = rows.loc[key]
        outcome = side_of_zero(row["difference_low"], row["difference_high"])
        outcomes.append(outcome)
        parts.append(f"{name} {_difference(row)} ({outcome})")
    rule = (
        "Confirmed where all three training sets gain, contradicted where one of them loses, else "
        f"not resolved. {BY_BOOTSTRAP}"
    )
    numbers = f"Difference to RD with 95 % interval: {'; '.join(parts)}."
    return Claim(all_of(outcomes), numbers, rule, trainings(row))


def best_fuse(intervals):
    """Differences of fused ODS to RD's, RD+PD's against those of the other sets."""
    rows = _scores(intervals, "fuse")
    ours = rows.loc["rd_pd"]
    others = rows.loc[["rd_gd", "rd_pd_gd"]]
    # Zero is RD's difference to itself.
    if max(0, others["difference_low"].max()) > ours["difference_high"]:
        outcome = CONTRADICTED
    elif max(0, others["difference_high"].max()) < ours["difference_low"]:
        outcome = CONFIRMED
    else:
        outcome = OPEN
    names = {"rd": "RD"} | SETS
    means = ", ".join(f"{name} {rows.loc[key, 'mean']:.3f}" for key, name in names.items())
    rule = (
        "Confirmed where the interval of RD+PD less RD lies above zero and above those of the "
        "other sets; contradicted where it lies below zero or below one of them; else not "
        f"resolved. {BY_BOOTSTRAP}"
    )
    numbers = f"{means}. RD+PD less RD {_difference(ours)}."
    return Claim(outcome, numbers, rule, trainings(ours))


def best_sides(intervals):
    """Where RD+GD has the best score of a side output."""
    n_best = n_gains = 0
    parts = []
    for side, metric in product(range(1, 6), METRICS):
        rows = _scores(intervals, f"side_{side}", metric)
        row = rows.loc["rd_gd"]
        if rows["mean"].idxmax() != "rd_gd":
            continue
        n_best += 1
        n_gains += row["difference_low"] > 0
        parts.append(f"side {side} {metric.upper()} {_difference(row)}")
    n_scores = 5 * len(METRICS)
    if n_gains >= n_scores - FEW_EXCEPTIONS:
        outcome = CONFIRMED
    elif n_best < n_scores - FEW_EXCEPTIONS:
        outcome = CONTRADICTED
    else:
        outcome = OPEN
    leads = f": {'; '.join(parts)} less RD" if parts else ""
    numbers = f"The best of the four sets in {n_best} of {n_scores} scores{leads}."
    rule = (
        f"Confirmed where RD+GD leads, with an interval above zero, in all but {FEW_EXCEPTIONS} of "
        f"{n_scores} scores (ODS, OIS, AP), contradicted where other sets lead in more, else not "
        f"resolved. {BY_BOOTSTRAP}"
    )
    caveat = f"In the paper's own Table III it leads in 7 of 15. {trainings(row)}"
    return Claim(outcome, numbers, rule, caveat)


def all_outputs(intervals):
    """On which outputs synthetic scenes raise the ODS."""
    parts = []
    outcomes = []
    for output in OUTPUTS:
        rows = _scores(intervals, output).loc[list(SETS)]
        best = rows.loc[rows["difference"].idxmax()]
        name = output.replace("_", " ")
        parts.append(f"{name} {SETS[best.name]} {_difference(best)}")
        highest = rows["difference_high"].max()
        outcomes.append(side_of_zero(best["difference_low"], highest))
    rule = (
        "Confirmed where on every output the best of the three sets gains, contradicted where on "
        f"one output all three lose, else not resolved. {BY_BOOTSTRAP}"
    )
    numbers = f"ODS of the best set less RD's: {'; '.join(parts)}."
    return Claim(all_of(outcomes), numbers, rule, trainings(best))


def fifth_side(intervals):
    """Differences of the ODS of side output 5 to RD's."""
    rows = _scores(intervals, "side_5")
    outcomes = []
    parts = []
    for key, name in SETS.items():
        row = rows.loc[key]
        outcomes.append(side_of_zero(-row["difference_high"], -row["difference_low"]))
        parts.append(f"{name} {_difference(row)}")
    rule = (
        "Confirmed where all three sets lose, contradicted where one of them gains, else not "
        f"resolved. {BY_BOOTSTRAP}"
    )
    return Claim(all_of(outcomes), f"ODS less RD's: {'; '.join(parts)}.", rule, trainings(row))


def gaussian(tests):
    """How many tests reject that block means and undulations of thickness are Gaussian."""
    parts = []
    agrees = True
    for what, of_one in tests.groupby("of", sort=False):
        n_rejected = int((of_one["p_value_correlated"] < SIGNIFICANT).sum())
        by_chance = int(stats.binom.ppf(0.975, len(of_one), SIGNIFICANT))
        agrees &= n_rejected <= by_chance
        parts.append(f"{what} {n_rejected} of {len(of_one)} (by chance up to {by_chance})")
    numbers = f"Tests by zone and slab that reject a Gaussian at 5 %: {'; '.join(parts)}."
    rule = (
        "Confirmed where no more tests reject than 97.5 % of chances allow, else contradicted; "
        "p-values allow for correlation along the flight."
    )
    caveat = "The reference flight draws thickness from another law: see its independence."
    return Claim(CONFIRMED if agrees else CONTRADICTED, numbers, rule, caveat)


def same_distribution(thickness):
    """Distance of thickness in label sets from the flight's, by zone."""
    parts = []
    agrees = True
    for zone, of_zone in thickness[thickness["slab"] < 0].groupby("zone"):
        counts = of_zone.sort_values("low_bins")[["n_observed", "n_synthetic"]]
        n = counts.sum()
        shares = counts.cumsum() / n
        distance = (shares["n_observed"] - shares["n_synthetic"]).abs().max()
        # Smirnov's for two samples, at 5 %.
        critical = 1.358 * np.sqrt(n.sum() / n.prod())
        agrees &= distance <= critical
        parts.append(f"zone {zone} {distance:.2f} of {critical:.2f}")
    rule = (
        "Confirmed where the largest difference of the two distribution functions lies within that "
        "of two samples of one law (95 %), in all zones; else contradicted."
    )
    numbers = f"Largest difference, and its limit: {'; '.join(parts)}."
    caveat = "Blocks are correlated along the flight, which the limit neglects."
    return Claim(CONFIRMED if agrees else CONTRADICTED, numbers, rule, caveat)


def same_spectra(spectra):
    """Departure of the spectra of thickness in label sets from the flight's."""
    ratio = spectra["synthetic"] / spectra["observed"]
    known = ratio[np.isfinite(ratio) & (ratio > 0)]
    off_db = 10 * np.log10(known)
    octave = np.floor(np.log2(spectra.loc[known.index, "wavenumber"]))
    by_octave = off_db.groupby(octave).median()
    worst_db = by_octave.abs().max()
    agrees = worst_db < MOST_SPECTRUM_DB
    numbers = (
        f"Label sets over flight, median of zones and slabs: off by {worst_db:.2f} dB in the worst "
        f"octave, by {by_octave.abs().median():.2f} dB in the median octave."
    )
    rule = f"Confirmed where every octave is within {MOST_SPECTRUM_DB:g} dB, else contradicted."
    return Claim(CONFIRMED if agrees else CONTRADICTED, numbers, rule)


def observed_vary_more(textures):
    """Spread between scenes of grey levels' deviation, observed against rendered."""
    deviation = _of_region(textures, "below", "deviation").dropna()
    parts = [f"observed {deviation['observed'].std():.2f}"]
    outcomes = []
    for method, name in RENDERED.items():
        total = deviation["observed"] + deviation[method]
        excess = deviation["observed"] - deviation[method]
        # Zero where both vary alike: Pitman (1939), Biometrika 31, 9-12.
        interval = stats.pearsonr(total, excess).confidence_interval()
        outcomes.append(side_of_zero(interval.low, interval.high))
        parts.append(f"{name} {deviation[method].std():.2f} ({outcomes[-1]})")
    rule = (
        "Confirmed where observed scenes vary more than the renders of their layers by both "
        "methods, contradicted where less than one of them, by the 95 % interval of the "
        "correlation of sum and difference (Pitman, 1939); else not resolved."
    )
    numbers = (
        "Standard deviation between scenes of the deviation of grey levels below the surface: "
        f"{', '.join(parts)}."
    )
    caveat = "Renders are of the layers of the observed scenes: variety of layers does not count."
    return Claim(all_of(outcomes), numbers, rule, caveat)


def chi_square(tracked):
    """Quantiles of tracked peak power against those of the fitted Gamma law."""
    inner = tracked[tracked["probability"].between(0.01, 0.99)]
    error = (inner["tracked"] / inner["gamma"] - 1).abs()
    worst = inner.loc[error.idxmax(), "probability"]
    numbers = (
        "Quantiles of tracked power over its group's mean, against Gamma of "
        f"{tracked['n_looks'].iloc[0]:.2f} looks: off by {100 * error.max():.1f} % at most, "
        f"at probability {worst:.2f}."
    )
    rule = (
        "Confirmed where quantiles 1 % to 99 % agree within "
        f"{100 * MOST_QUANTILE_ERROR:.0f} %, else contradicted."
    )
    caveat = (
        "The reference flight sums independent scatterers: any other outcome would be surprising."
    )
    agrees = error.max() < MOST_QUANTILE_ERROR
    return Claim(CONFIRMED if agrees else CONTRADICTED, numbers, rule, caveat)


def doppler(realism):
    """Highest over lowest band of the Doppler spectrum."""
    of_doppler = realism["quantity"].str.startswith("Doppler spectrum")
    value = realism.loc[of_doppler, "value"].iloc[0]
    rule = (
        f"Confirmed where its bands differ by less than {MOST_DOPPLER_DB:.0f} dB, contradicted "
        "where by more."
    )
    if not np.isfinite(value):
        return Claim(OPEN, "There is no complex segment to take a spectrum of.", rule)
    outcome = CONFIRMED if value < MOST_DOPPLER_DB else CONTRADICTED
    numbers = f"Highest over lowest band of the mean spectrum of layers 1 to 15: {value:.2f} dB."
    return Claim(outcome, numbers, rule, "Flat by construction of the reference flight.")


def equal_looks(config):
    """Looks of PHY and of the observed scenes, both settings."""
    rule = "Compares two settings."
    if config["source"] != "reference":
        return Claim(OPEN, "How many looks the scenes have is not known.", rule)
    ours = config["phy"]["n_looks"]
    observed = config["benchmark"]["n_looks"]
    numbers = f"phy.n_looks is {ours}, benchmark.n_looks {observed}."
    outcome = CONFIRMED if ours == observed else CONTRADICTED
    return Claim(outcome, numbers, rule, "PHY is given this number.")


def _convolution_errors(convolution):
    """Errors of PHY's scene and of the convolution on fine layering [dB], and scenes by method."""
    scenes = convolution[convolution["part"] == "scene"]
    scene_db = scenes.loc[scenes["method"] == "PHY", "error_db"].iloc[0]
    layered = convolution.query("sweep == 'fine layering' and method == 'convolution'")
    layering_db = layered.loc[layered["value"] == LAYERING_KG_M3, "error_db"].max()
    return scene_db, layering_db, scenes


def captures(convolution):
    """Error of the convolution against a coherent solver."""
    scene_db, layering_db, _ = _convolution_errors(convolution)
    n_within = sum([scene_db < SPECKLE_DB, layering_db < SPECKLE_DB])
    outcome = (CONTRADICTED, OPEN, CONFIRMED)[n_within]
    numbers = (
        f"Mean power against a coherent solver: off by {scene_db:.2f} dB on smooth layers, by "
        f"{layering_db:.2f} dB with fine layering of {LAYERING_KG_M3} kg m-3 as in density logs."
    )
    rule = (
        f"Confirmed where both lie below the speckle of 100 looks, {SPECKLE_DB:.2f} dB, "
        "contradicted where both lie above, else not resolved."
    )
    return Claim(outcome, numbers, rule, "The solver is one-dimensional and has no losses.")


def expensive(convolution):
    """Cost of full-wave scenes, and error of PHY without."""
    scene_db, layering_db, scenes = _convolution_errors(convolution)
    seconds = scenes.groupby("method")["seconds"].min()
    solver_s = seconds["transfer matrix, stack"]
    ratio = solver_s / seconds["PHY"]
    error_db = np.fmax(scene_db, layering_db)
    if ratio > MANY_TIMES and error_db < SPECKLE_DB:
        outcome = CONFIRMED
    elif ratio < MANY_TIMES and error_db > SPECKLE_DB:
        outcome = CONTRADICTED
    else:
        outcome = OPEN
    numbers = (
        f"A scene by a coherent solver with all multiples: {solver_s:.3g} s, by PHY "
        f"{1e3 * seconds['PHY']:.2g} ms, {ratio:,.0f} times less. What PHY's convolution leaves "
        f"out: {scene_db:.2f} dB on smooth layers, {layering_db:.2f} dB with fine layering of "
        f"{LAYERING_KG_M3} kg m-3 as in density logs (speckle of 100 looks: {SPECKLE_DB:.2f} dB). "
        "What a tracker would gain is not known."
    )
    rule = (
        f"Confirmed where the solver costs more than {MANY_TIMES} times as much and both errors "
        "lie below the speckle of 100 looks; contradicted where it costs less and one lies above; "
        "else not resolved."
    )
    caveat = (
        "The solver is a transfer matrix in one dimension, on stacks of the reference flight's "
        "layers: FDTD in two or three costs more, and sees what this one cannot."
    )
    return Claim(outcome, numbers, rule, caveat)


more_ssim = partial(better_similarity, metric="ssim", sign=1, unit="")
more_psnr = partial(better_similarity, metric="psnr", sign=1, unit="dB")
less_rmse = partial(better_similarity, metric="rmse", sign=-1, unit="grey levels")
phy_above = partial(better_region, region="above", better="phy")
cgan_below = partial(better_region, region="below", better="cgan")
more_ods = partial(augmentation, metric="ods")
more_ois = partial(augmentation, metric="ois")
# Claim, table by the name of its file, rule; in the order of the paper.
CLAIMS = (
    ("PHY follows the curvature of layers better than the cGAN.", "render_positions", curvature),
    ("The cGAN has the better texture.", "render_texture", texture),
    ("The cGAN has the better contrast.", "render_texture", contrast),
    ("The cGAN has the better SSIM.", "similarity", more_ssim),
    ("The cGAN has the better PSNR.", "similarity", more_psnr),
    ("The cGAN has the better RMSE.", "similarity", less_rmse),
    ("PHY is better above the surface.", "render_texture", phy_above),
    ("The cGAN adds texture above the surface.", "render_texture", needless_texture),
    ("The cGAN is better below the surface.", "render_texture", cgan_below),
    ("Augmentation raises the fused output's ODS.", "table3_intervals", more_ods),
    ("Augmentation raises the fused output's OIS.", "table3_intervals", more_ois),
    ("RD+PD gives the best fused ODS.", "table3_intervals", best_fuse),
    ("Synthetic data can improve all outputs.", "table3_intervals", all_outputs),
    (
        "RD+GD gives the best side outputs in almost all metrics.",
        "table3_intervals",
        best_sides,
    ),
    ("Side output 5 gets worse with synthetic data.", "table3_intervals", fifth_side),
    ("Observed scenes vary more than simulated ones.", "render_texture", observed_vary_more),
    ("Thickness and relative thickness are Gaussian.", "validation_tests", gaussian),
    (
        "Thickness in label sets has the flight's distribution.",
        "validation_thickness",
        same_distribution,
    ),
    ("Thickness in label sets has the flight's spectra.", "label_spectra", same_spectra),
    (
        "The convolution captures what shapes an echogram.",
        "convolution_accuracy",
        captures,
    ),
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
    """Outcomes of all claims, from tables by the names of their files; "no table" where one lacks.

    `synthetic`: the run is of the reference flight, which was built to have what some claims say.
    """
    found = []
    for words, needed, rule_of in CLAIMS:
        if needed in tables:
            claim = rule_of(tables[needed])
        else:
            claim = Claim(MISSING, f"Needs {needed}, which this run did not make.", "")
        built_in = synthetic and rule_of in BUILT_IN and claim.outcome == CONFIRMED
        found.append(replace(claim, claim=words, tables=(needed,), by_construction=built_in))
    return found
