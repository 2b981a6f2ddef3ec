"""Layers along track: relief of layers, change of slabs, trends, folds and the surface's row."""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import KILOMETRE
from snowsim.echogram import SURFACE_ROW
from snowsim.limits import check_values

MINIMUM_THICKNESS_BINS = 1.0  # two layers never share a pixel
GRID_BITS = 12  # layers are multiples of 2^-12 range bins, which float32 holds to bin 4096
# Smaller eigenvalues, relative to the largest, are set to zero: they are rounding, which differs
# between processors.
LEAST_EIGENVALUE = 1e-10
LENGTHS_AROUND = 8  # least length of the circle, in correlation lengths


def draw_stationary(covariance, n_lines, *, rng):
    """Gaussian series (row, range_line) with covariances (row, lag), by circulant embedding.

    Exact where the covariance, wrapped around a circle twice as long as the lags, has no negative
    eigenvalue (Dietrich & Newsam 1997, SIAM J. Sci. Comput. 18, 1088). Negative ones are set to
    zero and the others scaled, so that the variance stays.
    """
    wrapped = np.concatenate([covariance, covariance[:, -2:0:-1]], axis=1)
    eigenvalues = np.fft.fft(wrapped).real
    least = LEAST_EIGENVALUE * eigenvalues.max(axis=1, keepdims=True)
    eigenvalues = np.where(eigenvalues > least, eigenvalues, 0)
    mean = eigenvalues.mean(axis=1, keepdims=True)
    eigenvalues *= covariance[:, :1] / np.where(mean > 0, mean, 1)
    white = np.fft.fft(rng.standard_normal(wrapped.shape))
    return np.fft.ifft(white * np.sqrt(eigenvalues)).real[:, :n_lines]


def lags_on_circle(n_lines, length_lines):
    """Lags of a circle that is long enough for a scene and for this correlation length, (lag,)."""
    return np.arange(int(max(n_lines, LENGTHS_AROUND / 2 * length_lines)) + 1)


def draw_undulations(relief, n_slabs, n_lines, spacing_m, *, rng):
    """Thickness of slabs about their means [bins], (slab, range_line).

    `relief` holds the five numbers of `snowsim.statistics.relief` by name. Over h metres each layer
    changes by a mean square of ``2 variance (1 - exp(-(h / length)^exponent))``, each slab by
    ``slab_change (h / 1000 m)^slab_exponent`` [bins^2].
    """
    length_m = relief["relief_length_m"]
    lag = lags_on_circle(n_lines, length_m / spacing_m)
    falls = np.exp(-((lag * spacing_m / length_m) ** relief["relief_exponent"]))
    covariance = np.tile(relief["relief_variance_bins2"] * falls, (n_slabs + 1, 1))
    layers = draw_stationary(covariance, n_lines, rng=rng)
    # Steps of fractional Brownian motion, whose wrapped covariance has no negative eigenvalue.
    away_m = spacing_m * np.abs(np.arange(-1, n_lines + 2))
    change = (away_m / KILOMETRE) ** relief["slab_exponent"]
    change = relief["slab_change_bins2"] * change
    covariance = np.tile(np.diff(change, 2) / 2, (n_slabs, 1))
    steps = draw_stationary(covariance, n_lines, rng=rng)
    thickness = np.diff(layers, axis=0) + np.cumsum(steps, axis=1)
    return thickness - thickness.mean(axis=1, keepdims=True)


def draw_surface(statistics, n_lines, spacing_m, *, rng):
    """Range bin of the surface (range_line,): a slow error, and what whole-bin levelling leaves.

    `statistics` holds the four numbers of `snowsim.statistics.relief.surface_statistics` by name.
    """
    slow = _draw_slow(
        statistics["surface_error_bins"],
        statistics["surface_error_length_m"],
        n_lines,
        spacing_m,
        rng=rng,
    )
    start = rng.uniform()
    movement_bins = statistics["surface_movement_bins"]
    length_m = statistics["surface_movement_length_m"]
    movement = _draw_slow(movement_bins, length_m, n_lines, spacing_m, rng=rng)
    height = start + np.cumsum(movement)
    left = height - np.rint(height) if movement_bins > 0 else 0.0
    return SURFACE_ROW + slow - slow.mean() + left


def _draw_slow(deviation, length_m, n_lines, spacing_m, *, rng):
    """Gaussian series (range_line,) of this standard deviation and Gaussian correlation."""
    lag = lags_on_circle(n_lines, length_m / spacing_m)
    falls = np.exp(-((lag * spacing_m / max(length_m, 1e-100)) ** 2))
    return draw_stationary(deviation**2 * falls[None], n_lines, rng=rng)[0]


def mirrored(thickness):
    """Thickness mirrored at its minimum of one bin: values below it are as far above it."""
    return MINIMUM_THICKNESS_BINS + np.abs(thickness - MINIMUM_THICKNESS_BINS)


def layers_below(surface, thickness):
    """Layers (layer, range_line), from the surface (range_line,) and thickness (slab, range_line).

    Thickness is at least `MINIMUM_THICKNESS_BINS`. It is rounded once, to multiples of 2^-12 bins,
    whose sums are exact: layers stay a bin apart and are the same on every processor.
    """
    steps = np.concatenate([surface[None], thickness])
    return np.cumsum(np.ldexp(np.rint(np.ldexp(steps, GRID_BITS)), -GRID_BITS), axis=0)


def notes_of(drawn, mean, first_bins):
    """Counts for the notes of a scene, from thickness (slab, range_line) and means as drawn."""
    return {
        "n_layers": len(drawn),
        "n_samples": drawn.size,
        "n_touched": int((drawn < MINIMUM_THICKNESS_BINS).sum()),
        "n_means_touched": int((mean < MINIMUM_THICKNESS_BINS).sum()),
        "first_thickness_bins": first_bins,
    }


@dataclass(frozen=True)
class Nonstationary:
    """Trends and folds of layers, which the paper leaves to future work; none by default.

    ValueError if a standard deviation is negative or not finite, or if folds are shorter than 4
    range lines, which picks do not resolve.
    """

    # Standard deviation of the change of mean thickness over a scene, relative to the mean.
    trend_sd: float = 0.0
    fold_sd_bins: float = 0.0  # standard deviation of the amplitude of the deepest layer's fold
    fold_length_lines: float = 64.0  # wavelength of folds
    zones: tuple | None = None  # only scenes of these zones have them; None: all scenes

    def __post_init__(self):
        for name, least in (("trend_sd", 0), ("fold_sd_bins", 0), ("fold_length_lines", 4)):
            check_values(name, getattr(self, name), least)

    def bend(self, thickness, zone, *, rng):
        """Thickness (slab, range_line) [bins] with a trend and folds, and notes of both.

        The trend is a gradient of accumulation, one for all slabs, `trend` over the scene. A fold
        moves the layer at mean depth z by ``fold_bins (z / Z) sin(2 pi x / L + phase)``, Z the
        deepest: slabs share it by their mean thickness. The surface stays, and so do means.
        """
        if self.zones is not None and zone not in self.zones:
            return thickness, {}
        notes = {}
        lines = np.arange(thickness.shape[1])
        if self.trend_sd > 0:
            notes["trend"] = float(self.trend_sd * rng.standard_normal())
            thickness = thickness * (1 + notes["trend"] * (lines / lines[-1] - 0.5))
        if self.fold_sd_bins > 0:
            notes["fold_bins"] = float(self.fold_sd_bins * rng.standard_normal())
            phase = rng.uniform(0, 2 * np.pi)
            mean = thickness.mean(axis=1, keepdims=True)
            fold = np.sin(2 * np.pi * lines / self.fold_length_lines + phase)
            thickness = thickness + notes["fold_bins"] * mean / mean.sum() * fold
        return thickness, notes
