"""Fading of layers along track: autocovariance of power in dB, extrapolated from lags of one line and more to zero."""

import numpy as np
from scipy.optimize import least_squares

from snowsim.statistics.blocks import BLOCK_LINES
from snowsim.statistics.summaries import GROUP_LINES

DB = 10 / np.log(10)
CLEAR_SHARE = 0.5  # of power on a pick that must be the layer's own, or noise and tails hide its fading
FADING_LAGS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96])
FEWEST_BLOCKS = 4


def fading_products(summary, powers, frame_of):
    """Products of dB power along track by lag, (frame, surface or buried, lag 0 and others, sum and weights).

    Of whole blocks of tracked power about their mean, gaps left out. Noise and tails do not fade with it: where a layer
    has less than `CLEAR_SHARE` of the power on its pick, a block does not count; products of others at lags of one
    and more are divided by the square of that share. The last weight is the sum of those squares.
    """
    lags = np.append(0, FADING_LAGS)
    products = np.zeros((len(summary), 2, lags.size, 3))
    for i, frame in enumerate(summary):
        of_frame = powers[frame_of == i]
        n_blocks = frame.tracked_power.shape[1] // BLOCK_LINES
        for layer in range(min(len(frame.tracked_power), powers.shape[1])):
            for block in range(n_blocks):
                line = frame.tracked_power[layer, block * BLOCK_LINES : (block + 1) * BLOCK_LINES].astype(float)
                known = line > 0
                first = block * BLOCK_LINES // GROUP_LINES
                own = of_frame[first : first + BLOCK_LINES // GROUP_LINES, layer]
                if 2 * known.sum() < BLOCK_LINES or not np.isfinite(own).any():
                    continue
                share = np.nanmean(own) / line[known].mean()
                if share < CLEAR_SHARE:
                    continue
                value = DB * np.log(np.where(known, line, 1))
                value = np.where(known, value - value[known].mean(), 0)
                square = min(share, 1.0) ** 2
                for j, lag in enumerate(lags):
                    product, n = (
                        value[: BLOCK_LINES - lag] @ value[lag:],
                        (known[: BLOCK_LINES - lag] & known[lag:]).sum(),
                    )
                    products[i, min(layer, 1), j] += product / (square if lag else 1), n, n * square
    return products


def fading(products, speckle):
    """Standard deviation [dB], 1/e length [lines] and exponent of fading, and nugget [dB^2], from products by lag.

    ``C(h) = s^2 exp(-(h / l)^p)`` at lags of one line and more, less its mean over pairs of a block, which the block's
    own mean takes from every lag; what lag 0 has beyond is the nugget: speckle.
    """
    n = products[:, 1]
    if n.min() < BLOCK_LINES * FEWEST_BLOCKS or products[0, 0] <= 0:
        return np.full(4, np.nan)
    covariance = products[:, 0] / n
    lag = np.arange(BLOCK_LINES)
    pairs = np.where(lag > 0, 2, 1) * (BLOCK_LINES - lag) / BLOCK_LINES**2

    def expected(parameters):
        variance, length, exponent = np.exp(parameters[0]), np.exp(parameters[1]), parameters[2]
        kernel = variance * np.exp(-((lag / length) ** exponent))
        return kernel[np.append(0, FADING_LAGS)] - (pairs * kernel).sum() - speckle / BLOCK_LINES

    first = [np.log(max(covariance[1], 1e-3)), np.log(30.0), 1.5]
    bounds = ([np.log(1e-4), 0.0, 0.3], [np.log(1e3), np.log(4.0 * BLOCK_LINES), 2.0])
    first = np.clip(first, *bounds)
    fit = least_squares(lambda p: (expected(p) - covariance)[1:] * np.sqrt(n[1:] / n[1]), first, bounds=bounds)
    at_zero = expected(fit.x)[0]
    return np.array([np.exp(fit.x[0] / 2), np.exp(fit.x[1]), fit.x[2], covariance[0] - at_zero * products[0, 2] / n[0]])
