"""Nonstationary layers: means that change along track, and folds that bend the layers below them."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Nonstationary:
    """Trends and folds of layers in percolation and ablation zones, which the paper leaves to future work; zeros: none.

    ValueError if a s.d. is negative or not finite, or a fold is shorter than 4 lines, which no picks resolve.
    """

    trend_sd: float = 0.0  # of the change of mean thickness from the first line of a scene to its last, over the mean
    fold_sd_bins: float = 0.0  # of the amplitude of the deepest layer's fold
    fold_length_lines: float = 64.0  # wavelength of folds
    zones: tuple | None = None  # of which scenes are so; None: all

    def __post_init__(self):
        for name in ("trend_sd", "fold_sd_bins"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                msg = f"{name} must be finite and not negative, got {value}"
                raise ValueError(msg)
        if not self.fold_length_lines >= 4:
            msg = f"fold_length_lines must be at least 4 range lines, got {self.fold_length_lines}"
            raise ValueError(msg)

    def applies(self, zone):
        """Whether scenes of a zone have trends and folds."""
        return self.zones is None or zone in self.zones


def draw_nonstationary(thickness, nonstationary, *, rng):
    """Thickness (slab, range_line) [bins] with a trend and folds, and notes; what is off takes no number from `rng`.

    The trend is a gradient of accumulation, one for all slabs: thickness times ``1 + g (x / (N - 1) - 1/2)``, g ~ N(0,
    trend_sd^2), noted as `trend`; it leaves the mean of the scene as it was. A fold moves the layer at mean depth z
    below the surface by ``A (z / Z) sin(2 pi x / L + phase)``, Z the deepest, A ~ N(0, fold_sd_bins^2), noted as
    `fold_bins`: slabs share it by their mean thickness, the surface stays flat. Its curvature is ``A (z / Z) (2 pi /
    L)^2`` at most.
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
