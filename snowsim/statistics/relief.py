"""How layers change along track: the relief of each by itself, and the change of the slabs.

Let S_n(h) be the mean square change, over a distance h, of the distance between layers k and
k + n. Layers that undulate by themselves about slabs that change by themselves have ``S_n(h) =
2 R(h) + n A(h)``: R is the mean square change of one layer by itself, ``R(h) = 2 s^2 (1 - exp(-(h /
L)^p))`` of variance s^2 (`relief_variance_bins2`), length L (`relief_length_m`) and exponent p
(`relief_exponent`), a stable variogram; A is that of one slab, ``A(h) = a (h / 1000 m)^q``
(`slab_change_bins2`, `slab_exponent`), a power law. Neglected: slabs that change together, and what
the mean over `MEAN_LINES` takes from the change over as few lines, most where layers are rough.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

LAGS = 2 ** np.arange(8)  # [range lines]
# [range lines] Layers are averaged, as picks are whole bins and stray: of planted layers in whole
# bins .7 to 1.1 of their change over 4 to 64 lines comes back, without averaging .6 to .9.
MEAN_LINES = 5
MOST_APART = 6  # layers
MINIMUM_BLOCKS = 4  # in which a distance is known over a lag
STILL = 0.1  # root of a change [bins]: picks in whole bins that did not move
TELLING = (1, 6)  # of layers two apart over 64 lines: a zone without has too few data
KILOMETRE = 1000.0
# Mean of the root of the change of a Gaussian variable, to the fourth, over its mean square.
ROOTS = 0.457
EXPONENTS = np.arange(25, 101) / 50  # of relief
SLAB_EXPONENTS = np.arange(2, 40) / 20
# Of relief, of the shortest lag: from half of it to 16 times the longest.
LENGTHS = 2 ** np.arange(-1, 11.01, 0.125)
ALIKE = 1e-6  # keeps shapes apart that the data hardly tell apart
TINY = 1e-100


def relief_by_zone(depth_bins, zone, n_zones, spacing_m):
    """Variables (zone,) of relief, and how many zones with too few data take all zones together.

    From layers (block, layer, range_line) [bins] below the surface, NaN in gaps, of a zone each.
    """
    depth_bins = sliding_window_view(depth_bins, MEAN_LINES, axis=2).mean(axis=-1)
    fits = []
    n_of_all = 0
    for z in range(n_zones):
        change = mean_square_changes(depth_bins[zone == z])
        if np.isnan(change[TELLING]):
            change = mean_square_changes(depth_bins)
            n_of_all += 1
        fits.append(fit_relief(change, LAGS * spacing_m))
    return {name: ("zone", [fit[name] for fit in fits]) for name in fits[0]}, n_of_all


def mean_square_changes(depth_bins):
    """S_n(h) at `LAGS`, (apart, lag), NaN where it is not known.

    Of layers (block, layer, range_line), between lines without a gap of picks: behind a gap, a few
    in a hundred follow another layer. Robustly, as errors of picks have heavier tails than layers
    (Cressie & Hawkins 1980, Math. Geol. 12, 115, for many pairs). Not known where fewer than
    `MINIMUM_BLOCKS` blocks tell, or where two thirds of distances do not change, as of picks in
    whole bins; below that, rounded layers give .6 to 1.2 of what they change by.
    """
    change = np.full((MOST_APART, LAGS.size), np.nan)
    for apart in range(1, min(MOST_APART + 1, depth_bins.shape[1])):
        distance = depth_bins[:, apart:] - depth_bins[:, :-apart]
        n_gaps = np.cumsum(np.isnan(distance), axis=2)
        for i, lag in enumerate(LAGS):
            root = np.sqrt(np.abs(distance[..., lag:] - distance[..., :-lag]))
            known = np.isfinite(root) & (n_gaps[..., lag:] == n_gaps[..., :-lag])
            enough = known.any(axis=(1, 2)).sum() >= MINIMUM_BLOCKS
            root = root[known]
            if enough and 3 * (root < STILL).sum() < 2 * root.size:
                change[apart - 1, i] = root.mean() ** 4 / ROOTS
    return change


def fit_relief(change, lag_m):
    """The five numbers, by name, that fit changes (apart, lag) over distances (lag,).

    By least squares of relative residuals, as all are equally well known. Variances, not negative,
    are solved for, exponents and length are those of a grid: so the fit ends in the same digits on
    any processor, which a search for the smallest residual, flat about its end, does not. Without
    layers two apart all change is relief; without any, layers are flat.
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
