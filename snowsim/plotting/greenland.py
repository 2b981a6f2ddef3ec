"""A map of Greenland: a schematic coast between named places, and a polar stereographic projection."""

import numpy as np

# Degrees north and east, rounded; clockwise from the southern tip. The coast between them is drawn straight.
COAST = {
    "Cape Farewell": (59.8, -43.9),
    "Prins Christian Sund": (60.1, -43.1),
    "Lindenow Fjord": (60.5, -43.0),
    "Timmiarmiut": (62.5, -42.1),
    "Skjoldungen": (63.2, -41.4),
    "Kap Mosting": (63.7, -40.5),
    "Isortoq": (65.5, -39.0),
    "Tasiilaq": (65.6, -37.6),
    "Kap Gustav Holm": (66.6, -34.3),
    "Kangerlussuaq, east": (68.1, -31.8),
    "Kap Dalton": (69.4, -24.1),
    "Kap Brewster": (70.1, -22.1),
    "Ittoqqortoormiit": (70.5, -22.0),
    "Liverpool Land": (71.5, -21.7),
    "Traill Island": (72.5, -22.0),
    "Kap Broer Ruys": (73.5, -20.4),
    "Daneborg": (74.3, -20.2),
    "Shannon": (75.2, -17.5),
    "Danmarkshavn": (76.8, -18.7),
    "Ile de France": (77.7, -17.7),
    "Nordostrundingen": (81.4, -11.5),
    "Station Nord": (81.6, -16.7),
    "Kap Bridgman": (83.4, -26.0),
    "Cape Morris Jesup": (83.6, -33.4),
    "Lockwood Island": (83.4, -40.5),
    "Cape Bryant": (82.3, -55.0),
    "Kap Morton": (81.2, -63.6),
    "Kap Constitution": (80.6, -66.9),
    "Humboldt Glacier": (79.2, -65.5),
    "Cape Inglefield": (78.6, -72.7),
    "Cape Alexander": (78.2, -73.1),
    "Pituffik": (76.5, -68.8),
    "Cape York": (75.9, -66.4),
    "Melville Bay": (76.2, -62.0),
    "Kullorsuaq": (74.6, -57.2),
    "Upernavik": (72.8, -56.1),
    "Nuussuaq": (70.7, -54.6),
    "Qeqertarsuaq": (69.3, -53.5),
    "Aasiaat": (68.7, -52.9),
    "Sisimiut": (66.9, -53.7),
    "Maniitsoq": (65.4, -52.9),
    "Nuuk": (64.2, -51.7),
    "Paamiut": (62.0, -49.7),
    "Arsuk": (61.2, -48.4),
    "Nanortalik": (60.1, -45.2),
}
EARTH_RADIUS_KM = 6371.0
CENTRAL_LONGITUDE_DEG = -42.0
TRUE_LATITUDE_DEG = 70.0
PARALLELS_DEG = (60, 65, 70, 75, 80)
MERIDIANS_DEG = (-70, -60, -50, -40, -30, -20)


def project(latitude_deg, longitude_deg):
    """Polar stereographic coordinates on a sphere, x and y [km]: the pole at 0, scale true at 70 degrees north."""
    latitude, longitude = np.radians(latitude_deg), np.radians(np.asarray(longitude_deg) - CENTRAL_LONGITUDE_DEG)
    scale = (1 + np.sin(np.radians(TRUE_LATITUDE_DEG))) * EARTH_RADIUS_KM
    radius = scale * np.tan(np.pi / 4 - latitude / 2)
    return radius * np.sin(longitude), -radius * np.cos(longitude)


def draw_coast(ax):
    """Greenland with its graticule on axes in km of `project`; no ticks, the graticule is labelled."""
    coast = np.array([*COAST.values(), next(iter(COAST.values()))])
    x, y = project(*coast.T)
    ax.fill(x, y, color="#EDF2F5", edgecolor="0.45", linewidth=0.8, zorder=0)
    fine = {"color": "0.75", "linewidth": 0.5, "zorder": 1}
    for latitude in PARALLELS_DEG:
        ax.plot(*project(latitude, np.linspace(-75, -10, 100)), **fine)
        at = project(latitude, -10)
        ax.annotate(
            f"{latitude}°N", at, fontsize=7, color="0.35", xytext=(2, 0), textcoords="offset points", va="center"
        )
    for longitude in MERIDIANS_DEG:
        ax.plot(*project(np.linspace(58.5, 83, 50), longitude), **fine)
        at = project(58.5, longitude)
        ax.annotate(f"{-longitude}°W", at, fontsize=7, color="0.35", xytext=(0, -2), textcoords="offset points",
                    ha="center", va="top")  # fmt: skip
    ax.set_aspect("equal")
    ax.set_axis_off()
