"""The atlas of the estimators: flights planted with eq. (1), to where what was planted is lost.

A row has the mean `error` over layers, its `largest` magnitude, the mean `standard_error` claimed,
and as `note` the rule that degraded the result or the line that refused it. ``beyond`` is further
off than the quantity's bound and than `N_ERRORS` of the errors claimed. The outcome ``not finite``
must not be.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from evaluation.lib.closed_loop import BOUNDS, as_frame
from snowsim.constants import BLOCK_LINES
from snowsim.phy import mean_power
from snowsim.phy.waveform import waveform_width
from snowsim.statistics.estimate import ESTIMATORS, estimate
from snowsim.statistics.summaries import GROUP_LINES, merge, summarise
from snowsim.statistics.zones import ALL_ZONES, OTHER_SLABS

SURFACE_BIN = 60.0
BIN_SIZE_S = 2.886e-10
LINE_SPACING_M = 5.47
PANEL = "borders"  # of the panels the one that is no sweep
# Of its own, which an estimate may be off even beyond its bound: short flights tell no more.
N_ERRORS = 3
GAP_LINES = 24  # mean length of a gap in a layer's picks [range lines]
COLUMNS = (
    "panel",
    "value",
    "estimator",
    "quantity",
    "error",
    "largest",
    "standard_error",
    "unit",
    "bound",
    "outcome",
    "note",
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
        return {
            "peak_power": np.array(self.peak_power),
            "decay_rate": decay,
            "width_bins": waveform_width(self.variance_bins2, decay),
            "noise_power": np.array([self.noise_power]),
        }

    def frames(self, rng):
        """Pairs of echogram and layers, one at a time; layers are level within a group of lines."""
        for index in range(self.n_frames):
            layer_bins = self._layer_bins(rng)
            power = self._by_line(self._mean_power(layer_bins[:, ::GROUP_LINES]))
            if np.isfinite(self.n_looks):
                power = power * rng.gamma(self.n_looks, 1 / self.n_looks, power.shape)
            yield as_frame(
                power, layer_bins, index, bin_size_s=BIN_SIZE_S, line_spacing_m=LINE_SPACING_M
            )

    def _layer_bins(self, rng):
        """Rows of layers, (layer, range_line)."""
        n_slabs = len(self.peak_power) - 1
        n_groups = -(-self.n_lines // GROUP_LINES)
        thickness = np.full((n_slabs, n_groups), self.slab_bins)
        if self.thickness_sd > 0:
            # From frame to frame as from group to group: block means then differ, as do zones.
            for n_drawn in (1, n_groups):
                drawn = rng.standard_normal((n_slabs, n_drawn))
                thickness = thickness * np.exp(self.thickness_sd * drawn)
        surface = SURFACE_BIN + rng.uniform(-0.5, 0.5, (1, n_groups))
        return self._by_line(np.cumsum(np.concatenate([surface, thickness]), axis=0))

    def _by_line(self, of_groups):
        """Values (row, range_line) of values (row, group)."""
        return np.repeat(of_groups, GROUP_LINES, axis=1)[:, : self.n_lines]

    def _mean_power(self, layer_bins):
        """Mean power with the waveforms' peaks on the layers, (range_bin, column)."""
        power = mean_power(
            layer_bins,
            self.peak_power,
            np.full(len(layer_bins), self.variance_bins2),
            self.decay_rate,
            n_range_bins=int(layer_bins.max()) + 100,
        )
        return power + self.noise_power


def compared(panel, value, planted, frames, estimator, *, zone_edge_bins=None):
    """Rows of the atlas for one flight and one estimator."""
    row = {"panel": panel, "value": value, "estimator": estimator}
    try:
        summary = merge(summarise(*frame) for frame in frames)
        fitted = estimate(summary, estimator=estimator, zone_edge_bins=zone_edge_bins)
    except ValueError as error:
        return [{**row, "quantity": "all", "outcome": "refused", "note": str(error)}]
    row["note"] = rules_applied(fitted)
    if not is_finite(fitted):
        return [{**row, "quantity": "all", "outcome": "not finite"}]
    return [row | _compared(fitted, quantity, true) for quantity, true in planted.truth().items()]


def is_finite(fitted):
    """Whether every number is finite but the decay rate of the deepest layer in `paper`."""
    is_paper = fitted.attrs["estimator"] == "paper"
    for name, variable in fitted.variables.items():
        has_deepest = not (is_paper and name.startswith("decay_rate"))
        values = variable.values if has_deepest else variable.values[:-1]
        if not np.isfinite(values).all():
            return False
    numbers = [value for value in fitted.attrs.values() if not isinstance(value, str)]
    return all(map(np.isfinite, numbers))


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
    found = np.atleast_1d(fitted[quantity].values)
    claimed = np.atleast_1d(fitted[f"{quantity}_standard_error"].values)
    n = min(found.size, true.size)
    known = np.flatnonzero(np.isfinite(found[:n]))
    true = true[known]
    claimed = claimed[known]
    scale = true if bound.unit == "relative" else 1.0
    error = (found[known] - true) / scale
    allowed = np.maximum(bound.largest, N_ERRORS * claimed / scale)
    size = np.abs(error)
    return {
        "quantity": quantity,
        "error": _rounded(error.mean()),
        "largest": _rounded(size.max()),
        "standard_error": _rounded((claimed / scale).mean()),
        "unit": bound.unit,
        "bound": bound.largest,
        "outcome": "within" if (size <= allowed).all() else "beyond",
    }


def _rounded(number):
    """Three digits: beyond them results differ between machines."""
    return float(f"{number:.3g}")


def _weakest_over_noise(ratio_db):
    return Planted(noise_power=min(Planted.peak_power) * 10 ** (-ratio_db / 10))


# Values of each sweep, and the flight planted for one.
SWEEPS = {
    "slab thickness [bins]": (
        (3, 5, 8, 12, 18, 27, 44, 80),
        lambda bins: Planted(slab_bins=bins),
    ),
    "weakest layer over noise [dB]": (
        (-15, -10, -5, 0, 5, 10, 20, 30),
        _weakest_over_noise,
    ),
    "looks of a range line": ((0.2, 0.5, 1, 2, 5, 20, 100), lambda n: Planted(n_looks=n)),
    "range lines of a flight": (
        (200, 256, 512, 1024, 2048, 4096),
        lambda n: Planted(n_frames=1, n_lines=n),
    ),
    "share of picks missing": ((0, 0.2, 0.4, 0.6, 0.8, 0.95), lambda _: Planted()),
}


def sweep(panel, stream, *, share=1.0):
    """Rows of one panel of `SWEEPS` by every estimator.

    `share` of its values, spread evenly, both ends included; `stream` gives the random generator of
    a panel and a value.
    """
    values, plant = SWEEPS[panel]
    n_chosen = max(int(np.ceil(share * len(values))), 2)
    chosen = np.linspace(0, len(values) - 1, n_chosen).round().astype(int)
    rows = []
    for value in (values[place] for place in np.unique(chosen)):
        planted = plant(value)
        rng = stream(panel, value)
        frames = list(planted.frames(rng))
        if panel == "share of picks missing":
            frames = [with_gaps(frame, value, rng) for frame in frames]
        for estimator in ESTIMATORS:
            rows += compared(panel, float(value), planted, frames, estimator)
    return rows


def with_gaps(frame, share, rng):
    """A frame whose buried layers lose this share of picks, in runs of `GAP_LINES` on average."""
    echogram, layers = frame
    layers = layers.copy(deep=True)
    if share > 0:
        twtt = layers["twtt"].values
        n_layers, n_lines = twtt.shape
        leave = 1 / GAP_LINES
        enter = min(share / max(1 - share, 1e-9) / GAP_LINES, 1.0)
        missing = rng.random(n_layers) < share
        for line in range(n_lines):
            turn = rng.random(n_layers)
            missing = np.where(missing, turn >= leave, turn < enter)
            twtt[1:, line][missing[1:]] = np.nan
    return echogram, layers


def _with_picks(frame, layer, lines, twtt):
    """A frame with other travel times of a layer, or of a slice of them."""
    echogram, layers = frame
    layers = layers.copy(deep=True)
    layers["twtt"].values[layer, lines] = twtt
    return echogram, layers


def _without(frames, layer, lines=slice(None), first_frame=0):
    """Frames that lose picks of a layer, or of a slice of them, from a frame on."""
    lost = [_with_picks(frame, layer, lines, np.nan) for frame in frames[first_frame:]]
    return frames[:first_frame] + lost


def _crossed(frame):
    """A frame with a layer below the next in one place."""
    _, layers = frame
    return _with_picks(frame, 2, 100, layers["twtt"].values[3, 100] + 1e-9)


def _lost_lines(frame):
    """A frame with every third group of lines not recorded."""
    echogram, layers = frame
    echogram = echogram.copy(deep=True)
    lost = (np.arange(echogram.sizes["slow_time"]) // 20) % 3 == 1
    echogram["Data"].values[:, lost] = np.nan
    return echogram, layers


def _cut_rows(frames, rows):
    return [(echogram.isel(twtt=rows), layers) for echogram, layers in frames]


def _cut_lines(frames, lines):
    return [tuple(part.isel(slow_time=lines) for part in frame) for frame in frames]


@dataclass(frozen=True)
class Border:
    """A case at the limits of valid input: the planted flight, its frames, zone edges if given."""

    name: str
    planted: Planted
    frames: list
    zone_edge_bins: list | None = None


def border_cases(stream):
    """Every `Border`."""
    default = Planted()
    frames = list(default.frames(stream(PANEL, "default")))
    buried = slice(1, None)
    deepest = len(default.peak_power) - 1

    def changed(name, frames, zone_edge_bins=None):
        return Border(name, default, frames, zone_edge_bins)

    def without(name, *picks, **options):
        return changed(name, _without(frames, *picks, **options))

    def own(name, **changes):
        planted = Planted(**changes)
        return Border(name, planted, list(planted.frames(stream(PANEL, name))))

    return [
        changed("as planted", frames),
        without("no layers", slice(None)),
        without("surface alone", buried),
        own("one slab", peak_power=default.peak_power[:2], decay_rate=default.decay_rate[:2]),
        own("one zone: level slabs", thickness_sd=0.0),
        changed("zones without data", frames, [10.0, 20, 30, 40, 90]),
        changed("less than a block", _cut_lines(frames, slice(0, 255))),
        without("layer in 4 groups", deepest, slice(20, None)),
        without("layer in no whole block", deepest, slice(120, 130)),
        without("gaps in every block", buried, slice(100, 110)),
        without("layer never picked", 2),
        without("surface not picked in a frame", 0, first_frame=3),
        without("first slab picked in one frame", 1, first_frame=1),
        changed("picks below the record", _cut_rows(frames, slice(0, 200))),
        changed("no air above the surface", _cut_rows(frames, slice(30, None))),
        changed("a third of the lines lost", [_lost_lines(frame) for frame in frames]),
        own("no speckle", n_looks=np.inf),
        changed("layers cross", [_crossed(frame) for frame in frames]),
    ]


def draw_atlas(stream, *, share=1.0):
    """Rows of all panels as a table with `COLUMNS`.

    `stream` and `share` as for `sweep`; borders are always run.
    """
    rows = []
    for panel in SWEEPS:
        rows += sweep(panel, stream, share=share)
    for case in border_cases(stream):
        edges = case.zone_edge_bins
        for estimator in ESTIMATORS:
            rows += compared(
                PANEL, case.name, case.planted, case.frames, estimator, zone_edge_bins=edges
            )
    return pd.DataFrame(rows, columns=list(COLUMNS))
