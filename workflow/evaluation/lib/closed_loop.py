"""The closed loop: statistics of PHY's renders of label sets beside those that went in."""

import logging

import numpy as np
import pandas as pd

from lib.phy_renders import is_printed
from lib.placeholder_frames import METRES_PER_DEGREE, placeholder_frame
from snowsim.labels import with_waveforms_of
from snowsim.phy import render_echoes
from snowsim.statistics import estimate, merge, summarise
from snowsim.statistics.summaries import MINIMUM_BLOCKS

logger = logging.getLogger("snowsim")


# The largest error allowed, relative or [bins].
BOUNDS = {
    "peak_power": 0.03,
    "decay_rate": 0.05,
    "noise_power": 0.01,
    "variance_bins2": 0.20,
    "width_bins": 1.0,
    "thickness_mean_bins": 0.03,
    "thickness_variance_bins2": 0.10,
    "relative_thickness_mean": 0.03,
    "relative_thickness_variance": 0.10,
    "relief_variance_bins2": 0.30,
    "slab_change_bins2": 0.30,
    "surface_error_bins": 0.15,
    "surface_movement_bins": 0.15,
    "surface_movement_length_m": 0.15,
}
IN_BINS = ("width_bins",)
# What renders of label sets with one radiometry for all do not show, and its bound.
SPREADS = (
    "surface_spread_db",
    "common_spread_db",
    "layer_spread_db",
    "line_gain_spread_db",
)
SPREAD_BOUND = 0.15
WHERE = ["layer", "zone", "slab"]
NUMBERS = ["flight", "recovered", "error"]
COLUMNS = ["quantity", *WHERE, *NUMBERS, "unit", "bound", "within"]
# One in so many averaged range lines of a scene is kept.
STRIDE = 2


def compare(flight, recovered, *, varies=True):
    """Statistics of a flight and those re-estimated from renders, a row for each measured value.

    `layer`, `zone` and `slab` are -1 where a quantity has none; `error` is recovered against the
    flight's, in `unit`. Where label sets have one radiometry, nothing `varies` and `SPREADS` are
    left out.
    """
    bounds = BOUNDS | dict.fromkeys(SPREADS, SPREAD_BOUND) if varies else BOUNDS
    tables = [
        _compared(quantity, bound, flight, recovered)
        for quantity, bound in bounds.items()
        # Estimates by `paper`, and those of images, lack some.
        if quantity in flight and quantity in recovered
    ]
    return pd.concat(tables, ignore_index=True)


def _compared(quantity, bound, flight, recovered):
    """The rows of `compare` of one quantity: not where it was substituted, or pooled over zones."""
    found = recovered[quantity]
    if "layer" in found.dims:
        found = found.where(recovered["substituted"] == 0)
    if "slab" in found.dims:
        found = found.where(recovered["n_samples"] >= MINIMUM_BLOCKS)
    numbers = {
        "flight": flight[quantity],
        "recovered": found,
    }
    # Label sets may have other numbers of layers than the flight: what both have is compared.
    series = {name: values.expand_dims("row").to_series() for name, values in numbers.items()}
    table = pd.concat(series, axis=1, join="inner").dropna().reset_index()
    table = table[table["flight"] != 0]
    if quantity.startswith("relative_"):
        table = table[table["slab"] > 0]  # slab 0 is one in units of itself
    unit = "bins" if quantity in IN_BINS else "relative"
    scale = 1.0 if quantity in IN_BINS else table["flight"]
    error = (table["recovered"] - table["flight"]) / scale
    table = table.assign(
        quantity=quantity,
        error=error,
        unit=unit,
        bound=bound,
        within=error.abs() <= bound,
    )
    return table.reindex(columns=COLUMNS, fill_value=-1)


def as_frame(power, layer_bins, index, *, bin_size_s, line_spacing_m):
    """A rendered scene, linear power and layers, as a frame for `summarise`, sorted by `index`."""
    latitude = 70 + np.arange(power.shape[1]) * line_spacing_m / METRES_PER_DEGREE
    return placeholder_frame(power, layer_bins, latitude, bin_s=bin_size_s, minute=index)


def thinned(summary, stride):
    """A summary with one in `stride` of its averaged range lines; picks and their power stay whole.

    Of one scene. Its groups differ in speckle alone.
    """
    kept = summary.isel(group=slice(None, None, stride))
    return kept.assign(n_groups=("frame", [kept.sizes["group"]]))


def summarise_renders(scenes, flight, phy, *, stream):
    """Sums over renders of (number, scene) by statistics of a flight and the settings `phy`.

    `stream` gives the random generator of a scene by its name.
    """
    geometry = {name: flight.attrs[name] for name in ("bin_size_s", "line_spacing_m")}
    # As many looks as the flight: 20 lines average as many here as there.
    summaries = []
    for number, scene in scenes:
        # By scene, never by shard: how scenes are divided must not change them.
        rng = stream(scene.name)
        echoes = with_waveforms_of(scene, flight)
        power = render_echoes(echoes, scene.n_range_bins, rng=rng, as_printed=is_printed(phy))
        frame = as_frame(power, scene.layer_bins, number, **geometry)
        summaries.append(thinned(summarise(*frame, where=scene.name), STRIDE))
    return merge(summaries)


def recovery_table(summary, flight, *, varies):
    """`compare` of statistics re-estimated from the renders, by the zones of the flight.

    Without rows where renders are too few or too poor for any; the log says why.
    """
    edges = flight["zone_edge_bins"].values
    try:
        recovered = estimate(summary, estimator=flight.attrs["estimator"], zone_edge_bins=edges)
    except ValueError as error:
        logger.warning(
            "closed loop: nothing is recovered from %d renders: %s", summary.sizes["frame"], error
        )
        return pd.DataFrame(columns=COLUMNS)
    return compare(flight, recovered, varies=varies)
