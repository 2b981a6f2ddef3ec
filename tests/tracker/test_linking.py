"""Candidates become layers: joined through gaps, apart from each other, in order."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from refusals import refusal
from scipy.special import logit

from snowsim.echogram import check_layer_bins, layer_mask
from snowsim.tracker import (
    Candidates,
    Linking,
    Piece,
    confidence,
    confident_pieces,
    features,
    half_width_rows,
    join,
    link,
    pick_layers,
)

EVEN = 0.0


def candidates_of(lines):
    """Candidates of lists of (row, log-odds) by range line."""
    first = np.cumsum([0, *map(len, lines)])
    rows, log_odds = np.array([peak for line in lines for peak in sorted(line)]).reshape(-1, 2).T
    return Candidates(first, rows.astype(np.float32), log_odds.astype(np.float32))


def test_the_way_through_a_fade_is_the_one_with_more_evidence():
    # Two ways between the halves of a layer: straight, and weaker, or round by 2 rows.
    lines = []
    for line in range(260):
        fade = 120 <= line < 140
        lines.append([(50.0, 0.1), (56.0, 1.0)] if fade else [(50.0, 1.0)])
    (piece, *_) = link(candidates_of(lines), Linking(), EVEN)
    assert_array_equal(piece.row, 50)  # two steps of 6 rows cost more than a fade gains


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_layers_never_cross_whatever_the_candidates_are(seed):
    rng = np.random.default_rng(seed)
    n_lines = 120
    lines = []
    for _ in range(n_lines):
        rows = np.unique(rng.uniform(0, 60, rng.integers(0, 25)).round(1))
        lines.append([(row, rng.normal(0.6, 1)) for row in rows])
    # So that many chains are taken.
    pieces = join(link(candidates_of(lines), Linking(evidence_log_odds=12.0), EVEN))
    layers = np.full((len(pieces), n_lines), np.nan)
    for layer, piece in zip(layers, pieces, strict=True):
        layer[piece.line] = piece.row
    check_layer_bins(layers)


@pytest.mark.parametrize(("slope", "is_found"), [(1.2, True), (1.36, False)])
def test_a_layer_may_be_as_steep_as_its_evidence_outweighs_its_bend(slope, is_found):
    # Of each line's evidence of 1, half of the squared step is lost: .28 and .08 are left, and a
    # chain needs 55 on 256 lines.
    lines = [[(slope * line, 1.5)] for line in range(256)]
    assert len(link(candidates_of(lines), Linking(), EVEN)) == is_found


@pytest.mark.parametrize(("slope", "is_found"), [(0.5, True), (0.68, False)])
def test_a_step_over_a_gap_costs_as_much_as_the_slope_on_both_lines(slope, is_found):
    # Of the evidence on every other line, .5 is lost for the line between, and on two lines half of
    # the squared slope each: .25 and .04 are left for 300 candidates.
    lines = [[(slope * line, 1.5)] if line % 2 == 0 else [] for line in range(600)]
    assert len(link(candidates_of(lines), Linking(), EVEN)) == is_found


@pytest.mark.parametrize(("n_lines", "is_found"), [(100, True), (256, False), (500, False)])
def test_a_narrow_frame_asks_for_less_evidence_in_proportion(n_lines, is_found):
    # A layer over 100 lines with an evidence of 50: 55 are asked for on 256 lines, 21 on 100.
    lines = [[(50.0, 0.5)] if line < 100 else [] for line in range(n_lines)]
    assert len(link(candidates_of(lines), Linking(), EVEN)) == is_found


def piece_of(first, stop, row, slope=0.0):
    line = np.arange(first, stop)
    return Piece(line, row + slope * line, np.ones(line.size))


@pytest.mark.parametrize(("gap", "longest"), [(50, 300), (1000, 2000)])
def test_pieces_join_where_the_layers_beside_them_foretell_it_and_not_elsewhere(gap, longest):
    above = piece_of(0, longest, 30, 0.05)
    left = piece_of(0, 100, 50, 0.06)
    right = piece_of(100 + gap, longest, 50, 0.06)
    # Half-way between two layers that part, it stays half-way.
    beneath = piece_of(0, longest, 70, 0.07)
    joined = join([beneath, right, left, above])
    assert [piece.line.size for piece in joined] == [longest, longest - gap, longest]
    off = piece_of(100 + gap, longest, 57, 0.06)
    assert len(join([above, left, off, beneath])) == 4


@pytest.mark.parametrize(("gap", "off", "n_layers"), [(20, 1.9, 2), (20, 2.6, 3), (150, 3.3, 2)])
def test_what_foretells_a_piece_may_err_by_two_rows_and_one_more_in_a_hundred_lines(
    gap, off, n_layers
):
    above = piece_of(0, 400, 30)
    pieces = [above, piece_of(0, 100, 50), piece_of(100 + gap, 400, 50 + off)]
    assert len(join(pieces)) == n_layers


def test_the_row_at_the_end_of_a_piece_is_that_of_its_last_lines():
    above = piece_of(0, 300, 30)
    # Over the last 10 lines it lies .8 rows above its end, over 40 lines 3.
    sinks = piece_of(0, 100, 50, slope=0.15)
    goes_on = piece_of(106, 300, 65)
    assert len(join([above, sinks, goes_on])) == 2


def test_pieces_with_layers_between_them_are_not_joined():
    left = piece_of(0, 50, 100)
    beneath = piece_of(0, 70, 110)
    # Below the one beneath, then above the row of the first.
    rises = Piece(np.arange(55, 120), np.linspace(114, 84, 65), np.ones(65))
    right = piece_of(100, 120, 100)
    assert len(join([left, beneath, rises, right])) == 4


def test_pieces_that_cross_where_one_has_no_pick_are_all_kept():
    level = piece_of(0, 300, 50)
    dips = Piece(np.arange(300), np.where(np.arange(300) < 100, 46.0, 56.0), np.ones(300))
    # Where it begins, the one that dips has come to lie beneath the level one.
    begins = piece_of(150, 300, 70)
    found = join([begins, dips, level])
    assert [piece.row.mean() for piece in found] == [50, dips.row.mean(), 70]


def test_confidence_grows_with_evidence_and_intervals_shrink_with_it():
    weak, strong = (Piece(np.arange(200), np.full(200, 9.0), np.full(200, x)) for x in (0.2, 2.0))
    coefficients = (-0.6, 0.1, 1.1)
    low, high = (confidence(piece, 200, coefficients) for piece in (weak, strong))
    assert (low < high).all()
    # As sure at the end of a frame as in its middle.
    assert_allclose(high, high[0])
    # Less sure where the chain ends within the frame.
    ends = confidence(strong, 400, coefficients)
    assert ends[-1] < ends[100]
    assert (half_width_rows(high) < half_width_rows(low)).all()


def test_the_inputs_of_confidence_are_means_over_17_and_97_lines_of_clipped_log_odds(rng):
    n_lines = 200
    line = np.flatnonzero(rng.random(n_lines) < 0.7)[5:]
    piece = Piece(line, np.full(line.size, 50.0), rng.normal(1, 3, line.size))
    excess = np.zeros(n_lines)
    excess[line] = np.clip(piece.excess, -3, 3)
    slow = [
        [excess[max(at - reach, 0) : at + reach + 1].mean() for at in line] for reach in (8, 48)
    ]
    assert_allclose(features(piece, n_lines), slow, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("sure", "n_kept"), [(0.3, 0), (0.38, 0), (0.42, 1), (0.8, 1)])
def test_a_piece_that_is_more_probably_no_layer_is_left_out(sure, n_kept):
    piece = piece_of(0, 300, 50.0)
    kept = confident_pieces([piece], 300, (logit(sure), 0.0, 0.0))
    assert len(kept) == n_kept
    for _, sure_of_picks in kept:
        assert_allclose(sure_of_picks, sure)


def test_a_few_sure_picks_do_not_keep_a_piece():
    line = np.arange(300)
    piece = Piece(line, np.full(300, 50.0), np.where(line < 40, 3.0, 0.0))
    coefficients = (-1.5, 2.0, 0.0)
    sure = confidence(piece, 300, coefficients)
    assert sure.max() > 0.9
    assert sure.mean() < 0.4
    assert confident_pieces([piece], 300, coefficients) == []


def test_layers_of_a_mask_are_picked_at_the_middle_of_their_pixels(layer_bins):
    layer_bins[3, :50] = np.nan
    layer_bins[5, 60:] = np.nan
    mask = layer_mask(layer_bins, 320)
    assert_array_equal(pick_layers(mask, threshold=0.5), np.rint(layer_bins))
    thick = mask | np.roll(mask, 1, axis=0) | np.roll(mask, -1, axis=0)
    assert_array_equal(pick_layers(thick, threshold=0.5), np.rint(layer_bins))


def test_gaps_are_bridged_up_to_the_longest_and_specks_are_dropped():
    mask = np.zeros((60, 256))
    mask[20] = 1
    mask[20, 100:105] = 0  # five skipped lines
    mask[40] = 1
    mask[40, 100:120] = 0  # a fade: two pieces, the longer first
    mask[50, 30:60] = 1
    picks = pick_layers(mask, threshold=0.5)
    assert np.isfinite(picks).sum(axis=1).tolist() == [256, 136, 100]
    assert pick_layers(np.zeros((50, 60)), threshold=0.5).shape == (0, 60)


@pytest.mark.parametrize(
    ("largest", "threshold", "message"),
    [
        (255, 0.5, "map: probability must be finite, at least 0, at most 1, got 255"),
        (1, 0.0, "map: threshold must be finite, above 0"),
    ],
)
def test_maps_and_thresholds_beyond_their_limits_are_refused(largest, threshold, message):
    with refusal(message):
        pick_layers(np.full((9, 9), largest), threshold=threshold, where="map")
