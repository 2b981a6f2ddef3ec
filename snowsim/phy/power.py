"""Mean power of a scene by eq. (1): exact, or within a tolerance as planned."""

import numba
import numpy as np

from snowsim.limits import check_values
from snowsim.phy.parameters import EXACT_BOUND_DB, checked_waveforms
from snowsim.phy.plan import plan_power
from snowsim.phy.tables import tabulated_power
from snowsim.phy.waveform import waveform_exact

DEFAULT_RELATIVE_NOISE = 1e-4


def mean_power(
    layer_bins, peak_power, variance_bins2, decay_rate, n_range_bins, *,
    tolerance_db=None, noise_power=None, normalise="peak", align="peak",
):  # fmt: skip
    """Mean power of layered snow, without noise.

    Neglected: correlation between layers, off-nadir energy other than in the decay, surface
    roughness.

    Parameters
    ----------
    layer_bins : array_like, (layer, range_line)
        Fractional range bins, increasing with depth; NaN where absent. Tails of layers outside the
        window count, too.
    peak_power : array_like, (layer,) or (layer, range_line)
        Linear power, not negative; along track it may be NaN only where the layer is absent.
    variance_bins2 : array_like, (layer,)
        Variance of each layer's Gaussian [bins^2].
    decay_rate : array_like, (layer,)
        Rate of each layer's exponential [per bin].
    n_range_bins : int
        Height of the window.
    tolerance_db : float, optional
        Largest error of ``P_s + noise_power`` at any pixel [dB]. By default exact to the resolution
        of float64.
    noise_power : float, optional
        Noise that the tolerance includes; by default 1e-4 of the scene's largest P_s. It is not
        added.
    normalise : {"peak", "none"}
        ``peak``: the convolved waveform peaks at `peak_power`; ``none``: as printed, the Gaussian
        does, unconvolved.
    align : {"peak", "gaussian"}
        ``peak``: the waveform's peak lies on the layer; ``gaussian``: as printed, the Gaussian's
        does.

    Returns
    -------
    ndarray of float64, (range_bin, range_line)

    Raises
    ------
    ValueError
        If a power is negative or not finite, a variance, rate or tolerance not positive, a shape
        wrong, layers cross.

    Notes
    -----
    ``P_s(x) = sum_l m_l exp(-(x - mu_l)^2 / 2 d_l) (*) u(x) exp(-alpha_l x)``, convolved
    continuously in bins: Yari et al. (2021), IEEE JSTARS 14, eq. (1). How a tolerance is kept:
    `snowsim.phy.tables`.

    Examples
    --------
    >>> layer_bins = np.array([[50.0, 50.0], [70.0, 72.0]])
    >>> scene = layer_bins, [1.0, 0.1], [2.0, 2.0], [0.3, 0.1], 120
    >>> power = mean_power(*scene)
    >>> power.shape
    (120, 2)
    >>> power[50].round(3)  # the waveform of the surface peaks at 1
    array([1., 1.])
    >>> rough = mean_power(*scene, tolerance_db=0.05, noise_power=1e-3)
    >>> bool(np.abs(10 * np.log10((rough + 1e-3) / (power + 1e-3))).max() < 0.05)
    True
    """
    waveforms = checked_waveforms(
        layer_bins, peak_power, variance_bins2, decay_rate, n_range_bins, normalise, align
    )
    if tolerance_db is not None:
        check_values("tolerance_db", tolerance_db, EXACT_BOUND_DB)
    if noise_power is not None:
        check_values("noise_power", noise_power, 0, number=True)
    elif tolerance_db is None:
        noise_power = 0.0
    else:
        noise_power = DEFAULT_RELATIVE_NOISE * _least_largest_power(waveforms)
    power = planned_power(plan_power(waveforms, float(noise_power), tolerance_db))
    return power.astype(float, copy=False)


@np.errstate(under="ignore")
def planned_power(scene_plan, added_power=0.0):
    """Mean power of a planned scene plus `added_power`, (range_bin, range_line), in its type."""
    if scene_plan.supports is None:
        return exact_power(scene_plan.waveforms) + added_power
    return tabulated_power(scene_plan.waveforms, scene_plan.supports, added_power)


@np.errstate(under="ignore")
def exact_power(waveforms):
    """Mean power by the closed form on every pixel, float64 (range_bin, range_line)."""
    power = np.zeros(waveforms.shape)
    rows = np.arange(waveforms.n_range_bins)[:, None]
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = rows - waveforms.centre_bins[layer, lines]
        power[:, lines] += _layer_power(waveforms, layer, lines, x_bins)
    return power


@np.errstate(under="ignore")
def tail_power(waveforms, layers, least=0.0):
    """Power of some layers below their peak, all of it tail, float32 (range_bin, range_line).

    Eq. (1) far below, ``a sqrt(2 pi d) exp(alpha^2 d / 2 - alpha x)``, falls by one factor from bin
    to bin. A layer ends where it is below `least` on all range lines.
    """
    variance = waveforms.variance_bins2[layers, None]
    decay = waveforms.decay_rate[layers, None]
    centre = waveforms.centre_bins[layers]
    n_range_bins = waveforms.n_range_bins
    peak = np.ceil(centre + waveforms.peak_offset_bins[layers, None])
    first = np.clip(np.nan_to_num(peak, nan=np.inf), 0, n_range_bins).astype(int)
    share = 1.0 if waveforms.line_share is None else waveforms.line_share[layers]
    scale = waveforms.amplitude[layers, None] * np.sqrt(2 * np.pi * variance)
    scale = scale * np.exp(decay**2 * variance / 2)
    start = scale * share * np.exp(decay * (np.nan_to_num(centre) - first))
    start = np.where(np.isfinite(centre), start, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        n_rows = np.log(start.max(axis=1, initial=0) / least) / decay[:, 0]
    n_rows = np.clip(np.nan_to_num(n_rows), 0, n_range_bins).astype(int)
    factor = np.exp(-decay[:, 0]).astype(np.float32)
    power = np.zeros(waveforms.shape, dtype=np.float32)
    _add_tails(first, n_rows, start.astype(np.float32), factor, power)
    return power


@numba.njit(cache=True, nogil=True)
def _add_tails(first, n_rows, value, factor, power):
    """Add to `power` tails of layers from row `first`, of `value`, down by `factor` a row.

    `first` and `value` are (layer, range_line), `value` is overwritten.
    """
    n_range_bins, n_lines = power.shape
    for layer in range(first.shape[0]):
        last = -1
        for line in range(n_lines):
            if value[layer, line] > 0:
                last = max(last, first[layer, line])
        stop = min(last + n_rows[layer] + 1, n_range_bins)
        for row in range(first[layer].min(), stop):
            for line in range(n_lines):
                on = row >= first[layer, line]
                power[row, line] += value[layer, line] if on else np.float32(0)
                value[layer, line] *= factor[layer] if on else np.float32(1)


@np.errstate(under="ignore")
def _least_largest_power(waveforms):
    """Lower bound of the scene's largest power: a layer alone, at the pixel nearest to its peak."""
    peak_bins = waveforms.centre_bins + waveforms.peak_offset_bins[:, None]
    nearest = np.clip(np.rint(peak_bins), 0, waveforms.n_range_bins - 1)
    layer, line = np.nonzero(np.isfinite(peak_bins))
    x_bins = nearest[layer, line] - waveforms.centre_bins[layer, line]
    return float(_layer_power(waveforms, layer, line, x_bins).max(initial=0))


def _layer_power(waveforms, layer, line, x_bins):
    """Power of layers on range lines, at `x_bins` below their centres."""
    share = 1.0 if waveforms.line_share is None else waveforms.line_share[layer, line]
    one = waveform_exact(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
    return waveforms.amplitude[layer] * share * one
