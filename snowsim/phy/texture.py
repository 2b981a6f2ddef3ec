"""Texture of unlayered snow, down range and along track, and the receiver's gain by line."""

import numba
import numpy as np

from snowsim.phy.correlated import draw_normals

NEPERS = np.log(10) / 10  # per dB
REACH_LINES = 2.5  # of the taps along track, in standard deviations of their Gaussian


def draw_texture(n_range_bins, n_range_lines, texture, *, rng):
    """Factors of power of mean 1, float32 (range_bin, range_line).

    Lognormal of variance v; the logarithm has an autocorrelation of ``exp(-k / a)`` at k range bins
    and ``exp(-(h / b)^2)`` at h range lines, (v, a, b) being `texture`.
    """
    variance, length_bins, length_lines = texture
    spread = np.sqrt(np.log1p(variance))
    # White noise filtered by taps of this width has that autocorrelation.
    sigma_lines = max(length_lines / 2, 1e-3)
    reach = int(np.ceil(REACH_LINES * sigma_lines))
    away = np.arange(-reach, reach + 1) / sigma_lines
    taps = np.exp(-(away**2) / 2)
    taps *= spread / np.sqrt((taps**2).sum())
    white = draw_normals((n_range_bins, n_range_lines + 2 * reach), rng)
    kept = np.exp(-1 / length_bins)
    fresh = np.sqrt(1 - kept**2)
    rough = np.empty((n_range_bins, n_range_lines), dtype=np.float32)
    filter_texture(white, taps.astype(np.float32), np.float32(kept), np.float32(fresh), rough)
    rough -= np.float32(spread**2 / 2)
    return np.exp(rough, out=rough)


@numba.njit(cache=True, nogil=True)
def filter_texture(white, taps, kept, fresh, rough):
    """Fill `rough`: white normals filtered along track, then mixed with the row above."""
    n_range_bins, n_range_lines = rough.shape
    for row in range(n_range_bins):
        rough[row] = np.float32(0)
        for tap in range(taps.size):
            for line in range(n_range_lines):
                rough[row, line] += taps[tap] * white[row, line + tap]
        if row > 0:  # the first row keeps its variance: the series starts stationary
            for line in range(n_range_lines):
                rough[row, line] = kept * rough[row - 1, line] + fresh * rough[row, line]


def draw_gain(n_range_lines, spread_db, *, rng):
    """Factors of power by range line, lognormal of mean 1, float32 (range_line,)."""
    spread = NEPERS * spread_db
    log_gain = spread * rng.standard_normal(n_range_lines) - spread**2 / 2
    return np.exp(log_gain).astype(np.float32)
