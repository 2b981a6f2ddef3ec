"""Statistics of a flight with known spectra."""

import numpy as np
import xarray as xr

from snowsim.labels import prepare

N_LINES = 256
WAVENUMBER = np.fft.rfftfreq(N_LINES)


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
