"""Reference flights for tests: their climate, frames, and columns along them."""

import numpy as np

from reference import checked_settings, draw_climate, draw_frame
from reference.column import draw_column
from snowsim.seeding import random_stream

# Interfaces alone: nothing that moves a peak.
BARE = {
    "firn": {
        "layering_sd_kg_m3": 0.0,
        "crusts_per_year": 0.0,
        "horizon_year_sd": 0.0,
        "horizon_local_sd": 0.0,
    },
    "radar": {
        "sensitivity_sd_db": 0.0,
        "missing_rate": 0.0,
        "saturated_rate": 0.0,
        "surface_to_noise_db": 60.0,
        "sidelobe_db": -200.0,
        "band_noise_db": -200.0,
        "line_gain_sd_db": 0.0,
        "quantisation_db": 0.0,
    },
}


def climate_of(reference):
    settings = checked_settings(reference)
    return draw_climate(settings, rng=random_stream(1, "climate"))


def frames_of(reference, n_frames, n_range_lines):
    """Echogram and layers of frames of a short flight under these settings."""
    settings = checked_settings(reference)
    climate = draw_climate(settings, rng=np.random.default_rng(1))
    given = {"climate": climate, "settings": settings}
    return [
        draw_frame(i, n_frames, n_range_lines, **given, rng=np.random.default_rng(i))
        for i in range(n_frames)
    ]


def column_at(climate, km, n_lines, n_bins_below, *, rng):
    """Column under range lines of the flight from a position on."""
    position_km = km + np.arange(n_lines) * 5.47e-3
    return draw_column(climate, "flight", position_km, n_bins_below, rng=rng)
