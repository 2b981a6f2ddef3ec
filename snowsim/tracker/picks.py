"""Layers from log-odds, in one scene or in frames that follow one another."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.special import expit, logit

from snowsim.echogram import crossing_layers
from snowsim.limits import check_values
from snowsim.tracker.inputs import Canonical
from snowsim.tracker.joining import join, sort_downwards
from snowsim.tracker.layers import (
    POSITIONS,
    confidence,
    confident_pieces,
    layers_of_frame,
    on_lines,
)
from snowsim.tracker.linking import LINKING, Candidates, Piece, find_candidates, link
from snowsim.tracker.windows import log_odds_by_lines, stretches, to_input

SURFACE_ROWS = 3.0  # a candidate within this distance of the surface is the surface
MEAN_OVER = (5, 33)  # rows and range lines over which power is averaged to find echoes
ROWS_BELOW = 16  # rows below the deepest echo that are searched for candidates, so that none is cut
# No surface is where power rises most but the network detects nothing. In simulations this holds on
# at most .06 of the lines, in frames that are upside down on .31 or more.
UNSEEN_SHARE = 0.2
# Variables of an echogram that layers are made of once candidates are found.
USED_LATER = (*POSITIONS, "quality_mask", "flagged")
CERTAIN = (1e-6, 1 - 1e-6)  # probabilities are clipped to these


def pieces_in(log_odds, threshold):
    """Pieces of layers in a map of log-odds (row, range_line), list of `Piece`, strongest first.

    `threshold` is the log-odds above which a peak is evidence for a layer.
    """
    return link(find_candidates(log_odds, LINKING, threshold), LINKING, threshold)


def rows_in(log_odds, threshold):
    """Rows of the layers in a map of log-odds, (layer, range_line) downwards, NaN without pick.

    Each piece is a layer of its own; `join`, which links pieces over long gaps, is not used.
    """
    pieces = sort_downwards(pieces_in(log_odds, threshold))
    n_lines = log_odds.shape[1]
    lines = np.arange(n_lines)
    rows = np.array([on_lines(piece, piece.row, lines) for piece in pieces]).reshape(-1, n_lines)
    rows[crossing_layers(rows)] = np.nan
    return rows


def rows_in_image(run, image, card):
    """Rows of the layers in an 8-bit canonical image (row, range_line), as of `rows_in`.

    `run` gives log-odds of a stack of inputs.
    """
    return rows_in(run(to_input(image))[0, 0], card.threshold_log_odds)


def pick_layers(probability, *, threshold, where="image"):
    """Layers in a map of the probability of a layer, linked as `snowsim track` links them.

    Each linked piece is a layer; `snowsim track` also joins pieces over long gaps.

    Parameters
    ----------
    probability : array_like, (range_bin, range_line)
        In [0, 1], as the output of a network or thinned.
    threshold : float
        Probability, above 0 and below 1, above which a peak is evidence for a layer.
    where : str
        Name of the map, for errors.

    Returns
    -------
    ndarray, (layer, range_line)
        Fractional range bins, strictly increasing with layer, NaN without a pick.

    Raises
    ------
    ValueError
        If a probability or the threshold lies outside its limits.
    """
    probability = np.asarray(probability, dtype=np.float64)
    check_values(f"{where}: probability", probability, 0, 1)
    check_values(f"{where}: threshold", threshold, 0, np.nextafter(1, 0), above=True)
    log_odds = logit(np.clip(probability, *CERTAIN))
    return rows_in(log_odds, logit(threshold))


@dataclass(frozen=True, eq=False)
class Evidence:
    """Candidates for layers in a frame, and its surface, without the samples of the frame.

    On range lines of the canonical image, `surface` is the row of the surface and `surface_excess`
    the log-odds of the surface above the tracker's threshold. `surface_unseen` are the lines, bool,
    on which power rises at this surface but the network detects nothing there.
    """

    canonical: Canonical
    candidates: Candidates
    surface: np.ndarray
    surface_excess: np.ndarray
    surface_unseen: np.ndarray

    @property
    def slow_time(self):
        """Times of the frame's own range lines [UTC], (range_line,)."""
        return self.canonical.echogram["slow_time"].values

    @property
    def n_averaged(self):
        """Number of own range lines averaged in one line of the image."""
        return self.canonical.grid.n_averaged

    @property
    def notes(self):
        """Notes on what limits the layers of this frame, tuple of str."""
        return self.canonical.notes

    def with_notes(self, notes):
        """The same evidence with further notes, before its own."""
        canonical = replace(self.canonical, notes=(*notes, *self.notes))
        return replace(self, canonical=canonical)


def evidence_of(run, canonical, card):
    """`Evidence` in a canonical frame; `run` gives log-odds of a stack of inputs."""
    threshold = card.threshold_log_odds
    parts = []
    for _, image, log_odds_of in stretches(run, canonical.image, canonical.grid.n_lines):
        deepest = deepest_row(image, canonical.grey(card.echo_db))
        # The network need not see the rows of noise alone, which may be most of the frame.
        log_odds = log_odds_of(min(deepest.max() + ROWS_BELOW, len(image)))
        found = find_candidates(log_odds, LINKING, threshold)
        parts.append(found.where(found.row <= deepest[found.line]))
    echogram = canonical.echogram
    without_samples = echogram[[name for name in USED_LATER if name in echogram]]
    without_samples = replace(canonical, echogram=without_samples)
    return _split_surface(without_samples, Candidates.concatenated(parts), threshold)


def deepest_row(image, grey):
    """Deepest row on each range line whose mean over `MEAN_OVER` is brighter than `grey`."""
    n_rows, n_lines = MEAN_OVER
    padded = np.pad(image, ((n_rows // 2,) * 2, (n_lines // 2,) * 2), mode="edge")
    of_rows = np.zeros((len(image), padded.shape[1]), np.uint16)
    for row in range(n_rows):
        of_rows += padded[row : row + len(image)]
    total = np.zeros((len(image), padded.shape[1] + 1), np.int32)
    np.cumsum(of_rows, axis=1, dtype=np.int32, out=total[:, 1:])
    bright = total[:, n_lines:] - total[:, :-n_lines] > grey * (n_rows * n_lines)
    return np.where(bright.any(axis=0), len(image) - bright[::-1].argmax(axis=0), 0)


def _split_surface(canonical, candidates, threshold):
    """`Evidence` with the candidate nearest the surface on every line taken as the surface.

    Other candidates near the surface and those at the lower end of the window are dropped, because
    they are edges and no layers.
    """
    grid = canonical.grid
    line = candidates.line
    rows = grid.averaged(grid.surface_row)
    off = candidates.row - rows[line]
    excess = np.full(rows.size, -1.0)
    near = np.flatnonzero(np.abs(off) <= SURFACE_ROWS)
    near = near[np.argsort(-np.abs(off[near]), kind="stable")]  # the nearest comes last, and stays
    rows[line[near]] = candidates.row[near]
    excess[line[near]] = candidates.log_odds[near] - (threshold + LINKING.even_log_odds)
    below = candidates.row > rows[line] + LINKING.apart_rows
    inside = candidates.row < grid.bottom[line] - LINKING.apart_rows
    seen = np.isin(np.arange(rows.size), line[near])
    unseen = canonical.recorded & ~seen & canonical.surface_found
    n_lines = canonical.recorded.sum()
    if unseen.sum() > UNSEEN_SHARE * n_lines:
        note = (
            f"no surface is detected on {unseen.sum()} of {n_lines} range lines where power rises "
            "most: is the frame upside down, its surface outside the window, or the radar another "
            "one than the tracker's? no pick has quality 1"
        )
        canonical = replace(canonical, notes=(*canonical.notes, note), outside=True)
    return Evidence(canonical, candidates.where(below & inside), rows, excess, unseen)


def layers_of_frames(frames, card):
    """Layers datasets of frames that follow one another, one for each `Evidence`.

    Layer 0 is the surface; layer i is the same layer in every frame. A dataset has only the layers
    that were picked in its frame.
    """
    candidates = Candidates.concatenated([frame.candidates for frame in frames])
    n_lines = candidates.n_lines
    found = join(link(candidates, LINKING, card.threshold_log_odds))
    surface = _surface(frames)
    sure = confidence(surface, n_lines, card.confidence)
    unseen = np.concatenate([frame.surface_unseen for frame in frames])
    sure[unseen[surface.line]] = 0  # of such lines hardly one is right
    pieces = [(surface, sure), *confident_pieces(found, n_lines, card.confidence)]
    layers = []
    first_line = 0
    for frame in frames:
        layers.append(layers_of_frame(frame.canonical, pieces, first_line))
        first_line += frame.canonical.grid.n_lines
    return layers


def _surface(frames):
    """Surface of all frames as one `Piece`, on the range lines on which something was recorded."""
    rows = np.concatenate([frame.surface for frame in frames])
    excess = np.concatenate([frame.surface_excess for frame in frames])
    recorded = np.concatenate([frame.canonical.recorded for frame in frames])
    return Piece(np.flatnonzero(recorded), rows[recorded], excess[recorded])


def probability_of(run, canonical):
    """Probability of a layer at every pixel of an echogram, float32 (range_bin, range_line).

    It is interpolated linearly in the canonical image, and NaN outside that image.
    """
    grid = canonical.grid
    parts = log_odds_by_lines(run, canonical.image, grid.n_rows, grid.n_lines)
    probability = np.concatenate([expit(log_odds) for _, log_odds, _ in parts], axis=1)
    rows = grid.row(canonical.echogram["twtt"].values)
    lines = np.broadcast_to(grid.line, rows.shape)
    return map_coordinates(probability, [rows, lines], order=1, cval=np.nan)
