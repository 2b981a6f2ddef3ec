"""Flights planted with eq. (1), and what an estimator makes of one."""

from dataclasses import dataclass

import numpy as np

from lib.diagnostics.closed_loop import BOUNDS, as_frame
from snowsim.phy.waveform import waveform_exact, waveform_peak, waveform_width
from snowsim.statistics.estimate import estimate
from snowsim.statistics.summaries import GROUP_LINES, merge, summarise
from snowsim.statistics.zones import ALL_ZONES, OTHER_SLABS

SURFACE_BIN = 60.0
BIN_SIZE_S, LINE_SPACING_M = 2.886e-10, 5.47
QUANTITIES = ("peak_power", "decay_rate", "width_bins", "noise_power")


@dataclass(frozen=True)
class Planted:
    """A flight of layers of eq. (1); the default is five layers 44 bins apart, as many looks as a flight line has."""

    peak_power: tuple = (1.0, 0.3, 0.2, 0.15, 0.1)  # above the noise, by layer
    decay_rate: tuple = (0.09, 0.07, 0.06, 0.06, 0.05)  # per bin, by layer
    variance_bins2: float = 12.5  # of the Gaussian of all layers
    noise_power: float = 1e-3
    slab_bins: float = 44.0  # mean thickness of slabs
    thickness_sd: float = 0.05  # its relative s.d., from frame to frame and from group to group
    n_looks: float = 5  # of a range line; infinite: no speckle
    n_frames: int = 4
    n_lines: int = 256

    def truth(self):
        """What is planted, by quantity."""
        decay = np.array(self.decay_rate)
        width = waveform_width(np.full(decay.size, self.variance_bins2), decay)
        values = (np.array(self.peak_power), decay, width, np.array([self.noise_power]))
        return dict(zip(QUANTITIES, values, strict=True))

    def frames(self, rng):
        """Pairs of echogram and layers, one at a time; layers are level within a group of lines."""
        for index in range(self.n_frames):
            layer_bins = self._layer_bins(rng)
            power = self._mean_power(layer_bins[:, ::GROUP_LINES])
            power = np.repeat(power, GROUP_LINES, axis=1)[:, : self.n_lines]
            if np.isfinite(self.n_looks):
                power = power * rng.gamma(self.n_looks, 1 / self.n_looks, power.shape)
            yield as_frame(power, layer_bins, index, bin_size_s=BIN_SIZE_S, line_spacing_m=LINE_SPACING_M)

    def _layer_bins(self, rng):
        """Rows of layers, (layer, range_line)."""
        n_groups = -(-self.n_lines // GROUP_LINES)
        thickness = np.full((len(self.peak_power) - 1, n_groups), self.slab_bins)
        if self.thickness_sd > 0:
            # From frame to frame as from group to group: block means then differ, and zones with them.
            for size in ((len(thickness), 1), thickness.shape):
                thickness = thickness * np.exp(self.thickness_sd * rng.standard_normal(size))
        surface = SURFACE_BIN + rng.uniform(-0.5, 0.5, (1, n_groups))
        layer_bins = np.cumsum(np.concatenate([surface, thickness]), axis=0)
        return np.repeat(layer_bins, GROUP_LINES, axis=1)[:, : self.n_lines]

    def _mean_power(self, layer_bins):
        """Mean power with the waveforms' peaks on the layers, (range_bin, column)."""
        row = np.arange(int(layer_bins.max()) + 100)[:, None]
        power = np.full((row.size, layer_bins.shape[1]), self.noise_power)
        for layer, (peak_power, decay) in enumerate(zip(self.peak_power, self.decay_rate, strict=True)):
            offset, height = waveform_peak(self.variance_bins2, decay)
            lag = row - layer_bins[layer] + offset
            power += peak_power / height * waveform_exact(lag, self.variance_bins2, decay)
        return power


def judged(panel, value, planted, frames, estimator, *, zone_edge_bins=None):
    """Rows of the atlas for one flight and one estimator."""
    row = {"panel": panel, "value": value, "estimator": estimator}
    try:
        summary = merge(summarise(*frame) for frame in frames)
        fitted = estimate(summary, estimator=estimator, zone_edge_bins=zone_edge_bins)
    except ValueError as error:
        return [row | {"quantity": "all", "outcome": "refused", "note": str(error)}]
    note = rules_applied(fitted)
    if not is_finite(fitted):
        return [row | {"quantity": "all", "outcome": "not finite", "note": note}]
    return [row | _compared(fitted, quantity, true) | {"note": note} for quantity, true in planted.truth().items()]


def is_finite(fitted):
    """Whether every number is finite but the decay rate of the deepest layer in `paper`."""
    for name, variable in fitted.variables.items():
        values = np.atleast_1d(variable.values)
        if fitted.attrs["estimator"] == "paper" and name.startswith("decay_rate"):
            values = values[:-1]
        if not np.isfinite(values).all():
            return False
    return all(np.isfinite(value) for value in fitted.attrs.values() if not isinstance(value, str))


def rules_applied(fitted):
    """The rules that degraded a result, with counts, in words; empty if none did."""
    counts = {
        "layers not their own": int(fitted["substituted"].sum()),
        "layers left out": max(fitted.attrs["n_layers_seen"] - fitted.sizes["layer"], 0),
        "thicknesses of all zones": int((fitted["source"] == ALL_ZONES).sum()),
        "of the slab above": int((fitted["source"] == OTHER_SLABS).sum()),
        "spectra of all zones": int((fitted["psd_source"] == ALL_ZONES).sum()),
        "of other slabs": int((fitted["psd_source"] == OTHER_SLABS).sum()),
        "spectra over closed gaps": fitted.attrs["n_closed_blocks"],
        "blocks placed by other slabs": fitted.attrs["n_blocks_placed_by_other_slabs"],
        "picks outside": fitted.attrs["n_picks_outside"],
        "frames without surface": fitted.attrs["n_frames_without_surface"],
    }
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n)


def _compared(fitted, quantity, true):
    """Error of one quantity over the layers that were found."""
    bound = BOUNDS[quantity]
    found, claimed = (np.atleast_1d(fitted[name].values) for name in (quantity, f"{quantity}_standard_error"))
    n = min(found.size, true.size)
    known = np.isfinite(found[:n])
    found, claimed, true = found[:n][known], claimed[:n][known], true[:n][known]
    scale = true if bound.unit == "relative" else np.ones(true.size)
    error = (found - true) / scale
    largest = float(np.abs(error).max())
    # Three digits: beyond them results differ between machines.
    numbers = {"error": error.mean(), "largest": largest, "standard_error": (claimed / scale).mean()}
    return {name: float(f"{number:.3g}") for name, number in numbers.items()} | {
        "quantity": quantity,
        "unit": bound.unit,
        "bound": bound.largest,
        "outcome": "within" if largest <= bound.largest else "beyond",
    }
