"""Annotation: how deep horizons can be seen, and an emulated semi-automatic picker."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from snowsim.echogram import crossing_layers

STEPS_BETWEEN = 10  # samples between a layer and the one above it, where its valley is sought
REACH_BINS = 4  # how far from a layer the picker looks for its peak
# A pick further off follows something else; the person who checks removes it.
LAST_TRUSTED_BINS = 3.0
AGAIN_DB = 0.5  # a lost layer is picked again only where it rises this much more


def rise_db(mean_power, layer_bins, n_windows):
    """How much each layer rises over the snow above it in mean power, (layer, window) [dB].

    Power on the layer over the minimum between it and the layer above, each averaged along the
    layers over `n_windows` pieces, so that no single minimum decides; infinite for the surface, NaN
    where the layer leaves the record. `mean_power` (range_bin, range_line) is free of speckle, with
    noise; `layer_bins` (layer, range_line) complete.
    """
    n_bins, n_lines = mean_power.shape
    edges = np.linspace(0, n_lines, n_windows + 1).astype(int)
    step = np.arange(1, STEPS_BETWEEN + 1) / STEPS_BETWEEN
    between = (
        layer_bins[:-1, None] + step[:, None] * np.diff(layer_bins, axis=0)[:, None]
    )  # (slab, step, line)
    whole = np.floor(between).astype(int)
    inside = (whole >= 0) & (whole < n_bins - 1)
    whole = np.clip(whole, 0, n_bins - 2)  # read anywhere, then discarded
    share = between - whole
    lines = np.arange(n_lines)
    sampled = (1 - share) * mean_power[whole, lines] + share * mean_power[whole + 1, lines]
    sampled[~inside] = np.nan
    profile = np.add.reduceat(sampled, edges[:-1], axis=2) / np.diff(edges)
    rise = np.full((len(layer_bins), n_windows), np.inf)
    rise[1:] = 10 * np.log10(profile[:, -1] / profile.min(axis=1))
    return rise


def n_visible_layers(rise, visible_db):
    """Number of layers, surface included and at least 1, down to where horizons fade.

    The deepest horizon whose own rise (layer,) over the whole stretch, see `rise_db`, reaches
    `visible_db` decides: weaker ones between are counted, as a reader who follows the years would.
    """
    seen = np.flatnonzero(rise[1:] >= visible_db)  # NaN compares false
    return 2 + int(seen[-1]) if seen.size else 1


def visible_layers(mean_power, layer_bins, visible_db):
    """Complete layers (layer, range_line) down to where they fade, see `n_visible_layers`."""
    rise = rise_db(mean_power, layer_bins, 1)[:, 0]
    return layer_bins[: n_visible_layers(rise, visible_db)]


def pick_visible(rise, layer_bins, gap_db):
    """Layers with NaN where their own rise, interpolated between the windows' centres, is less than `gap_db`."""
    n_windows, n_lines = rise.shape[1], layer_bins.shape[1]
    centres = (np.arange(n_windows) + 0.5) * n_lines / n_windows - 0.5
    picked = layer_bins.copy()
    for layer in range(1, len(layer_bins)):
        here = np.interp(np.arange(n_lines), centres, rise[layer])
        picked[layer, ~(here >= gap_db)] = np.nan
    return picked


def pick_peaks(power, layer_bins, settings):
    """Layers as a semi-automatic picker finds them on an echogram, (layer, range_line), whole bins, NaN where lost.

    A person marks a layer where it is clearest; from there the picker follows its peak to both
    sides, line by line, at most one bin per line, on an image averaged along track. It loses a
    layer that rises too little over the snow above and below (weak layers, and steep ones, which
    the averaging blurs), picks it up again behind the gap, and drops short pieces. The person who
    checks removes pieces that follow something else: the picker misses pixels, it does not invent
    layers. `power` is linear; the complete `layer_bins` lie inside it.
    """
    n_bins, n_lines = power.shape
    smooth_db = uniform_filter1d(
        10 * np.log10(power), settings.picker_lines, axis=1, mode="nearest"
    )
    near = np.rint(layer_bins).astype(int)
    # Half of the thinner slab beside it: beyond lies another layer.
    gaps = np.diff(layer_bins, axis=0).mean(axis=1)
    reach = np.minimum(np.append(gaps, np.inf), np.insert(gaps, 0, np.inf)) / 2
    offsets = np.arange(-2 * REACH_BINS, 2 * REACH_BINS + 1)
    rows = near[:, None, :] + offsets[:, None]
    outside = (rows < 0) | (rows >= n_bins)
    strip = smooth_db[np.clip(rows, 0, n_bins - 1), np.arange(n_lines)]  # (layer, offset, line)
    strip[outside] = -np.inf
    searched = np.abs(offsets) <= np.maximum(1, np.minimum(REACH_BINS, np.floor(reach)))[:, None]
    followed = _follow(np.where(searched[:, :, None], strip, -np.inf), near)
    rise = _rise_of_peak(strip, followed, reach)

    found = np.zeros(layer_bins.shape, dtype=bool)
    for layer in range(len(layer_bins)):
        found[layer] = _kept(rise[layer], settings)
    picked = near + offsets[followed].astype(float)
    found &= np.abs(picked - layer_bins) <= LAST_TRUSTED_BINS
    picked[~found] = np.nan
    picked[crossing_layers(picked)] = np.nan
    return picked


def _follow(strip, near):
    """Index of the followed peak, (layer, range_line), from the clearest line of each layer to both sides."""
    n_layers, n_offsets, n_lines = strip.shape
    layers = np.arange(n_layers)
    usable = np.where(np.isfinite(strip), strip, np.nan)
    clearness = np.nanmax(usable, axis=1) - np.nanmean(usable, axis=1)
    followed = np.zeros((n_layers, n_lines), dtype=int)
    for seed_side in (1, -1):
        # One sweep for all layers: a layer sits on its seed's peak until the sweep has passed the
        # seed.
        seed = clearness.argmax(axis=1)
        at = strip[layers, :, seed].argmax(axis=1)
        order = range(n_lines) if seed_side == 1 else range(n_lines - 1, -1, -1)
        previous = None
        for line in order:
            active = (line - seed) * seed_side >= 0
            if previous is not None:
                # The strip moves with the rounded layer: the same row is another offset on the next
                # line.
                moved = at + near[:, previous] - near[:, line]
                candidates = np.clip(moved[:, None] + np.array([0, -1, 1]), 0, n_offsets - 1)
                best = strip[layers[:, None], candidates, line].argmax(axis=1)
                stepped = candidates[layers, best]
                at = np.where(active & (line != seed), stepped, at)
            followed[active, line] = at[active]
            previous = line
    return followed


def _rise_of_peak(strip, followed, reach):
    """Peak over the mean of the lowest values above and below it in the strip [dB], (layer, range_line)."""
    n_layers, n_offsets, n_lines = strip.shape
    index = np.arange(n_offsets)[None, :, None]
    distance = index - followed[:, None, :]
    width = np.minimum(2 * REACH_BINS, np.maximum(2, np.ceil(reach)))[:, None, None]
    peak = np.take_along_axis(strip, followed[:, None, :], axis=1)[:, 0]
    known = np.where(np.isfinite(strip), strip, np.inf)
    above = np.where((distance < 0) & (distance >= -width), known, np.inf).min(axis=1)
    below = np.where((distance > 0) & (distance <= width), known, np.inf).min(axis=1)
    valley = np.where(
        np.isfinite(above) & np.isfinite(below), (above + below) / 2, np.minimum(above, below)
    )
    return np.where(np.isfinite(valley), peak - valley, 0.0)


def _kept(rise, settings):
    """Where one layer is found: hysteresis on its smoothed rise, short pieces dropped, bool (range_line,)."""
    smooth = uniform_filter1d(rise, settings.picker_lines, mode="nearest")
    weak = smooth > settings.picker_db
    clear = smooth > settings.picker_db + AGAIN_DB
    edges = np.flatnonzero(np.diff(np.concatenate([[0], weak, [0]])))
    kept = np.zeros(rise.size, dtype=bool)
    for start, end in edges.reshape(-1, 2):
        if clear[start:end].any() and end - start >= settings.shortest_run:
            kept[start:end] = True
    return kept
