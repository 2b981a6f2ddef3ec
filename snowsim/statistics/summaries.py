"""What the statistics need of a frame, read once: picks, power under them, averaged lines, air; merged in any order."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numba import njit

from snowsim.echogram import along_track_m, bin_size_s, check_echogram, check_layers, layer_bins_of
from snowsim.statistics.texture import N_TERMS, texture_terms

GROUP_LINES = 20  # lines averaged incoherently, Yari et al. (2021), section III
FIRST_ROW = -40  # averaged lines begin here, in bins from the surface
PARTS = 4  # of a group's picks of a layer, sorted by depth: they describe the rows that a sloping layer covers
AIR_MARGIN_BINS = (
    30  # bins above the surface that still hold its rise: 8 standard deviations at a variance of 15
)
AIR_LAGS = (
    13  # of products down range, from 0; the last give what lines share beyond the range response
)
ROWS_BELOW = 60  # averaged lines end here below the frame's deepest pick
SAME_BIN_SIZE = 1e-4  # a tenth of a bin over 1000 bins
BY_FRAME = ("start_ns", "bin_size_s", "line_spacing_m", "n_outside")
BY_LINE = ("depth_bins", "tracked_power")
BY_GROUP = (
    *("power", "position", "spread", "n_picks"),
    *("air_sum", "air_square", "air_count", "air_products", "air_pairs", "texture_terms"),
)
DIMENSIONS = {
    "power": "row",
    "air_products": "air_lag",
    "air_pairs": "air_lag",
    "texture_terms": "term",
}  # else layer
FIXED = {"air_lag": AIR_LAGS, "term": N_TERMS}
CONTENT = "snowsim flight summary 4"


@dataclass(frozen=True)
class FrameSummary:
    """What the statistics need of one frame, about 0.4 kB per range line.

    Lines are averaged in groups of 20, each shifted by the whole bin of its surface; the sub-bin
    remainder, a variance of up to 1/12 bins^2, stays in the positions.
    """

    start_ns: int  # UTC of the first range line [ns since 1970]
    bin_size_s: float  # two-way travel time of a range bin
    line_spacing_m: float  # median distance of range lines
    # (layer, range_line), float32, NaN in gaps:
    depth_bins: (
        np.ndarray
    )  # picks below the surface, which is bridged linearly in its gaps but not in its own row
    tracked_power: np.ndarray  # linear power in the bin of each pick
    surface_bins: (
        np.ndarray
    )  # (range_line,), float32, row of the surface, NaN where it is not picked
    # (group, row), float32, NaN outside the record:
    power: np.ndarray  # averaged lines from `FIRST_ROW` below the surface
    # (group, layer, part), float32, by quarters of the picks in order of depth; NaN with fewer than
    # `PARTS` picks:
    position: np.ndarray  # mean row
    spread: np.ndarray  # variance of the row [bins^2]
    n_picks: np.ndarray  # (group, layer), int
    # (group,), power in the air more than `AIR_MARGIN_BINS` above the surface:
    air_sum: np.ndarray
    air_square: np.ndarray  # sum of squares
    air_count: np.ndarray  # number of bins
    # (group, air_lag), of power in the air over its line's mean, less its row's mean over the
    # frame:
    air_products: np.ndarray  # sum of products of bins so many apart
    air_pairs: np.ndarray  # number of them
    texture_terms: np.ndarray  # (group, term), see `snowsim.statistics.texture`
    n_outside: int  # picks outside the record, treated as gaps

    def order(self):
        """Sorting key: time, then content for frames that share one."""
        return (
            self.start_ns,
            self.depth_bins.shape,
            float(self.air_sum.sum()),
            float(np.nansum(self.tracked_power)),
        )


def summarise(echogram, layers, where="frame"):
    """One frame, echogram and layers in the Open Polar Radar convention, as a list of one `FrameSummary` for `merge`.

    Layer 0 is the snow surface. Picks outside the record become gaps and are counted; a frame
    without a surface pick adds nothing; up to 19 range lines at its end belong to no group; data
    that are exactly zero are padding, not air. ValueError, naming the frame by `where`, if a
    dataset breaks the convention or no two range lines have a position.
    """
    check_echogram(echogram, where)
    check_layers(layers, where)
    power = np.ascontiguousarray(echogram["Data"].transpose("slow_time", "twtt").values)
    layer_bins = layer_bins_of(layers, echogram)
    n_lines, n_range_bins = power.shape
    with np.errstate(invalid="ignore"):
        outside = (layer_bins <= -0.5) | (layer_bins >= n_range_bins - 0.5)
    layer_bins[outside] = np.nan
    picked = np.isfinite(layer_bins[:1]).any()
    if not picked:
        layer_bins[:] = np.nan
    surface = _bridged(layer_bins[0]) if picked else np.zeros(n_lines)
    surface_row = np.rint(surface).astype(np.int64)
    rows = layer_bins - surface_row
    n_groups = n_lines // GROUP_LINES if picked else 0
    deepest = int(np.ceil(np.nanmax(rows))) if picked else 0
    averaged, air = _average(power, surface_row, n_groups, deepest + ROWS_BELOW - FIRST_ROW + 1)
    products, pairs = _air_products(
        power[: n_groups * GROUP_LINES], surface_row[: n_groups * GROUP_LINES]
    )
    deepest_row = np.fmax.reduce([surface_row, *layer_bins])
    by_group = (
        of_line[: n_groups * GROUP_LINES].reshape(n_groups, GROUP_LINES, *of_line.shape[1:])
        for of_line in (power, surface_row - AIR_MARGIN_BINS, deepest_row)
    )
    grouped = (
        rows[:, : n_groups * GROUP_LINES].reshape(len(rows), n_groups, GROUP_LINES).swapaxes(0, 1)
    )
    position, spread = _positions(np.sort(grouped))
    spacing = np.diff(along_track_m(echogram)) if n_lines > 1 else np.array([np.nan])
    if not np.isfinite(spacing).any():
        msg = f"{where}: Latitude and Longitude must be finite on two neighbouring range lines, are on none"
        raise ValueError(msg)
    summary = FrameSummary(
        start_ns=int(echogram["slow_time"].values[0].astype("datetime64[ns]").astype(np.int64)),
        bin_size_s=bin_size_s(echogram),
        line_spacing_m=float(np.nanmedian(spacing)),
        depth_bins=(layer_bins - surface).astype(np.float32),
        tracked_power=_tracked(power, layer_bins),
        surface_bins=layer_bins[0].astype(np.float32),
        power=averaged,
        position=position,
        spread=spread,
        n_picks=np.isfinite(grouped).sum(axis=2),
        air_sum=air[0],
        air_square=air[1],
        air_count=air[2].astype(np.int64),
        air_products=products,
        air_pairs=pairs,
        texture_terms=texture_terms(*by_group),
        n_outside=int(outside.sum()),
    )
    return [summary]


def _bridged(surface):
    """Surface with its gaps bridged linearly."""
    known = np.isfinite(surface)
    return np.interp(np.arange(surface.size), np.flatnonzero(known), surface[known])


def _tracked(power, layer_bins):
    """Power in the bin of each pick, float32 (layer, range_line), NaN in gaps."""
    layer, line = np.nonzero(np.isfinite(layer_bins))
    tracked = np.full(layer_bins.shape, np.nan, dtype=np.float32)
    tracked[layer, line] = power[line, np.rint(layer_bins[layer, line]).astype(int)]
    return tracked


@njit(cache=True)
def _average(power, surface_row, n_groups, n_rows):
    """Averaged lines float32 (group, row), and air (3, group): sum, sum of squares, count."""
    averaged = np.full((n_groups, n_rows), np.nan, dtype=np.float32)
    air = np.zeros((3, n_groups))
    for group in range(n_groups):
        total = np.zeros(n_rows)
        count = np.zeros(n_rows)
        for line in range(group * GROUP_LINES, (group + 1) * GROUP_LINES):
            top = surface_row[line] + FIRST_ROW
            for row in range(max(0, -top), min(n_rows, power.shape[1] - top)):
                value = power[line, top + row]
                if not np.isnan(value):
                    total[row] += value
                    count[row] += 1
            for range_bin in range(
                max(0, min(surface_row[line] - AIR_MARGIN_BINS, power.shape[1]))
            ):
                value = np.float64(power[line, range_bin])
                if value > 0:
                    air[0, group] += value
                    air[1, group] += value * value
                    air[2, group] += 1
        for row in range(n_rows):
            # A row that only some lines of a group reach would mix depths of different noise and
            # fading.
            if 2 * count[row] >= GROUP_LINES:
                averaged[group, row] = total[row] / count[row]
    return averaged, air


def _air_products(power, surface_row):
    """Sums of products of deviations in the air, float64 (group, air_lag), and numbers of products, of whole groups.

    Power is divided by its line's mean, which removes gain and overloaded lines; then its row's
    mean is subtracted, which removes bands of coherent noise. Both change a product by the same
    amount at every lag.
    """
    n_bins = max(int(surface_row.max(initial=0)) - AIR_MARGIN_BINS, 0)
    air = power[:, :n_bins].astype(float)
    held = (air > 0) & (np.arange(n_bins) < surface_row[:, None] - AIR_MARGIN_BINS)
    air = np.where(held, air, 0)
    air *= (held.sum(axis=1) / np.maximum(air.sum(axis=1), np.finfo(float).tiny))[:, None]
    deviation = np.where(held, air - air.sum(axis=0) / np.maximum(held.sum(axis=0), 1), 0)
    sums = []
    for values in (deviation, held.astype(float)):
        ends = [(values[:, : max(n_bins - lag, 0)], values[:, lag:]) for lag in range(AIR_LAGS)]
        by_line = np.stack([np.einsum("ij,ij->i", *pair) for pair in ends], axis=1)
        sums.append(by_line.reshape(len(power) // GROUP_LINES, GROUP_LINES, AIR_LAGS).sum(axis=1))
    return sums[0], sums[1].astype(np.int64)


@njit(cache=True)
def _positions(rows):
    """Mean and variance of each part of rows (group, layer, line) sorted along the last axis, NaN at its end."""
    n_groups, n_layers, n_lines = rows.shape
    position = np.full((n_groups, n_layers, PARTS), np.nan, dtype=np.float32)
    spread = np.full((n_groups, n_layers, PARTS), np.nan, dtype=np.float32)
    for group in range(n_groups):
        for layer in range(n_layers):
            n_picks = 0
            while n_picks < n_lines and not np.isnan(rows[group, layer, n_picks]):
                n_picks += 1
            if n_picks < PARTS:
                continue
            for part in range(PARTS):
                held = rows[group, layer, part * n_picks // PARTS : (part + 1) * n_picks // PARTS]
                position[group, layer, part] = held.mean()
                spread[group, layer, part] = held.var()
    return position, spread


def merge(summaries):
    """Lists of `FrameSummary` as one, sorted by time; ValueError if there is no frame or their bin sizes differ."""
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


def summary_to_dataset(summary):
    """A summary as a dataset for `snowsim.io.files.write_dataset`: frames one after the other, padded with NaN."""
    n_layers = max(frame.depth_bins.shape[0] for frame in summary)
    widths = FIXED | {"layer": n_layers, "row": max(frame.power.shape[1] for frame in summary)}
    variables = {
        name: ("frame", np.array([getattr(frame, name) for frame in summary])) for name in BY_FRAME
    }
    shapes = [
        (f.depth_bins.shape[1], len(f.power), len(f.depth_bins), f.power.shape[1]) for f in summary
    ]
    for name, sizes in zip(
        ("n_lines", "n_groups", "n_layers", "n_rows"), np.array(shapes).T, strict=True
    ):
        variables[name] = ("frame", sizes.astype(np.int64))
    for name in BY_LINE:
        parts = [_widened(getattr(frame, name).T, n_layers) for frame in summary]
        variables[name] = (("range_line", "layer"), np.concatenate(parts))
    variables["surface_bins"] = (
        "range_line",
        np.concatenate([frame.surface_bins for frame in summary]),
    )
    for name in BY_GROUP:
        parts = [getattr(frame, name) for frame in summary]
        if parts[0].ndim == 1:
            variables[name] = ("group", np.concatenate(parts))
        else:
            dim = DIMENSIONS.get(name, "layer")
            dims = ("group", dim, "part")[: parts[0].ndim]
            variables[name] = (
                dims,
                np.concatenate([_widened(part, widths[dim]) for part in parts]),
            )
    return xr.Dataset(variables, attrs={"content": CONTENT})


def summary_from_dataset(dataset):
    """The summary in a dataset of `summary_to_dataset`; ValueError if it is none."""
    if dataset.attrs.get("content") != CONTENT:
        msg = f"expected attribute content {CONTENT!r}, got {dataset.attrs.get('content')!r}"
        raise ValueError(msg)
    variables = {name: dataset[name].values for name in dataset.variables}
    summary, line, group = [], 0, 0
    for i in range(dataset.sizes["frame"]):
        lines = slice(line, line + int(variables["n_lines"][i]))
        groups = slice(group, group + int(variables["n_groups"][i]))
        widths = FIXED | {
            "layer": int(variables["n_layers"][i]),
            "row": int(variables["n_rows"][i]),
        }
        parts = {name: variables[name][i].item() for name in BY_FRAME}
        parts |= {
            name: np.ascontiguousarray(variables[name][lines, : widths["layer"]].T)
            for name in BY_LINE
        }
        parts["surface_bins"] = variables["surface_bins"][lines]
        for name in BY_GROUP:
            part = variables[name][groups]
            parts[name] = (
                part if part.ndim == 1 else part[:, : widths[DIMENSIONS.get(name, "layer")]]
            )
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
        parts.append(
            _widened(lines.reshape(len(lines), n_groups, GROUP_LINES).swapaxes(0, 1), n_layers)
        )
    return np.concatenate(parts)


def _widened(array, width):
    """`array` with axis 1 filled up to `width` with NaN, integers with 0."""
    missing = [(0, 0)] * array.ndim
    missing[1] = (0, width - array.shape[1])
    return np.pad(array, missing, constant_values=np.nan if array.dtype.kind == "f" else 0)
