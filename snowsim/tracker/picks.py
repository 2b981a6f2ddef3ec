"""From log-odds to layers: of one scene, or of frames that follow one another."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import map_coordinates, uniform_filter
from scipy.special import expit, logit

from snowsim.echogram import crossing_layers
from snowsim.limits import check_values
from snowsim.tracker.inputs import Canonical
from snowsim.tracker.joining import downwards, join
from snowsim.tracker.layers import confidence, layers_of_frame, likely, on_lines
from snowsim.tracker.linking import LINKING, Candidates, Piece, find_candidates, link
from snowsim.tracker.windows import log_odds_by_lines, to_input

# A candidate so near to the surface is the surface.
SURFACE_ROWS = 3.0
MEAN_OVER = (5, 33)  # rows and range lines, to tell echoes from noise
CERTAIN = (1e-6, 1 - 1e-6)  # probabilities beyond count as these


def pieces_in(log_odds, threshold):
    """Pieces of layers in a map of log-odds (row, range_line), list of `Piece`, strongest first.

    `threshold` are the log-odds from which a peak speaks for a layer.
    """
    return link(find_candidates(log_odds, LINKING, threshold), LINKING, threshold)


def rows_in(log_odds, threshold):
    """Rows of the layers in a map of log-odds, (layer, range_line) downwards, NaN without a pick.

    Each piece is a layer: `join` gives those on either side of a long gap one name.
    """
    pieces = downwards(pieces_in(log_odds, threshold))
    n_lines = log_odds.shape[1]
    lines = np.arange(n_lines)
    rows = np.array([on_lines(piece, piece.row, lines) for piece in pieces]).reshape(-1, n_lines)
    rows[crossing_layers(rows)] = np.nan
    return rows


def rows_in_image(run, image, card):
    """`rows_in` an 8-bit image (row, range_line) that is as the tracker was trained to see it.

    `run` gives log-odds of a stack of inputs.
    """
    return rows_in(run(to_input(image))[0, 0], card.threshold_log_odds)


def pick_layers(probability, *, threshold, where="image"):
    """Layers in a map of the probability of a layer, linked as `snowsim track` links them.

    `snowsim track` also gives the pieces of a layer on either side of a long gap one name; here
    each is a layer.

    Parameters
    ----------
    probability : array_like, (range_bin, range_line)
        In [0, 1]; as a network gives it, or thin.
    threshold : float
        Probability, above 0 and below 1, from which a peak speaks for a layer.
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
    """What the network saw in a frame, whose samples are not kept.

    `surface` are rows, and `surface_excess` log-odds above even ones, on range lines of the
    image.
    """

    canonical: Canonical
    candidates: Candidates
    surface: np.ndarray
    surface_excess: np.ndarray

    @property
    def slow_time(self):
        """Times of the frame's own range lines [UTC], (range_line,)."""
        return self.canonical.echogram["slow_time"].values

    @property
    def n_averaged(self):
        """Own range lines in one of the image."""
        return self.canonical.grid.n_averaged

    @property
    def notes(self):
        """What a reader of the layers should know, tuple of lines."""
        return self.canonical.notes


def evidence_of(run, canonical, card):
    """`Evidence` of a canonical frame; `run` gives log-odds of a stack of inputs."""
    threshold = card.threshold_log_odds
    grid = canonical.grid
    parts = []
    for _, log_odds, image in log_odds_by_lines(run, canonical.image, grid.n_rows, grid.n_lines):
        found = find_candidates(log_odds, LINKING, threshold)
        deepest = deepest_row(image, canonical.grey(card.echo_db))
        parts.append(found.where(found.row <= deepest[found.line]))
    without_samples = replace(canonical, echogram=canonical.echogram.drop_vars("Data"))
    return _split_surface(without_samples, Candidates.concatenated(parts), threshold)


def deepest_row(image, grey):
    """The deepest row on each range line that is brighter than so much in the mean around it."""
    bright = uniform_filter(image.astype(np.float32), MEAN_OVER, mode="nearest") > grey
    return np.where(bright.any(axis=0), len(image) - bright[::-1].argmax(axis=0), 0)


def _split_surface(canonical, candidates, threshold):
    """Evidence: the candidate nearest the surface on every line is it.

    Others near it are none, nor are those at the lower end of the window: both are edges.
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
    return Evidence(canonical, candidates.where(below & inside), rows, excess)


def layers_of_frames(frames, card):
    """Layers datasets of frames that follow one another, list of `Evidence`; all name them alike.

    Layer 0 is the surface, layer i the same in every frame; a frame holds those picked in it.
    """
    candidates = Candidates.concatenated([frame.candidates for frame in frames])
    n_lines = candidates.n_lines
    found = join(link(candidates, LINKING, card.threshold_log_odds))
    surface = _surface(frames)
    sure = confidence(surface, n_lines, card.confidence)
    pieces = [(surface, sure), *likely(found, n_lines, card.confidence)]
    layers = []
    first_line = 0
    for frame in frames:
        layers.append(layers_of_frame(frame.canonical, pieces, first_line))
        first_line += frame.canonical.grid.n_lines
    return layers


def _surface(frames):
    """The surface of frames as a `Piece` of the range lines on which something was recorded."""
    rows = np.concatenate([frame.surface for frame in frames])
    excess = np.concatenate([frame.surface_excess for frame in frames])
    recorded = np.concatenate([frame.canonical.recorded for frame in frames])
    return Piece(np.flatnonzero(recorded), rows[recorded], excess[recorded])


def probability_of(run, canonical):
    """Probability of a layer at every pixel of an echogram, float32 (range_bin, range_line).

    Linear between rows of the image and between its range lines; NaN where it has none.
    """
    grid = canonical.grid
    parts = log_odds_by_lines(run, canonical.image, grid.n_rows, grid.n_lines)
    probability = np.concatenate([expit(log_odds) for _, log_odds, _ in parts], axis=1)
    rows = grid.row(canonical.echogram["twtt"].values)
    lines = np.broadcast_to(grid.line, rows.shape)
    return map_coordinates(probability, [rows, lines], order=1, cval=np.nan)
