"""The closed loop: statistics of PHY's renders of label sets beside those that went in."""

from dataclasses import asdict, dataclass, replace

import numpy as np
import pandas as pd

from snowsim.constants import EARTH_RADIUS_M
from snowsim.frames.blocks import placeholder_frame
from snowsim.labels import Dress, redress
from snowsim.phy import plan, render_plan
from snowsim.statistics import estimate, merge, summarise
from snowsim.statistics.blocks import BLOCK_LINES
from snowsim.statistics.summaries import BY_GROUP
from snowsim.statistics.zones import OWN_ZONE

SURE = 2.0  # standard errors by which a difference counts as one
# A Gaussian of variance 1 stands in three bins: below, its width is not seen in samples one bin
# apart.
NARROW_BINS2 = 1.0


@dataclass(frozen=True)
class Bound:
    """How a quantity is compared: dimensions, unit of the error, and the largest error allowed."""

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
    "thickness_trend_variance_bins2": Bound(("zone", "slab"), "relative", 0.15),
    "surface_fraction": Bound((), "relative", 0.05),
    "surface_trend_variance_bins2": Bound((), "relative", 0.15),
    "noise_spread_db": Bound((), "relative", 0.15),
    "surface_to_noise_spread_db": Bound((), "relative", 0.15),
    "common_spread_db": Bound((), "relative", 0.15),
    "layer_spread_db": Bound((), "relative", 0.15),
    "fading_spread_db": Bound(("interface",), "relative", 0.15),
    "fading_length_lines": Bound(("interface",), "relative", 0.15),
    "line_gain_spread_db": Bound((), "relative", 0.15),
    "texture_variance": Bound((), "relative", 0.15),
    "texture_length_bins": Bound((), "relative", 0.15),
    "texture_length_lines": Bound((), "relative", 0.15),
}
# What renders of label sets with one radiometry for all do not show.
VARIES = (
    "noise_spread_db",
    "surface_to_noise_spread_db",
    "common_spread_db",
    "layer_spread_db",
    "fading_spread_db",
    "fading_length_lines",
    "line_gain_spread_db",
    "texture_variance",
    "texture_length_bins",
    "texture_length_lines",
)
WHERE = ("layer", "zone", "slab", "band", "interface")
NUMBERS = ("given", "given_standard_error", "recovered", "recovered_standard_error")
COMPARISON = ("error", "error_standard_error", "unit", "bound", "within", "reason")
COLUMNS = ("quantity", *WHERE, *NUMBERS, *COMPARISON)


def compare(given, recovered, *, varies=True):
    """Statistics re-estimated from renders beside those given, a row for each measured value.

    `layer`, `zone`, `slab`, `band` of wavenumber and `interface` (surface or buried) are -1 where a
    quantity has none; `error` is recovered against given, in `unit`, its standard error that of
    sampling the renders. Where label sets have one radiometry, nothing `varies` and the quantities
    of `VARIES` are left out. Different zones or bands are refused.
    """
    for name in ("zone_edge_bins", "band_edge_wavenumber"):
        ours, theirs = given[name].values, recovered[name].values
        if ours.shape != theirs.shape or not np.allclose(ours, theirs, rtol=1e-9):
            msg = f"statistics to compare must share {name}, "
            msg += f"got {ours.tolist()} and {theirs.tolist()}"
            raise ValueError(msg)
    rows = []
    for quantity, bound in BOUNDS.items():
        # Estimates by `paper` have no trends.
        absent = quantity not in given or quantity not in recovered
        if absent or (quantity in VARIES and not varies):
            continue
        arrays = [*_values(given, quantity, bound.dims), *_values(recovered, quantity, bound.dims)]
        shape = tuple(np.minimum(arrays[0].shape, arrays[2].shape))
        measured = _measured(recovered, quantity, shape)
        for at in np.ndindex(shape):
            numbers = [float(array[at]) for array in arrays]
            if measured[at] and np.isfinite(numbers).all() and numbers[0] != 0:
                where = dict(zip(bound.dims, at, strict=True))
                rows.append(_row(quantity, bound, where, numbers, given))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def largest_errors(table):
    """Bound, median and, where sampling resolves it, largest error of every quantity.

    `score`: mean over powers, decay rates, noise, widths and, where estimated, offsets of the
    median over its bound.
    """
    magnitude = table["error"].abs()
    resolved = _is_resolved(table)
    errors = {}
    shares = []
    for quantity, bound in BOUNDS.items():
        of = table["quantity"] == quantity
        errors[f"{quantity}_bound"] = bound.largest
        errors[f"{quantity}_median"] = magnitude[of].median()
        errors[f"{quantity}_largest"] = magnitude[of & resolved].max()
        if quantity in ("peak_power", "decay_rate", "noise_power", "width_bins", "offset_bins"):
            shares.append(errors[f"{quantity}_median"] / bound.largest)
    errors["score"] = float(pd.Series(shares).mean())  # NaN where there is none
    return errors


def summarise_loop(table):
    """A table of `compare` in short, a row a quantity: how many values are within, and errors."""
    errors = largest_errors(table)
    rows = []
    for quantity in table["quantity"].unique():
        part = table[table["quantity"] == quantity]
        reasons = part.loc[~part["within"], "reason"].value_counts()
        resolved = _is_resolved(part)
        listed = [f"{reason}: {n}" for reason, n in sorted(reasons.items())]
        row = {
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
            "reasons": "; ".join(listed),
        }
        rows.append(row)
    return pd.DataFrame(rows)


def _is_resolved(table):
    """Where two standard errors of sampling are below the bound."""
    return table["error_standard_error"] < table["bound"] / SURE


def _values(statistics, quantity, dims):
    """Values and standard errors of a quantity; of a spectrum means over bands of wavenumber."""
    names = (quantity, f"{quantity}_standard_error")
    if "band" not in dims:
        return [statistics[name].transpose(*dims).values.astype(float) for name in names]
    dims = ("zone", "slab", "wavenumber")
    density, error = (statistics[name].transpose(*dims).values for name in names)
    means = []
    errors = []
    for band in _bands(statistics):
        means.append(density[..., band].mean(axis=-1))
        # Periodograms of different wavenumbers are independent, all but for leakage.
        n = error[..., band].shape[-1]
        errors.append(np.sqrt((error[..., band] ** 2).sum(axis=-1)) / n)
    return [np.stack(means, axis=-1), np.stack(errors, axis=-1)]


def _bands(statistics):
    """Slices of wavenumber, one a band."""
    edges = np.rint(statistics["band_edge_wavenumber"].values * BLOCK_LINES).astype(int)
    return [slice(low, high) for low, high in zip(edges[:-1], edges[1:], strict=True)]


def _measured(recovered, quantity, shape):
    """Where a recovered value is measured: not substituted, not pooled, not slab 0 over itself."""
    measured = np.ones(shape, dtype=bool)
    if "layer" not in BOUNDS[quantity].dims and "slab" not in BOUNDS[quantity].dims:
        return measured
    if len(shape) == 1:
        return measured & (recovered["substituted"].values[: shape[0]] == 0)
    of_spectrum = quantity in ("thickness_psd", "thickness_trend_variance_bins2")
    source = recovered["psd_source" if of_spectrum else "source"]
    own = source.transpose("zone", "slab").values[: shape[0], : shape[1]] == OWN_ZONE
    measured &= own.reshape(own.shape + (1,) * (len(shape) - 2))
    if quantity.startswith("relative_"):
        measured[:, 0] = False
    return measured


def _row(quantity, bound, where, numbers, given):
    """A row of `compare` of given and recovered `numbers`, each with its standard error."""
    value, _, found, found_error = numbers
    if bound.unit == "relative":
        error = found / value - 1
        sampling = found_error / abs(value)
    elif bound.unit == "bins":
        error = found - value
        sampling = found_error
    else:
        # A density that came back as zero is as far off as one can be.
        held = max(found, 1e-30)
        error = 10 * np.log10(held / value)
        sampling = 10 / np.log(10) * found_error / held
    excess = abs(error) - bound.largest
    within = excess <= 0
    row = {"quantity": quantity}
    row |= {dim: where.get(dim, -1) for dim in WHERE}
    row |= dict(zip(NUMBERS, numbers, strict=True))
    return row | {
        "error": error,
        "error_standard_error": sampling,
        "unit": bound.unit,
        "bound": bound.largest,
        "within": within,
        "reason": "" if within else _reason(quantity, where, found, excess, sampling, given),
    }


def _reason(quantity, where, found, excess, sampling, given):
    """Why an error is beyond its bound: the first that holds, else `bias`."""
    if excess <= SURE * sampling:
        return "sampling"
    # Labels draw slab 0 about evenly within a zone, the flight has it as it snowed.
    if quantity in ("thickness_mean_bins", "thickness_variance_bins2"):
        expected = _drawn_evenly(quantity, where, given)
        evenly = abs(found / expected - 1) <= BOUNDS[quantity].largest + SURE * sampling
        return "zone drawn evenly" if evenly else "bias"
    # Any series that does not end where it began leaks as k^-2.
    if quantity == "thickness_psd" and _falls_steeply(given, where):
        return "leakage"
    # PHY takes no offset: its convention is one.
    if quantity == "offset_bins":
        return "set by align"
    if "layer" in where:
        layer = where["layer"]
        if given["peak_power"].values[layer] < float(given["noise_power"]):
            return "below the noise"
        narrow = given["variance_bins2"].values[layer] < NARROW_BINS2
        if quantity == "variance_bins2" and narrow:
            return "narrower than a bin"
    return "bias"


def _drawn_evenly(quantity, where, given):
    """Mean or variance of thickness where slab 0 is uniform over its zone."""
    zone = where["zone"]
    low, high = given["zone_edge_bins"].values[zone : zone + 2]
    mean = (high + low) / 2
    variance = (high - low) ** 2 / 12
    factor = _by_slab(given, "relative_thickness_mean", where)
    if quantity == "thickness_mean_bins":
        return mean * factor
    spread = _by_slab(given, "relative_thickness_variance", where)
    return variance * factor**2 + (mean**2 + variance) * spread


def _by_slab(given, name, where):
    """Value of a zone's slab."""
    return given[name].transpose("zone", "slab", ...).values[where["zone"], where["slab"]]


def _falls_steeply(given, where):
    """Whether a band of a given spectrum lies below the lowest band's continued as k^-2."""
    density = _by_slab(given, "thickness_psd", where)
    bands = _bands(given)
    lowest = bands[0]
    band = bands[where["band"]]
    square = np.maximum(np.arange(density.size), 1.0) ** 2
    continued = (density * square)[lowest].mean() * (1 / square[band]).mean()
    return density[band].mean() < continued


def as_frame(power, layer_bins, index, *, bin_size_s, line_spacing_m):
    """A rendered scene, linear power and layers, as a frame for `summarise`, sorted by `index`."""
    latitude = 70 + np.degrees(line_spacing_m / EARTH_RADIUS_M) * np.arange(power.shape[1])
    return placeholder_frame(power, layer_bins, latitude, bin_s=bin_size_s, minute=index)


def thinned(summary, stride):
    """A summary with one in `stride` of its averaged range lines; picks and their power stay whole.

    The groups of a scene differ in speckle and fading. Too few of them measure a layer's power, and
    its share of the power on its picks, where it happens to be strong or faint: with 2 of 12 a
    sixth of the fading is lost, with 6 none.
    """
    return [
        replace(frame, **{name: getattr(frame, name)[::stride] for name in BY_GROUP})
        for frame in summary
    ]


def summarise_renders(scenes, given, convention, phy, stride, stream):
    """Sums over renders of (number, scene) by statistics `given`.

    A `Convention` replaces that of the settings `phy`, whose further ones stay; `stream` gives the
    random generator of a scene by its name.
    """
    geometry = {name: given.attrs[name] for name in ("bin_size_s", "line_spacing_m")}
    # As many looks as the flight: 20 lines average as many here as there.
    choices, options = Dress.split(phy | {"width": convention.width, "n_looks": None})
    options |= {
        "normalise": convention.normalise,
        "align": convention.align,
        "speckle": "gamma",
    }
    summaries = []
    for number, scene in scenes:
        # By scene, never by part; where no width is drawn, the same speckle for every convention.
        rng = stream(scene.name)
        echoes = redress(scene, given, choices, rng=rng)
        planned = plan(echoes.bins, echoes.parameters(), scene.n_range_bins, **options)
        frame = as_frame(render_plan(planned, rng=rng), scene.layer_bins, number, **geometry)
        summaries.append(thinned(summarise(*frame, where=scene.name), stride))
    return merge(summaries)


def recover(summary, given, *, varies):
    """Statistics of renders by the zones of those `given`, and their table of `compare`.

    Where renders are too poor for any, statistics are NaN, and every row of the table says why.
    """
    edges = given["zone_edge_bins"].values
    try:
        recovered = estimate(summary, estimator=given.attrs["estimator"], zone_edge_bins=edges)
        table = compare(given, recovered, varies=varies)
    except ValueError as error:
        recovered = _unknown(given).assign_attrs(n_frames=len(summary), not_recovered=str(error))
        table = _without_values(compare(given, given, varies=varies), str(error))
    return recovered.assign_attrs(synthetic="renders by PHY, not observed data"), table


def _unknown(statistics):
    """The same variables with NaN for every real number but the edges."""
    kept = ("zone_edge_bins", "band_edge_wavenumber")
    real = [name for name, values in statistics.items() if values.dtype.kind == "f"]
    return statistics.assign({name: statistics[name] * np.nan for name in real if name not in kept})


def _without_values(table, reason):
    """A table of `compare` whose values never came back."""
    missing = ["recovered", "recovered_standard_error", "error", "error_standard_error"]
    return table.assign(**dict.fromkeys(missing, np.nan), within=False, reason=reason)


def convention_table(tried):
    """A row for each (`Convention`, table of `recover`, number of scenes)."""
    rows = [
        asdict(convention) | {"n_scenes": n_scenes} | largest_errors(errors)
        for convention, errors, n_scenes in tried
    ]
    table = pd.DataFrame(rows)
    table.insert(5, "closest", table["score"] == table["score"].min())
    return table
