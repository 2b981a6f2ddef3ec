"""Eq. (1) for one layer: its mean waveform, position of the peak, and width."""

import numpy as np
from scipy.special import erfc, erfcx

# Limits within which the closed form, the peak and the width were checked against 80 digits. PHY
# refuses values outside.
SAFE_RANGE = {"variance_bins2": (1e-12, 1e12), "decay_rate": (1e-12, 1e6)}

_SQRT2 = np.sqrt(2.0)
_SQRT_PI = np.sqrt(np.pi)
_SQRT_HALF_PI = np.sqrt(np.pi / 2)


def waveform_exact(x_bins, variance_bins2, decay_rate):
    """Mean waveform of one layer at `x_bins` below the centre of its Gaussian; broadcasts.

    A Gaussian of height 1 and variance `variance_bins2` [bins^2] is convolved with a one-sided
    exponential of height 1 and rate `decay_rate` [per bin]. The result is zero where it underflows.

    Notes
    -----
    Yari et al. (2021), eq. (1): ``w(x) = exp(-x^2 / 2d) (*) u(x) exp(-a x) = sqrt(pi d / 2) exp(a^2
    d / 2 - a x) erfc(z)`` with ``z = (a d - x) / sqrt(2 d)``, the exponentially modified Gaussian.
    As written the exponential overflows; for z >= 0 it is instead ``sqrt(pi d / 2) exp(-x^2 / 2d)
    erfcx(z)``, and for z < 0 the exponent is below ``-a^2 d / 2`` already. The relative error of
    both is below 5e-13.
    """
    x = np.asarray(x_bins, dtype=float)
    variance = np.asarray(variance_bins2, dtype=float)
    decay = np.asarray(decay_rate, dtype=float)
    deviation = np.sqrt(variance)
    z = (decay * variance - x) / (_SQRT2 * deviation)
    with np.errstate(under="ignore", over="ignore"):
        z = np.asarray(z)
        rises = z >= 0
        rising = -x * x / (2 * variance)
        # Where z < 0 the exponent of the falling branch is negative; elsewhere it is not used.
        falling = np.minimum(decay * (decay * variance / 2 - x), 0)
        exponent = np.where(rises, rising, falling)
        factor = np.empty(rises.shape)
        factor[rises] = erfcx(z[rises])
        factor[~rises] = erfc(z[~rises])
        return _SQRT_HALF_PI * deviation * (np.exp(exponent) * factor)


@np.errstate(under="ignore")
def waveform_peak(variance_bins2, decay_rate):
    """Depth of the waveform's peak below the Gaussian's centre [bins], and its value there.

    Two ndarray; broadcasts. ``w' = exp(-x^2 / 2d) - a w`` vanishes where ``erfcx(z) = sqrt(2 / (pi
    d)) / a``, so ``value = exp(-x^2 / 2d) / a``. Newton's method on ``log erfcx``, convex and
    decreasing, started on its left, converges from one side, quadratically: a step below 1e-9
    leaves rounding only.
    """
    variance_bins2 = np.asarray(variance_bins2, dtype=float)
    decay_rate = np.asarray(decay_rate, dtype=float)
    deviation = np.sqrt(variance_bins2)
    peak = _peak_in_deviations(decay_rate * deviation)
    return deviation * peak, np.exp(-(peak**2) / 2) / decay_rate


def waveform_width(variance_bins2, decay_rate):
    """Distance [bins] from the waveform's peak to where it has fallen to 1/e below; broadcasts.

    Newton's method on the concave ``log w``, started right of the root, converges from one side,
    quadratically.
    """
    variance_bins2 = np.asarray(variance_bins2, dtype=float)
    decay_rate = np.asarray(decay_rate, dtype=float)
    deviation = np.sqrt(variance_bins2)
    # The width in deviations depends on this product only, and by less than 1e-12 where large.
    product = np.minimum(decay_rate * deviation, 1e6)
    peak = _peak_in_deviations(product)
    target = _log_waveform(peak, product) - 1
    # w <= sqrt(2 pi d) exp(a^2 d / 2 - a x) everywhere: this bound meets the target to the right.
    bound = (product**2 / 2 + np.log(2 * _SQRT_HALF_PI) - target) / product
    u = np.maximum(bound, peak)
    with np.errstate(under="ignore"):
        for _ in range(60):
            log_value = _log_waveform(u, product)
            slope = product - np.exp(-(u**2) / 2 - log_value)
            step = (log_value - target) / slope
            u = u + step
            if _is_settled(step, u):
                break
    return deviation * (u - peak)


def _is_settled(step, value):
    """True if steps of Newton's method are so small that one more leaves rounding only."""
    return np.all(np.abs(step) <= 1e-9 * (1 + np.abs(value)))


def _peak_in_deviations(product):
    """Peak of the waveform in standard deviations, for decay times deviation `product`."""
    target = 1 / (_SQRT_HALF_PI * np.minimum(product, 1e4))
    # Left of the root: erfcx(z) >= exp(z^2) for z <= 0,
    negative = -np.sqrt(np.log(np.maximum(target, 1)))
    # and >= 2 / sqrt(pi) / (z + sqrt(z^2 + 2)) for z >= 0.
    asymptote = 2 / (_SQRT_PI * target)
    positive = np.maximum(asymptote / 2 - 1 / asymptote, 0)
    z = np.where(target >= 1, negative, positive)
    for _ in range(20):
        value = erfcx(z)
        slope = 2 / (_SQRT_PI * value) - 2 * z
        step = np.log(value / target) / slope
        z = z + step
        if _is_settled(step, z):
            break
    # Where the difference cancels, the expansion of erfcx for large arguments is good to
    # product^-5.
    return np.where(product < 1e3, product - _SQRT2 * z, 1 / product - product**-3.0)


def _log_waveform(u, product):
    """Logarithm of w / sqrt(d) at u standard deviations, for decay times deviation `product`.

    It never underflows.
    """
    z = (product - u) / _SQRT2
    rising = np.log(erfcx(np.maximum(z, 0))) - u**2 / 2
    falling = np.log(erfc(np.minimum(z, 0))) + product * (product / 2 - u)
    return np.log(_SQRT_HALF_PI) + np.where(z >= 0, rising, falling)
