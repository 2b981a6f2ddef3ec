"""Every claim of the paper with the tables that bear on it, and its verdict from those there are."""

import math
from functools import partial

import numpy as np

from lib.diagnostics import render_claims, tracker_claims
from lib.diagnostics.verdicts import CONFIRMED, CONTRADICTED, MISSING, OPEN, Verdict

MOST_QUANTILE_ERROR = 0.05
MOST_DOPPLER_DB = 3.0
MANY_TIMES = 100
LAYERING_KG_M3 = 50  # detrended near-surface logs: 46-56
SPECKLE_DB = 10 / math.log(10) / math.sqrt(100)  # standard deviation of 100 looks: 0.43 dB
BY_CONSTRUCTION = "The reference flight adds independent scatterers: this could hardly come out otherwise."


def chi_square(tracked):
    """Tracked peak power follows chi-square: quantiles against those of the fitted Gamma law."""
    inner = tracked[tracked["probability"].between(0.01, 0.99)]
    error = (inner["tracked"] / inner["gamma"] - 1).abs()
    worst = inner.loc[error.idxmax()]
    return Verdict(
        "Tracked peak power is chi-square distributed.",
        CONFIRMED if error.max() < MOST_QUANTILE_ERROR else CONTRADICTED,
        f"Quantiles of tracked power over its group's mean, against Gamma of {tracked['n_looks'].iloc[0]:.2f} looks: "
        f"off by {100 * error.max():.1f} % at most, at probability {worst['probability']:.2f}.",
        f"Confirmed where quantiles 1 % to 99 % agree within {100 * MOST_QUANTILE_ERROR:.0f} %, else contradicted.",
        BY_CONSTRUCTION,
    )


def doppler(realism):
    """The Doppler spectrum is flat: highest over lowest band."""
    row = realism[realism["quantity"].str.startswith("Doppler spectrum")].iloc[0]
    value = row["value"]
    known = np.isfinite(value)
    verdict = OPEN if not known else CONFIRMED if value < MOST_DOPPLER_DB else CONTRADICTED
    return Verdict(
        "The Doppler spectrum is flat.",
        verdict,
        f"Highest over lowest band of the mean spectrum of layers 1 to 15: {value:.2f} dB."
        if known
        else "There is no complex segment to take a spectrum of.",
        f"Confirmed where its bands differ by less than {MOST_DOPPLER_DB:.0f} dB, contradicted where by more.",
        "Flat by construction of the reference flight." if known else "",
    )


def expensive(convolution):
    """Models of the FDTD class are too expensive for what they add: cost of full-wave scenes, error of PHY without."""
    scenes = convolution[convolution["part"] == "scene"]
    least = scenes.groupby("method")["seconds"].min()
    scene_db = scenes.loc[scenes["method"] == "PHY", "error_db"].iloc[0]
    layered = convolution[(convolution["sweep"] == "fine layering") & (convolution["method"] == "convolution")]
    layering_db = layered.loc[layered["value"] == LAYERING_KG_M3, "error_db"].max()
    error_db = np.fmax(scene_db, layering_db)
    ratio = least["transfer matrix, stack"] / least["PHY"]
    if ratio > MANY_TIMES and error_db < SPECKLE_DB:
        verdict = CONFIRMED
    else:
        verdict = CONTRADICTED if error_db > SPECKLE_DB and ratio < MANY_TIMES else OPEN
    return Verdict(
        "Models of the FDTD class are too expensive for what they add.",
        verdict,
        f"A scene by a coherent solver with all multiples: {least['transfer matrix, stack']:.3g} s, by PHY "
        f"{1e3 * least['PHY']:.2g} ms, {ratio:,.0f} times less. What PHY's convolution leaves out: "
        f"{scene_db:.2f} dB on smooth layers, {layering_db:.2f} dB with fine layering of {LAYERING_KG_M3} kg m-3 as in "
        f"density logs (speckle of 100 looks: {SPECKLE_DB:.2f} dB). What a tracker would gain is not known.",
        f"Confirmed where the solver costs more than {MANY_TIMES} times as much and both errors lie below the speckle "
        "of 100 looks; contradicted where it costs less and one lies above; else not resolved.",
        "The solver is a transfer matrix in one dimension, on stacks of the reference flight's layers: FDTD in two or "
        "three costs more, and sees what this one cannot.",
    )


CLAIMS = (
    (("render_positions",), render_claims.curvature),
    (("render_texture",), render_claims.texture),
    (("render_texture",), render_claims.contrast),
    (
        ("similarity",),
        partial(
            render_claims.similarity_claim, metric="psnr", sign=1, sentence="The cGAN has the better PSNR.", unit="dB"
        ),
    ),
    (
        ("similarity",),
        partial(
            render_claims.similarity_claim,
            metric="rmse",
            sign=-1,
            sentence="The cGAN has the better RMSE.",
            unit="grey levels",
        ),
    ),
    (
        ("render_texture",),
        partial(render_claims.region_claim, region="above", better="phy", sentence="PHY is better above the surface."),
    ),
    (("render_texture",), render_claims.needless_texture),
    (
        ("render_texture",),
        partial(
            render_claims.region_claim, region="below", better="cgan", sentence="The cGAN is better below the surface."
        ),
    ),
    (("table3_intervals",), partial(tracker_claims.augmentation, metric="ods")),
    (("table3_intervals",), partial(tracker_claims.augmentation, metric="ois")),
    (("table3_intervals",), tracker_claims.best_fuse),
    (("table3_intervals",), tracker_claims.best_sides),
    (("table3_intervals",), tracker_claims.fifth_side),
    (("tracked_power",), chi_square),
    (("realism",), doppler),
    (("convolution_accuracy",), expensive),
)


def judge_claims(tables):
    """Verdicts on all claims.

    Parameters
    ----------
    tables : dict of pandas.DataFrame
        By name of their files, without the ending.

    Returns
    -------
    list of Verdict
        One per claim, in the order of the paper; "no evidence" where a table is missing.
    """
    found = []
    for needed, judge in CLAIMS:
        missing = [name for name in needed if name not in tables]
        if missing:
            words = (judge.func if isinstance(judge, partial) else judge).__doc__.split(":")[0].rstrip(".")
            given = getattr(judge, "keywords", {})
            score = f" ({given['metric'].upper()})" if "metric" in given else ""
            sentence = given.get("sentence", f"{words}{score}.")
            verdict = Verdict(sentence, MISSING, f"Needs {', '.join(missing)}, which this run did not make.", "")
        else:
            verdict = judge(*(tables[name] for name in needed))
        found.append(Verdict(**{**vars(verdict), "tables": needed}))
    return found
