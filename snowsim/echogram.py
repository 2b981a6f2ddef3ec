"""The data model: echogram and layer datasets, scenes and echoes, their checks, 8-bit scaling."""

import re
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

SURFACE_ROW = 50  # where the published benchmark keeps the snow surface
ROWS_BELOW_LAST_LAYER = 100  # as in the published benchmark
MINIMUM_ROWS = 300
DB_BELOW_NOISE_FLOOR = 10.0

ECHOGRAM_ALONG_TRACK = ("Latitude", "Longitude", "Elevation", "Surface")
# Larger echograms are refused, which stops decompression bombs. The largest frames of the archives
# are about 30000 x 5000 float32, 0.6 GB.
MAXIMUM_BYTES = 2**30
UNITS = {
    "Data": "W (uncalibrated)",
    "twtt": "s",
    "Latitude": "degrees_north",
    "Longitude": "degrees_east",
    "Elevation": "m",
    "Surface": "s",
    "Bottom": "s",
    "Roll": "radian",
    "Pitch": "radian",
    "Heading": "radian",
    "Elevation_Correction": "range bins",
}
AXES_OF_VARIABLE = {"Data": ("twtt", "slow_time"), "twtt": "twtt"}
ALONG_TRACK = [name for name in UNITS if name not in AXES_OF_VARIABLE]
SURFACE_NAME = "surface"
MOST_REPEATED = 0.1  # share of range lines with a repeated time, beyond which a file is refused
INVENTED_TIME = np.datetime64("2000-01-01", "ns")
# Segment and frame in a name: Data_20120330_04_001.mat, IRSNO1B_20120330_04_001_deconv.nc.
FRAME_IN_NAME = re.compile(r"(\d{8}_\d{2})_(\d{3})(?!\d)")
DEGREES = {"Latitude": 90, "Longitude": 360}
# Power this far below all other power was not recorded: some files hold tiny numbers in place of
# zero. If the pixels of a simulated frame are sorted by power, neighbours differ by at most 9 dB
# with one look and by less than 1 dB with five. With five looks, the gap below all other pixels is
# 42 dB for a true row of air 60 dB down, and 80 dB or more for 2e-16 in place of noise. Between
# means of rows, the gap is 88 dB with one look, too.
FAR_PIXEL_DB = 50
FAR_ROW_DB = 70


class Kind(IntEnum):
    """Origin of an echo."""

    LAYER = 0  # a labelled layer
    BACKGROUND = 1  # snow between layers: an exponential that starts at the surface
    BELOW = 2  # an unlabelled echo below the last layer


@dataclass(frozen=True, eq=False)
class Echoes:
    """Echoes of a scene from the surface down, terms of eq. (1), with its noise and speckle.

    Attributes
    ----------
    bins : ndarray, (row, range_line)
        Range bin where each echo's waveform peaks; NaN where it is absent.
    power : ndarray, (row, range_line)
        Linear power of the waveform there; PHY also accepts one value for each row, (row,).
    variance_bins2, decay_rate : ndarray, (row,)
        Variance [bins^2] and decay [per bin] of each echo's waveform.
    kind : ndarray of int8, (row,)
        One of `Kind`.
    noise_power : float
        Linear power of the noise.
    n_looks : float
        Independent looks averaged in a pixel.
    speckle_correlation : ndarray, (lag,), or None
        Autocorrelation of speckle down range; None where range bins are independent.
    line_gain_spread_db : float
        Standard deviation of gain from range line to range line [dB].
    """

    bins: np.ndarray
    power: np.ndarray
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    kind: np.ndarray
    noise_power: float
    n_looks: float
    speckle_correlation: np.ndarray | None = None
    line_gain_spread_db: float = 0.0


@dataclass
class Scene:
    """One block of range lines with its layers and, once observed or rendered, its 8-bit image.

    Attributes
    ----------
    name : str
        Unique within its set.
    n_range_bins : int
        Height of the image.
    layer_bins : ndarray, (layer, range_line)
        Annotated layers in fractional range bins, NaN where absent; layer 0 is the snow surface.
    image : ndarray of uint8, (range_bin, range_line), or None
        Scaled by `to_uint8`. Grey level 0 is 10 dB below `noise_floor_db`, 255 is `maximum_db`.
    complete_layer_bins : ndarray, (layer, range_line), or None
        All layers in order, if `layer_bins` holds only layers that a picker found. It may have
        more rows than `layer_bins`.
    echoes : Echoes, or None
        Echoes that PHY renders, if they were drawn with the layers.
    zone : int
        Accumulation zone, -1 where unknown.
    notes : dict
        Counts of the steps that made the scene (a plan's bound and cost, counts of the label rule).
        Renderers do not use them.
    """

    name: str
    n_range_bins: int
    layer_bins: np.ndarray
    image: np.ndarray | None = None
    complete_layer_bins: np.ndarray | None = None
    echoes: Echoes | None = None
    noise_floor_db: float = np.nan
    maximum_db: float = np.nan
    zone: int = -1
    notes: dict = field(default_factory=dict)

    def __repr__(self):
        size = f"{self.n_range_bins} range bins, {self.n_range_lines} range lines"
        n_labelled = int(np.isfinite(self.layer_bins).any(axis=1).sum())
        image = "no image" if self.image is None else "image"
        return f"Scene({self.name!r}, {size}, {n_labelled} layers labelled, {image})"

    @property
    def n_range_lines(self):
        """Number of range lines."""
        return self.layer_bins.shape[1]

    def mask(self) -> NDArray[np.bool_]:
        """Mask of the annotated layers, bool (range_bin, range_line)."""
        return layer_mask(self.layer_bins, self.n_range_bins)


def is_surface(name):
    """True if a layer is named surface, in any case, with or without its group."""
    return str(name).rpartition(":")[2].strip().lower() == SURFACE_NAME


def repeats(slow_time):
    """Range lines that have the time of the line before, bool (range_line,).

    None where they are more than a tenth of all: then the clock stood still.
    """
    same = np.append(False, np.diff(slow_time) == np.timedelta64(0))
    return same & (same.sum() <= max(1, MOST_REPEATED * same.size))


def without_repeats(dataset, where):
    """Dataset without range lines that repeat a time; a warning counts them."""
    slow_time = dataset["slow_time"]
    if slow_time.dims != ("slow_time",) or slow_time.dtype.kind != "M" or slow_time.size == 0:
        return dataset  # checks refuse it
    repeated = repeats(slow_time.values)
    if not repeated.any():
        return dataset
    msg = (
        f"{where}: slow_time: {repeated.sum()} of {repeated.size} range lines are left out, for "
        f"they have the time of the line before (the first is {repeated.argmax()})"
    )
    warnings.warn(msg, UserWarning, stacklevel=2)
    return dataset.isel(slow_time=~repeated)


def named_frame(path):
    """Segment and frame number in a file's name; (None, None) if the name does not hold them."""
    named = FRAME_IN_NAME.search(Path(path).stem)
    return (named[1], int(named[2])) if named else (None, None)


def echogram(data, *, twtt, slow_time=None, attrs=None, **along_track):
    """Echogram dataset of arrays in memory, like that of `snowsim.io.read_echogram`.

    Parameters
    ----------
    data : array_like, (range_bin, range_line)
        Linear power; NaN or masked where nothing was recorded.
    twtt : array_like, (range_bin,)
        Two-way travel time of the range bins, evenly spaced [s].
    slow_time : array_like of datetime64, (range_line,), optional
        UTC; by default, range lines are a millisecond apart from 2000-01-01 on.
        Of range lines of the same time the first is kept, with a warning.
    attrs : dict, optional
        Attributes of the dataset.
    **along_track : array_like, (range_line,)
        `Latitude`, `Longitude` [deg], `Elevation` [m], `Surface` and `Bottom` (travel times) [s],
        `Roll`, `Pitch`, `Heading` [radian]; the first four are NaN by default.

    Returns
    -------
    xarray.Dataset
        See `snowsim.io.read_echogram`.

    Raises
    ------
    ValueError
        In one line, if a name is unknown, lengths differ, or power is negative or holds grey levels
        (whole numbers of 8 bits).

    Examples
    --------
    >>> import numpy as np
    >>> power = np.random.default_rng(1).gamma(4, 0.25, size=(300, 64))
    >>> frame = echogram(power, twtt=3e-6 + 2.886e-10 * np.arange(300))
    >>> dict(frame.sizes), int(frame["Surface"].isnull().sum())
    ({'twtt': 300, 'slow_time': 64}, 64)
    """
    if not along_track.keys() <= UNITS.keys():
        known, given = (", ".join(sorted(names)) for names in (UNITS, along_track))
        msg = f"echogram: names: expected {known}, found {given}"
        raise ValueError(msg)
    content = {}
    for name, values in {"Data": data, "twtt": twtt, "slow_time": slow_time, **along_track}.items():
        if values is not None:
            with one_line_for("echogram", f"{name}: expected an array"):
                content[name] = np.asanyarray(values)
    return echogram_dataset("echogram", content, attrs or {})


def echogram_dataset(where, content, attributes):
    """Echogram dataset of arrays by name, checked; messages begin with `where`.

    `content` holds linear power `Data` (range_bin, range_line), `twtt`, and any variables along
    slow_time. Without `slow_time`, range lines are a millisecond apart; missing positions and a
    missing surface are NaN. `Data` are transposed if their axes fit the others only then.
    """
    # Imported here: every job loads this module, and loading xarray takes half a second.
    import xarray as xr

    data = content["Data"]
    n_bins = np.size(content["twtt"])
    n_lines = (
        np.size(content["slow_time"]) if "slow_time" in content else data.size // max(n_bins, 1)
    )
    if n_bins != n_lines and data.shape == (n_lines, n_bins):
        data = data.T
    if n_lines == 1 and data.size == n_bins:
        data = data.reshape(n_bins, 1)
    kept = np.float32 if data.dtype.kind in "iub" else data.dtype.newbyteorder("=")
    data = data.astype(kept, copy=False)
    invented = {"slow_time": INVENTED_TIME + np.arange(n_lines) * np.timedelta64(1, "ms")}
    unknown = dict.fromkeys(ECHOGRAM_ALONG_TRACK, np.full(n_lines, np.nan))
    dataset = xr.Dataset(attrs=attributes)
    # `Data` come first, so that the dataset has their order of axes.
    for name, values in ({"Data": data} | invented | unknown | content | {"Data": data}).items():
        with one_line_for(where, f"{name}: expected real numbers, as many as others have"):
            if name not in ("Data", "slow_time"):
                values = np.ravel(values).astype(float)
            dataset[name] = (AXES_OF_VARIABLE.get(name, "slow_time"), values)
            if name in UNITS:
                dataset[name].attrs["units"] = UNITS[name]
    dataset = without_repeats(dataset, where)
    check_echogram(dataset, str(where))
    return as_recorded(dataset)


@contextmanager
def one_line_for(where, expected):
    """Context that turns errors of numpy, xarray and torch into a ValueError of one line."""
    try:
        yield
    except (TypeError, ValueError, RuntimeError) as error:  # torch raises the last
        found = " ".join(str(error).split())
        msg = f"{where}: {expected}, found {type(error).__name__} {found}"
        raise ValueError(msg) from error


def check_choice(name, value, choices):
    """Raise ValueError, with all `choices`, unless the value called `name` is one of them."""
    if value not in choices:
        msg = f"{name} must be one of {', '.join(choices)}, got {value!r}"
        raise ValueError(msg)


def scene_height(layer_bins):
    """Height of a scene in range bins, max(300, deepest + 100), as in the published benchmark."""
    if not np.isfinite(layer_bins).any():
        msg = "a scene needs at least one annotated pixel, got none"
        raise ValueError(msg)
    return max(MINIMUM_ROWS, int(np.ceil(np.nanmax(layer_bins))) + ROWS_BELOW_LAST_LAYER)


def zone_of(first_thickness_bins, zone_edge_bins):
    """Accumulation zone of each mean thickness of the first slab: 0 the thinnest, -1 for NaN.

    Thicknesses beyond the outer edges belong to the outer zones.
    """
    thickness = np.asarray(first_thickness_bins, dtype=float)
    zone = np.searchsorted(np.asarray(zone_edge_bins)[1:-1], thickness, side="right")
    return np.where(np.isnan(thickness), -1, zone)


def layer_mask(layer_bins, n_range_bins):
    """Mask of layers, bool (range_bin, range_line): one pixel per layer and range line.

    `layer_bins` (layer, range_line) are fractional and are rounded. A NaN or a bin outside the
    image gives no pixel.
    """
    layer_bins = np.asarray(layer_bins, dtype=float)
    mask = np.zeros((n_range_bins, layer_bins.shape[1]), dtype=bool)
    inside = (layer_bins > -0.5) & (layer_bins < n_range_bins - 0.5)
    _, lines = np.nonzero(inside)
    mask[np.rint(layer_bins[inside]).astype(int), lines] = True
    return mask


def crossing_layers(layer_bins):
    """Mask of picks that do not lie below all layers above, bool (layer, range_line)."""
    layer_bins = np.asarray(layer_bins, dtype=float)
    filled = np.where(np.isnan(layer_bins), -np.inf, layer_bins)
    deepest_above = np.maximum.accumulate(filled, axis=0)
    crossing = np.zeros(layer_bins.shape, dtype=bool)
    crossing[1:] = layer_bins[1:] <= deepest_above[:-1]  # NaN compares false
    return crossing


def check_layer_bins(layer_bins, where="layer_bins"):
    """Raise ValueError, naming `where`, unless layers (layer, range_line) never cross."""
    layer_bins = np.asarray(layer_bins, dtype=float)
    if layer_bins.ndim != 2 or np.isinf(layer_bins).any():
        msg = (
            f"{where}: layers (layer, range_line) must be finite or NaN, "
            f"got {np.isinf(layer_bins).sum()} infinite ones of shape {layer_bins.shape}"
        )
        raise ValueError(msg)
    crossing = crossing_layers(layer_bins)
    if crossing.any():
        layer, line = np.argwhere(crossing)[0]
        msg = (
            f"{where}: layers must increase strictly with depth, "
            f"layer {layer} does not at range_line {line}"
        )
        raise ValueError(msg)


def to_db(power):
    """Decibels of linear power; zero power gives -inf without a warning."""
    with np.errstate(divide="ignore"):
        return 10 * np.log10(power)


def recorded(power):
    """Linear power (range_bin, range_line), with NaN where it lies far below all other power.

    Pixels are sorted by power. If a gap of more than 50 dB lies below most of them, pixels below
    the gap become NaN. Rows are sorted by their mean in decibels and treated likewise, with a gap
    of 70 dB. Power of zero or less is not changed. Whole numbers become single precision.
    """
    if power.dtype.kind in "iu":
        power = power.astype(np.float32)
    positive = power > 0
    if not positive.any() or not _may_have_gap(power, positive):
        return power
    power_db = to_db(np.where(positive, power, np.nan).astype(float))
    counts = positive.sum(axis=1)
    mean_db = np.nansum(power_db, axis=1) / np.maximum(counts, 1)
    rows = counts > 0
    is_far = power_db < _above_gap(power_db[positive], FAR_PIXEL_DB)
    is_far |= positive & (mean_db < _above_gap(mean_db[rows], FAR_ROW_DB))[:, None]
    return np.where(is_far, np.nan, power) if is_far.any() else power


def _may_have_gap(power, positive):
    """True if power may have a gap, by a quick test that `recorded` makes before it sorts pixels.

    The median is that of some pixels, so half of `FAR_PIXEL_DB` is left for its error.
    """
    some = power.flat[:: 1 + power.size // 100_000]
    some = some[some > 0]
    least = power.min(where=positive, initial=np.inf)
    return some.size == 0 or to_db(np.median(some)) - to_db(least) > FAR_PIXEL_DB / 2


def _above_gap(values_db, gap_db):
    """Lower limit of the values above the uppermost gap of `gap_db` with most values above it.

    It is -inf if there is no such gap.
    """
    low_db = values_db.min()
    counts = np.bincount(np.floor(values_db - low_db).astype(int))
    # Decibels above the lowest value, in steps of 1 dB, at which there are values.
    steps = np.flatnonzero(counts)
    n_above = np.cumsum(counts[::-1])[::-1][steps]
    ends = np.flatnonzero((np.diff(steps) > gap_db) & (2 * n_above[1:] > values_db.size))
    return low_db + steps[ends[-1] + 1] if ends.size else -np.inf


def as_recorded(dataset):
    """Echogram dataset with NaN in `Data` where `recorded` finds that nothing was recorded."""
    data = dataset["Data"].transpose("twtt", "slow_time")
    return dataset.assign(Data=data.copy(data=recorded(data.values)))


def to_uint8(power):
    """8-bit image of linear power: 0 is ``noise_floor_db - 10`` and below, 255 the maximum.

    Parameters
    ----------
    power : array_like, (range_bin, range_line)
        Linear power. ValueError unless all of it is positive and finite, no pixel lies far below
        all others (see `recorded`), and not all pixels are equal.

    Returns
    -------
    image : ndarray of uint8, (range_bin, range_line)
    noise_floor_db, maximum_db : float
        Smallest row mean of the dB image and its maximum, by the rule of the koenig_TC2016_ML data
        set.
    """
    power = np.asarray(power)
    bad = ~((power > 0) & np.isfinite(power))
    if bad.any():
        row, line = np.argwhere(bad)[0]
        msg = (
            "power must be positive and finite, "
            f"got {power[row, line]} at range_bin {row}, range_line {line}"
        )
        raise ValueError(msg)
    missing = np.isnan(recorded(power))
    if missing.any():
        row, line = np.argwhere(missing)[0]
        msg = (
            f"power must have been recorded, got {power[row, line]:.3g} at range_bin {row}, "
            f"range_line {line}: {missing.sum()} pixels lie far below all others"
        )
        raise ValueError(msg)
    power_db = 10 * np.log10(power)
    noise_floor_db = float(power_db.mean(axis=1, dtype=np.float64).min())
    maximum_db = float(power_db.max())
    if not maximum_db > noise_floor_db:
        msg = f"image without contrast: every pixel is {maximum_db:g} dB"
        raise ValueError(msg)
    return to_grey(power_db, noise_floor_db, maximum_db), noise_floor_db, maximum_db


def to_grey(power_db, noise_floor_db, maximum_db):
    """8-bit image of decibels (range_bin, range_line) on the scale of `to_uint8`."""
    bottom_db = noise_floor_db - DB_BELOW_NOISE_FLOOR
    scaled = power_db - bottom_db
    scaled *= 255 / (maximum_db - bottom_db)
    np.clip(scaled, 0, 255, out=scaled)
    return np.rint(scaled, out=scaled).astype(np.uint8)


def from_uint8(image, noise_floor_db, maximum_db):
    """Power [dB] of the grey levels of an 8-bit image, float64, the inverse of `to_uint8`."""
    bottom_db = noise_floor_db - DB_BELOW_NOISE_FLOOR
    return bottom_db + np.asarray(image, dtype=float) * ((maximum_db - bottom_db) / 255)


def check_echogram(echogram, where="echogram"):
    """Raise ValueError, naming `where`, unless the dataset follows the Open Polar Radar convention.

    Dimensions and coordinates are `slow_time` [UTC, datetime64] and `twtt` [s]. Both increase, and
    `twtt` is evenly spaced. `Data` are linear power, not negative, NaN where missing, and no grey
    levels. `Latitude`, `Longitude`, `Elevation` and `Surface` lie along `slow_time`; degrees are
    within 90 and 360.
    """
    along_track = dict.fromkeys(ECHOGRAM_ALONG_TRACK, ("slow_time",))
    axes = {"Data": ("twtt", "slow_time"), "twtt": ("twtt",)}
    _check_variables(echogram, axes | along_track, where)
    twtt = echogram["twtt"].values
    even = np.linspace(twtt[:1], twtt[-1:], twtt.size)[:, 0]
    # Errors of a thousandth of a bin do not matter. Some files store single precision. Its last
    # digit is rounded twice: at both ends of the axis, and by a change of units. NaN is uneven.
    last_digit = 2 * np.spacing(np.abs(twtt).max(initial=0).astype(np.float32))
    step = np.diff(even[:2])
    uneven = ~((step > 0) & (np.abs(twtt - even) < 1e-3 * step + last_digit))
    if twtt.size < 2 or uneven.any():
        msg = f"{where}: twtt must increase in even steps, {uneven.sum()} of {twtt.size} do not"
        raise ValueError(msg)
    data = echogram["Data"].values
    bad = np.isinf(data) | (data < 0) if data.dtype.kind in "fiu" else np.ones((1, 1), dtype=bool)
    if bad.any():
        at = tuple(int(i) for i in np.argwhere(bad)[0])
        msg = (
            f"{where}: Data: expected linear power, finite or NaN and not negative (not decibels), "
            f"got {data[at]} at {at}"
        )
        raise ValueError(msg)
    # A mask of 0 and 1 passes. Two rows are tested first, which usually saves the test of all.
    is_whole = (data[:2] == np.rint(data[:2])).all() and (data == np.rint(data)).all()
    if is_whole and 2 <= data.max() <= 255 and data.min() < data.max():
        msg = f"{where}: Data: expected linear power, found whole numbers of 8 bits: grey levels?"
        raise ValueError(msg)
    for name, largest in DEGREES.items():
        outside = np.abs(echogram[name].values) > largest  # NaN (unknown) passes
        if outside.any():
            msg = (
                f"{where}: {name}: expected degrees within +-{largest}, "
                f"found {echogram[name].values[outside][0]:g}"
            )
            raise ValueError(msg)


def check_layers(layers, where="layers"):
    """Raise ValueError, naming `where`, unless layers follow the Open Polar Radar convention.

    They hold `twtt`, `quality` and `type` on (layer, slow_time), and do not cross. Positions, where
    they have them, are those of range lines. Picks lie within `twtt_low` and `twtt_high`.
    """
    axes = ("layer", "slow_time")
    _check_variables(layers, dict.fromkeys(("twtt", "quality", "type"), axes), where)
    check_layer_bins(layers["twtt"].transpose(*axes).values, f"{where}: twtt")
    for name in ("Latitude", "Longitude", "Elevation"):
        if name in layers and "layer" in layers[name].dims:
            msg = (
                f"{where}: {name}: expected along slow_time alone, found {layers[name].dims}: take "
                "that of one layer, or join layers by xr.concat(..., data_vars='minimal')"
            )
            raise ValueError(msg)
    if {"twtt_low", "twtt_high"} <= set(layers):
        outside = (layers["twtt"] < layers["twtt_low"]) | (layers["twtt"] > layers["twtt_high"])
        if outside.any():
            layer, line = np.argwhere(outside.transpose(*axes).values)[0]
            msg = (
                f"{where}: twtt: expected picks within twtt_low and twtt_high, found "
                f"{outside.values.sum()} outside (the first: layer {layer}, range line {line}): "
                "move the limits with the pick, or set them to NaN"
            )
            raise ValueError(msg)


def _check_variables(dataset, axes, where):
    """Raise ValueError unless a dataset has all variables on these axes, and increasing times."""
    held = {name: variable.dims for name, variable in dataset.variables.items()}
    wrong = [name for name, dims in axes.items() if set(held.get(name, ())) != set(dims)]
    if wrong or "slow_time" not in held:
        expected = "; ".join(f"{name} ({', '.join(axes[name])})" for name in wrong) or "slow_time"
        found = "; ".join(f"{name} ({', '.join(map(str, dims))})" for name, dims in held.items())
        msg = f"{where}: expected variables {expected}, found {found or 'none'}"
        raise ValueError(msg)
    slow_time = dataset["slow_time"].values
    if not np.issubdtype(slow_time.dtype, np.datetime64) or not slow_time.size:
        msg = (
            f"{where}: slow_time: expected UTC times as datetime64, without a time zone, found "
            f"{slow_time.size} of type {slow_time.dtype}"
        )
        raise ValueError(msg)
    missing = np.isnat(slow_time)
    if missing.any():
        msg = (
            f"{where}: slow_time: expected a time on every range line, found none on "
            f"{missing.sum()} of {missing.size} (the first is {missing.argmax()})"
        )
        raise ValueError(msg)
    later = np.append(True, np.diff(slow_time) > np.timedelta64(0))
    if not later.all():
        line = int(later.argmin())
        n_late = later.size - later.sum()
        msg = (
            f"{where}: slow_time must increase: range line {line} is not later than line "
            f"{line - 1} ({n_late} such lines of {slow_time.size}; in CReSIS files, GPS_time)"
        )
        raise ValueError(msg)
