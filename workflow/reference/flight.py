"""Frames and the complex segment of the reference flight, as Open Polar Radar datasets."""

import numpy as np
import xarray as xr

from reference.echo import draw_stretch
from reference.line import SECONDS_PER_KM, line_coordinates, line_length_km, place_at
from reference.picks import pick_peaks, visible_layers
from reference.radar import draw_look
from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.limits import check_count, check_values

SYNTHETIC = "synthetic reference flight, not observed data"
TAKE_OFF = np.datetime64("2012-04-29T12:00:00", "ns")
FLIGHT_TRACK = "flight"
SEGMENT_M = 5000.0  # as in Fig. 8 of the paper
SEGMENT_ROWS = 600
SEGMENT_CANDIDATES = np.linspace(0.1, 0.9, 161)  # positions, as shares of the line
GOOD = 1  # quality in CReSIS layer files
AUTOMATIC = 2  # type in CReSIS layer files


def draw_frame(frame, n_frames, n_range_lines, *, climate, settings, rng):
    """Draw echogram and layers of one frame of the sample flight, datasets of `snowsim.echogram`.

    Frame `frame` lies in the middle of its part of the line, which is divided into `n_frames` equal
    parts; `rng` is for this frame alone. Layers are picked by the semi-automatic picker that also
    picks train scenes. Missing range lines have no picks; layers too deep to be seen are left out.
    Attributes say that the data are synthetic, their looks and their position. ValueError if there
    is no such frame, or the frames do not fit on the line.
    """
    radar = settings.radar
    length_km = n_range_lines * radar.line_spacing_m / 1e3
    check_values("frame", frame, 0, n_frames - 1)
    check_count("n_range_lines", n_range_lines, 2)
    kilometres = f"kilometres of {n_frames} frames of {n_range_lines} range lines"
    check_values(kilometres, n_frames * length_km, 0, line_length_km())
    start_km = (frame + 0.5) / n_frames * line_length_km() - length_km / 2
    where = (FLIGHT_TRACK, start_km, n_range_lines, radar.surface_bin, radar.n_range_bins)
    stretch = draw_stretch(climate, settings, *where, rng=rng)
    power = stretch.echo.draw(radar.n_looks, rng=rng)
    picked = _picked(stretch, power, settings.picks, rng=rng)
    attributes = {
        **_attributes(stretch, settings),
        "frame": frame,
        "n_looks": radar.n_looks,
        "line_spacing_m": radar.line_spacing_m,
    }
    window = _window(stretch.position_km, stretch.surface_row, radar, radar.n_range_bins)
    data = (("twtt", "slow_time"), power, {"units": "1", "long_name": "power"})
    echogram = xr.Dataset({"Data": data}, window.coords, attributes).merge(window)
    layers = _layers_dataset(picked, window, radar, attributes)
    return echogram, layers


def _picked(stretch, power, settings, *, rng):
    """Picks of the layers that can be seen, (layer, range_line) [range bins], NaN in gaps."""
    layer_bins = visible_layers(stretch.echo.mean(), stretch.layer_bins(), settings.visible_db)
    picked = pick_peaks(power, layer_bins, settings, rng=rng)
    # The surface is the product's own; people pick the layers below it.
    picked[0] = stretch.surface_row
    picked[:, stretch.echo.without_echo] = np.nan
    return picked


def draw_complex_segment(*, climate, settings, rng):
    """Draw a complex, elevation-compensated segment of 5 km, for the Doppler spectrum.

    It lies where the firn shows most years, away from the ends of the line. Variables are `Real`
    and `Imaginary` (twtt, slow_time) float32, in which each look is a range line of its own, and
    `layer_twtt` (layer, slow_time) [s] of all layers in the window, surface first. Scatterers are
    independent from look to look, so that the Doppler spectrum is flat by construction; that it is
    flat, as the paper claims, proves nothing.
    """
    radar = settings.radar
    n_lines = round(SEGMENT_M / radar.line_spacing_m)
    length_km = n_lines * radar.line_spacing_m / 1e3
    start_km = _clearest_km(climate, settings.climate) - length_km / 2
    where = (FLIGHT_TRACK, start_km, n_lines, radar.surface_bin, SEGMENT_ROWS)
    stretch = draw_stretch(climate, settings, *where, rng=rng)
    amplitude = np.sqrt(stretch.echo.sub_bin_power / 2)
    looks = np.stack(
        [draw_look(amplitude, radar, stretch.echo.margin, rng=rng) for _ in range(radar.n_looks)],
        axis=1,
    )
    looks = looks.reshape(-1, SEGMENT_ROWS).T  # (range_bin, look of a range line)

    layer_bins = stretch.layer_bins()
    layer_bins = layer_bins[layer_bins.max(axis=1) < SEGMENT_ROWS - 1]
    spacing_m = radar.line_spacing_m / radar.n_looks
    repeat_km = stretch.position_km[0] + np.arange(n_lines * radar.n_looks) * spacing_m / 1e3
    repeated_row = np.repeat(stretch.surface_row, radar.n_looks)
    window = _window(repeat_km, repeated_row, radar, SEGMENT_ROWS)
    repeated_bins = np.repeat(layer_bins, radar.n_looks, axis=1)
    layer_twtt_s = window.twtt.values[0] + repeated_bins * radar.bin_size_s
    return xr.Dataset(
        {
            "Real": (("twtt", "slow_time"), np.ascontiguousarray(looks.real)),
            "Imaginary": (("twtt", "slow_time"), np.ascontiguousarray(looks.imag)),
            "layer_twtt": (("layer", "slow_time"), layer_twtt_s, {"units": "s"}),
        },
        coords=window.coords,
        attrs={
            **_attributes(stretch, settings),
            "n_looks": 1,
            "line_spacing_m": spacing_m,
            "doppler": "flat by construction: scatterers are independent from look to look",
        },
    ).merge(window)


def _clearest_km(climate, settings):
    """Position [km] on the flight's line at which the firn shows most years."""
    n_years_seen = []
    candidates_km = SEGMENT_CANDIDATES * line_length_km()
    for position_km in candidates_km:
        place = place_at(position_km, settings.accumulation_factor)
        fade_depth_m = climate.fade_depth_m(FLIGHT_TRACK, place)
        n_years_seen.append(fade_depth_m / place.accumulation_m)
    return float(candidates_km[np.argmax(n_years_seen)])


def _attributes(stretch, settings):
    """Attributes that frames, layers and the segment have in common."""
    column = stretch.column
    return {
        "synthetic": SYNTHETIC,
        "bin_size_s": settings.radar.bin_size_s,
        "start_km": float(stretch.position_km[0]),
        "end_km": float(stretch.position_km[-1]),
        "accumulation_m": column.place.accumulation_m,
        "percolation": column.percolation,
        "fade_depth_m": column.fade_depth_m,
    }


def _window(position_km, surface_row, radar, n_range_bins):
    """Dataset of a window's fast time and of the variables along track."""
    first_s = 2 * radar.height_m / SPEED_OF_LIGHT_M_S
    below_surface = np.arange(n_range_bins) - radar.surface_bin
    twtt_s = first_s + below_surface * radar.bin_size_s
    latitude, longitude = line_coordinates(position_km)
    ends_km = position_km[[0, -1]]
    ice_m = np.interp(position_km, ends_km, [place_at(km).elevation_m for km in ends_km])
    nanoseconds = np.rint(position_km * SECONDS_PER_KM * 1e9)
    surface_s = twtt_s[0] + surface_row * radar.bin_size_s
    elevation_m = ice_m + SPEED_OF_LIGHT_M_S * surface_s / 2
    return xr.Dataset(
        {
            "Latitude": ("slow_time", latitude, {"units": "degrees_north"}),
            "Longitude": ("slow_time", longitude, {"units": "degrees_east"}),
            "Elevation": ("slow_time", elevation_m, {"units": "m"}),
            "Surface": ("slow_time", surface_s, {"units": "s"}),
        },
        coords={
            "slow_time": TAKE_OFF + nanoseconds.astype("timedelta64[ns]"),
            "twtt": ("twtt", twtt_s, {"units": "s"}),
        },
    )


def _layers_dataset(picked, window, radar, attributes):
    """Layer dataset of picks [range bins], down to the deepest layer that has one."""
    deepest = int(np.flatnonzero(np.isfinite(picked).any(axis=1)).max(initial=0))
    picked = picked[: deepest + 1]
    twtt_s = window.twtt.values[0] + picked * radar.bin_size_s
    variables = {"twtt": (("layer", "slow_time"), twtt_s, {"units": "s"})}
    for name, code in (("quality", GOOD), ("type", AUTOMATIC)):
        codes = np.full(picked.shape, code, dtype=np.int8)
        variables[name] = (("layer", "slow_time"), codes)
    coords = {"layer": np.arange(len(picked)), "slow_time": window.slow_time}
    return xr.Dataset(variables, coords, attributes)
