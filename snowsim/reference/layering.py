"""The fine layering of density in dry firn."""

import numpy as np
from scipy.signal import lfilter


def draw_layering(n_profiles, n_samples, spacing_m, sd_kg_m3, length_m, *, rng):
    """Fine layering of density about its trend, as logs of snow pits show it.

    Parameters
    ----------
    n_profiles, n_samples : int
        Logs, and samples of each.
    spacing_m : float
        Between samples.
    sd_kg_m3, length_m : float
        Standard deviation and vertical 1/e length of the autocorrelation.
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of float32, (profile, sample)
        Gaussian, exponential autocorrelation [kg m-3]. float32: its rounding is 1e-7 of a field known to percents.
    """
    persistence = np.float32(np.exp(-spacing_m / length_m))
    noise = rng.standard_normal((n_profiles, n_samples), dtype=np.float32)
    # The first sample keeps unit variance: the series starts stationary.
    noise[:, 1:] *= np.sqrt(1 - persistence**2)
    one = np.ones(1, dtype=np.float32)
    return np.float32(sd_kg_m3) * lfilter(one, np.array([1, -persistence], dtype=np.float32), noise, axis=1)
