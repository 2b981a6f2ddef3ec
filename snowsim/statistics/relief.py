"""Change of layers along track: relief of each layer, change of slabs, row of the surface.

Let S_n(h) be the mean square change, over a distance h, of the distance between layers k and
k + n. Layers that undulate by themselves about slabs that change by themselves have ``S_n(h) =
2 R(h) + n A(h)``: R is the mean square change of one layer by itself, ``R(h) = 2 s^2 (1 - exp(-(h /
L)^p))`` of variance s^2 (`relief_variance_bins2`), length L (`relief_length_m`) and exponent p
(`relief_exponent`), a stable variogram; A is that of one slab, ``A(h) = a (h / 1000 m)^q``
(`slab_change_bins2`, `slab_exponent`), a power law. Neglected: slabs that change together, and the
part of the change over a few lines that the mean over `MEAN_LINES` removes, most in rough layers.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from snowsim.constants import KILOMETRE
from snowsim.statistics.summaries import MINIMUM_BLOCKS, in_blocks, known_mean

CHANGE_LAGS = 2 ** np.arange(8)  # [range lines]
# [range lines] Layers are averaged over these, because picks are whole bins and scatter. For smooth
# planted layers in whole bins, .7 to 1.1 of their change over 4 to 64 lines is found, without
# averaging .6 to .9; for rough layers .4 to .8 over 4 lines, and .1 to .5 over one.
MEAN_LINES = 5
MOST_APART = 6  # layers
STILL = 0.1  # root of a change [bins], below which picks in whole bins did not move
TELLING = (1, 6)  # index of the change of layers two apart over 64 lines; a zone needs to know it
EXPONENTS = np.arange(25, 101) / 50  # of relief
SLAB_EXPONENTS = np.arange(2, 40) / 20
ALIKE = 1e-6  # added to the diagonal, so that shapes that are almost alike can be solved for
TINY = 1e-100
# A product levels in whole bins if its steps exceed this share of those that levelling makes.
LEVELLED_SHARE = 0.5
# [range lines] Lengths of relief and of the slow error, from half the shortest lag to 8 times the
# longest.
LENGTHS = 2 ** np.arange(-1, 10.01, 0.125)


def relief_by_zone(depth_bins, zone, n_zones, spacing_m):
    """Variables of relief (zone,), and the number of zones that take the relief of all zones.

    Zones with too few data do so. `depth_bins` (block, layer, range_line) holds layers below the
    surface [bins], NaN in gaps; `zone` (block,) is the zone of each block.
    """
    depth_bins = sliding_window_view(depth_bins, MEAN_LINES, axis=2).mean(axis=-1)
    fits = []
    n_of_all = 0
    for z in range(n_zones):
        change = mean_square_changes(depth_bins[zone == z])
        if np.isnan(change[TELLING]):
            change = mean_square_changes(depth_bins)
            n_of_all += 1
        fits.append(fit_relief(change, CHANGE_LAGS * spacing_m))
    return {name: ("zone", [fit[name] for fit in fits]) for name in fits[0]}, n_of_all


def mean_square_changes(depth_bins):
    """S_n(h) at `CHANGE_LAGS`, (apart, lag), NaN where it is not known.

    Layers are (block, layer, range_line). Changes are between lines without a gap of picks: behind
    a gap, a few in a hundred follow another layer. The estimate is robust, as errors of picks have
    heavier tails than layers (Cressie & Hawkins 1980, Math. Geol. 12, 115, for many pairs). A
    change is unknown (NaN) if fewer than `MINIMUM_BLOCKS` blocks measure it, or if two thirds of
    the distances do not change, which happens with picks in whole bins. With fewer unchanged
    distances, rounded layers give .6 to 1.2 of their true change.
    """
    change = np.full((MOST_APART, CHANGE_LAGS.size), np.nan)
    for apart in range(1, min(MOST_APART + 1, depth_bins.shape[1])):
        distance = depth_bins[:, apart:] - depth_bins[:, :-apart]
        n_gaps = np.cumsum(np.isnan(distance), axis=2)
        for i, lag in enumerate(CHANGE_LAGS):
            root = np.sqrt(np.abs(distance[..., lag:] - distance[..., :-lag]))
            known = np.isfinite(root) & (n_gaps[..., lag:] == n_gaps[..., :-lag])
            enough = known.any(axis=(1, 2)).sum() >= MINIMUM_BLOCKS
            root = root[known]
            if enough and 3 * (root < STILL).sum() < 2 * root.size:
                # Of a Gaussian change, the mean of the root, to the fourth, is 0.457 of the square.
                change[apart - 1, i] = root.mean() ** 4 / 0.457
    return change


def fit_relief(change, lag_m):
    """Five numbers of relief, by name, fitted to changes (apart, lag) over distances (lag,).

    Least squares of relative residuals, because all changes are equally well known. The variances
    are solved for and not negative; exponents and length are chosen from a grid. So the fit ends in
    the same digits on every processor; a search would not, because the residual is flat about its
    minimum. Without layers two apart all change is relief; without changes layers are flat.
    """
    apart, at = np.nonzero(change > 0)
    measured = change[apart, at]
    length_m = lag_m[0] * LENGTHS
    away = lag_m[at] / length_m[:, None, None]
    relief = 4 * (1 - np.exp(-(away ** EXPONENTS[:, None]))) / measured
    slab = (lag_m[at] / KILOMETRE) ** SLAB_EXPONENTS[:, None] / measured
    slab *= (apart + 1) * (apart.max(initial=0) > 0)
    # Normal equations by (length, exponent, slab exponent), in which shapes may be alike.
    both = relief @ slab.T
    relief_square = (relief**2).sum(axis=-1)[..., None] + TINY
    relief_sum = relief.sum(axis=-1)[..., None]
    slab_square = (slab**2).sum(axis=-1) + TINY
    slab_sum = slab.sum(axis=-1)
    rest = (1 + ALIKE) * relief_square * slab_square - both**2
    slab_change = (relief_square * slab_sum - both * relief_sum) / rest
    # Where relief would be negative, slabs alone.
    slab_change = np.clip(slab_change, 0, slab_sum / slab_square)
    variance = np.maximum((relief_sum - slab_change * both) / relief_square, 0)
    explained = variance * relief_sum + slab_change * slab_sum
    i, j, k = np.unravel_index(explained.argmax(), explained.shape)
    return {
        "relief_variance_bins2": variance[i, j, k],
        "relief_length_m": length_m[i],
        "relief_exponent": EXPONENTS[j],
        "slab_change_bins2": slab_change[i, j, k],
        "slab_exponent": SLAB_EXPONENTS[k],
    }


def surface_statistics(summary):
    """Four numbers of the surface's row, name to (dimensions, values).

    A product levels the aircraft's height m in whole bins, which leaves ``m - round(m)``; a slow
    error comes on top, of standard deviation `surface_error_bins` and Gaussian correlation
    ``exp(-(h / surface_error_length_m)^2)``. `surface_movement_bins` is the r.m.s. change of m from
    one range line to the next, and this change has a Gaussian correlation, too, of
    `surface_movement_length_m`; both are 0 where a product does not level in whole bins. The error
    is that of least squares of relative residuals; its length is one of `LENGTHS`.
    """
    rows = in_blocks(summary, "surface_bins")
    movement, n_lines = _movement(rows[np.isfinite(rows).all(axis=1)])
    spacing_m = np.median(summary["line_spacing_m"])
    change = np.array([known_mean((rows[:, lag:] - rows[:, :-lag]) ** 2) for lag in CHANGE_LAGS])
    known = change > 0
    shape = 2 * (1 - np.exp(-((CHANGE_LAGS[known] / LENGTHS[:, None]) ** 2))) / change[known]
    # The rest that levelling leaves is uniform within a bin: its mean square change is 1/6 bins^2.
    target = 1 - 1 / 6 * (movement > 0) / change[known]
    square = np.maximum((shape**2).sum(axis=1), TINY)
    variance = np.maximum((shape * target).sum(axis=1), 0) / square
    best = (variance**2 * square).argmax()
    return {
        "surface_error_bins": ((), np.sqrt(variance[best])),
        "surface_error_length_m": ((), LENGTHS[best] * spacing_m),
        "surface_movement_bins": ((), movement),
        "surface_movement_length_m": ((), n_lines * spacing_m),
    }


def _movement(rows):
    """R.m.s. movement between range lines that was levelled in whole bins, and its length [lines].

    Both are zero if nothing was levelled. Movement is the change of `rows` (block, range_line) less
    whole bins, since it changes by less than half a bin per line. A product counts as levelled if
    its rows have as many steps as rounding such a height makes. The length is where the
    autocorrelation of movement falls to 1/e.
    """
    step = np.diff(rows, axis=1)
    if step.size == 0:
        return 0.0, 0
    first = step[:, :1] - np.rint(step[:, :1])
    bend = np.diff(step, axis=1)
    change = np.cumsum(bend - np.rint(bend), axis=1)
    movement = np.concatenate([first, first + change], axis=1)
    # Moving every line by whole bins does not change the fraction.
    movement -= np.rint(movement.mean(axis=1, keepdims=True))
    n_steps = np.abs(np.rint(step - movement)).sum()
    rms = np.sqrt((movement**2).mean())
    if n_steps <= LEVELLED_SHARE * np.sqrt(2 / np.pi) * rms * movement.size:
        return 0.0, 0
    for lag in range(1, movement.shape[1]):
        if (movement[:, lag:] * movement[:, :-lag]).mean() * np.e < rms**2:
            break
    return rms, lag
