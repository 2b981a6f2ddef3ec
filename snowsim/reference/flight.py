"""Frames of the synthetic reference flight and its one complex segment, as Open Polar Radar datasets."""

import numpy as np
import xarray as xr

from snowsim.constants import SPEED_OF_LIGHT_M_S
from snowsim.echogram import check_echogram, check_layers
from snowsim.reference.column import draw_column
from snowsim.reference.echo import draw_echo
from snowsim.reference.line import SECONDS_PER_KM, line_coordinates, line_length_km, place_at
from snowsim.reference.picks import n_visible_layers, pick_visible, rise_db
from snowsim.reference.radar import draw_look, draw_surface_row

SYNTHETIC = "synthetic reference flight, not observed data"
TAKE_OFF = np.datetime64("2012-04-29T12:00:00", "ns")
FLIGHT_TRACK = "flight"
WINDOW_LINES = 64  # over which the rise of a layer is averaged
SEGMENT_M = 5000.0  # as in Fig. 8 of the paper
SEGMENT_ROWS = 600
SEGMENT_CANDIDATES = np.linspace(0.1, 0.9, 161)  # of the line
GOOD, AUTOMATIC = 1, 2  # quality and type in CReSIS layer files


def draw_frame(frame, n_frames, n_range_lines, *, climate, settings, rng):
    """Echogram and layers of one frame of the sample flight, datasets of `snowsim.echogram`; `rng` is its own.

    Frames 0 ... n_frames - 1 lie evenly along the line, in the middle of its equal parts. Layers
    lie where the mean echo of their horizon peaks, NaN where it hardly rises over the snow above or
    the range line is missing; layers too deep to be seen are left out. Attributes say that they are
    synthetic, their looks and position. ValueError if there is no such frame, or the frames do not
    fit on the line.
    """
    radar = settings.radar
    length_km = n_range_lines * radar.line_spacing_m / 1e3
    if not 0 <= frame < n_frames:
        msg = f"frame must lie in [0, {n_frames - 1}], got {frame}"
        raise ValueError(msg)
    if n_range_lines < 2 or n_frames * length_km > line_length_km():
        msg = f"{n_frames} frames of {n_range_lines} range lines must fit on the line of {line_length_km():.0f} km, "
        msg += f"they have {n_frames * length_km:.1f} km"
        raise ValueError(msg)
    start_km = (frame + 0.5) / n_frames * line_length_km() - length_km / 2
    position_km = start_km + np.arange(n_range_lines) * radar.line_spacing_m / 1e3
    surface_row = draw_surface_row(n_range_lines, radar.surface_bin, radar, rng=rng)
    column = draw_column(
        climate, FLIGHT_TRACK, position_km, radar.n_range_bins - radar.surface_bin, rng=rng
    )
    echo = draw_echo(column, surface_row, radar.n_range_bins, settings.firn, radar, rng=rng)
    layer_bins = column.layer_bins(surface_row)
    mean_power = echo.mean()
    n_visible = n_visible_layers(
        rise_db(mean_power, layer_bins, 1)[:, 0], settings.picks.visible_db
    )
    layer_bins = layer_bins[:n_visible]
    n_windows = max(1, n_range_lines // WINDOW_LINES)
    picked = pick_visible(
        rise_db(mean_power, layer_bins, n_windows), layer_bins, settings.picks.gap_db
    )
    picked[:, echo.without_echo] = np.nan
    attributes = _attributes(column, position_km, settings)
    attributes |= {"frame": frame, "n_looks": radar.n_looks, "line_spacing_m": radar.line_spacing_m}
    twtt_s, along_track = _along_track(position_km, surface_row, radar, radar.n_range_bins)
    echogram = xr.Dataset(
        {
            "Data": (
                ("twtt", "slow_time"),
                echo.draw(radar.n_looks, rng=rng),
                {"units": "1", "long_name": "power"},
            )
        },
        coords={"twtt": ("twtt", twtt_s, {"units": "s"}), "slow_time": along_track.slow_time},
        attrs=attributes,
    ).merge(along_track)
    layers = _layers_dataset(picked, twtt_s, radar, along_track.slow_time, attributes)
    where = f"frame {frame}"
    check_echogram(echogram, where)
    check_layers(layers, where)
    return echogram, layers


def draw_complex_segment(*, climate, settings, rng):
    """A 5 km segment of the flight, complex, elevation-compensated and undetected, for the Doppler spectrum.

    It lies where the firn shows most years, away from the ends of the line. Variables: `Real` and
    `Imaginary` (twtt, slow_time) float32, the looks of a range line as range lines of their own;
    `layer_twtt` (layer, slow_time) [s] of all layers in the window, surface first. Scatterers are
    independent from look to look: the Doppler spectrum is flat by construction, here as in the
    paper's claim, and proves nothing.
    """
    radar = settings.radar
    n_lines = round(SEGMENT_M / radar.line_spacing_m)
    length_km = n_lines * radar.line_spacing_m / 1e3
    factor = settings.climate.accumulation_factor
    places = [place_at(km, factor) for km in SEGMENT_CANDIDATES * line_length_km()]
    n_years_seen = [
        climate.fade_depth_m(FLIGHT_TRACK, place) / place.accumulation_m for place in places
    ]
    start_km = places[int(np.argmax(n_years_seen))].position_km - length_km / 2
    position_km = start_km + np.arange(n_lines) * radar.line_spacing_m / 1e3
    surface_row = draw_surface_row(n_lines, radar.surface_bin, radar, rng=rng)
    column = draw_column(
        climate, FLIGHT_TRACK, position_km, SEGMENT_ROWS - radar.surface_bin, rng=rng
    )
    echo = draw_echo(column, surface_row, SEGMENT_ROWS, settings.firn, radar, rng=rng)
    amplitude = np.sqrt(echo.sub_bin_power / 2)
    looks = np.stack(
        [draw_look(amplitude, radar, echo.margin, rng=rng) for _ in range(radar.n_looks)], axis=1
    )
    looks = looks.reshape(-1, looks.shape[-1]).T  # (range_bin, look of a range line)

    layer_bins = column.layer_bins(surface_row)
    layer_bins = layer_bins[layer_bins.max(axis=1) < SEGMENT_ROWS - 1]
    spacing_m = radar.line_spacing_m / radar.n_looks
    repeat_km = position_km[0] + np.arange(n_lines * radar.n_looks) * spacing_m / 1e3
    repeated_row = np.repeat(surface_row, radar.n_looks)
    twtt_s, along_track = _along_track(repeat_km, repeated_row, radar, SEGMENT_ROWS)
    layer_twtt = twtt_s[0] + np.repeat(layer_bins, radar.n_looks, axis=1) * radar.bin_size_s
    return xr.Dataset(
        {
            "Real": (("twtt", "slow_time"), np.ascontiguousarray(looks.real)),
            "Imaginary": (("twtt", "slow_time"), np.ascontiguousarray(looks.imag)),
            "layer_twtt": (("layer", "slow_time"), layer_twtt, {"units": "s"}),
        },
        coords={"twtt": ("twtt", twtt_s, {"units": "s"}), "slow_time": along_track.slow_time},
        attrs={
            **_attributes(column, position_km, settings),
            "n_looks": 1,
            "line_spacing_m": spacing_m,
            "doppler": "flat by construction: scatterers are independent from look to look",
        },
    ).merge(along_track)


def _attributes(column, position_km, settings):
    """Attributes that frames, layers and segment have in common."""
    return {
        "synthetic": SYNTHETIC,
        "bin_size_s": settings.radar.bin_size_s,
        "start_km": float(position_km[0]),
        "end_km": float(position_km[-1]),
        "accumulation_m": column.place.accumulation_m,
        "percolation": column.percolation,
        "fade_depth_m": column.fade_depth_m,
    }


def _along_track(position_km, surface_row, radar, n_range_bins):
    """Fast time of a window, and the along-track variables of a dataset."""
    twtt_s = (
        2 * radar.height_m / SPEED_OF_LIGHT_M_S
        + (np.arange(n_range_bins) - radar.surface_bin) * radar.bin_size_s
    )
    latitude, longitude = line_coordinates(position_km)
    ice_m = np.array([place_at(km).elevation_m for km in (position_km[0], position_km[-1])])
    ice_m = np.interp(position_km, position_km[[0, -1]], ice_m)
    seconds = position_km * SECONDS_PER_KM
    slow_time = TAKE_OFF + np.rint(seconds * 1e9).astype("timedelta64[ns]")
    surface_s = twtt_s[0] + surface_row * radar.bin_size_s
    return twtt_s, xr.Dataset(
        {
            "Latitude": ("slow_time", latitude, {"units": "degrees_north"}),
            "Longitude": ("slow_time", longitude, {"units": "degrees_east"}),
            "Elevation": ("slow_time", ice_m + SPEED_OF_LIGHT_M_S * surface_s / 2, {"units": "m"}),
            "Surface": ("slow_time", surface_s, {"units": "s"}),
        },
        coords={"slow_time": slow_time},
    )


def _layers_dataset(picked, twtt_s, radar, slow_time, attributes):
    """Layer dataset of picks in range bins, down to the deepest layer with a pick."""
    deepest = int(np.flatnonzero(np.isfinite(picked).any(axis=1)).max(initial=0))
    picked = picked[: deepest + 1]
    picks = {
        "twtt": (("layer", "slow_time"), twtt_s[0] + picked * radar.bin_size_s, {"units": "s"})
    }
    for name, code in (("quality", GOOD), ("type", AUTOMATIC)):
        picks[name] = (("layer", "slow_time"), np.full(picked.shape, code, dtype=np.int8))
    return xr.Dataset(picks, {"layer": np.arange(len(picked)), "slow_time": slow_time}, attributes)
