"""Reference flights for tests: their climate, columns along them, and where a mean echo peaks."""

import numpy as np

from reference import checked_settings, draw_climate, draw_frame
from reference.column import draw_column
from reference.radar import range_response
from snowsim.seeding import random_stream

BARE_FIRN = {
    "layering_sd_kg_m3": 0.0,
    "crusts_per_year": 0.0,
    "horizon_year_sd": 0.0,
    "horizon_local_sd": 0.0,
}
BARE_RADAR = {
    "sensitivity_sd_db": 0.0,
    "missing_rate": 0.0,
    "saturated_rate": 0.0,
    "surface_to_noise_db": 60.0,
    "sidelobe_db": -200.0,
    "band_noise_db": -200.0,
    "line_gain_sd_db": 0.0,
    "quantisation_db": 0.0,
}
# Interfaces alone: nothing that moves a peak.
BARE = {"firn": BARE_FIRN, "radar": BARE_RADAR}


def climate_of(reference, seed=1):
    settings = checked_settings(reference)
    return draw_climate(settings, rng=random_stream(seed, "climate"))


def frames_of(reference, n_frames, n_range_lines, seed=1):
    """Echogram and layers of frames of a short flight under these settings."""
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=np.random.default_rng(seed))
    given = {"climate": climate, "settings": settings}
    return [
        draw_frame(i, n_frames, n_range_lines, **given, rng=np.random.default_rng(i))
        for i in range(n_frames)
    ]


def column_at(climate, km, n_lines, n_bins_below, *, rng):
    """Column under range lines of the flight from a position on."""
    position_km = km + np.arange(n_lines) * 5.47e-3
    return draw_column(climate, "flight", position_km, n_bins_below, rng=rng)


def peak_rows(echo, line, rows):
    """Rows of the maxima of a line's mean echo next to given rows, by parabolas of sub-bins."""
    n_sub = echo.radar.n_sub_bins
    response = range_response(echo.radar).astype(float) ** 2
    power = echo.sub_bin_power[line].astype(float)
    received = np.convolve(power, response, "same")
    centre = echo.margin + np.rint(rows * n_sub).astype(int)
    near = centre[:, None] + np.arange(-4, 5)
    top = near[np.arange(len(rows)), received[near].argmax(axis=1)]
    left = received[top - 1]
    middle = received[top]
    right = received[top + 1]
    vertex = top + 0.5 * (left - right) / (left - 2 * middle + right)
    return (vertex - echo.margin) / n_sub
