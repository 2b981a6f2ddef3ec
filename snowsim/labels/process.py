"""Thickness along track: Gaussian series of a given mean periodogram, trends and folds."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from snowsim.limits import check_values

ITERATIONS = 20  # of Richardson-Lucy
LEAST_EIGENVALUE = 1e-9  # of a correlation matrix, of the largest; below, its root is rounding
# Density that a wave of unit variance and half a cycle per block has in the first two cycles of a
# tapered, detrended spectrum, divided by the number of lines of the block.
HALF_CYCLE_SHOWS = np.array([0.0722, 0.0084])
SETTLED = 20  # rounds; each leaves a third of the error of the one before


@lru_cache(maxsize=4)
def leakage_matrix(n_lines, n_long):
    """Expected periodogram of `n_lines` cut from a series of `n_long`, per unit variance.

    (wavenumber, long wavenumber): one-sided density at ``k / n_lines``, k = 1 ... n_lines / 2, from
    ``j / n_long``, j = 1 ... n_long / 2. A cosine of random phase has ``E|X_k|^2 = (|D(f_j -
    f_k)|^2 + |D(f_j + f_k)|^2) / 2`` per unit variance, with the Dirichlet kernel D of the cut; the
    block's mean does not reach k >= 1.
    """
    wavenumber = np.arange(1, n_lines // 2 + 1) / n_lines
    long_wavenumber = np.arange(1, n_long // 2 + 1) / n_long
    matrix = np.zeros((wavenumber.size, long_wavenumber.size))
    for sign in (-1, 1):
        half_turn = np.pi * (long_wavenumber + sign * wavenumber[:, None])
        sine = np.sin(half_turn)
        at_pole = np.abs(sine) < 1e-12
        kernel = np.sin(n_lines * half_turn) / np.where(at_pole, 1, sine)
        matrix += np.where(at_pole, n_lines, kernel) ** 2 / 2
    matrix *= 2 / n_lines
    if n_lines % 2 == 0:
        matrix[-1] /= 2
    return matrix


def line_variances(psd, n_long):
    """Variances of a long series whose cut blocks have the mean periodogram `psd`.

    `psd (..., wavenumber)` is one-sided, of blocks about their mean, from wavenumber 0 to 1/2; the
    variances (..., long wavenumber) go from ``1 / n_long`` to 1/2, `n_long` being at least twice
    the length of a block. A series built on the block's own wavenumbers would end where it began. A
    longer one does not, but cutting it leaks low wavenumbers into high ones a second time.
    Richardson-Lucy iterations (Richardson 1972, J. Opt. Soc. Am. 62, 55) find positive variances
    whose leaked periodogram is the one observed.
    """
    n_lines = 2 * (psd.shape[-1] - 1)
    matrix = leakage_matrix(n_lines, n_long)
    target = psd[..., 1:]
    at = np.arange(1, n_long // 2 + 1) * (n_lines / n_long) - 1
    variances = np.maximum(_interpolated(target, at), 0) / n_long
    weight = matrix.sum(axis=0)
    for _ in range(ITERATIONS):
        leaked = variances @ matrix.T
        ratio = np.divide(target, leaked, out=np.zeros_like(target), where=leaked > 0)
        variances = variances * (ratio @ matrix) / weight
    return variances


def plain_variances(psd, trend_variance, n_long):
    """The same for spectra (..., wavenumber) without leakage, about trends of a variance (...).

    Density is interpolated in the logarithm between wavenumbers. The trend is the part of slower
    waves within a block: one wave of half a cycle per block represents them all. With its variance,
    and the share of faster waves, the rise of least-squares lines through cut blocks, from first
    line to last, has `trend_variance`. The lines do not remove all of this wave: what it adds to
    the first two cycles is subtracted there, down to a tenth at most.
    """
    n_lines = 2 * (psd.shape[-1] - 1)
    at = np.arange(2, n_long // 2 + 1) * (n_lines / n_long) - 1
    rise = _rise_of_waves(n_lines, n_long)
    slowest = np.zeros(psd.shape[:-1])
    for _ in range(SETTLED):
        density = np.maximum(psd[..., 1:], np.finfo(float).tiny)
        leaked = slowest[..., None] * n_lines * HALF_CYCLE_SHOWS
        density[..., :2] -= np.minimum(leaked, 0.9 * density[..., :2])
        faster = np.exp(_interpolated(np.log(density), at)) / n_long
        slowest = np.maximum(trend_variance - faster @ rise[1:], 0) / rise[0]
    return np.concatenate([slowest[..., None], faster], axis=-1)


def _rise_of_waves(n_lines, n_long):
    """Mean square rise over a block of lines fitted to unit waves, (long wavenumber,)."""
    line = np.arange(n_lines) - (n_lines - 1) / 2
    wavenumber = np.arange(1, n_long // 2 + 1) / n_long
    turn = np.exp(2j * np.pi * np.outer(wavenumber, line))
    return np.abs(turn @ line / (line @ line) * (n_lines - 1)) ** 2


def lengthened(variances, n_long):
    """Variances of a longer series: the same density, held constant below its lowest wavenumber."""
    n_old = 2 * variances.shape[-1]
    old = np.arange(1, n_old // 2 + 1) / n_old
    new = np.arange(1, n_long // 2 + 1) / n_long
    density = np.array([np.interp(new, old, row) for row in variances])
    return density * (n_old / n_long)


def draw_series(variances, mixing, n_lines, *, rng):
    """Gaussian series about their means, (row, range_line), correlated by band of wavenumber.

    `variances (row, long wavenumber)` are those of `line_variances`; `mixing` holds for each band a
    slice of long wavenumbers and a factor C (row, row) of the correlation matrix C C^T there.
    """
    n_rows, n_wavenumbers = variances.shape
    normal = rng.standard_normal((2, n_rows, n_wavenumbers))
    spectrum = normal[0] + 1j * normal[1]
    for band, factor in mixing:
        spectrum[:, band] = factor @ spectrum[:, band]
    n_long = 2 * n_wavenumbers
    # irfft halves all but the last; there one real normal must carry the variance.
    spectrum *= np.sqrt(variances) * (n_long / 2)
    spectrum[:, -1] = spectrum[:, -1].real * 2
    with_mean = np.concatenate([np.zeros((n_rows, 1)), spectrum], axis=1)
    series = np.fft.irfft(with_mean, n_long)[:, :n_lines]
    return series - series.mean(axis=1, keepdims=True)


def correlation_factor(correlation_by_separation, n_rows):
    """Factor C of the correlation matrix C C^T of rows, whose correlation by separation is given.

    The last value continues. Measured correlations need not form a valid matrix: eigenvalues below
    `LEAST_EIGENVALUE` of the largest are set to zero, the diagonal back to one. The factor is the
    symmetric root, the only one that does not depend on which eigenvectors a processor finds.
    """
    separation = np.abs(np.arange(n_rows)[:, None] - np.arange(n_rows))
    furthest = len(correlation_by_separation) - 1
    matrix = correlation_by_separation[np.minimum(separation, furthest)].astype(float)
    np.fill_diagonal(matrix, 1.0)
    values, vectors = np.linalg.eigh(matrix)
    root = np.sqrt(np.where(values > LEAST_EIGENVALUE * values[-1], values, 0))
    factor = (vectors * root) @ vectors.T
    return factor / np.sqrt((factor**2).sum(axis=1, keepdims=True))


def _interpolated(values, at):
    """Linear interpolation along the last axis at fractional indices, constant beyond the ends."""
    at = np.clip(at, 0, values.shape[-1] - 1)
    low = np.minimum(at.astype(int), values.shape[-1] - 2)
    return values[..., low] + (at - low) * (values[..., low + 1] - values[..., low])


@dataclass(frozen=True)
class Nonstationary:
    """Trends and folds of layers, which the paper leaves to future work; zeros: none.

    ValueError if a s.d. is negative or not finite, or a fold is shorter than 4 lines, which no
    picks resolve.
    """

    # Of the change of mean thickness from the first line of a scene to its last, over the mean.
    trend_sd: float = 0.0
    fold_sd_bins: float = 0.0  # of the amplitude of the deepest layer's fold
    fold_length_lines: float = 64.0  # wavelength of folds
    zones: tuple | None = None  # whose scenes have them; None: all

    def __post_init__(self):
        for name, least in (("trend_sd", 0), ("fold_sd_bins", 0), ("fold_length_lines", 4)):
            check_values(name, getattr(self, name), least)

    def applies(self, zone):
        """Whether scenes of a zone have trends and folds."""
        return self.zones is None or zone in self.zones


def draw_nonstationary(thickness, nonstationary, *, rng):
    """Thickness (slab, range_line) [bins] with a trend and folds, and notes.

    The trend is a gradient of accumulation, one for all slabs: thickness times ``1 + g (x / (N - 1)
    - 1/2)``, g ~ N(0, trend_sd^2), noted as `trend`; it leaves the mean of the scene as it was. A
    fold moves the layer at mean depth z below the surface by ``A (z / Z) sin(2 pi x / L + phase)``,
    Z the deepest, A ~ N(0, fold_sd_bins^2), noted as `fold_bins`: slabs share it by their mean
    thickness, the surface stays flat. Its curvature is ``A (z / Z) (2 pi / L)^2`` at most.
    """
    notes = {}
    lines = np.arange(thickness.shape[1])
    if nonstationary.trend_sd > 0:
        notes["trend"] = float(nonstationary.trend_sd * rng.standard_normal())
        thickness = thickness * (1 + notes["trend"] * (lines / lines[-1] - 0.5))
    if nonstationary.fold_sd_bins > 0:
        notes["fold_bins"] = float(nonstationary.fold_sd_bins * rng.standard_normal())
        phase = rng.uniform(0, 2 * np.pi)
        mean = thickness.mean(axis=1)
        share = mean / mean.sum()
        fold = np.sin(2 * np.pi * lines / nonstationary.fold_length_lines + phase)
        thickness = thickness + notes["fold_bins"] * share[:, None] * fold
    return thickness, notes
