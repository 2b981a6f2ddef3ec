"""The line over Greenland that the reference flight follows, and the mean climate along it."""

from dataclasses import dataclass

import numpy as np

from snowsim.constants import EARTH_RADIUS_M
from snowsim.snowpack.firn import temperature_fausto09

# The great circle from central Greenland to the north-west: (degrees north, degrees east).
LINE_START = (69.0, -38.5)
LINE_END = (76.7, -64.6)
EARTH_RADIUS_KM = EARTH_RADIUS_M / 1000

# Schematic profiles along the line. Accumulation [m w.e. / yr]: south-central plateau, dry interior
# north of Summit, wet north-west flank, in the range of Koenig et al. (2016), Cryosphere 10,
# 1739-1752. Ice surface [m]: rounded.
PROFILE_FRACTION = np.array([0.0, 0.25, 0.5, 0.7, 0.85, 0.95, 1.0])
ACCUMULATION_M = np.array([0.40, 0.29, 0.23, 0.20, 0.28, 0.42, 0.55])
ELEVATION_M = np.array([2550.0, 3000.0, 2900.0, 2650.0, 2250.0, 1800.0, 1300.0])

SECONDS_PER_KM = 1 / 0.12  # at 120 m/s


@dataclass(frozen=True)
class Place:
    """A point of the line: height of the ice, mean accumulation [m w.e. / yr], mean temperature."""

    position_km: float
    latitude: float
    longitude: float
    elevation_m: float
    accumulation_m: float
    temperature_k: float


def place_at(position_km, accumulation_factor=1.0):
    """`Place` at a position along the line; ValueError outside it.

    `accumulation_factor` is that of `ClimateSettings`.
    """
    length_km = line_length_km()
    latitude, longitude = map(float, line_coordinates(position_km))
    elevation_m = float(_profile(ELEVATION_M, position_km / length_km))
    return Place(
        position_km=float(position_km),
        latitude=latitude,
        longitude=longitude,
        elevation_m=elevation_m,
        accumulation_m=float(accumulation_factor * accumulation_m(position_km)),
        temperature_k=temperature_fausto09(elevation_m, latitude, longitude),
    )


def accumulation_m(position_km):
    """Long-term mean accumulation [m w.e. / yr] at positions along the line, of their shape."""
    return _profile(ACCUMULATION_M, np.asarray(position_km) / line_length_km())


def _profile(values, fraction):
    # SciPy's interpolation is slow to import, and planning a run needs no profile.
    from scipy.interpolate import PchipInterpolator

    return PchipInterpolator(PROFILE_FRACTION, values)(fraction)


def line_length_km():
    """Length [km] of the great circle from `LINE_START` to `LINE_END` on a sphere."""
    start = _unit_vector(*LINE_START)
    end = _unit_vector(*LINE_END)
    sine = np.linalg.norm(np.cross(start, end))
    return float(EARTH_RADIUS_KM * np.arctan2(sine, start @ end))


def line_coordinates(position_km):
    """Latitude and longitude [degrees] at positions along the line [km], of their shape."""
    start = _unit_vector(*LINE_START)
    end = _unit_vector(*LINE_END)
    angle = line_length_km() / EARTH_RADIUS_KM
    along = np.asarray(position_km, dtype=float) / EARTH_RADIUS_KM
    of_start = np.sin(angle - along) / np.sin(angle)
    of_end = np.sin(along) / np.sin(angle)
    x, y, z = (of_start * a + of_end * b for a, b in zip(start, end, strict=True))
    latitude = np.arctan2(z, np.hypot(x, y))
    return np.degrees(latitude), np.degrees(np.arctan2(y, x))


def _unit_vector(latitude_deg, longitude_deg):
    latitude = np.radians(latitude_deg)
    longitude = np.radians(longitude_deg)
    x = np.cos(latitude) * np.cos(longitude)
    y = np.cos(latitude) * np.sin(longitude)
    return np.array([x, y, np.sin(latitude)])
