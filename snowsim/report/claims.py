"""Every claim of the paper with the tables that bear on it, and its verdict from those there are."""

from functools import partial

import numpy as np

from snowsim.report import render_claims, tracker_claims
from snowsim.report.verdicts import CONFIRMED, CONTRADICTED, MISSING, OPEN, Verdict

MOST_QUANTILE_ERROR = 0.05
MOST_DOPPLER_DB = 3.0
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


def expensive(scenes):
    """More elaborate models cost too much for what they add: cost per pixel, and what is known of their gain."""
    seconds = scenes.assign(ns=scenes["seconds"] / scenes["n_pixels"] * 1e9)
    least = seconds.groupby(["method", "setting"])["ns"].min()
    phy, nature = least.loc["PHY"].min(), least.loc["nature run"].min()
    return Verdict(
        "Models of the FDTD class are too expensive for what they add.",
        OPEN,
        f"Per pixel: PHY {phy:.3g} ns, the reference flight's sum of scatterers {nature:.3g} ns, "
        f"{nature / phy:.0f} times as much, itself far below a solver of Maxwell's equations. "
        "The cost is shown; what such a solver would add is "
        "not: no FDTD model was run.",
        "Confirmed only where a table gives both the cost of such a model and what a tracker gains by it.",
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
    (("speed_accuracy_scenes",), expensive),
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
            sentence = getattr(judge, "keywords", {}).get("sentence", f"{words}.")
            verdict = Verdict(sentence, MISSING, f"Needs {', '.join(missing)}, which this run did not make.", "")
        else:
            verdict = judge(*(tables[name] for name in needed))
        found.append(Verdict(**{**vars(verdict), "tables": needed}))
    return found
