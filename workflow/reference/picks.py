"""Annotation of the reference flight: layers that can be seen, and a semi-automatic picker."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from snowsim.echogram import crossing_layers

STEPS_BETWEEN = 10  # samples between a layer and the one above, among which its valley is sought
REACH_BINS = 4  # distance from a layer within which the picker looks for its peak
# A pick farther from its layer follows something else, and the person who checks removes it.
LAST_TRUSTED_BINS = 3.0
AGAIN_DB = 0.5  # additional rise from which on a lost layer is picked again
N_BITS = 16  # binary places of a power in dB, 1.5e-5: all processors agree on them


def on_grid(values, n_bits):
    """Values as multiples of 2^-`n_bits`, float64 of the same shape: 2.4e-4 for 12."""
    return np.ldexp(np.rint(np.ldexp(np.asarray(values, dtype=float), n_bits)), -n_bits)


def rise_db(mean_power, layer_bins):
    """Rise of each layer over the snow above it in mean power, (layer,) [dB].

    It is the power on the layer over the least power between it and the layer above. Both are
    averaged along the layers, so that no single minimum decides. The surface has an infinite rise;
    a layer that leaves the record has NaN. `mean_power` (range_bin, range_line) holds noise but no
    speckle; `layer_bins` (layer, range_line) are complete.
    """
    n_bins, n_lines = mean_power.shape
    step = np.arange(1, STEPS_BETWEEN + 1)[:, None] / STEPS_BETWEEN
    slab_bins = np.diff(layer_bins, axis=0)[:, None]
    between = layer_bins[:-1, None] + step * slab_bins  # (slab, step, range_line)
    whole = np.floor(between).astype(int)
    inside = (whole >= 0) & (whole < n_bins - 1)
    whole = np.clip(whole, 0, n_bins - 2)  # values read outside are discarded below
    share = between - whole
    lines = np.arange(n_lines)
    above = mean_power[whole, lines]
    below = mean_power[whole + 1, lines]
    sampled = (1 - share) * above + share * below
    sampled[~inside] = np.nan
    profile = np.add.reduceat(sampled, [0], axis=2)[..., 0] / n_lines
    rise = np.full(len(layer_bins), np.inf)
    rise[1:] = 10 * np.log10(profile[:, -1] / profile.min(axis=1))
    return rise


def n_visible_layers(rise, visible_db):
    """Number of layers down to where horizons fade, surface included, at least 1.

    The last one is the deepest horizon whose `rise` (layer,) over the whole stretch, see `rise_db`,
    reaches `visible_db`. Weaker horizons above it count, as a reader who follows the years would
    count them.
    """
    seen = np.flatnonzero(rise[1:] >= visible_db)  # NaN compares false
    return 2 + int(seen[-1]) if seen.size else 1


def visible_layers(mean_power, layer_bins, visible_db):
    """Layers (layer, range_line), without gaps, down to where they fade; see `n_visible_layers`."""
    rise = rise_db(mean_power, layer_bins)
    return layer_bins[: n_visible_layers(rise, visible_db)]


def pick_peaks(power, layer_bins, settings, *, rng):
    """Layers as a semi-automatic picker finds them, (layer, range_line): whole bins, NaN if lost.

    A person marks a layer where it is clearest. From there the picker follows its peak to both
    sides, line by line and by at most one bin a line, on an image averaged along track. It loses a
    layer that rises too little over the snow above and below: a weak one, or a steep one, which the
    averaging blurs. Behind a gap it picks the layer up again; short pieces are dropped. The person
    who checks removes pieces between layers, but in `wrong_share` of the pieces behind a gap takes
    the layer above or below for the one sought. `power` (range_bin, range_line) is linear and holds
    all of the complete `layer_bins`.
    """
    n_bins, n_lines = power.shape
    power_db = on_grid(10 * np.log10(power), N_BITS)
    smooth_db = uniform_filter1d(power_db, settings.picker_lines, axis=1, mode="nearest")
    near = np.rint(layer_bins).astype(int)
    offsets = np.arange(-2 * REACH_BINS, 2 * REACH_BINS + 1)
    rows = near[:, None, :] + offsets[:, None]
    outside = (rows < 0) | (rows >= n_bins)
    strip = smooth_db[np.clip(rows, 0, n_bins - 1), np.arange(n_lines)]  # (layer, offset, line)
    strip[outside] = -np.inf
    # A peak is sought within half of the thinner slab beside its layer: beyond is another layer's.
    slab_bins = np.diff(layer_bins, axis=0).mean(axis=1)
    reach = np.minimum(np.append(slab_bins, np.inf), np.insert(slab_bins, 0, np.inf)) / 2
    searched_bins = np.clip(np.floor(reach), 1, REACH_BINS)
    searched = np.abs(offsets) <= searched_bins[:, None]
    followed = _follow(np.where(searched[:, :, None], strip, -np.inf), near)
    rise = _rise_of_peak(strip, followed, reach)
    found = np.array([_kept(of_layer, settings) for of_layer in rise])
    picked = near + offsets[followed].astype(float)
    found &= np.abs(picked - layer_bins) <= LAST_TRUSTED_BINS
    picked[~found] = np.nan
    picked[crossing_layers(picked)] = np.nan
    return _mistaken(picked, settings.wrong_share, rng=rng)


def _mistaken(picked, wrong_share, *, rng):
    """Picks of which some pieces behind a gap follow the layer above or below instead.

    That layer then has no pick there. Where it had none before, the piece keeps its own picks. The
    surface is never mistaken.
    """
    mistaken = picked.copy()
    for layer in range(1, len(picked)):
        for start, end in _pieces(np.isfinite(picked[layer]))[1:]:
            is_wrong = rng.random() < wrong_share
            followed = layer + rng.choice((-1, 1))
            if not is_wrong or not 1 <= followed < len(picked):
                continue
            lines = start + np.flatnonzero(np.isfinite(picked[followed, start:end]))
            mistaken[layer, lines] = picked[followed, lines]
            mistaken[followed, lines] = np.nan
    mistaken[crossing_layers(mistaken)] = np.nan
    return mistaken


def _pieces(mask):
    """First line of each stretch of true values, and the line after its last, (piece, 2)."""
    return np.flatnonzero(np.diff(np.pad(mask.astype(int), 1))).reshape(-1, 2)


def _follow(strip, near):
    """Offset of the peak that the picker follows from each layer's clearest line on, as an index.

    (layer, range_line); `near` are the whole rows that the middle of `strip` stands for.
    """
    n_layers, n_offsets, n_lines = strip.shape
    layers = np.arange(n_layers)
    usable = np.where(np.isfinite(strip), strip, np.nan)
    clearness = np.nanmax(usable, axis=1) - np.nanmean(usable, axis=1)
    seed = clearness.argmax(axis=1)
    followed = np.zeros((n_layers, n_lines), dtype=int)
    for side in (1, -1):
        # One sweep serves all layers: until it passes a layer's seed, the layer keeps the peak
        # there.
        at = strip[layers, :, seed].argmax(axis=1)
        for line in range(n_lines)[::side]:
            # The strip moves with the rounded layer, so the same row has another offset on the next
            # line. On the first line of the sweep no layer is past its seed.
            before = np.clip(line - side, 0, n_lines - 1)
            moved = at + near[:, before] - near[:, line]
            candidates = np.clip(moved[:, None] + [0, -1, 1], 0, n_offsets - 1)
            best = strip[layers[:, None], candidates, line].argmax(axis=1)
            is_past = (line - seed) * side > 0
            at = np.where(is_past, candidates[layers, best], at)
            is_reached = (line - seed) * side >= 0
            followed[is_reached, line] = at[is_reached]
    return followed


def _rise_of_peak(strip, followed, reach):
    """Peak over the mean of the least values above and below it [dB], (layer, range_line)."""
    index = np.arange(strip.shape[1])[None, :, None]
    distance = index - followed[:, None, :]
    width = np.clip(np.ceil(reach), 2, 2 * REACH_BINS)[:, None, None]
    peak = np.take_along_axis(strip, followed[:, None, :], axis=1)[:, 0]
    known = np.where(np.isfinite(strip), strip, np.inf)
    is_above = (distance < 0) & (distance >= -width)
    is_below = (distance > 0) & (distance <= width)
    above = np.where(is_above, known, np.inf).min(axis=1)
    below = np.where(is_below, known, np.inf).min(axis=1)
    has_both = np.isfinite(above) & np.isfinite(below)
    valley = np.where(has_both, (above + below) / 2, np.minimum(above, below))
    return np.where(np.isfinite(valley), peak - valley, 0.0)


def _kept(rise, settings):
    """Whether a layer is found, bool (range_line,): pieces of some rise, long and clear enough."""
    smooth = uniform_filter1d(rise, settings.picker_lines, mode="nearest")
    weak = smooth > settings.picker_db
    clear = smooth > settings.picker_db + AGAIN_DB
    kept = np.zeros(rise.size, dtype=bool)
    for start, end in _pieces(weak):
        if clear[start:end].any() and end - start >= settings.shortest_run:
            kept[start:end] = True
    return kept
