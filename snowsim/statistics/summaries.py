"""One frame read once: picks, the power under them, averaged range lines, air; kept small, merged in any order.

Summaries of frames as one flight: merged in any order, on disk and back, stacked into arrays.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numba import njit

from snowsim.echogram import along_track_m, bin_size_s, check_echogram, check_layers, layer_bins_of

GROUP_LINES = 20  # lines averaged incoherently, Yari et al. (2021), section III
FIRST_ROW = -40  # averaged lines begin here, in bins from the surface
PARTS = 4  # of a group's picks of a layer, in order of depth: where its layers lie, for averages of sloping layers
AIR_MARGIN_BINS = 30  # bins above the surface that still hold its rise: 8 standard deviations at a variance of 15
ROWS_BELOW = 60  # averaged lines end here below the frame's deepest pick


@dataclass(frozen=True)
class FrameSummary:
    """What the statistics need of one frame, some 0.4 kB a range line.

    Attributes
    ----------
    start_ns : int
        UTC of the first range line [ns since 1970].
    bin_size_s, line_spacing_m : float
        Two-way travel time of a range bin; median distance of range lines.
    depth_bins : ndarray of float32, (layer, range_line)
        Picks below the surface; NaN in gaps. A surface gap is bridged linearly for reference, its own row stays NaN.
    tracked_power : ndarray of float32, (layer, range_line)
        Linear power in the bin of each pick; NaN in gaps.
    power : ndarray of float32, (group, row)
        Range lines averaged in groups of 20, each shifted by the whole bin of its surface, from `FIRST_ROW` down; NaN
        outside the record. The shift leaves the sub-bin remainder, a variance of up to 1/12 bins^2, in the positions.
    position, spread : ndarray of float32, (group, layer, part)
        Mean row and variance of the row of each quarter of the layer's picks in a group, in order of depth; NaN with
        fewer than `PARTS` picks.
    n_picks : ndarray of int, (group, layer)
        Picks in the group.
    air_sum, air_square, air_count : ndarray, (group,)
        Sum and sum of squares of the power in the air more than `AIR_MARGIN_BINS` above the surface, number of bins.
    n_outside : int
        Picks outside the record, treated as gaps.
    """

    start_ns: int
    bin_size_s: float
    line_spacing_m: float
    depth_bins: np.ndarray
    tracked_power: np.ndarray
    power: np.ndarray
    position: np.ndarray
    spread: np.ndarray
    n_picks: np.ndarray
    air_sum: np.ndarray
    air_square: np.ndarray
    air_count: np.ndarray
    n_outside: int

    def order(self):
        """Sorting key: time, then content for frames that share one."""
        return self.start_ns, self.depth_bins.shape, float(self.air_sum.sum()), float(np.nansum(self.tracked_power))


def summarise(echogram, layers, where="frame"):
    """Reduce one frame to what the statistics need.

    Parameters
    ----------
    echogram, layers : xarray.Dataset
        Open Polar Radar convention: `Data` (linear power) on `twtt`, `slow_time`; `twtt` on `layer`, `slow_time`, layer
        0 the snow surface, NaN in gaps.
    where : str
        Names the frame in errors.

    Returns
    -------
    list of FrameSummary
        One element; `merge` concatenates.

    Raises
    ------
    ValueError
        If a dataset breaks the convention or no two range lines have a position.

    Notes
    -----
    Picks outside the record become gaps, counted. A frame without one surface pick adds nothing. Up to 19
    range lines at the end of a frame belong to no group. Data that are exactly zero are padding and no air.
    """
    check_echogram(echogram, where)
    check_layers(layers, where)
    power = np.ascontiguousarray(echogram["Data"].transpose("slow_time", "twtt").values)
    layer_bins = layer_bins_of(layers, echogram)
    n_lines, n_range_bins = power.shape
    with np.errstate(invalid="ignore"):
        outside = (layer_bins <= -0.5) | (layer_bins >= n_range_bins - 0.5)
    layer_bins[outside] = np.nan
    surface_row, picked = _surface_rows(layer_bins)
    if not picked:
        layer_bins[:] = np.nan
    rows = layer_bins - surface_row
    n_groups = n_lines // GROUP_LINES if picked else 0
    deepest = int(np.ceil(np.nanmax(rows))) if picked else 0
    averaged, air = _average(power, surface_row, n_groups, deepest + ROWS_BELOW - FIRST_ROW + 1)
    grouped = rows[:, : n_groups * GROUP_LINES].reshape(len(rows), n_groups, GROUP_LINES).swapaxes(0, 1)
    position, spread = _positions_compiled(np.sort(grouped), PARTS)
    spacing = np.diff(along_track_m(echogram)) if n_lines > 1 else np.array([np.nan])
    if not np.isfinite(spacing).any():
        msg = f"{where}: Latitude and Longitude must be finite on two neighbouring range lines, are on none"
        raise ValueError(msg)
    surface = layer_bins[0] if layer_bins.shape[0] else np.empty(n_lines)
    summary = FrameSummary(
        start_ns=int(echogram["slow_time"].values[0].astype("datetime64[ns]").astype(np.int64)),
        bin_size_s=bin_size_s(echogram),
        line_spacing_m=float(np.nanmedian(spacing)),
        depth_bins=(layer_bins - _bridged(surface)).astype(np.float32),
        tracked_power=_tracked(power, layer_bins),
        power=averaged,
        position=position,
        spread=spread,
        n_picks=np.isfinite(grouped).sum(axis=2),
        air_sum=air[0],
        air_square=air[1],
        air_count=air[2].astype(np.int64),
        n_outside=int(outside.sum()),
    )
    return [summary]


def _bridged(surface):
    """Surface with its gaps bridged linearly; NaN throughout if there is nothing to bridge from."""
    known = np.isfinite(surface)
    if not known.any():
        return np.full(surface.shape, np.nan)
    return np.interp(np.arange(surface.size), np.flatnonzero(known), surface[known])


def _surface_rows(layer_bins):
    """Whole bin of the surface in every line, (range_line,), and whether a surface pick exists at all."""
    if not (layer_bins.shape[0] and np.isfinite(layer_bins[0]).any()):
        return np.zeros(layer_bins.shape[1], dtype=np.int64), False
    return np.rint(_bridged(layer_bins[0])).astype(np.int64), True


def _tracked(power, layer_bins):
    """Power in the bin of each pick, float32 (layer, range_line), NaN in gaps."""
    layer, line = np.nonzero(np.isfinite(layer_bins))
    tracked = np.full(layer_bins.shape, np.nan, dtype=np.float32)
    tracked[layer, line] = power[line, np.rint(layer_bins[layer, line]).astype(int)]
    return tracked


def _average(power, surface_row, n_groups, n_rows):
    """Averaged lines float32 (group, row), and air (3, group): sum, sum of squares, count."""
    return _average_compiled(power, surface_row, n_groups, n_rows, GROUP_LINES, FIRST_ROW, AIR_MARGIN_BINS)


@njit(cache=True)
def _average_compiled(power, surface_row, n_groups, n_rows, group_lines, first_row, air_margin):
    averaged = np.full((n_groups, n_rows), np.nan, dtype=np.float32)
    air = np.zeros((3, n_groups))
    for group in range(n_groups):
        total = np.zeros(n_rows)
        count = np.zeros(n_rows)
        for line in range(group * group_lines, (group + 1) * group_lines):
            top = surface_row[line] + first_row
            for row in range(max(0, -top), min(n_rows, power.shape[1] - top)):
                value = power[line, top + row]
                if not np.isnan(value):
                    total[row] += value
                    count[row] += 1
            for range_bin in range(max(0, min(surface_row[line] - air_margin, power.shape[1]))):
                value = np.float64(power[line, range_bin])
                if value > 0:
                    air[0, group] += value
                    air[1, group] += value * value
                    air[2, group] += 1
        for row in range(n_rows):
            # A row that only some lines of a group reach would mix depths of different noise and fading.
            if 2 * count[row] >= group_lines:
                averaged[group, row] = total[row] / count[row]
    return averaged, air


@njit(cache=True)
def _positions_compiled(rows, n_parts):
    """Mean and variance of each part of rows (group, layer, line) sorted along the last axis with NaN at its end."""
    n_groups, n_layers, n_lines = rows.shape
    position = np.full((n_groups, n_layers, n_parts), np.nan, dtype=np.float32)
    spread = np.full((n_groups, n_layers, n_parts), np.nan, dtype=np.float32)
    for group in range(n_groups):
        for layer in range(n_layers):
            n_picks = 0
            while n_picks < n_lines and not np.isnan(rows[group, layer, n_picks]):
                n_picks += 1
            if n_picks < n_parts:
                continue
            for part in range(n_parts):
                held = rows[group, layer, part * n_picks // n_parts : (part + 1) * n_picks // n_parts]
                position[group, layer, part] = held.mean()
                spread[group, layer, part] = held.var()
    return position, spread


SAME_BIN_SIZE = 1e-4  # a tenth of a bin over 1000 bins


def merge(summaries):
    """Summaries of several lots of frames as one, whatever their order and partition.

    Parameters
    ----------
    summaries : iterable of list of FrameSummary

    Returns
    -------
    list of FrameSummary
        Sorted by time.

    Raises
    ------
    ValueError
        If there is none, or bin sizes differ.
    """
    frames = sorted((frame for summary in summaries for frame in summary), key=FrameSummary.order)
    if not frames:
        msg = "a flight needs at least one frame, got none"
        raise ValueError(msg)
    first = frames[0].bin_size_s
    for frame in frames:
        if abs(frame.bin_size_s - first) > SAME_BIN_SIZE * first:
            time = np.datetime64(frame.start_ns, "ns")
            msg = f"frames of a flight must share one bin size, got {first:g} s and, at {time}, {frame.bin_size_s:g} s"
            raise ValueError(msg)
    return frames


_BY_FRAME = ("start_ns", "bin_size_s", "line_spacing_m", "n_outside")
_BY_LINE = ("depth_bins", "tracked_power")  # (layer, range_line)
_BY_GROUP = ("power", "position", "spread", "n_picks", "air_sum", "air_square", "air_count")


def summary_to_dataset(summary):
    """A summary as a dataset for `snowsim.io.files.write_dataset`: frames one after the other, padded with NaN."""
    n_layers = max(frame.depth_bins.shape[0] for frame in summary)
    n_rows = max(frame.power.shape[1] for frame in summary)
    variables = {name: ("frame", np.array([getattr(frame, name) for frame in summary])) for name in _BY_FRAME}
    shape = {
        "n_lines": [frame.depth_bins.shape[1] for frame in summary],
        "n_groups": [frame.power.shape[0] for frame in summary],
        "n_layers": [frame.depth_bins.shape[0] for frame in summary],
        "n_rows": [frame.power.shape[1] for frame in summary],
    }
    variables |= {name: ("frame", np.array(values, dtype=np.int64)) for name, values in shape.items()}
    for name in _BY_LINE:
        parts = [_widened(getattr(frame, name).T, n_layers) for frame in summary]
        variables[name] = (("range_line", "layer"), np.concatenate(parts))
    for name in _BY_GROUP:
        parts = [getattr(frame, name) for frame in summary]
        if parts[0].ndim == 1:
            variables[name] = ("group", np.concatenate(parts))
        else:
            width, dim = (n_rows, "row") if name == "power" else (n_layers, "layer")
            dims = ("group", dim, "part")[: parts[0].ndim]
            variables[name] = (dims, np.concatenate([_widened(part, width) for part in parts]))
    return xr.Dataset(variables, attrs={"content": "snowsim flight summary 1"})


def summary_from_dataset(dataset):
    """The summary in a dataset of `summary_to_dataset`; ValueError if it is none."""
    if dataset.attrs.get("content") != "snowsim flight summary 1":
        msg = f"expected attribute content 'snowsim flight summary 1', got {dataset.attrs.get('content')!r}"
        raise ValueError(msg)
    variables = {name: dataset[name].values for name in dataset.variables}
    summary, line, group = [], 0, 0
    for i in range(dataset.sizes["frame"]):
        lines = slice(line, line + int(variables["n_lines"][i]))
        groups = slice(group, group + int(variables["n_groups"][i]))
        n_layers, n_rows = int(variables["n_layers"][i]), int(variables["n_rows"][i])
        parts = {name: variables[name][i].item() for name in _BY_FRAME}
        parts |= {name: np.ascontiguousarray(variables[name][lines, :n_layers].T) for name in _BY_LINE}
        for name in _BY_GROUP:
            part = variables[name][groups]
            parts[name] = part if part.ndim == 1 else part[:, : n_rows if name == "power" else n_layers]
        summary.append(FrameSummary(**parts))
        line, group = lines.stop, groups.stop
    return summary


def stacked(summary, name):
    """One array of all groups of a flight, (group,) or (group, row or layer, ...), padded with NaN or 0."""
    parts = [getattr(frame, name) for frame in summary]
    if parts[0].ndim == 1:
        return np.concatenate(parts)
    width = max(part.shape[1] for part in parts)
    return np.concatenate([_widened(part, width) for part in parts])


def stacked_tracked(summary):
    """Power under the picks of all groups, (group, layer, line of the group); NaN in gaps."""
    n_layers = max(frame.depth_bins.shape[0] for frame in summary)
    parts = []
    for frame in summary:
        n_groups = frame.power.shape[0]
        lines = frame.tracked_power[:, : n_groups * GROUP_LINES]
        parts.append(_widened(lines.reshape(len(lines), n_groups, GROUP_LINES).swapaxes(0, 1), n_layers))
    return np.concatenate(parts)


def _widened(array, width):
    """`array` with axis 1 filled up to `width` with NaN, integers with 0."""
    missing = [(0, 0)] * array.ndim
    missing[1] = (0, width - array.shape[1])
    return np.pad(array, missing, constant_values=np.nan if array.dtype.kind == "f" else 0)
