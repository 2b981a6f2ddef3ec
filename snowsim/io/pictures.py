"""Pictures of layers on their echograms, over axes of distance and depth."""

import numpy as np
import xarray as xr

from snowsim.alignment import along_track_m
from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db
from snowsim.io.files import written_whole

NO_MATPLOTLIB = "pictures need matplotlib: pip install 'snowsim[plot]'"
# Name and colour of picks by their quality.
QUALITIES = {1: ("good", "#009e73"), 2: ("moderate", "#f0a000"), 3: ("bad", "#d50000")}
TYPICAL_DENSITY_KG_M3 = 350.0  # assumed if depths are not given
MARGIN_S = 5e-9  # shown above the surface and below the deepest pick
BLACK_AND_WHITE_PERCENT = (5, 99.7)  # percentiles of power that are black and white
N_DEPTHS = 800
NAME_SHARES = (0.05, 0.03)  # width and height of a layer's name, as shares of the picture
# Two files round the time of one range line by less than this.
ROUNDING_OF_TIMES = np.timedelta64(1, "ms")
YEARS_BETWEEN_BANDS = 5  # the limits of ages are drawn for one year in this many


def write_picture(path, layers, echograms=(), accumulated=None):
    """Write a PNG of named layers on their echograms, with accumulation by year below if given.

    `layers` is a dataset whose first layer is the surface; `echograms` are the datasets of its
    frames. The colour of a pick is its quality. `accumulated` is a result of
    `snowsim.accumulation`; without it, depths are those in snow of 350 kg m-3. Needs matplotlib.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ValueError(NO_MATPLOTLIB) from error
    n_panels = 1 if accumulated is None else 2
    figure = Figure(figsize=(11, 1 + 4.5 * n_panels), layout="constrained")
    panels = figure.subplots(n_panels, sharex=True, squeeze=False)[:, 0]
    layers = layers.transpose("layer", "slow_time", ...)
    surface = layers["twtt"][0]
    below = layers["twtt"] - surface
    times_s, depths_m = _depths(below, accumulated)
    distance, label = _distance(layers)
    at = xr.DataArray(distance, {"slow_time": layers["slow_time"].values})
    if echograms:
        shown_m = np.linspace(depths_m[0], depths_m[-1], N_DEPTHS)
        shown_s = xr.DataArray(np.interp(shown_m, depths_m, times_s), {"depth": shown_m})
        power_db = xr.concat(
            [_power_db(_on_lines_of(layers, each), surface + shown_s) for each in echograms],
            "slow_time",
        )
        if power_db.notnull().any():
            low_db, high_db = np.nanpercentile(power_db, BLACK_AND_WHITE_PERCENT)
            _draw_image(
                panels[0], power_db, at, "power [dB]", cmap="gray", vmin=low_db, vmax=high_db
            )
    _draw_layers(panels[0], layers, distance, np.interp(below, times_s, depths_m))
    panels[0].set(ylim=depths_m[[-1, 0]], ylabel="depth [m]", xlabel="")
    if accumulated is None:
        panels[0].set_ylabel(f"depth in snow of {TYPICAL_DENSITY_KG_M3:g} kg m$^{{-3}}$ [m]")
    else:
        _draw_accumulation(panels[1], accumulated, at)
    panels[-1].set(xlabel=label)
    with written_whole(path) as aside:
        figure.savefig(aside, format="png", dpi=110)


def _draw_image(axes, image, at, label, **how):
    """Draw an image over `at`, the distance (slow_time,) of its range lines along track."""
    image = image.assign_coords(slow_time=at.sel(slow_time=image["slow_time"]).values)
    image.plot.imshow(ax=axes, x="slow_time", cbar_kwargs={"label": label}, **how)
    axes.set(title="")


def _draw_accumulation(axes, accumulated, at):
    """Draw accumulation by year, hatched if it is the mean of several years, and limits of ages."""
    _draw_image(axes, accumulated["accumulation_m_we"], at, "accumulation [m w.e. / yr]")
    year = accumulated["year"].values
    mean = accumulated["n_years"].values > 1
    if mean.any() and mean.shape[0] > 1:
        axes.contourf(at, year, mean, levels=[0.5, 1], hatches=["////"], colors="none")
    last_autumn = accumulated.attrs["last_autumn"]
    low = last_autumn - accumulated["age_high"].values
    high = last_autumn - accumulated["age_low"].values
    for number in range(0, year.size, YEARS_BETWEEN_BANDS):
        axes.fill_between(
            at, low[number], high[number], facecolor="#d5000030", edgecolor="#d50000", lw=0.7
        )
    axes.set_title("hatched: means of several years; red: nine of ten ages", fontsize="small")
    axes.yaxis.get_major_locator().set_params(integer=True)


def _draw_layers(axes, layers, distance, depth_m):
    """Draw layers (layer, range_line), with the name of each at its last pick."""
    for quality, (name, colour) in QUALITIES.items():
        of_quality = np.where(layers["quality"].values == quality, depth_m, np.nan)
        first, *_ = axes.plot(distance, of_quality.T, color=colour, lw=1)
        first.set_label(f"{name} picks")
    ends = []
    wide, high = NAME_SHARES[0] * np.ptp(distance), NAME_SHARES[1] * np.nan_to_num(depth_m).max()
    for name, of_layer in zip(layers["layer"].values, depth_m, strict=True):
        if not np.isfinite(of_layer).any():
            continue
        last = np.flatnonzero(np.isfinite(of_layer))[-1]
        x, y = distance[last], of_layer[last]
        # A name moves down until it lies clear of the names that end nearby.
        for other_y in sorted(other_y for other_x, other_y in ends if abs(x - other_x) < wide):
            if abs(y - other_y) < high:
                y = other_y + high
        ends.append((x, y))
        axes.text(x, y, str(name), fontsize=5, color="#56b4e9")
    axes.legend(fontsize="small", ncols=3, loc="lower left", bbox_to_anchor=(0, 1))


def _distance(layers):
    """Distance along track [km], or range line numbers if positions are missing; and axis label."""
    distance_m = along_track_m(layers)
    if np.isfinite(distance_m).all() and distance_m[-1] > 0:
        return distance_m / 1000, "distance [km]"
    return np.arange(distance_m.size), "range line"


def _depths(below, accumulated):
    """Travel times below the surface [s] and their depths [m], from above it to below all picks."""
    if accumulated is not None:
        known = accumulated["depth_at"]
        return known["below_s"].values, known.values
    per_s = SPEED_OF_LIGHT_M_S / (2 * (1 + KOVACS_M3_KG * TYPICAL_DENSITY_KG_M3))
    times_s = np.array([-MARGIN_S, float(below.fillna(0).max()) + MARGIN_S])
    return times_s, per_s * times_s


def _on_lines_of(layers, echogram):
    """Range lines of an echogram that `layers` have too, with the times that `layers` have."""
    times = layers.get_index("slow_time")
    line = times.get_indexer(echogram["slow_time"].values, "nearest", tolerance=ROUNDING_OF_TIMES)
    if (line < 0).all():
        msg = "picture: expected an echogram of the layers' range lines, found it has none of them"
        raise ValueError(msg)
    return echogram.isel(slow_time=line >= 0).assign_coords(slow_time=times[line[line >= 0]])


def _power_db(echogram, twtt):
    """Power [dB] of an echogram at travel times `twtt` (depth, slow_time) [s].

    NaN outside the echogram, and on range lines without a surface.
    """
    at = twtt.sel(slow_time=echogram["slow_time"])
    first = echogram["twtt"][0]
    power = echogram["Data"].sel(twtt=at.fillna(first), slow_time=at["slow_time"], method="nearest")
    inside = (at >= first) & (at <= echogram["twtt"][-1]) & (power > 0)
    return to_db(power.where(inside))
