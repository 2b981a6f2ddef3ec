"""The closed loop: label sets rendered by PHY, and their statistics beside those they were rendered from."""

from collections import namedtuple
from dataclasses import replace

import numpy as np
import pandas as pd

from snowsim.constants import EARTH_RADIUS_M
from snowsim.frames.blocks import placeholder_frame
from snowsim.phy import plan, render_plan, scene_parameters
from snowsim.statistics import estimate, merge, summarise
from snowsim.statistics.blocks import BLOCK_LINES
from snowsim.statistics.summaries import BY_GROUP
from snowsim.statistics.zones import OWN_ZONE

SURE = 2.0  # standard errors by which a difference counts as one
# A Gaussian of variance 1 stands in three bins: below, its width is not seen in samples one bin
# apart.
NARROW_BINS2 = 1.0


# How a quantity is compared: its dimensions, the unit of its error, and the largest error asked
# for.
Bound = namedtuple("Bound", "dims unit largest")
BOUNDS = {
    "peak_power": Bound(("layer",), "relative", 0.03),
    "decay_rate": Bound(("layer",), "relative", 0.05),
    "noise_power": Bound((), "relative", 0.01),
    "variance_bins2": Bound(("layer",), "relative", 0.20),
    **dict.fromkeys(("width_bins", "offset_bins"), Bound(("layer",), "bins", 1.0)),
    "thickness_mean_bins": Bound(("zone", "slab"), "relative", 0.03),
    "thickness_variance_bins2": Bound(("zone", "slab"), "relative", 0.10),
    "relative_thickness_mean": Bound(("zone", "slab"), "relative", 0.03),
    "relative_thickness_variance": Bound(("zone", "slab"), "relative", 0.10),
    "thickness_psd": Bound(("zone", "slab", "band"), "dB", 1.0),
    "thickness_trend_variance_bins2": Bound(("zone", "slab"), "relative", 0.15),
    "surface_fraction": Bound((), "relative", 0.05),
    "surface_trend_variance_bins2": Bound((), "relative", 0.15),
    **dict.fromkeys(("noise_spread_db", "surface_to_noise_spread_db"), Bound((), "relative", 0.15)),
    **dict.fromkeys(("common_spread_db", "layer_spread_db"), Bound((), "relative", 0.15)),
    **dict.fromkeys(
        ("fading_spread_db", "fading_length_lines"), Bound(("interface",), "relative", 0.15)
    ),
    **dict.fromkeys(("line_gain_spread_db", "texture_variance"), Bound((), "relative", 0.15)),
    **dict.fromkeys(("texture_length_bins", "texture_length_lines"), Bound((), "relative", 0.15)),
}
# What renders of label sets with one radiometry for all do not show.
VARIES = [
    name
    for name in BOUNDS
    if name.endswith(("_spread_db", "_length_lines")) or name.startswith("texture_")
]
COLUMNS = (
    *("quantity", "layer", "zone", "slab", "band", "interface"),
    *("given", "given_standard_error", "recovered", "recovered_standard_error"),
    *("error", "error_standard_error", "unit", "bound", "within", "reason"),
)


def compare(given, recovered, *, varies=True):
    """What comes back of the statistics that went into renders, a row a value that was measured, with `COLUMNS`.

    `layer`, `zone`, `slab`, `band` of wavenumber and `interface` (surface or buried) are -1 where a
    quantity has none; `error` is recovered against given, in `unit`, its standard error that of
    sampling the renders. Where label sets have one radiometry, nothing `varies` and the quantities
    of `VARIES` are left out. Different zones or bands are refused.
    """
    for name in ("zone_edge_bins", "band_edge_wavenumber"):
        ours, theirs = given[name].values, recovered[name].values
        if ours.shape != theirs.shape or not np.allclose(ours, theirs, rtol=1e-9):
            msg = f"statistics to compare must share {name}, got {ours.tolist()} and {theirs.tolist()}"
            raise ValueError(msg)
    rows = []
    for quantity, bound in BOUNDS.items():
        absent = (
            quantity not in given or quantity not in recovered
        )  # trends, by `paper` and version 0.1
        if absent or (quantity in VARIES and not varies):
            continue
        values = [_values(dataset, quantity, bound.dims) for dataset in (given, recovered)]
        shape = tuple(np.minimum(values[0][0].shape, values[1][0].shape))
        measured = _measured(recovered, quantity, shape)
        for at in np.ndindex(shape):
            numbers = [float(array[at]) for pair in values for array in pair]
            if measured[at] and np.isfinite(numbers).all() and numbers[0] != 0:
                rows.append(
                    _row(quantity, bound, dict(zip(bound.dims, at, strict=True)), numbers, given)
                )
    return pd.DataFrame(rows, columns=list(COLUMNS))


def largest_errors(table):
    """Bound, median and largest magnitude of every quantity's error, the latter over what sampling resolves.

    `score`: mean over powers, decay rates, noise, widths and, where estimated, offsets of the
    median over its bound.
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
    """A table of `compare` in short, a row a quantity: how many of all and of resolved values are within, errors."""
    errors = largest_errors(table)
    rows = []
    for quantity in table["quantity"].unique():
        part = table[table["quantity"] == quantity]
        reasons = part.loc[~part["within"], "reason"].value_counts()
        resolved = _is_resolved(part)
        row = {
            "quantity": quantity,
            "unit": BOUNDS[quantity].unit,
            "bound": BOUNDS[quantity].largest,
        }
        row |= {
            "n": len(part),
            "n_within": int(part["within"].sum()),
            "n_resolved": int(resolved.sum()),
        }
        row["n_resolved_within"] = int(part.loc[resolved, "within"].sum())
        row["median"] = errors[f"{quantity}_median"]
        row["median_standard_error"] = part["error_standard_error"].median()
        row["largest"] = errors[f"{quantity}_largest"]
        rows.append(
            row | {"reasons": "; ".join(f"{reason}: {n}" for reason, n in sorted(reasons.items()))}
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
    density, error = (
        statistics[name].transpose("zone", "slab", "wavenumber").values for name in names
    )
    bands = _bands(statistics)
    # Periodograms of different wavenumbers are independent, all but for leakage.
    errors = [
        np.sqrt((error[..., band] ** 2).sum(axis=-1)) / error[..., band].shape[-1] for band in bands
    ]
    return [
        np.stack([density[..., band].mean(axis=-1) for band in bands], axis=-1),
        np.stack(errors, axis=-1),
    ]


def _bands(statistics):
    """Slices of wavenumber, one a band."""
    edges = np.rint(statistics["band_edge_wavenumber"].values * BLOCK_LINES).astype(int)
    return [slice(low, high) for low, high in zip(edges[:-1], edges[1:], strict=True)]


def _measured(recovered, quantity, shape):
    """Where a recovered value is a measurement of its own: not substituted, not pooled, not slab 0 over itself."""
    measured = np.ones(shape, dtype=bool)
    if "layer" not in BOUNDS[quantity].dims and "slab" not in BOUNDS[quantity].dims:
        return measured
    if len(shape) == 1:
        return measured & (recovered["substituted"].values[: shape[0]] == 0)
    source = (
        "psd_source"
        if quantity in ("thickness_psd", "thickness_trend_variance_bins2")
        else "source"
    )
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
        **{dim: where.get(dim, -1) for dim in COLUMNS[1:6]},
        **dict(zip(COLUMNS[6:10], numbers, strict=True)),
        **{
            "error": error,
            "error_standard_error": sampling,
            "unit": bound.unit,
            "bound": bound.largest,
        },
        "within": within,
        "reason": ""
        if within
        else _reason(quantity, where, found, abs(error) - bound.largest, sampling, given),
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
        if given["peak_power"].values[where["layer"]] < float(given["noise_power"]):
            return "below the noise"
        if (
            quantity == "variance_bins2"
            and given["variance_bins2"].values[where["layer"]] < NARROW_BINS2
        ):
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
    density = (
        given["thickness_psd"]
        .transpose("zone", "slab", "wavenumber")
        .values[where["zone"], where["slab"]]
    )
    lowest, band = (_bands(given)[i] for i in (0, where["band"]))
    square = np.maximum(np.arange(density.size), 1.0) ** 2
    return density[band].mean() < (density * square)[lowest].mean() * (1 / square[band]).mean()


def as_frame(power, layer_bins, index, *, bin_size_s, line_spacing_m):
    """One rendered scene, linear power and layers, as a frame that `summarise` reads; frames sort by `index`."""
    latitude = 70 + np.degrees(line_spacing_m / EARTH_RADIUS_M) * np.arange(power.shape[1])
    return placeholder_frame(power, layer_bins, latitude, bin_s=bin_size_s, minute=index)


def thinned(summary, stride):
    """A summary with one in `stride` of its averaged range lines, at least one; picks and their power stay whole.

    The groups of a scene differ in speckle and fading. Too few of them measure a layer's power, and
    its share of the power on its picks, where it happens to be strong or faint: with 2 of 12 a
    sixth of the fading is lost, with 6 none.
    """
    return [
        replace(frame, **{name: getattr(frame, name)[::stride] for name in BY_GROUP})
        for frame in summary
    ]


def summarise_renders(scenes, given, convention, phy, stride, stream):
    """Sums over renders of (number, scene) by statistics `given`; `stream` gives the random generator of a scene.

    A convention is named ``<estimator>_<normalise>_<align>_<width>``; the rest of the settings is
    that of `phy`.
    """
    geometry = {name: given.attrs[name] for name in ("bin_size_s", "line_spacing_m")}
    _, normalise, align, width = convention.split("_")
    options = {
        "tolerance_db": phy["tolerance_db"],
        "speckle": "gamma",
        "normalise": normalise,
        "align": align,
    }
    drawn = {"width": width, "speckle_correlation": phy["speckle_correlation"]}
    summaries = []
    for number, scene in scenes:
        # By scene, never by part; where no width is drawn, the same speckle for every convention.
        rng = stream(scene.name)
        # As many looks as the flight: 20 lines average as many here as there.
        layer_bins, parameters = scene_parameters(scene, given, **drawn, rng=rng)
        power = render_plan(plan(layer_bins, parameters, scene.n_range_bins, **options), rng=rng)
        frame = as_frame(power, scene.layer_bins, number, **geometry)
        summaries.append(thinned(summarise(*frame, where=scene.name), stride))
    return merge(summaries)


def recover(summary, given, *, varies):
    """Statistics of renders, zone by zone as the flight's, and their table of `compare` beside those `given`."""
    recovered = estimate(
        summary, estimator=given.attrs["estimator"], zone_edge_bins=given["zone_edge_bins"].values
    )
    table = compare(given, recovered, varies=varies)
    return recovered.assign_attrs(synthetic="renders by PHY, not observed data"), table


def convention_table(tried):
    """A row a convention, of (its name, table of `recover`, number of scenes); the least `score` comes closest."""
    rows = []
    for convention, errors, n_scenes in tried:
        names = dict(
            zip(("estimator", "normalise", "align", "width"), convention.split("_"), strict=True)
        )
        rows.append(names | {"n_scenes": n_scenes} | largest_errors(errors))
    table = pd.DataFrame(rows)
    table.insert(5, "closest", table["score"] == table["score"].min())
    return table
