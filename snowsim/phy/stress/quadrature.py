"""Eq. (1) by quadrature: slow, sharing no formula with the closed form; what the atlas judges by."""

import numpy as np

REACH_DEVIATIONS = 9.5  # beyond, a Gaussian is below 3e-20 of its peak
REACH_DECAYS = 45  # beyond, an exponential is
CHUNK = 20_000
NODES, WEIGHTS = np.polynomial.legendre.leggauss(128)


def quadrature_power(waveforms, rows):
    """Mean power on some rows, float64 (len(rows), range_line).

    Parameters
    ----------
    waveforms : Waveforms
        The scene's layers.
    rows : array_like of int
        Range bins wanted.
    """
    power = np.zeros((len(rows), waveforms.shape[1]))
    for layer, lines in enumerate(np.isfinite(waveforms.centre_bins)):
        x_bins = np.asarray(rows, dtype=float)[:, None] - waveforms.centre_bins[layer, lines]
        one = waveform_by_quadrature(x_bins, waveforms.variance_bins2[layer], waveforms.decay_rate[layer])
        power[:, lines] += waveforms.amplitude[layer] * one
    return power


def waveform_by_quadrature(x_bins, variance_bins2, decay_rate):
    """Waveform of one layer, ``int_0^inf exp(-(x - t)^2 / 2d - a t) dt``, float64 of the shape of `x_bins`.

    Gauss-Legendre over where the integrand, whose logarithm is a parabola, exceeds 1e-19 of its largest value. All
    terms are positive, so nothing cancels.
    """
    x_bins = np.asarray(x_bins, dtype=float)
    flat = x_bins.ravel()
    chunks = [_integral(flat[i : i + CHUNK], variance_bins2, decay_rate) for i in range(0, flat.size, CHUNK)]
    return np.concatenate([np.empty(0), *chunks]).reshape(x_bins.shape)


@np.errstate(under="ignore", over="ignore")
def _integral(x, variance, decay):
    """Over u = t - t0, t0 >= 0 where the integrand is largest: there ``x - t0 = min(a d, x)``, and nothing cancels."""
    reach = REACH_DEVIATIONS * np.sqrt(variance)
    largest_at = np.maximum(x - decay * variance, 0)
    largest = -(np.minimum(decay * variance, x) ** 2) / (2 * variance) - decay * largest_at
    slope = np.maximum(decay - x / variance, 0)  # where t0 = 0, how fast the integrand falls
    start = -np.minimum(largest_at, reach)
    stop = np.minimum(reach, REACH_DECAYS / np.maximum(slope, 1e-300))
    half = (stop - start)[:, None] / 2
    u = start[:, None] + half * (1 + NODES)
    exponent = largest[:, None] - slope[:, None] * u - u**2 / (2 * variance)
    return (half * WEIGHTS * np.exp(exponent)).sum(axis=1)
