"""Echograms and their layers on common axes: joined, resampled, levelled, and cut into scenes.

`join` puts the layers on the range lines of their echogram and checks both clocks. Later steps
receive an echogram and layers that were joined.
"""

import warnings

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.constants import BLOCK_LINES, EARTH_RADIUS_M, SPEED_OF_LIGHT_M_S
from snowsim.echogram import (
    INVENTED_TIME,
    SURFACE_NAME,
    SURFACE_ROW,
    Scene,
    check_choice,
    is_surface,
    named_frame,
    scene_height,
    to_uint8,
)

OVERLAP_LINES = 6  # range lines that neighbouring blocks share
FLAGGED = "range lines flagged"  # last words of the reason why a block is skipped
FAR_BINS = 6  # if layer 0 is further from the echogram's surface, it may be another layer
FAR_M = 500.0  # if layers are further from the echogram, their range lines are others
# [median spacings of a layer file] Largest distance between a pick and a range line that uses it.
FARTHEST_PICK = 1.5
# [spacings] Two files differ by less than this in the time of a range line, by rounding alone.
SAME_LINE_SPACINGS = 1e-3
# A flight may pass midnight, and segments are named by the day on which they begin.
MOST_DAYS = 1
# Aircraft fly at 60 to 250 m/s and record several range lines a second.
FAR_APART_M = 1000.0
FASTEST_M_S = 350.0
LEAST_SPACING_M = 0.01  # below this mean spacing all range lines lie on one spot
# An interface, or a pick of its echo; and the peak of the echo of a simulated interface.
TIMES_OF_LAYERS = ("twtt", "peak_twtt")
LEVELLING = ("surface", "elevation", "none")
# Flags of an IRSNO1B supplement for which a range line is left out by default; the archive's
# analysts set them for whole frames. Lines with the three other flags are kept.
# `deconvolution_artifact`: sidelobes some 30 dB below a bright echo do not move layers, and the
# product without deconvolution has the same supplement. `low_SNR`: such lines are weak but
# measured; without them, the mean power would be too high. `land_ice` is a kind of ground, not a
# defect.
FLAGGED_BY = (
    "coh_noise_removal_artifact",  # power without an echo, in the air and below the picks
    "vertical_stripes_artifact",  # likewise: vertical stripes or a raised noise floor
    "missing_data",  # the range gate clips the echogram
    "no_good_data",
    "unclassified_artifact",
)


def bin_size_s(echogram):
    """Length of a range bin of an echogram dataset in two-way travel time [s]."""
    twtt = echogram["twtt"].values
    return float((twtt[-1] - twtt[0]) / (twtt.size - 1))


def data_of(echogram):
    """`Data` of an echogram dataset, (range_bin, range_line)."""
    return echogram["Data"].transpose("twtt", "slow_time").values


def levelled(power, first, n_rows):
    """Power (row, range_line) of `n_rows` bins of each range line, from bin `first` of it down.

    `power` is (range_bin, range_line), `first` (range_line,); bins outside the record are NaN.
    """
    n_bins = len(power)
    dtype = np.result_type(power.dtype, np.float32)
    rows = np.full((n_rows, first.size), np.nan, dtype)
    starts = np.clip(-first, 0, n_rows)
    stops = np.clip(n_bins - first, 0, n_rows)
    # Lines that begin with the same bin are copied together.
    changes = np.flatnonzero(np.diff(first)) + 1
    for line, end in zip([0, *changes], [*changes, first.size], strict=True):
        top, start, stop = first[line], starts[line], stops[line]
        rows[start:stop, line:end] = power[start + top : stop + top, line:end]
    return rows


def echo_twtt(layers):
    """Travel times of the echoes of layers, DataArray of the axes of `twtt` [s].

    They are `peak_twtt` where the layers have it, as simulated ones do, whose `twtt` is that of the
    interface above the peak; else `twtt`. A layer without `twtt` is absent in any case.
    """
    if "peak_twtt" not in layers:
        return layers["twtt"]
    return layers["peak_twtt"].where(layers["twtt"].notnull())


def layer_bins_of(layers, echogram):
    """Echoes of layers in range bins of an echogram, (layer, range_line), NaN where absent.

    ValueError unless both have the same range lines: equally many, and each pair less than half a
    line spacing apart in time.
    """
    twtt = echo_twtt(layers).transpose("layer", "slow_time").values
    theirs, ours = (dataset["slow_time"].values for dataset in (layers, echogram))
    if theirs.size != ours.size:
        msg = f"layers cover {theirs.size} range lines, the echogram {ours.size}"
        raise ValueError(msg)
    away = np.abs(theirs - ours)
    if ours.size > 1 and (2 * away > np.median(np.diff(ours))).any():
        line = int(away.argmax())
        msg = (
            f"layers: slow_time is not that of the echogram: range line {line} is at "
            f"{theirs[line]}, the echogram's at {ours[line]}; "
            "snowsim.alignment.align_layers puts layers on its lines"
        )
        raise ValueError(msg)
    return range_bins(twtt, echogram)


def range_bins(twtt, echogram):
    """Two-way travel times [s] as fractional range bins of an echogram."""
    return (twtt - float(echogram["twtt"].values[0])) / bin_size_s(echogram)


def surface_away_bins(echogram, layers):
    """Median distance of layer 0 from the echogram's own surface [range bins], NaN if unknown.

    If it exceeds `FAR_BINS`, layer 0 may be another layer.
    """
    own = range_bins(echogram["Surface"].values, echogram)
    own[~(own >= 0)] = np.nan  # above the record
    away = np.abs(range_bins(layers["twtt"].isel(layer=0).values, echogram) - own)
    return np.nanmedian(away) if np.isfinite(away).any() else np.nan


def along_track_m(echogram):
    """Distance of every range line from the first with a position, (range_line,) [m].

    The Earth is a sphere of radius 6371 km. Lines without a position are spaced evenly between
    lines with one. Before the first position and after the last, the distance is NaN.
    """
    positions = positions_of(echogram)
    known = np.flatnonzero(np.isfinite(positions).all(axis=0))
    along_m = np.full(positions.shape[1], np.nan)
    if known.size == 0:
        return along_m
    steps_m = distance_m(positions[:, known[:-1]], positions[:, known[1:]])
    inside = np.arange(known[0], known[-1] + 1)
    along_m[inside] = np.interp(inside, known, np.concatenate([[0], np.cumsum(steps_m)]))
    return along_m


def contradictions(echogram, name=""):
    """Notes on a checked echogram where file name, times and positions contradict one another.

    At most one note on the date in the file's `name`, or in the attribute `granule`, and one on
    places: degrees that may be radians, range lines on one spot or kilometres apart, a speed that
    no aircraft has. Nothing is changed.
    """
    notes = (_note_on_date(echogram, name), _note_on_place(echogram))
    return [note for note in notes if note is not None]


def _note_on_date(echogram, name):
    segment = named_frame(name)[0] or named_frame(str(echogram.attrs.get("granule", "")))[0]
    first = echogram["slow_time"].values[0]
    if segment is None or first == INVENTED_TIME:
        return None
    day = pd.to_datetime(segment[:8], format="%Y%m%d", errors="coerce")
    if pd.isna(day) or abs((pd.Timestamp(first).normalize() - day).days) <= MOST_DAYS:
        return None
    return (
        f"the name says {day:%Y-%m-%d}, but slow_time begins on {pd.Timestamp(first):%Y-%m-%d}: "
        "is it counted from another date? Layers are dated by slow_time"
    )


def _note_on_place(echogram):
    positions = positions_of(echogram)
    positions = positions[:, np.isfinite(positions).all(axis=0)]
    steps_m = np.diff(along_track_m(echogram))
    steps_m = steps_m[np.isfinite(steps_m)]
    if steps_m.size == 0:
        return None
    # Degrees as small as any radians: the Gulf of Guinea, without snow or ice.
    largest = np.degrees(np.abs(positions).max(axis=1))
    if largest.max() > 0 and (largest <= (np.pi / 2, 2 * np.pi)).all():
        north, east = np.degrees(positions[:, 0])
        return (
            f"Latitude and Longitude: expected degrees of a place with snow, found {north:.5g}, "
            f"{east:.5g}: are they radians? Taken as degrees, by which range lines lie too close"
        )
    extent_m = distance_m(positions[:, :1], positions).max()
    if extent_m < LEAST_SPACING_M * steps_m.size:
        return (
            f"all range lines lie within {extent_m:.2g} m: expected lines along a flight, for how "
            "many are averaged follows from their spacing"
        )
    n_far = int((steps_m > FAR_APART_M).sum())
    if n_far:
        return (
            f"{n_far} of {steps_m.size} steps from range line to range line are longer than 1 km, "
            f"up to {steps_m.max() / 1000:.4g} km: expected metres, for layers are followed across"
        )
    times = echogram["slow_time"].values
    interval_s = np.median(np.diff(times)) / np.timedelta64(1, "s")
    speed_m_s = np.median(steps_m) / interval_s
    if speed_m_s > FASTEST_M_S and times[0] != INVENTED_TIME:
        return (
            f"range lines {np.median(steps_m):.3g} m and {interval_s:.3g} s apart mean "
            f"{speed_m_s:.4g} m/s: expected less than {FASTEST_M_S:g}, so dates, or how many lines "
            "are averaged, are wrong"
        )
    return None


def order_from_surface(twtt, names):
    """Indices of layers (layer, range_line) from the surface down, (layer,) of int.

    Layer i goes before j if it is above j on a line where both are picked. Layers that share no
    line are ordered by their median depth below the surface. The layer named "surface" goes first.
    Of layers that cross, directly or through others, the shallowest goes first.
    """
    twtt = pd.DataFrame(twtt)
    above = np.array([(row <= twtt.values).any(axis=1) for row in twtt.values])
    np.fill_diagonal(above, False)
    surface = surface_among(names)
    depth = twtt
    if surface is not None:
        above[surface] = np.arange(len(names)) != surface
        above[:, surface] = False
        depth = twtt - twtt.iloc[surface]
    depth = depth.median(axis=1).fillna(twtt.median(axis=1))
    order = []
    left = list(depth.sort_values(kind="stable").index)
    while left:
        free = [layer for layer in left if not above[left, layer].any()]
        order.append((free or left)[0])
        left.remove(order[-1])
    return np.array(order)


def surface_among(names):
    """Index of the name of the snow surface, with or without its group, or None."""
    plain = [name.rpartition(":")[2] for name in names]
    if SURFACE_NAME in plain:
        return plain.index(SURFACE_NAME)
    return next((number for number, name in enumerate(names) if is_surface(name)), None)


def with_fixes(dataset):
    """Dataset with NaN for positions at 0 degrees north and east, where there is no snow."""
    if not {"Latitude", "Longitude"} <= set(dataset):
        return dataset
    away = (dataset["Latitude"] != 0) | (dataset["Longitude"] != 0)
    names = ("Latitude", "Longitude")
    return dataset.assign(**{name: dataset[name].where(away) for name in names})


def positions_of(dataset):
    """Latitude and longitude of range lines, (2, range_line) [radian], NaN where unknown."""
    dataset = with_fixes(dataset)
    return np.radians([dataset[name].values for name in ("Latitude", "Longitude")])


def distance_m(first, second):
    """Distance on a sphere between pairs of places, both of `positions_of`, (range_line,) [m]."""
    half_chord = (
        np.sin((second[0] - first[0]) / 2) ** 2
        + np.cos(first[0]) * np.cos(second[0]) * np.sin((second[1] - first[1]) / 2) ** 2
    )
    return 2 * EARTH_RADIUS_M * np.arcsin(np.sqrt(half_chord))


def join(
    echogram,
    layers,
    *,
    echogram_name="echogram",
    layers_name="layers",
    flagged_by=FLAGGED_BY,
    bin_s=None,
    flattening="surface",
):
    """Echogram and layers of one frame on the same range lines, for statistics and blocks.

    Layers are put on the echogram's lines (`align_layers`). Flagged lines lose their power and
    picks (`leave_out_flagged`). If `bin_s` is given, range bins are resampled to this length
    (`resample_range`). The frame is levelled (`flatten`). The two names appear in messages.
    ValueError if a step refuses the frame, or if all range lines are flagged. UserWarning if layer
    0 is far from the echogram's surface.
    """
    layers = align_layers(layers, echogram, where=layers_name)
    away_bins = surface_away_bins(echogram, layers)
    if away_bins > FAR_BINS:
        msg = (
            f"{layers_name}: layer 0 lies {away_bins:.0f} range bins from the echogram's "
            "Surface in the median: is it the snow surface?"
        )
        warnings.warn(msg, UserWarning, stacklevel=3)
    # Before levelling: a flagged line must not decide where the surface lies.
    echogram, layers = leave_out_flagged(echogram, layers, flags=flagged_by)
    n_flagged, flags = count_flagged(echogram)
    if n_flagged == echogram.sizes["slow_time"]:
        msg = (
            f"{echogram_name}: quality_mask: expected a range line without a flag, "
            f"found all {n_flagged} flagged ({flags})"
        )
        raise ValueError(msg)
    if bin_s is not None:
        echogram = resample_range(echogram, bin_s)
    return flatten(echogram, layers, method=flattening)


def align_layers(layers, echogram, where="layers"):
    """Layers on the range lines of an echogram, with travel times from its antenna.

    `twtt`, and `peak_twtt` if the layers have it, are interpolated between neighbouring picks. They
    are NaN where one of the two is missing, and on range lines that are more than `FARTHEST_PICK`
    line spacings of the layers from the nearest line of the layers. `quality` and `type` are those
    of the nearest line. Layer files have their own antenna elevation. Where both elevations are
    known, ``t += 2 (z_echogram - z_layers) / c``, as in the CReSIS toolbox. Messages begin with
    `where`.

    ValueError if the layers do not cover the echogram's time span to within one of their own line
    spacings, if their positions are far from the echogram's, or if a layer lies outside the
    echogram's window.
    """
    first_time, last_time = echogram["slow_time"].values[[0, -1]]
    theirs_s, ours_s = (
        (dataset["slow_time"].values - first_time) / np.timedelta64(1, "s")
        for dataset in (layers, echogram)
    )
    spacing_s = np.median(np.diff(theirs_s)) if theirs_s.size > 1 else -np.inf
    if theirs_s[0] > spacing_s or theirs_s[-1] + spacing_s < ours_s[-1]:
        msg = (
            f"{where}: slow_time: expected to cover {first_time} to {last_time}, found "
            f"{theirs_s.size} lines, {theirs_s[0]:.6g} to {theirs_s[-1]:.6g} s from the first on"
        )
        raise ValueError(msg)
    nearest = pd.Index(theirs_s).get_indexer(ours_s, method="nearest")
    if {"Latitude", "Longitude"} <= set(layers):
        _check_positions(layers.isel(slow_time=nearest), echogram, where)
    picked = layers.transpose("layer", ...)
    away = np.abs(ours_s - theirs_s[nearest]) / spacing_s
    later_s = 0
    if "Elevation" in layers:
        their_m = np.interp(ours_s, theirs_s, layers["Elevation"].values)
        rise_m = echogram["Elevation"].values - their_m
        later_s = np.where(np.isfinite(rise_m), rise_m, 0) * 2 / SPEED_OF_LIGHT_M_S
    variables = {}
    for name in [name for name in TIMES_OF_LAYERS if name in picked]:
        their_twtt = picked[name].values
        twtt = np.array([np.interp(ours_s, theirs_s, row) for row in their_twtt])
        # A range line with the time of a layer line takes its pick, even if the pick beside is
        # missing.
        twtt = np.where(away < SAME_LINE_SPACINGS, their_twtt[:, nearest], twtt)
        twtt[:, away > FARTHEST_PICK] = np.nan
        variables[name] = (("layer", "slow_time"), twtt + later_s, {"units": "s"})
    _check_window(variables["twtt"][1], echogram, where)
    for name in ("quality", "type"):
        variables[name] = picked[name][:, nearest].variable
    variables["Elevation"] = ("slow_time", echogram["Elevation"].values, {"units": "m"})
    of_layers = {name: c for name, c in layers.coords.items() if c.dims == ("layer",)}
    coordinates = {"slow_time": echogram["slow_time"].values, **of_layers}
    return xr.Dataset(variables, coordinates, layers.attrs)


def _check_window(twtt, echogram, where):
    """Raise ValueError if a layer lies outside the echogram's window; NaN is not outside."""
    half_bin = bin_size_s(echogram) / 2
    first, last = echogram["twtt"].values[[0, -1]]
    outside = (twtt < first - half_bin) | (twtt > last + half_bin)
    if outside.any():
        msg = (
            f"{where}: twtt: expected layers within the echogram's window, {first:.6g} to "
            f"{last:.6g} s, found {twtt[outside][0]:.6g} s"
        )
        raise ValueError(msg)


def _check_positions(layers, echogram, where):
    """Raise ValueError if the layers' positions are far from the echogram's in the median."""
    away_m = pd.Series(distance_m(positions_of(layers), positions_of(echogram))).median()
    if away_m > FAR_M:
        msg = (
            f"{where}: positions: expected those of the echogram at the same times, found them "
            f"{away_m:.0f} m away: is one of both GPS time?"
        )
        raise ValueError(msg)


def flatten(echogram, layers, *, method="surface"):
    """Echogram and layers of a level frame, after each range line was shifted by whole bins.

    Both must have the same range lines (`align_layers`). Method "surface" puts layer 0 into the row
    of its median; where layer 0 is not picked, it is interpolated. "elevation" removes the changes
    of the aircraft's height above the ellipsoid, as the CReSIS toolbox does. "none" changes
    nothing, and neither does any method if the frame is level already.

    A shift by k bins adds ``k dt`` to travel times and ``k dt c / 2`` to `Elevation`. Rows are
    added at both ends so that no pixel is lost; they are NaN outside the record. ValueError if the
    method is unknown, if layer 0 has no pick, or if no elevation is known.
    """
    check_choice("method", method, LEVELLING)
    if method == "none":
        return echogram, layers
    bin_s = bin_size_s(echogram)
    if method == "surface":
        bins = range_bins(layers["twtt"].isel(layer=0).values, echogram)
    else:
        bins = echogram["Elevation"].values / (SPEED_OF_LIGHT_M_S / 2 * bin_s)
    if not np.isfinite(bins).any():
        msg = f"{method} is not known on any range line, so the frame cannot be levelled"
        raise ValueError(msg)
    bridged = pd.Series(bins).interpolate(limit_direction="both").to_numpy()
    # Halves are rounded up, not to even, so that a shift by whole bins changes no rounding.
    rows = np.floor(bridged + 0.5).astype(int)
    shift = int(np.floor(np.median(rows))) - rows
    if not shift.any():
        return echogram, layers
    return shifted(echogram, shift), _add_delay(layers, TIMES_OF_LAYERS, shift * bin_s)


def shifted(echogram, shift):
    """Echogram with range lines moved down by `shift` whole bins, (range_line,); NaN above them."""
    bin_s = bin_size_s(echogram)
    lowest = int(min(shift.min(), 0))
    n_rows = echogram.sizes["twtt"] + int(max(shift.max(), 0)) - lowest
    moved = levelled(data_of(echogram), lowest - shift, n_rows)
    twtt = echogram["twtt"].values[0] + bin_s * (np.arange(n_rows) + lowest)
    moved_echogram = _replace_power(echogram, moved, twtt)
    return _add_delay(moved_echogram, ("Surface", "Bottom"), shift * bin_s)


def _replace_power(echogram, power, twtt):
    """Echogram with new power on new range bins `twtt`; its variables along track stay."""
    others = echogram.drop_dims("twtt")
    others = others.assign_coords(twtt=("twtt", twtt, {"units": "s"}))
    return others.assign(Data=(("twtt", "slow_time"), power, echogram["Data"].attrs))


def _add_delay(dataset, names, delay_s):
    """Dataset with a delay (range_line,) [s] added to the travel times called `names`.

    The antenna is raised by the same distance, so that layers keep their elevation.
    """
    delay = xr.DataArray(delay_s, dims="slow_time")
    rise_m = delay * SPEED_OF_LIGHT_M_S / 2
    changes = [(name, delay, "s") for name in names] + [("Elevation", rise_m, "m")]
    for name, change, units in changes:
        if name in dataset:
            moved = (dataset[name] + change).transpose(*dataset[name].dims)
            dataset = dataset.assign({name: moved.assign_attrs(units=units)})
    return dataset


def resample_range(echogram, bin_s):
    """Echogram in range bins of another length `bin_s` in two-way travel time [s].

    Longer bins hold the mean power of the old bins that they cover; shorter bins hold the power
    interpolated between old bin centres. The first bin keeps its travel time. A new bin is NaN if
    it uses a NaN. If the lengths agree to a millionth, the echogram is returned as it is.
    ValueError unless two bins fit into the echogram.
    """
    present_s = bin_size_s(echogram)
    power = data_of(echogram)
    longest_s = present_s * (power.shape[0] - 1)
    if not 0 < bin_s <= longest_s * (1 + 1e-6):
        msg = f"bin_s must be positive, and two bins fit into the {longest_s:.3g} s, got {bin_s}"
        raise ValueError(msg)
    ratio = bin_s / present_s
    if abs(ratio - 1) < 1e-6:
        return echogram
    n_rows = int((power.shape[0] - 1) / ratio) + 1
    # Rounded to a millionth of a bin: a centre that coincides with an old one must not use the
    # neighbouring bin, which may be missing.
    centres = np.round(ratio * np.arange(n_rows), 6)
    resampled = _box_means(power, centres, ratio) if ratio > 1 else _interpolate(power, centres)
    first_s = float(echogram["twtt"].values[0])
    twtt = first_s + bin_s * np.arange(n_rows)
    dataset = _replace_power(echogram, resampled.astype(power.dtype, copy=False), twtt)
    return dataset.assign_attrs(resampled_from_bin_size_s=present_s)


def _box_means(power, centres, ratio):
    """Mean power over boxes of `ratio` bins about `centres`, from the integral at their edges."""
    missing = ~np.isfinite(power)
    n_bins, n_lines = power.shape
    edges = np.append(centres - ratio / 2, centres[-1] + ratio / 2) + 0.5
    edges = np.clip(edges, 0, n_bins)
    whole = np.minimum(edges.astype(int), n_bins - 1)
    rest = (edges - whole)[:, None]

    def between_edges(values):
        total = np.cumsum(values, axis=0, dtype=float)
        integral = np.concatenate([np.zeros((1, n_lines)), total])
        return np.diff(integral[whole] + rest * values[whole], axis=0)

    means = between_edges(np.where(missing, 0, power)) / np.diff(edges)[:, None]
    means[between_edges(missing.astype(float)) > 1e-9] = np.nan
    return np.maximum(means, 0)  # rounding of the integral can give -1e-17 of the power above


def _interpolate(power, centres):
    """Power at fractional range bins `centres`, linear between neighbouring bins."""
    left = np.minimum(centres.astype(int), power.shape[0] - 2)
    weight = (centres - left)[:, None]
    low, high = power[left], power[left + 1]
    return np.where(weight == 0, low, (1 - weight) * low + weight * high)


def leave_out_flagged(echogram, layers, *, flags=FLAGGED_BY):
    """Echogram, with `flagged (slow_time)`, and layers, both NaN on lines with one of `flags`.

    The lines stay in place, so that the distance between other lines does not change. The
    echogram's `quality_mask (slow_time)` has one bit for each flag, named by its attributes
    `flag_masks` and `flag_meanings` (CF conventions, section 3.5); it may lack some of `flags`.
    Without a mask, echogram and layers are returned as they are.
    """
    lines_by_flag = flagged_lines(echogram)
    if lines_by_flag is None:
        return echogram, layers
    flagged = np.zeros(echogram.sizes["slow_time"], dtype=bool)
    for name in flags:
        flagged |= lines_by_flag.get(name, False)
    echogram = echogram.assign(flagged=("slow_time", flagged))
    if flagged.any():
        unflagged = xr.DataArray(~flagged, dims="slow_time")
        echogram["Data"] = echogram["Data"].where(unflagged)
        layers = layers.assign(twtt=layers["twtt"].where(unflagged))
    return echogram, layers


def flagged_lines(echogram):
    """Flagged range lines by flag, {name: bool (range_line,)}, or None without a mask of flags."""
    mask = echogram.get("quality_mask")
    if mask is None or mask.dtype.kind not in "iu":
        return None
    if not {"flag_masks", "flag_meanings"} <= set(mask.attrs):
        return None
    names = str(mask.attrs["flag_meanings"]).split()
    bits = np.atleast_1d(mask.attrs["flag_masks"])
    return {name: (mask.values & bit) != 0 for name, bit in zip(names, bits, strict=True)}


def count_flagged(echogram):
    """Number of lines that `leave_out_flagged` left out, and a text that counts lines by flag.

    The text is like "low_SNR 12; land_ice 512". It is "none" if no flag is set, and empty if the
    echogram has no mask of flags.
    """
    lines_by_flag = flagged_lines(echogram)
    n_flagged = int(echogram["flagged"].sum()) if "flagged" in echogram else 0
    if lines_by_flag is None:
        return n_flagged, ""
    counts = {name: int(lines.sum()) for name, lines in lines_by_flag.items()}
    return n_flagged, "; ".join(f"{name} {n}" for name, n in counts.items() if n) or "none"


def cut_blocks(echogram, layers, *, name):
    """Scenes of a level frame, cut as in the published benchmark, and reasons for skipped blocks.

    Blocks have 256 lines and overlap by 6; lines left over at the end are not used. A scene is a
    cropped block. The surface, layer 0, lies in its row 50. It ends 100 rows below its last layer
    and has at least 300 rows. Each scene has its own 8-bit scale and is called
    ``{name}_{block:03d}``; its `notes` hold `first_line`, `first_twtt_s` and `bin_size_s`. Layers
    without a pick in a block are left out of its scene. Of simulated layers the crop follows the
    interfaces, and the scene has the peaks of their echoes.

    An image cannot have gaps. A block is therefore skipped if it has a line `flagged` by
    `leave_out_flagged`, no pick of the surface, missing pixels, or rows outside the frame. Returns
    the list of scenes, and the reasons in a dict by the name of the skipped block.
    """
    echo_bins = layer_bins_of(layers, echogram)
    layer_bins = range_bins(layers["twtt"].transpose("layer", "slow_time").values, echogram)
    power = data_of(echogram)
    flagged = np.zeros(power.shape[1], dtype=bool)
    if "flagged" in echogram:
        flagged = echogram["flagged"].values
    first_s = float(echogram["twtt"].values[0])
    bin_s = bin_size_s(echogram)
    scenes = []
    skipped = {}
    starts = range(0, power.shape[1] - BLOCK_LINES + 1, BLOCK_LINES - OVERLAP_LINES)
    for block, start in enumerate(starts):
        lines = slice(start, start + BLOCK_LINES)
        scene_name = f"{name}_{block:03d}"
        bins = layer_bins[:, lines]
        reason = _reason_to_skip(power[:, lines], bins, flagged[lines])
        if reason:
            skipped[scene_name] = reason
            continue
        top, bottom = _scene_rows(bins)
        image, noise_floor_db, maximum_db = to_uint8(power[top:bottom, lines])
        scene = Scene(
            scene_name,
            bottom - top,
            _layers_with_picks(echo_bins[:, lines]) - top,
            image=image,
            noise_floor_db=noise_floor_db,
            maximum_db=maximum_db,
            notes={"first_line": start, "first_twtt_s": first_s + top * bin_s, "bin_size_s": bin_s},
        )
        scenes.append(scene)
    return scenes, skipped


def _reason_to_skip(power, bins, flagged):
    """Reason why no scene is cut from a block, or None."""
    if flagged.any():
        return f"{int(flagged.sum())} of {flagged.size} {FLAGGED}"
    if not np.isfinite(bins[0]).any():
        return "the surface is not picked"
    top, bottom = _scene_rows(bins)
    if top < 0 or bottom > power.shape[0]:
        return f"rows {top} to {bottom} are needed, the frame has {power.shape[0]}"
    cropped = power[top:bottom]
    n_missing = int((~((cropped > 0) & np.isfinite(cropped))).sum())
    return f"{n_missing} pixels without a measurement" if n_missing else None


def _scene_rows(bins):
    """First row of a block's scene, 50 rows above the surface, and the row after its last row."""
    top = int(np.floor(np.nanmedian(bins[0]) + 0.5)) - SURFACE_ROW
    return top, top + scene_height(_layers_with_picks(bins) - top)


def _layers_with_picks(bins):
    """Layers that have a pick on at least one range line."""
    return bins[np.isfinite(bins).any(axis=1)]
