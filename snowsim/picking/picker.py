"""Frames to layers with one network: evidence of each, linked over all that follow one another."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import map_coordinates, uniform_filter
from scipy.special import expit, logit

from snowsim.echogram import crossing_layers
from snowsim.limits import check_values
from snowsim.picking.candidates import Candidates, find_candidates, joined
from snowsim.picking.canonical import Canonical
from snowsim.picking.confidence import confidence
from snowsim.picking.joining import downwards, join
from snowsim.picking.layers import layers_of, on_lines
from snowsim.picking.linking import Linking, Piece, link
from snowsim.picking.windows import log_odds_by_lines

# A candidate so near to the surface is the surface.
SURFACE_ROWS = 3.0
MEAN_OVER = (5, 33)  # rows and range lines, to tell echoes from noise
CERTAIN = (1e-6, 1 - 1e-6)  # probabilities beyond count as these


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the network saw in a frame.

    `surface` are rows, and `surface_excess` log-odds above even ones, on range lines of the image.
    """

    canonical: Canonical
    candidates: Candidates
    surface: np.ndarray
    surface_excess: np.ndarray

    def without_data(self):
        """The same, holding the echogram's along-track variables alone."""
        echogram = self.canonical.echogram.drop_vars("Data")
        return replace(self, canonical=replace(self.canonical, echogram=echogram))


def evidence_of(run, canonical, card, linking=None):
    """`Evidence` of a canonical frame; `run` gives logits of a stack of inputs."""
    linking = linking or Linking()
    even = card.threshold_log_odds + linking.even
    grid = canonical.grid
    parts = []
    for _, logits, image in log_odds_by_lines(run, canonical.image, grid.n_rows, grid.n_lines):
        log_odds = logits / np.float32(card.temperature)
        found = find_candidates(log_odds, even - linking.skipped)
        deepest = deepest_row(image, canonical.grey(card.echo_db))
        parts.append(found.where(found.row <= deepest[found.line]))
    candidates = joined(parts)
    surface = grid.averaged(grid.surface_row)
    return _split_surface(canonical, candidates, surface, even, linking.apart)


def deepest_row(image, grey):
    """The deepest row on each range line that is brighter than so much in the mean around it."""
    bright = uniform_filter(image.astype(np.float32), MEAN_OVER, mode="nearest") > grey
    return np.where(bright.any(axis=0), len(image) - bright[::-1].argmax(axis=0), 0)


def _split_surface(canonical, candidates, surface, even, apart):
    """Evidence: the candidate nearest the surface on every line is it.

    Others near it are none, nor are those at the lower end of the window: both are edges.
    """
    line = candidates.line
    off = candidates.row - surface[line]
    rows = surface.copy()
    excess = np.full(rows.size, -1.0)
    near = np.flatnonzero(np.abs(off) <= SURFACE_ROWS)
    near = near[np.argsort(-np.abs(off[near]), kind="stable")]  # the nearest comes last, and stays
    rows[line[near]] = candidates.row[near]
    excess[line[near]] = candidates.log_odds[near] - even
    below = candidates.row > rows[line] + apart
    inside = candidates.row < canonical.grid.bottom[line] - apart
    return Evidence(canonical, candidates.where(below & inside), rows, excess)


def linked(candidates, linking, threshold):
    """Layers of candidates downwards, list of `Piece`; see `link` and `join`."""
    return join(link(candidates, linking, threshold))


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
        Fractional range bins, strictly increasing with layer, NaN without a pick. Skipped lines of
        a chain are filled straight, as many as `Linking.longest` allows.

    Raises
    ------
    ValueError
        If a probability or the threshold lies outside its limits.
    """
    probability = np.asarray(probability, dtype=np.float64)
    check_values(f"{where}: probability", probability, 0, 1)
    check_values(f"{where}: threshold", threshold, 0, np.nextafter(1, 0), above=True)
    linking = Linking()
    even = logit(threshold)
    log_odds = logit(np.clip(probability, *CERTAIN))
    candidates = find_candidates(log_odds, even - linking.skipped)
    lines = np.arange(probability.shape[1])
    pieces = downwards(link(candidates, linking, even))
    rows = [on_lines(piece, piece.excess, lines, linking.longest)[0] for piece in pieces]
    rows = np.array(rows).reshape(-1, lines.size)
    rows[crossing_layers(rows)] = np.nan
    return rows


def layers_of_frames(frames, card, linking=None):
    """Layers datasets of frames that follow one another, list of `Evidence`; all name them alike.

    Layer 0 is the surface, layer i the same in every frame; a frame holds those picked in it.
    """
    linking = linking or Linking()
    candidates = joined([frame.candidates for frame in frames])
    pieces = linked(candidates, linking, card.threshold_log_odds)
    n_lines = candidates.n_lines
    sure = [
        (piece, confidence(piece, n_lines, card.confidence))
        for piece in (_surface(frames), *pieces)
    ]
    layers = []
    first_line = 0
    for frame in frames:
        layers.append(layers_of(frame.canonical, sure, first_line, linking.longest))
        first_line += frame.canonical.grid.n_lines
    return layers


def _surface(frames):
    """The surface of frames as a `Piece` of the range lines on which something was recorded."""
    rows = np.concatenate([frame.surface for frame in frames])
    excess = np.concatenate([frame.surface_excess for frame in frames])
    recorded = np.concatenate([frame.canonical.recorded for frame in frames])
    return Piece(np.flatnonzero(recorded), rows[recorded], excess[recorded])


def probability_of(run, canonical, card):
    """Probability of a layer at every pixel of an echogram, float32 (range_bin, range_line).

    Linear between rows of the image and between its range lines; NaN where it has none.
    """
    grid = canonical.grid
    probability = np.empty((grid.n_rows, grid.n_lines), dtype=np.float32)
    for first, logits, _ in log_odds_by_lines(run, canonical.image, grid.n_rows, grid.n_lines):
        stop = first + logits.shape[1]
        probability[:, first:stop] = expit(logits / np.float32(card.temperature))
    rows = grid.row(canonical.echogram["twtt"].values)
    lines = np.broadcast_to(grid.line, rows.shape)
    return map_coordinates(probability, [rows, lines], order=1, cval=np.nan)
