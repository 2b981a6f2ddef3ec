"""Statistics of a flight with known spectra, and spectra of known laws."""

import numpy as np
import xarray as xr

from snowsim.labels import prepare

N_LINES = 256
WAVENUMBER = np.fft.rfftfreq(N_LINES)

PARAMETERS = {
    "white": (3.0,),
    "power_law": (2e-4, 2.3),
    "ar1": (0.02, 0.95),
    "matern": (5e-5, np.log(0.03), 1.6),
}


def density_of(name):
    """Density of the planted parameters, written out by hand."""
    k = np.where(WAVENUMBER > 0, WAVENUMBER, np.inf)
    a, *shape = PARAMETERS[name]
    if name == "white":
        density = np.full(k.size, a)
    elif name == "power_law":
        density = a / k ** shape[0]
    elif name == "ar1":
        density = a / (1 + shape[0] ** 2 - 2 * shape[0] * np.cos(2 * np.pi * WAVENUMBER))
    else:
        density = a / (np.exp(shape[0]) ** 2 + WAVENUMBER**2) ** shape[1]
    density[0] = 0
    density[-1] /= 2
    return density


def planted(n_slabs=20, scale=40.0):
    """Statistics of a flight with a red spectrum, four zones and slabs that thin with depth."""
    psd = np.zeros((4, n_slabs, WAVENUMBER.size))
    psd[:, :, 1:] = (
        scale * np.array([0.7, 0.9, 1.1, 1.3])[:, None, None] / (1 + (WAVENUMBER[1:] / 0.01) ** 2)
    )
    separation = np.arange(n_slabs)
    return xr.Dataset(
        {
            "thickness_psd": (("zone", "slab", "wavenumber"), psd),
            "zone_edge_bins": ("edge", [15.0, 20, 25, 30, 40]),
            "relative_thickness_mean": (("zone", "slab"), np.tile(1 - 0.02 * separation, (4, 1))),
            "relative_thickness_variance": (("zone", "slab"), np.full((4, n_slabs), 0.01)),
            "thickness_correlation": (
                ("band", "separation"),
                np.array([0.9, 0.6, 0.3, 0])[:, None] ** separation,
            ),
            "relative_thickness_correlation": ("separation", 0.5**separation),
        },
        coords={
            "wavenumber": WAVENUMBER,
            "band_edge_wavenumber": ("band_edge", np.array([1, 3, 9, 27, 129]) / N_LINES),
        },
    )


def paper_model(statistics, n_range_lines=N_LINES, **choices):
    """Label model by the paper's choices where others are not named."""
    paper = {
        "n_layers": (5, 40),
        "first_slab": "uniform",
        "surface": "flat",
        "radiometry": "constant",
    }
    return prepare(statistics, n_range_lines, **paper | choices)
