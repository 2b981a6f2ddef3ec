"""What the statistics need of a frame, read once: picks, power under them, averaged lines, air.

Merged in any order.
"""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numba import njit

from snowsim.echogram import along_track_m, bin_size_s, check_echogram, check_layers, layer_bins_of
from snowsim.limits import check_count
from snowsim.statistics.texture import texture_terms

GROUP_LINES = 20  # lines averaged incoherently, Yari et al. (2021), section III
FIRST_ROW = -40  # averaged lines begin here, in bins from the surface
# Of a group's picks of a layer, sorted by depth: the rows that a sloping layer covers.
PARTS = 4
# Bins above the surface that still hold its rise: 8 standard deviations at a variance of 15.
AIR_MARGIN_BINS = 30
# Of products down range, from 0; the last give what lines share beyond the range response.
AIR_LAGS = 13
ROWS_BELOW = 60  # averaged lines end here below the frame's deepest pick
SAME_BIN_SIZE = 1e-4  # a tenth of a bin over 1000 bins
BY_FRAME = ("start_ns", "bin_size_s", "line_spacing_m", "n_outside")
BY_LINE = ("depth_bins", "tracked_power")
# Dimensions of what is held by group; layers and rows of a frame are fewer than those of a flight.
BY_GROUP = {
    "power": ("group", "row"),
    "position": ("group", "layer", "part"),
    "spread": ("group", "layer", "part"),
    "n_picks": ("group", "layer"),
    "air_sum": ("group",),
    "air_square": ("group",),
    "air_count": ("group",),
    "air_products": ("group", "air_lag"),
    "air_pairs": ("group", "air_lag"),
    "texture_terms": ("group", "term"),
}
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
    # picks below the surface, which is bridged linearly in its gaps but not in its own row
    depth_bins: np.ndarray
    tracked_power: np.ndarray  # linear power in the bin of each pick
    # (range_line,), float32, NaN where it is not picked:
    surface_bins: np.ndarray  # row of the surface
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
    n_outside: int  # picks outside the record or on lines without power, treated as gaps

    def order(self):
        """Sorting key: time, then content for frames that share one."""
        return (
            self.start_ns,
            self.depth_bins.shape,
            float(self.air_sum.sum()),
            float(np.nansum(self.tracked_power)),
        )


def summarise(echogram, layers, where="frame"):
    """One frame as a list of one `FrameSummary`, for `merge`.

    Echogram and layers follow the Open Polar Radar convention. Layer 0 is the snow surface. Picks
    outside the record become gaps and are counted; a frame without a surface pick adds nothing; up
    to 19 range lines at its end belong to no group; data that are exactly zero are padding, not
    air, and a range line of nothing else is missing. ValueError, naming the frame by `where`, if a
    dataset breaks the convention or no two range lines have a position.
    """
    check_echogram(echogram, where)
    check_layers(layers, where)
    power = np.ascontiguousarray(echogram["Data"].transpose("slow_time", "twtt").values)
    layer_bins = layer_bins_of(layers, echogram)
    power, layer_bins, n_outside = _within_record(power, layer_bins)
    n_lines = len(power)
    n_groups = n_lines // GROUP_LINES
    surface = np.zeros(n_lines)
    if np.isfinite(layer_bins[0]).any():
        surface = _bridged(layer_bins[0])
    else:
        layer_bins[:] = np.nan
        n_groups = 0
    surface_row = np.rint(surface).astype(np.int64)
    rows = layer_bins - surface_row
    deepest_row = np.fmax.reduce([surface_row, *layer_bins])
    # No line is deeper below its surface than this.
    n_rows = int(np.ceil((deepest_row - surface_row).max())) + ROWS_BELOW - FIRST_ROW + 1

    def grouped(of_line):
        whole = of_line[: n_groups * GROUP_LINES]
        return whole.reshape(n_groups, GROUP_LINES, *of_line.shape[1:])

    averaged, air = _average(power, surface_row, n_groups, n_rows)
    products, pairs = _air_products(power, surface_row, n_groups)
    grouped_rows = grouped(rows.T).swapaxes(1, 2)
    position, spread = _positions(np.sort(grouped_rows))
    air_end = grouped(surface_row - AIR_MARGIN_BINS)
    texture = texture_terms(grouped(power), air_end, grouped(deepest_row))
    start = echogram["slow_time"].values[0].astype("datetime64[ns]")
    summary = FrameSummary(
        start_ns=int(start.astype(np.int64)),
        bin_size_s=bin_size_s(echogram),
        line_spacing_m=_line_spacing_m(echogram, where),
        depth_bins=(layer_bins - surface).astype(np.float32),
        tracked_power=_tracked(power, layer_bins),
        surface_bins=layer_bins[0].astype(np.float32),
        power=averaged,
        position=position,
        spread=spread,
        n_picks=np.isfinite(grouped_rows).sum(axis=2),
        air_sum=air[0],
        air_square=air[1],
        air_count=air[2].astype(np.int64),
        air_products=products,
        air_pairs=pairs,
        texture_terms=texture,
        n_outside=n_outside,
    )
    return [summary]


def _within_record(power, layer_bins):
    """Power without lines of zeros, picks where there is power, and how many lie elsewhere."""
    empty = (power == 0).all(axis=1)
    if empty.any():
        power = np.where(empty[:, None], np.nan, power)
    outside = (layer_bins <= -0.5) | (layer_bins >= power.shape[1] - 0.5)
    outside |= empty & np.isfinite(layer_bins)
    return power, np.where(outside, np.nan, layer_bins), int(outside.sum())


def _line_spacing_m(echogram, where):
    spacing_m = np.diff(along_track_m(echogram)) if echogram.sizes["slow_time"] > 1 else np.nan
    n_known = np.isfinite(spacing_m).sum()
    check_count(f"{where}: neighbouring range lines with Latitude and Longitude", n_known)
    return float(np.nanmedian(spacing_m))


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
    n_range_bins = power.shape[1]
    for group in range(n_groups):
        total = np.zeros(n_rows)
        count = np.zeros(n_rows)
        for line in range(group * GROUP_LINES, (group + 1) * GROUP_LINES):
            top = surface_row[line] + FIRST_ROW
            for row in range(max(0, -top), min(n_rows, n_range_bins - top)):
                value = power[line, top + row]
                if not np.isnan(value):
                    total[row] += value
                    count[row] += 1
            air_end = min(surface_row[line] - AIR_MARGIN_BINS, n_range_bins)
            for range_bin in range(max(0, air_end)):
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


def _air_products(power, surface_row, n_groups):
    """Sums of products of deviations in the air, float64 (group, air_lag), and numbers of products.

    Of whole groups. Power is divided by its line's mean, which removes gain and overloaded lines;
    then its row's mean is subtracted, which removes bands of coherent noise. Both change a product
    by the same amount at every lag.
    """
    air_end = surface_row[: n_groups * GROUP_LINES] - AIR_MARGIN_BINS
    n_bins = max(int(air_end.max(initial=0)), 0)
    air = power[: air_end.size, :n_bins].astype(float)
    held = (air > 0) & (np.arange(n_bins) < air_end[:, None])
    air = np.where(held, air, 0)
    total = np.maximum(air.sum(axis=1), np.finfo(float).tiny)
    air *= (held.sum(axis=1) / total)[:, None]
    row_mean = air.sum(axis=0) / np.maximum(held.sum(axis=0), 1)
    deviation = np.where(held, air - row_mean, 0)
    products = _products_by_group(deviation, n_groups)
    pairs = _products_by_group(held.astype(float), n_groups)
    return products, pairs.astype(np.int64)


def _products_by_group(values, n_groups):
    """Sums of products of values (range_line, range_bin) so many bins apart, (group, air_lag)."""
    n_bins = values.shape[1]
    by_lag = []
    for lag in range(AIR_LAGS):
        upper = values[:, : max(n_bins - lag, 0)]
        by_lag.append(np.einsum("ij,ij->i", upper, values[:, lag:]))
    by_line = np.stack(by_lag, axis=1)
    return by_line.reshape(n_groups, GROUP_LINES, AIR_LAGS).sum(axis=1)


@njit(cache=True)
def _positions(rows):
    """Mean and variance of each part of rows (group, layer, line), sorted, NaN at its end."""
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
    """Lists of `FrameSummary` as one, sorted by time.

    ValueError if there is no frame or their bin sizes differ.
    """
    frames = [frame for summary in summaries for frame in summary]
    check_count("frames of a flight", len(frames))
    frames.sort(key=FrameSummary.order)
    first = frames[0].bin_size_s
    for frame in frames:
        if abs(frame.bin_size_s - first) > SAME_BIN_SIZE * first:
            time = np.datetime64(frame.start_ns, "ns")
            msg = (
                f"frames of a flight must share one bin size, got {first:g} s and, at {time}, "
                f"{frame.bin_size_s:g} s"
            )
            raise ValueError(msg)
    return frames


def summary_to_dataset(summary):
    """A summary as a dataset for `snowsim.io.files.write_dataset`.

    Frames lie one after the other, padded with NaN.
    """
    variables = {}
    for name in BY_FRAME:
        variables[name] = "frame", np.array([getattr(frame, name) for frame in summary])
    variables["n_lines"] = "frame", np.array([frame.surface_bins.size for frame in summary])
    variables["n_groups"] = "frame", np.array([len(frame.power) for frame in summary])
    variables["n_layers"] = "frame", np.array([len(frame.depth_bins) for frame in summary])
    variables["n_rows"] = "frame", np.array([frame.power.shape[1] for frame in summary])
    for name in BY_LINE:
        lines = [getattr(frame, name).T for frame in summary]
        variables[name] = ("range_line", "layer"), _joined(lines)
    variables["surface_bins"] = "range_line", stacked(summary, "surface_bins")
    for name, dims in BY_GROUP.items():
        variables[name] = dims, stacked(summary, name)
    return xr.Dataset(variables, attrs={"content": CONTENT})


def summary_from_dataset(dataset):
    """The summary in a dataset of `summary_to_dataset`."""
    last_line = dataset["n_lines"].values.cumsum()
    last_group = dataset["n_groups"].values.cumsum()
    summary = []
    for i in range(dataset.sizes["frame"]):
        frame = dataset.isel(frame=i)
        first_line = last_line[i] - int(frame["n_lines"])
        first_group = last_group[i] - int(frame["n_groups"])
        frame = frame.isel(
            range_line=slice(first_line, last_line[i]),
            group=slice(first_group, last_group[i]),
            layer=slice(int(frame["n_layers"])),
            row=slice(int(frame["n_rows"])),
        )
        parts = {name: frame[name].item() for name in BY_FRAME}
        for name in BY_LINE:
            parts[name] = np.ascontiguousarray(frame[name].values.T)
        for name in ("surface_bins", *BY_GROUP):
            parts[name] = frame[name].values
        summary.append(FrameSummary(**parts))
    return summary


def stacked(summary, name):
    """One array of all groups of a flight, (group,) or (group, row or layer, ...), padded."""
    return _joined([getattr(frame, name) for frame in summary])


def stacked_tracked(summary):
    """Power under the picks of all groups, (group, layer, line of the group); NaN in gaps."""
    parts = []
    for frame in summary:
        n_groups = len(frame.power)
        lines = frame.tracked_power[:, : n_groups * GROUP_LINES]
        by_group = lines.reshape(len(lines), n_groups, GROUP_LINES)
        parts.append(by_group.swapaxes(0, 1))
    return _joined(parts)


def _joined(parts):
    """Arrays one after the other, axis 1 filled up to the widest with NaN, integers with 0."""
    if parts[0].ndim == 1:
        return np.concatenate(parts)
    width = max(part.shape[1] for part in parts)
    fill = np.nan if parts[0].dtype.kind == "f" else 0
    filled = []
    for part in parts:
        missing = [(0, 0)] * part.ndim
        missing[1] = (0, width - part.shape[1])
        filled.append(np.pad(part, missing, constant_values=fill))
    return np.concatenate(filled)
