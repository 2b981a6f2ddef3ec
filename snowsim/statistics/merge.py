"""Summaries of frames as one flight: merged in any order, on disk and back, stacked into arrays."""

import numpy as np
import xarray as xr

from snowsim.statistics.frames import GROUP_LINES, FrameSummary

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
