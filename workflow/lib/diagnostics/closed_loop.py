"""The closed loop: statistics of renders beside the statistics they were rendered from.

Rendered scenes as frames of a flight, so that their statistics can be taken like a flight's.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import xarray as xr

from snowsim.constants import EARTH_RADIUS_M
from snowsim.statistics.blocks import BLOCK_LINES
from snowsim.statistics.zones import OWN_ZONE

SURE = 2.0  # standard errors by which a difference counts as one
NARROW_BINS2 = (
    1.0  # a Gaussian of variance 1 stands in three bins: below, its width is not seen in samples one bin apart
)


@dataclass(frozen=True)
class Bound:
    """How a quantity is compared: its dimensions, the unit of its error, and the largest error asked for."""

    dims: tuple
    unit: str
    largest: float


BOUNDS = {
    "peak_power": Bound(("layer",), "relative", 0.03),
    "decay_rate": Bound(("layer",), "relative", 0.05),
    "noise_power": Bound((), "relative", 0.01),
    "variance_bins2": Bound(("layer",), "relative", 0.20),
    "width_bins": Bound(("layer",), "bins", 1.0),
    "offset_bins": Bound(("layer",), "bins", 1.0),
    "thickness_mean_bins": Bound(("zone", "slab"), "relative", 0.03),
    "thickness_variance_bins2": Bound(("zone", "slab"), "relative", 0.10),
    "relative_thickness_mean": Bound(("zone", "slab"), "relative", 0.03),
    "relative_thickness_variance": Bound(("zone", "slab"), "relative", 0.10),
    "thickness_psd": Bound(("zone", "slab", "band"), "dB", 1.0),
}
COLUMNS = (
    *("quantity", "layer", "zone", "slab", "band"),
    *("given", "given_standard_error", "recovered", "recovered_standard_error"),
    *("error", "error_standard_error", "unit", "bound", "within", "reason"),
)


def compare(given, recovered):
    """What comes back of the statistics that went into renders.

    Parameters
    ----------
    given, recovered : xarray.Dataset
        Of `estimate`: those that layers and renders were drawn from, and those of the renders, with the same zones.

    Returns
    -------
    pandas.DataFrame
        A row per quantity and `layer`, or `zone` and `slab`, or `zone`, `slab` and `band` of wavenumber of a spectrum
        (-1 where it has none): `given` and `recovered` with their standard errors; `error`, recovered against given, in
        `unit` (relative, bins, dB) with the standard error that sampling of the renders gives it; the `bound` of
        `BOUNDS`; whether the error is `within` it; and the `reason` for one that is not, see `_reason`.

    Raises
    ------
    ValueError
        If zones or bands differ.

    Notes
    -----
    Compared is what both hold. Left out is what is no measurement: values given as NaN, recovered in `paper` for the
    deepest layer, recovered where `substituted` is 1 or zones were pooled (`source`, `psd_source`), and slab 0 relative
    to itself.
    """
    for name in ("zone_edge_bins", "band_edge_wavenumber"):
        ours, theirs = given[name].values, recovered[name].values
        if ours.shape != theirs.shape or not np.allclose(ours, theirs, rtol=1e-9):
            msg = f"statistics to compare must share {name}, got {ours.tolist()} and {theirs.tolist()}"
            raise ValueError(msg)
    rows = []
    for quantity, bound in BOUNDS.items():
        values = [_values(dataset, quantity, bound.dims) for dataset in (given, recovered)]
        shape = tuple(np.minimum(values[0][0].shape, values[1][0].shape))
        measured = _measured(recovered, quantity, shape)
        for at in np.ndindex(shape):
            numbers = [float(array[at]) for pair in values for array in pair]
            if measured[at] and np.isfinite(numbers).all() and numbers[0] != 0:
                rows.append(_row(quantity, bound, dict(zip(bound.dims, at, strict=True)), numbers, given))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def largest_errors(table):
    """Median and largest error of each quantity of a table of `compare`.

    Returns
    -------
    dict
        `<quantity>_bound`, `<quantity>_median`, `<quantity>_largest`: of the magnitude of the error in its own unit;
        the largest over what sampling resolves, that is, where the standard error of the error is below half the bound.
        NaN where there is none. `score`: mean over powers, decay rates, noise, widths and, where they are estimated,
        offsets of the median error over its bound.
    """
    magnitude = table["error"].abs()
    resolved = _is_resolved(table)
    errors, shares = {}, []
    for quantity, bound in BOUNDS.items():
        of = table["quantity"] == quantity
        errors[f"{quantity}_bound"] = bound.largest
        errors[f"{quantity}_median"] = magnitude[of].median()
        errors[f"{quantity}_largest"] = magnitude[of & resolved].max()
        if quantity in ("peak_power", "decay_rate", "noise_power", "width_bins", "offset_bins"):
            shares.append(errors[f"{quantity}_median"] / bound.largest)
    errors["score"] = float(np.nanmean(shares))
    return errors


def summarise_loop(table):
    """A table of `compare` in short: a row a quantity.

    Returns
    -------
    pandas.DataFrame
        `n` values compared and `n_within` their bound; `n_resolved`, of which sampling resolves the bound, as in
        `largest_errors`, and `n_resolved_within`; `median` and `largest` magnitude of the error,
        `median_standard_error`, and `reasons`, how many of those beyond have which.
    """
    errors = largest_errors(table)
    rows = []
    for quantity in table["quantity"].unique():
        part = table[table["quantity"] == quantity]
        reasons = part.loc[~part["within"], "reason"].value_counts()
        resolved = _is_resolved(part)
        rows.append(
            {
                "quantity": quantity,
                "unit": BOUNDS[quantity].unit,
                "bound": BOUNDS[quantity].largest,
                "n": len(part),
                "n_within": int(part["within"].sum()),
                "n_resolved": int(resolved.sum()),
                "n_resolved_within": int(part.loc[resolved, "within"].sum()),
                "median": errors[f"{quantity}_median"],
                "median_standard_error": part["error_standard_error"].median(),
                "largest": errors[f"{quantity}_largest"],
                "reasons": "; ".join(f"{reason}: {n}" for reason, n in sorted(reasons.items())),
            }
        )
    return pd.DataFrame(rows)


def _is_resolved(table):
    """Where two standard errors of sampling are below the bound."""
    return table["error_standard_error"] < table["bound"] / SURE


def _values(statistics, quantity, dims):
    """Values and standard errors of a quantity; of a spectrum means over bands of wavenumber."""
    names = (quantity, f"{quantity}_standard_error")
    if "band" not in dims:
        return [statistics[name].transpose(*dims).values.astype(float) for name in names]
    edges = np.rint(statistics["band_edge_wavenumber"].values * BLOCK_LINES).astype(int)
    density, error = (statistics[name].transpose("zone", "slab", "wavenumber").values for name in names)
    bands = [slice(low, high) for low, high in zip(edges[:-1], edges[1:], strict=True)]
    # Periodograms of different wavenumbers are independent, all but for leakage.
    errors = [np.sqrt((error[..., band] ** 2).sum(axis=-1)) / error[..., band].shape[-1] for band in bands]
    return [np.stack([density[..., band].mean(axis=-1) for band in bands], axis=-1), np.stack(errors, axis=-1)]


def _measured(recovered, quantity, shape):
    """Where a recovered value is a measurement of its own, bool of this shape."""
    measured = np.ones(shape, dtype=bool)
    if not shape:
        return measured
    if len(shape) == 1:
        return measured & (recovered["substituted"].values[: shape[0]] == 0)
    source = "psd_source" if quantity == "thickness_psd" else "source"
    own = recovered[source].transpose("zone", "slab").values[: shape[0], : shape[1]] == OWN_ZONE
    measured &= own.reshape(own.shape + (1,) * (len(shape) - 2))
    if quantity.startswith("relative_"):
        measured[:, 0] = False
    return measured


def _row(quantity, bound, where, numbers, given):
    value, _, found, found_error = numbers
    if bound.unit == "relative":
        error, sampling = found / value - 1, found_error / abs(value)
    elif bound.unit == "bins":
        error, sampling = found - value, found_error
    else:
        # A density that came back as zero is as far off as one can be.
        error = 10 * np.log10(max(found, 1e-30) / value)
        sampling = 10 / np.log(10) * found_error / max(found, 1e-30)
    within = abs(error) <= bound.largest
    return {
        "quantity": quantity,
        **{dim: where.get(dim, -1) for dim in ("layer", "zone", "slab", "band")},
        **dict(zip(COLUMNS[5:9], numbers, strict=True)),
        "error": error,
        "error_standard_error": sampling,
        "unit": bound.unit,
        "bound": bound.largest,
        "within": within,
        "reason": "" if within else _reason(quantity, where, found, abs(error) - bound.largest, sampling, given),
    }


def _reason(quantity, where, found, excess, sampling, given):
    """Why an error is beyond its bound, the first of these that holds.

    `sampling`: two standard errors of the renders' own sampling reach back to the bound. `zone drawn evenly`: labels
    draw the first slab uniformly over a zone's range, the flight has it as it snowed, and what came back is what that
    gives, within the bound and two standard errors (`_drawn_evenly`). `leakage`: the given spectrum falls more steeply
    than k^-2, as which the ends of any series leak that does not end where it began. `set by align`: PHY takes no
    offset, its convention is one. `below the noise`: the layer's peak power is less than the noise. `narrower than a
    bin`: the Gaussian's variance is below `NARROW_BINS2`. `bias`: none.
    """
    if excess <= SURE * sampling:
        return "sampling"
    if quantity in ("thickness_mean_bins", "thickness_variance_bins2"):
        expected = _drawn_evenly(quantity, where, given)
        evenly = abs(found / expected - 1) <= BOUNDS[quantity].largest + SURE * sampling
        return "zone drawn evenly" if evenly else "bias"
    if quantity == "thickness_psd" and _falls_steeply(given, where):
        return "leakage"
    if quantity == "offset_bins":
        return "set by align"
    if "layer" in where:
        if given["peak_power"].values[where["layer"]] < float(given["noise_power"]):
            return "below the noise"
        if quantity == "variance_bins2" and given["variance_bins2"].values[where["layer"]] < NARROW_BINS2:
            return "narrower than a bin"
    return "bias"


def _drawn_evenly(quantity, where, given):
    """Mean or variance of thickness where slab 0 is uniform over its zone and deeper slabs are it times a Gaussian."""
    low, high = given["zone_edge_bins"].values[where["zone"] : where["zone"] + 2]
    mean, variance = (high + low) / 2, (high - low) ** 2 / 12
    names = ("relative_thickness_mean", "relative_thickness_variance")
    at = where["zone"], where["slab"]
    factor, spread = (given[name].transpose("zone", "slab").values[at] for name in names)
    if quantity == "thickness_mean_bins":
        return mean * factor
    return variance * factor**2 + (mean**2 + variance) * spread


def _falls_steeply(given, where):
    """Whether a band of a given spectrum lies below the lowest band's continued as k^-2."""
    density = given["thickness_psd"].transpose("zone", "slab", "wavenumber").values[where["zone"], where["slab"]]
    edges = np.rint(given["band_edge_wavenumber"].values * BLOCK_LINES).astype(int)
    lowest, band = slice(edges[0], edges[1]), slice(*edges[where["band"] : where["band"] + 2])
    square = np.maximum(np.arange(density.size), 1.0) ** 2
    return density[band].mean() < (density * square)[lowest].mean() * (1 / square[band]).mean()


START = np.datetime64("2012-01-01T00:00:00", "ns")


def as_frame(power, layer_bins, index, *, bin_size_s, line_spacing_m):
    """One rendered scene as a frame that `summarise` reads.

    Parameters
    ----------
    power : ndarray, (range_bin, range_line)
        Linear.
    layer_bins : ndarray, (layer, range_line)
        Fractional range bins; NaN where absent.
    index : int
        Of the scene: frames sort by it.
    bin_size_s, line_spacing_m : float

    Returns
    -------
    echogram, layers : xarray.Dataset
        Open Polar Radar convention. Times and positions are made up: a minute a scene, northward.
    """
    n_lines = power.shape[1]
    start = START + index * np.timedelta64(1, "m")
    slow_time = start + np.arange(n_lines) * np.timedelta64(1, "ms")
    twtt = bin_size_s * layer_bins
    along = {
        "Latitude": 70 + np.degrees(line_spacing_m / EARTH_RADIUS_M) * np.arange(n_lines),
        "Longitude": np.full(n_lines, -45.0),
        "Elevation": np.zeros(n_lines),
        "Surface": twtt[0],
    }
    echogram = xr.Dataset(
        {"Data": (("twtt", "slow_time"), power)} | {name: ("slow_time", values) for name, values in along.items()},
        coords={"twtt": bin_size_s * np.arange(len(power)), "slow_time": slow_time},
    )
    ones = np.ones(layer_bins.shape, dtype=np.int8)
    dims = ("layer", "slow_time")
    layers = xr.Dataset(
        {"twtt": (dims, twtt), "quality": (dims, ones), "type": (dims, ones)}, coords={"slow_time": slow_time}
    )
    return echogram, layers


def thinned(summary, stride):
    """A summary with one in `stride` of its averaged range lines; picks and the power under them stay whole.

    The groups of a scene differ in speckle alone and `deblend` takes a limited number of them for the shapes: more
    cost time and disk, not accuracy. A frame keeps at least its first group.
    """
    names = ("power", "position", "spread", "n_picks", "air_sum", "air_square", "air_count")
    return [replace(frame, **{name: getattr(frame, name)[::stride] for name in names}) for frame in summary]
