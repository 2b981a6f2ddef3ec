"""Pictures of layers on their echograms, over axes of distance and depth."""

import gc
import glob

import numpy as np
import xarray as xr

from snowsim.alignment import along_track_m
from snowsim.constants import KOVACS_M3_KG, SPEED_OF_LIGHT_M_S
from snowsim.echogram import to_db
from snowsim.io.echograms import read_echogram
from snowsim.io.files import (
    image_format_of,
    library_errors,
    noted,
    written_together,
    written_whole,
)

NO_MATPLOTLIB = "pictures need matplotlib: pip install 'snowsim[plot]'"
# Name and colour of picks by their quality.
QUALITIES = {1: ("good", "#009e73"), 2: ("moderate", "#f0a000"), 3: ("bad", "#d50000")}
TYPICAL_DENSITY_KG_M3 = 350.0  # assumed if depths are not given
MARGIN_S = 5e-9  # shown above the surface and below the deepest pick
BLACK_AND_WHITE_PERCENT = (5, 99.7)  # percentiles of power that are black and white
N_DEPTHS = 800
NAME_SHARES = (0.07, 0.037)  # width and height of a layer's name, as shares of the picture
# Two files round the time of one range line by less than this.
ROUNDING_OF_TIMES = np.timedelta64(1, "ms")
AGES_SHARE = 0.2  # width of the panel of ages, as share of the others'
SURE = 0.8  # probability from which on a date is not flagged
LINES_OF_PICTURE = 2000  # most range lines of a picture of picks


def pictures_of(folder, path):
    """Files in a folder that hold the picks of the input `path`, drawn by `draw_picks`."""
    stem = f"{glob.escape(path.stem)}_picks"
    return sorted([*folder.glob(f"{stem}.png"), *folder.glob(f"{stem}_[0-9][0-9].png")])


def draw_picks(path, layers, folder, bin_s):
    """Draw the picks of a file, which `layers` of its segment have, on its echogram.

    A long frame has several pictures. The file, if an image with range bins of `bin_s`, is read
    once more, because the samples of all frames of a segment do not fit into memory, and which
    samples are drawn depends on the picks.
    """
    picture = folder / f"{path.stem}_picks.png"
    with library_errors(picture, "picture: expected layers that can be drawn"):
        with noted(path):  # as when it was tracked
            if image_format_of(path) is None:
                drawn_on = read_echogram(path)
            else:
                from snowsim.io.pairs import read_image_as_echogram  # not above: it needs Pillow

                drawn_on = read_image_as_echogram(path, bin_s)
        gc.collect()  # bytes of the file, which are in a cycle of references: .1 GB of 50,000 lines
        of_frame = np.flatnonzero(layers["frame"] == path.stem)
        n_pictures = -(-of_frame.size // LINES_OF_PICTURE)
        with written_together():
            for number, lines in enumerate(np.array_split(of_frame, max(n_pictures, 1)), 1):
                part = layers.isel(slow_time=lines)
                is_drawn = part["twtt"].notnull().any("slow_time").values
                is_drawn[0] = True
                if n_pictures > 1:
                    picture = folder / f"{path.stem}_picks_{number:02d}.png"
                if lines.size:  # all lines of a frame may be another's, too
                    write_picture(picture, part.isel(layer=is_drawn), [drawn_on])


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
    columns = {"ncols": n_panels, "width_ratios": (1, AGES_SHARE)[:n_panels]}
    panels = figure.subplots(n_panels, sharex="col", squeeze=False, **columns)
    _draw_record(panels[:, 0], layers, echograms, accumulated)
    if accumulated is not None:
        _draw_ages(*panels[:, 1], panels[1, 0], accumulated)
    with written_whole(path) as aside:
        figure.savefig(aside, format="png", dpi=110)


def _draw_record(panels, layers, echograms, accumulated):
    """Draw layers on their echograms in the first panel, accumulation in the second, if any."""
    layers = layers.transpose("layer", "slow_time", ...)
    surface = layers["twtt"][0]
    below = layers["twtt"] - surface
    times_s, depths_m = _depths(below, accumulated)
    distance, label = _distance(layers)
    at = xr.DataArray(distance, {"slow_time": layers["slow_time"].values})
    if echograms:
        shown_m = np.linspace(depths_m[0], depths_m[-1], N_DEPTHS)
        shown_s = xr.DataArray(np.interp(shown_m, depths_m, times_s), {"depth": shown_m})
        _draw_echograms(panels[0], echograms, layers, at, surface + shown_s)
    panels[0].set(ylim=depths_m[[-1, 0]])
    _draw_layers(panels[0], layers, distance, np.interp(below, times_s, depths_m))
    if accumulated is None:
        panels[0].set_ylabel(f"depth in snow of {TYPICAL_DENSITY_KG_M3:g} kg m$^{{-3}}$ [m]")
    else:
        panels[0].set_ylabel("depth, by the density of the table [m]")
        _draw_accumulation(panels[1], accumulated, at)
    panels[0].set(xlabel="")
    panels[-1].set(xlabel=label)


def _draw_echograms(axes, echograms, layers, at, twtt):
    """Draw the power of echograms at travel times `twtt` (depth, slow_time) [s] of layers."""
    power_db = xr.concat(
        [_power_db(_on_lines_of(layers, each), twtt) for each in echograms], "slow_time"
    )
    if power_db.notnull().any():
        low_db, high_db = np.nanpercentile(power_db, BLACK_AND_WHITE_PERCENT)
        _draw_image(axes, power_db, at, "power [dB]", cmap="gray", vmin=low_db, vmax=high_db)


def _draw_image(axes, image, at, label, **how):
    """Draw an image over `at`, the distance (slow_time,) of its range lines along track."""
    image = image.assign_coords(slow_time=at.sel(slow_time=image["slow_time"]).values)
    image.plot.imshow(ax=axes, x="slow_time", cbar_kwargs={"label": label}, **how)
    axes.set(title="")


def _draw_accumulation(axes, accumulated, at):
    """Draw accumulation by year, hatched if it is the mean of several years."""
    _draw_image(axes, accumulated["accumulation_m_we"], at, "accumulation [m w.e. / yr]")
    year = accumulated["year"].values
    mean = accumulated["n_years"].values > 1
    if mean.any() and mean.shape[0] > 1:
        axes.contourf(at, year, mean, levels=[0.5, 1], hatches=["////"], colors="none")
        axes.set_title("hatched: mean of several years", fontsize="small")
    axes.set_ylabel("year of the autumn horizon;\nits snow lies below it")
    axes.yaxis.get_major_locator().set_params(integer=True)


def _draw_ages(above, axes, beside, accumulated):
    """Draw how far each year may be off: a bar a year, beside the years of other axes.

    The axes `above` hold the legend alone.
    """
    year = accumulated["year"].values
    last_autumn = accumulated.attrs["last_autumn"]
    # A layer has one age along track; lines without it are NaN.
    of_lines = {"dim": "slow_time", "skipna": True}
    low, high = (
        last_autumn - accumulated[name].median(**of_lines).values - year
        for name in ("age_high", "age_low")
    )
    sure = accumulated["year_confidence"].median(**of_lines).values >= SURE
    for is_sure, colour in ((True, "#0072b2"), (False, "#d55e00")):
        some = (sure == is_sure) & np.isfinite(low)
        if some.any():
            label = f"year_confidence {'at least' if is_sure else 'below'} {SURE:g}"
            axes.barh(year[some], (high - low)[some], 0.5, low[some], color=colour, label=label)
            axes.plot(np.zeros(some.sum()), year[some], ".", color="black", ms=3)
    axes.set(ylim=beside.get_ylim(), xlabel="error of the year [years]")
    axes.tick_params(labelleft=False)
    axes.grid(axis="x", lw=0.4)
    above.set_axis_off()
    title = "dates: nine of ten lie\nwithin the bar below"
    names = axes.get_legend_handles_labels()
    above.legend(*names, title=title, fontsize=8, title_fontsize=8, loc="lower center")


def _draw_layers(axes, layers, distance, depth_m):
    """Draw layers (layer, range_line), with the name of each at its last pick."""
    for quality, (name, colour) in QUALITIES.items():
        of_quality = np.where(layers["quality"].values == quality, depth_m, np.nan)
        first, *_ = axes.plot(distance, of_quality.T, color=colour, lw=1)
        first.set_label(f"{name} picks")
    ends = []
    wide, high = NAME_SHARES[0] * np.ptp(distance), NAME_SHARES[1] * np.ptp(axes.get_ylim())
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
        axes.text(x, y, str(name), fontsize=8, color="#56b4e9")
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
