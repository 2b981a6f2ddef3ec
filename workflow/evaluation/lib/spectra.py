"""Laws of few parameters fitted to tabulated spectra of thickness."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from snowsim.echogram import check_choice

# Of the largest density: below lie rounding and leakage, not undulations that a scene shows.
FAINTEST = 1e-8
LONGEST_PERIOD = (
    1e5  # [lines] of the corner of a Matern spectrum: longer than a block it has no effect
)


def _white(wavenumber, _):
    return np.ones(wavenumber.size)


def _power_law(wavenumber, shape):
    return wavenumber ** -shape[0]


def _ar1(wavenumber, shape):
    # (1 - r)^2 + 4 r sin^2: what 1 + r^2 - 2 r cos would lose to cancellation for r close to 1.
    return 1 / ((1 - shape[0]) ** 2 + 4 * shape[0] * np.sin(np.pi * wavenumber) ** 2)


def _matern(wavenumber, shape):
    return (np.exp(2 * shape[0]) + wavenumber**2) ** -shape[1]


@dataclass(frozen=True)
class Spectrum:
    """A law of spectra, density over scale by wavenumber and shape; start and bounds of search."""

    shape: object
    start: tuple = ()
    bounds: tuple = ()

    @property
    def n_parameters(self):
        """Number of parameters, scale included."""
        return 1 + len(self.start)


SPECTRA = {
    "white": Spectrum(_white),
    "power_law": Spectrum(_power_law, (2.0,), ((0.0, 8.0),)),
    "ar1": Spectrum(_ar1, (0.9,), ((0.0, 0.99999),)),
    "matern": Spectrum(_matern, (np.log(0.01), 1.0), ((-np.log(LONGEST_PERIOD), 0.0), (0.05, 8.0))),
}
TABULATED = "tabulated"
MODELS = (TABULATED, *SPECTRA)


def fit_spectrum(name, psd):
    """Density of a law most likely behind a mean periodogram, (wavenumber,); its scale and shape.

    ``white``: a. ``power_law``: a k^-b. ``ar1``: a / |1 - r exp(2 pi i k)|^2. ``matern``: a (k0^2 +
    k^2)^-b. `psd` is one-sided from wavenumber 0 to 1/2, as `snowsim.statistics` gives it; the
    density is 0 at 0 and half the law's value at 1/2, as periodograms are, and 0 throughout where
    `psd` is. An unknown law is refused.

    Whittle (1953), Ark. Mat. 2, 423-434: ``-log L = n sum_k (log S_k + P_k / S_k)`` for the mean P
    of n periodograms. The scale that minimises it follows from the shape; the shape by L-BFGS-B.
    Wavenumbers 0 and 1/2 are left out, and those 80 dB below the largest density. The law is fitted
    to the expected periodogram of blocks, as tabulated; a plain one includes its leakage.
    """
    check_choice("psd", name, SPECTRA)
    spectrum = SPECTRA[name]
    wavenumber = np.arange(psd.size) / (2 * (psd.size - 1))
    inside = psd > FAINTEST * psd.max()
    inside[[0, -1]] = False
    if not inside.any():
        return np.zeros(psd.size), np.zeros(spectrum.n_parameters)

    def unlikelihood(shape):
        unit = spectrum.shape(wavenumber[inside], shape)
        return np.log(unit).mean() + np.log((psd[inside] / unit).mean())

    shape = np.array(spectrum.start)
    if spectrum.start:
        shape = minimize(unlikelihood, shape, method="L-BFGS-B", bounds=spectrum.bounds).x
    unit = np.zeros(psd.size)
    unit[1:] = spectrum.shape(wavenumber[1:], shape)
    scale = (psd[inside] / unit[inside]).mean()
    unit[-1] /= 2
    return scale * unit, np.array([scale, *shape])


def with_spectra(zone_model, psd):
    """One of the flight's `zone_models` with spectra of one of `MODELS`, to draw labels from."""
    density = zone_model["thickness_psd"].transpose("zone", "slab", "wavenumber")
    return zone_model.assign(thickness_psd=(density.dims, densities_of(density.values, psd)))


def densities_of(tabulated, psd):
    """Spectra (zone, slab, wavenumber) as one of `MODELS`."""
    if psd == TABULATED:
        return tabulated
    densities = np.zeros(tabulated.shape)
    for at in np.ndindex(tabulated.shape[:2]):
        densities[at] = fit_spectrum(psd, tabulated[at])[0]
    return densities
