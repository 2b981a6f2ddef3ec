"""The atlas of the estimators: all is finite, and the deblended one holds where it should."""

import numpy as np
import pytest

from evaluation.lib import statistics_atlas
from evaluation.lib.statistics_atlas import (
    Planted,
    compared,
    draw_atlas,
    is_finite,
    rules_applied,
    with_gaps,
)
from snowsim import labels
from snowsim.phy import mean_power
from snowsim.seeding import random_stream
from snowsim.statistics import estimate, fit


@pytest.fixture(scope="module")
def borders():
    """The atlas of border cases (a test of the tiny run has the sweeps), and what was fitted."""
    fits = []

    def kept(*summary, **options):
        fits.append(estimate(*summary, **options))
        return fits[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(statistics_atlas, "SWEEPS", {})
        patch.setattr(statistics_atlas, "estimate", kept)
        return draw_atlas(lambda *keys: random_stream(20120429, *keys)), fits


@pytest.fixture(scope="module")
def atlas(borders):
    return borders[0]


def test_what_degrades_stays_finite_through_labels_and_renders(borders, rng):
    atlas, fits = borders
    drawn_from = [fitted for fitted in fits if fitted.attrs["estimator"] == "deblended"]
    for fitted in drawn_from:
        layer_bins = labels.draw(fitted, 32, rng=rng)
        echoes = labels.dress(layer_bins, fitted)
        shapes = (echoes.variance_bins2, echoes.decay_rate)
        power = mean_power(echoes.bins, echoes.power, *shapes, 300)
        assert np.isfinite(power).all(), rules_applied(fitted)
        assert power.max() > 0
    held = (atlas["estimator"] == "deblended") & (atlas["outcome"] != "refused")
    assert len(drawn_from) == atlas.loc[held, "value"].nunique() > 0
    assert not atlas["note"].str.contains("\n").any()


def test_border_cases_end_as_stated(atlas):
    borders = atlas[(atlas["panel"] == "borders") & (atlas["estimator"] == "deblended")]
    by_case = borders.groupby("value")
    outcome = by_case["outcome"].first()
    outcome[by_case["outcome"].agg(set).map(lambda found: "beyond" in found)] = "beyond"
    refused = {
        "no layers",
        "surface alone",
        "less than a block",
        "no air above the surface",
        "layers cross",
    }
    assert set(outcome.index[outcome == "refused"]) == refused
    # What planted layers still say stays within its bounds, but where a layer is hidden, half cut
    # off or hardly picked.
    lost = {"layer never picked", "picks below the record", "first slab picked in one frame"}
    assert set(outcome.index[outcome == "beyond"]) <= lost
    note = by_case["note"].first()
    for case, words in {
        "layer in 4 groups": "1 layers left out",
        "layer in no whole block": "4 of other slabs",
        "gaps in every block": "128 lines of a stretch, for spectra",
        "layer never picked": "1 layers not their own",
        "first slab picked in one frame": "3 blocks placed by other slabs",
        "picks below the record": "picks outside",
        "surface not picked in a frame": "1 frames without surface",
    }.items():
        assert words in note[case], case


def test_only_deblended_returns_what_was_planted(atlas):
    planted = atlas[(atlas["panel"] == "borders") & (atlas["value"] == "as planted")]
    outcome = planted.pivot(index="quantity", columns="estimator", values="outcome")
    assert (outcome["deblended"] == "within").all()
    # The recipe as printed is biased there, as the design says.
    assert outcome.loc["peak_power", "paper"] == "beyond"


def test_gaps_take_the_share_asked_for(rng):
    planted = Planted(n_lines=4000, n_frames=1)
    _, layers = with_gaps(next(planted.frames(rng)), 0.4, rng)
    missing = np.isnan(layers["twtt"].values)
    assert not missing[0].any()
    # 4 layers of 4000 lines in gaps of 24 on average: some 270 gaps, the share to 0.03; allow four
    # of those.
    assert abs(missing[1:].mean() - 0.4) < 0.12
    _, layers = with_gaps(next(planted.frames(rng)), 0.0, rng)
    assert layers["twtt"].notnull().all()


def test_what_is_not_finite_is_reported(rng):
    planted = Planted(n_frames=1)
    frames = list(planted.frames(rng))
    rows = compared("panel", 1.0, planted, frames, "paper")
    assert {row["outcome"] for row in rows} <= {"within", "beyond"}
    fitted = fit(frames)
    assert is_finite(fitted)
    assert rules_applied(fitted) == rows[0]["note"]
    assert not is_finite(fitted.assign(peak_power=fitted["peak_power"] * np.nan))
    assert not is_finite(fitted.assign_attrs(n_looks=np.inf))
