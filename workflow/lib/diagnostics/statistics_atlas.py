"""The atlas of the estimators: flights planted with eq. (1), to where one or both lose what was planted.

A row has the mean `error` over layers, its `largest` magnitude, the mean `standard_error` claimed,
and as `note` the rule that degraded the result or the line that refused it. ``beyond`` is further
off than the quantity's bound and than `N_ERRORS` of the errors claimed. The outcome ``not finite``
must not be.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from lib.diagnostics.closed_loop import BOUNDS, as_frame
from snowsim.constants import BLOCK_LINES
from snowsim.phy import mean_power
from snowsim.phy.waveform import waveform_width
from snowsim.statistics.estimate import ESTIMATORS, estimate
from snowsim.statistics.summaries import GROUP_LINES, merge, summarise
from snowsim.statistics.zones import ALL_ZONES, OTHER_SLABS

SURFACE_BIN = 60.0
BIN_SIZE_S, LINE_SPACING_M = 2.886e-10, 5.47
QUANTITIES = ("peak_power", "decay_rate", "width_bins", "noise_power")
PANEL = "borders"  # of the panels the one that is no sweep
N_ERRORS = (
    3  # of its own, which an estimate may be off even beyond its bound: short flights tell no more
)
GAP_LINES = 24  # mean length of a gap in a layer's picks [range lines]
COLUMNS = (
    *("panel", "value", "estimator", "quantity", "error", "largest", "standard_error"),
    *("unit", "bound", "outcome", "note"),
)


@dataclass(frozen=True)
class Planted:
    """A flight of layers of eq. (1); the default is five layers 44 bins apart."""

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
            yield as_frame(
                power, layer_bins, index, bin_size_s=BIN_SIZE_S, line_spacing_m=LINE_SPACING_M
            )

    def _layer_bins(self, rng):
        """Rows of layers, (layer, range_line)."""
        n_groups = -(-self.n_lines // GROUP_LINES)
        thickness = np.full((len(self.peak_power) - 1, n_groups), self.slab_bins)
        if self.thickness_sd > 0:
            # From frame to frame as from group to group: block means then differ, and zones with
            # them.
            for size in ((len(thickness), 1), thickness.shape):
                thickness = thickness * np.exp(self.thickness_sd * rng.standard_normal(size))
        surface = SURFACE_BIN + rng.uniform(-0.5, 0.5, (1, n_groups))
        layer_bins = np.cumsum(np.concatenate([surface, thickness]), axis=0)
        return np.repeat(layer_bins, GROUP_LINES, axis=1)[:, : self.n_lines]

    def _mean_power(self, layer_bins):
        """Mean power with the waveforms' peaks on the layers, (range_bin, column)."""
        variance_bins2 = np.full(len(layer_bins), self.variance_bins2)
        n_range_bins = int(layer_bins.max()) + 100
        return (
            mean_power(layer_bins, self.peak_power, variance_bins2, self.decay_rate, n_range_bins)
            + self.noise_power
        )


def compared(panel, value, planted, frames, estimator, *, zone_edge_bins=None):
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
    return [
        row | _compared(fitted, quantity, true) | {"note": note}
        for quantity, true in planted.truth().items()
    ]


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
        "lines of a stretch, for spectra": fitted.attrs["n_spectral_lines"] % BLOCK_LINES,
        "blocks placed by other slabs": fitted.attrs["n_blocks_placed_by_other_slabs"],
        "picks outside": fitted.attrs["n_picks_outside"],
        "frames without surface": fitted.attrs["n_frames_without_surface"],
    }
    return ", ".join(f"{n} {name}" for name, n in counts.items() if n)


def _compared(fitted, quantity, true):
    """Error of one quantity over the layers that were found."""
    bound = BOUNDS[quantity]
    found, claimed = (
        np.atleast_1d(fitted[name].values) for name in (quantity, f"{quantity}_standard_error")
    )
    n = min(found.size, true.size)
    known = np.isfinite(found[:n])
    found, claimed, true = found[:n][known], claimed[:n][known], true[:n][known]
    scale = true if bound.unit == "relative" else np.ones(true.size)
    error = (found - true) / scale
    largest = float(np.abs(error).max())
    # Three digits: beyond them results differ between machines.
    numbers = {
        "error": error.mean(),
        "largest": largest,
        "standard_error": (claimed / scale).mean(),
    }
    row = {name: float(f"{number:.3g}") for name, number in numbers.items()}
    row |= {"quantity": quantity, "unit": bound.unit, "bound": bound.largest}
    allowed = np.maximum(bound.largest, N_ERRORS * claimed / scale)
    return row | {"outcome": "within" if (np.abs(error) <= allowed).all() else "beyond"}


# Values of each sweep, and the flight planted for one.
SWEEPS = {
    "slab thickness [bins]": (
        (3, 5, 8, 12, 18, 27, 44, 80),
        lambda value: Planted(slab_bins=value),
    ),
    "weakest layer over noise [dB]": (
        (-15, -10, -5, 0, 5, 10, 20, 30),
        lambda value: Planted(noise_power=min(Planted.peak_power) * 10 ** (-value / 10)),
    ),
    "looks of a range line": ((0.2, 0.5, 1, 2, 5, 20, 100), lambda value: Planted(n_looks=value)),
    "range lines of a flight": (
        (200, 256, 512, 1024, 2048, 4096),
        lambda value: Planted(n_frames=1, n_lines=value),
    ),
    "share of picks missing": ((0, 0.2, 0.4, 0.6, 0.8, 0.95), lambda _: Planted()),
}


def sweep(panel, stream, *, share=1.0):
    """Rows of one panel of `SWEEPS`: a share of its values, spread evenly, both ends included, by every estimator.

    `stream` gives the random generator of a panel and a value.
    """
    values, plant = SWEEPS[panel]
    chosen = np.unique(
        np.linspace(0, len(values) - 1, max(int(np.ceil(share * len(values))), 2))
        .round()
        .astype(int)
    )
    rows = []
    for value in (values[i] for i in chosen):
        planted = plant(value)
        rng = stream(panel, value)
        frames = list(planted.frames(rng))
        if panel == "share of picks missing":
            frames = [with_gaps(frame, value, rng) for frame in frames]
        for estimator in ESTIMATORS:
            rows += compared(panel, float(value), planted, frames, estimator)
    return rows


def with_gaps(frame, share, rng):
    """A frame whose buried layers lose this share of their picks, in runs of `GAP_LINES` on average."""
    echogram, layers = frame
    layers = layers.copy(deep=True)
    if share > 0:
        n_layers, n_lines = layers["twtt"].shape
        leave, enter = 1 / GAP_LINES, share / max(1 - share, 1e-9) / GAP_LINES
        missing = rng.random(n_layers) < share
        for line in range(n_lines):
            turn = rng.random(n_layers)
            missing = np.where(missing, turn >= leave, turn < min(enter, 1.0))
            layers["twtt"].values[1:, line] = np.where(
                missing[1:], np.nan, layers["twtt"].values[1:, line]
            )
    return echogram, layers


def _picks(frames, change):
    """Frames whose travel times of layers are changed in place by a function of (frame, twtt)."""
    changed = []
    for index, (echogram, layers) in enumerate(frames):
        layers = layers.copy(deep=True)
        change(index, layers["twtt"].values)
        changed.append((echogram, layers))
    return changed


def _without(layer, lines=slice(None), first_frame=0):
    """A change that removes picks of a layer (or a slice of them) from a frame on."""

    def change(index, twtt):
        if index >= first_frame:
            twtt[layer, lines] = np.nan

    return change


def _crossed(_, twtt):
    twtt[2, 100] = twtt[3, 100] + 1e-9


def _lost_lines(frame):
    """A frame with every third group of lines not recorded."""
    echogram, layers = frame
    echogram = echogram.copy(deep=True)
    lost = (np.arange(echogram.sizes["slow_time"]) // 20) % 3 == 1
    echogram["Data"].values[:, lost] = np.nan
    return echogram, layers


def border_cases(stream):
    """Name, planted flight, frames, and zone edges where they are given, of every case."""
    default = Planted()
    frames = list(default.frames(stream(PANEL, "default")))

    def own(name, planted):
        return name, planted, list(planted.frames(stream(PANEL, name))), None

    def cut(**selection):
        return [tuple(part.isel(**selection) for part in frame) for frame in frames]

    def cut_rows(rows):
        return [(echogram.isel(twtt=rows), layers) for echogram, layers in frames]

    buried, deepest = slice(1, None), len(default.peak_power) - 1
    return [
        ("as planted", default, frames, None),
        ("no layers", default, _picks(frames, _without(slice(None))), None),
        ("surface alone", default, _picks(frames, _without(buried)), None),
        own(
            "one slab",
            replace(default, peak_power=default.peak_power[:2], decay_rate=default.decay_rate[:2]),
        ),
        own("one zone: level slabs", replace(default, thickness_sd=0.0)),
        ("zones without data", default, frames, [10.0, 20, 30, 40, 90]),
        ("less than a block", default, cut(slow_time=slice(0, 255)), None),
        ("layer in 4 groups", default, _picks(frames, _without(deepest, slice(20, None))), None),
        (
            "layer in no whole block",
            default,
            _picks(frames, _without(deepest, slice(120, 130))),
            None,
        ),
        ("gaps in every block", default, _picks(frames, _without(buried, slice(100, 110))), None),
        ("layer never picked", default, _picks(frames, _without(2)), None),
        (
            "surface not picked in a frame",
            default,
            _picks(frames, _without(0, first_frame=3)),
            None,
        ),
        (
            "first slab picked in one frame",
            default,
            _picks(frames, _without(1, first_frame=1)),
            None,
        ),
        ("picks below the record", default, cut_rows(slice(0, 200)), None),
        ("no air above the surface", default, cut_rows(slice(30, None)), None),
        ("a third of the lines lost", default, [_lost_lines(frame) for frame in frames], None),
        own("no speckle", replace(default, n_looks=np.inf)),
        ("layers cross", default, _picks(frames, _crossed), None),
    ]


def draw_atlas(stream, *, share=1.0):
    """Rows of all panels as a table with `COLUMNS`; `stream` and `share` as for `sweep`, borders are always run."""
    rows = [row for panel in SWEEPS for row in sweep(panel, stream, share=share)]
    for name, planted, frames, edges in border_cases(stream):
        for estimator in ESTIMATORS:
            rows += compared(PANEL, name, planted, frames, estimator, zone_edge_bins=edges)
    return pd.DataFrame(rows, columns=list(COLUMNS))
