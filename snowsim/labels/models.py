"""Families of thickness spectra with few parameters, fitted by the likelihood of Whittle.

No more parameters than a flight needs: numbers of zones and families of spectra by information criteria.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import minimize

LONGEST_PERIOD = 1e5  # [lines] of the corner of a Matern spectrum: beyond a block it is not told from none


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
class Family:
    """A shape of spectra: density over scale, where its search starts, and between what."""

    shape: object
    start: tuple = ()
    bounds: tuple = ()

    @property
    def n_parameters(self):
        """Parameters with the scale."""
        return 1 + len(self.start)


FAMILIES = {
    "white": Family(_white),
    "power_law": Family(_power_law, (2.0,), ((0.0, 8.0),)),
    "ar1": Family(_ar1, (0.9,), ((0.0, 0.99999),)),
    "matern": Family(_matern, (np.log(0.01), 1.0), ((-np.log(LONGEST_PERIOD), 0.0), (0.05, 8.0))),
}


def fit_family(name, psd):
    """The density of a family that is most likely behind a mean periodogram.

    Parameters
    ----------
    name : str
        ``white``: a. ``power_law``: a k^-b. ``ar1``: a / |1 - r exp(2 pi i k)|^2. ``matern``: a (k0^2 + k^2)^-b.
    psd : ndarray, (wavenumber,)
        One-sided mean periodogram from wavenumber 0 to 1/2, as `snowsim.statistics` gives it.

    Returns
    -------
    density : ndarray, (wavenumber,)
        0 at wavenumber 0, half the family's value at 1/2, as periodograms are; all 0 where `psd` is.
    parameters : ndarray, (parameter,)
        Scale, then shape.

    Raises
    ------
    ValueError
        If the family is unknown.

    Notes
    -----
    Whittle (1953), Ark. Mat. 2, 423-434: ``-log L = n sum_k (log S_k + P_k / S_k)`` for the mean P of n periodograms.
    The scale that minimises it follows from the shape; the shape by L-BFGS-B. Wavenumbers 0 and 1/2 are left out.
    What is fitted is the expected periodogram of blocks, leakage and all, as the tabulated density is.
    """
    if name not in FAMILIES:
        msg = f"psd must be one of {', '.join(FAMILIES)}, got {name!r}"
        raise ValueError(msg)
    family = FAMILIES[name]
    wavenumber = np.arange(psd.size) / (2 * (psd.size - 1))
    inside = slice(1, -1)
    if not (psd[inside] > 0).any():
        return np.zeros(psd.size), np.zeros(family.n_parameters)

    def unlikelihood(shape):
        unit = family.shape(wavenumber[inside], shape)
        return np.log(unit).mean() + np.log((psd[inside] / unit).mean())

    shape = np.array(family.start)
    if family.start:
        shape = minimize(unlikelihood, shape, method="L-BFGS-B", bounds=family.bounds).x
    unit = np.zeros(psd.size)
    unit[1:] = family.shape(wavenumber[1:], shape)
    scale = (psd[inside] / unit[inside]).mean()
    unit[-1] /= 2
    return scale * unit, np.array([scale, *shape])


def whittle_log_likelihood(periodogram, density, n):
    """Log likelihood of mean periodograms of `n` blocks each for a density, wavenumbers 0 and 1/2 left out.

    Parameters
    ----------
    periodogram, density : ndarray, (..., wavenumber)
    n : ndarray of int, (...)

    Returns
    -------
    float
        Cells without blocks, and those whose density is 0, add nothing.
    """
    periodogram, density = periodogram[..., 1:-1], density[..., 1:-1]
    held = density > 0
    safe = np.where(held, density, 1)
    return float(-(n[..., None] * np.where(held, np.log(safe) + periodogram / safe, 0)).sum())


def tabulate_families(psd):
    """Spectra of one slab by zone beside what each family makes of them.

    Parameters
    ----------
    psd : ndarray, (zone, wavenumber)

    Returns
    -------
    pandas.DataFrame
        `zone`, `wavenumber`, `tabulated` and a column a family [bins^2 per cycle per line].
    """
    parts = []
    for zone, tabulated in enumerate(psd):
        wavenumber = np.arange(tabulated.size) / (2 * (tabulated.size - 1))
        columns = {"zone": zone, "wavenumber": wavenumber, "tabulated": tabulated}
        parts.append(pd.DataFrame(columns | {name: fit_family(name, tabulated)[0] for name in FAMILIES})[1:])
    return pd.concat(parts, ignore_index=True)


CRITERIA = ("aic", "bic")
TABULATED = "tabulated"
MODELS = (TABULATED, *FAMILIES)
OWN_ZONE, ALL_ZONES = 0, 1  # where spectra of a cell come from, as `snowsim.statistics` writes it
POOLED_NAMES = ("thickness_psd", "block_psd", "n_psd_samples", "psd_source")


def tabulate_criteria(zone_models):
    """How well label models explain a flight and how many parameters they take.

    Parameters
    ----------
    zone_models : list of xarray.Dataset
        Of `snowsim.statistics.zone_models.zone_models`, one a number of zones.

    Returns
    -------
    pandas.DataFrame
        A row a number of zones and a kind of spectrum: `n_zones`, `psd`, `n_parameters`, `log_likelihood`, `aic`,
        `bic`; `dispersion`, the same in all.

    Notes
    -----
    Means are Gaussian, periodograms exponential about their density (Whittle), cells independent. Densities of
    neighbouring blocks of different level scatter more than that: log likelihoods of spectra are divided by the
    dispersion of the finest division, as for a quasi-likelihood (Burnham & Anderson 2002, section 2.5). The penalty of
    a tabulated density is exact for exponential values, ``2 n / (n - 1)`` a wavenumber in `aic`. Slabs undulate
    together, so the flight tells less than is counted here: both criteria lean to more parameters.
    """
    finest = max(zone_models, key=lambda model: model.sizes["zone"])
    dispersion = finest.attrs["dispersion"]
    rows = []
    for model in zone_models:
        for psd in MODELS:
            likelihood, n_parameters, penalty = _spectra_likelihood(model, psd)
            total = model.attrs["means_log_likelihood"] + likelihood / dispersion
            rows.append(
                {
                    "n_zones": model.sizes["zone"],
                    "psd": psd,
                    "n_parameters": model.attrs["means_n_parameters"] + n_parameters,
                    "log_likelihood": total,
                    "aic": model.attrs["means_aic_penalty"] + penalty["aic"] - 2 * total,
                    "bic": model.attrs["means_bic_penalty"] + penalty["bic"] - 2 * total,
                    "dispersion": dispersion,
                }
            )
    return pd.DataFrame(rows)


def choose(table, n_zones, psd):
    """Number of zones and kind of spectrum asked for, or the best by a criterion among those asked for.

    Parameters
    ----------
    table : pandas.DataFrame
        Of `tabulate_criteria`.
    n_zones : int or {"aic", "bic"}
    psd : {"tabulated", "white", "power_law", "ar1", "matern", "aic", "bic"}

    Returns
    -------
    n_zones : int
    psd : str

    Raises
    ------
    ValueError
        If both are left to different criteria, or the table does not hold what is asked for.
    """
    asked = {value for value in (n_zones, psd) if value in CRITERIA}
    if len(asked) > 1:
        msg = f"zones and spectra are chosen by one criterion, got {n_zones} and {psd}"
        raise ValueError(msg)
    held = table
    for column, value in (("n_zones", n_zones), ("psd", psd)):
        if value not in CRITERIA:
            held = held[held[column] == value]
    if held.empty:
        msg = f"label models hold no {n_zones} zones with {psd} spectra"
        raise ValueError(msg)
    row = held.loc[held[next(iter(asked))].idxmin()] if asked else held.iloc[0]
    return int(row["n_zones"]), str(row["psd"])


def label_model(zone_model, psd):
    """Statistics to draw labels from with spectra of one kind; the tabulated ones stay in `thickness_psd_tabulated`.

    Parameters
    ----------
    zone_model : xarray.Dataset
        One of `zone_models`.
    psd : str
        One of `MODELS`.

    Returns
    -------
    xarray.Dataset
    """
    density = zone_model["thickness_psd"].transpose("zone", "slab", "wavenumber")
    return zone_model.assign(
        thickness_psd=(density.dims, _densities(density.values, psd)), thickness_psd_tabulated=density
    ).assign_attrs(n_zones=zone_model.sizes["zone"], psd=psd)


def _densities(tabulated, psd):
    """Spectra of a kind, (zone, slab, wavenumber)."""
    if psd == TABULATED:
        return tabulated
    densities = np.zeros(tabulated.shape)
    for at in np.ndindex(tabulated.shape[:2]):
        densities[at] = fit_family(psd, tabulated[at])[0]
    return densities


def _spectra_likelihood(model, psd):
    """Log likelihood of block periodograms, number of parameters, and penalties by criterion."""
    tabulated, own, n, source = (model[name].values for name in POOLED_NAMES)
    # Slabs with too few blocks everywhere take the one above: they tell nothing, and it is the same ones in all models.
    n = np.where(source > ALL_ZONES, 0, n)
    likelihood = whittle_log_likelihood(own, _densities(tabulated, psd), n)
    # Cells with too few blocks share what all blocks of their slab give.
    blocks = [count for count, where in zip(n.ravel(), source.ravel(), strict=True) if where == OWN_ZONE]
    blocks += [n[:, slab].sum() for slab in range(n.shape[1]) if (source[:, slab] == ALL_ZONES).any()]
    blocks = np.array(blocks, dtype=float)
    n_wavenumbers = tabulated.shape[-1] - 2
    if psd == TABULATED:
        n_parameters, aic = n_wavenumbers * blocks.size, (2 * n_wavenumbers * blocks / (blocks - 1)).sum()
        bic = (n_wavenumbers * np.log(blocks)).sum()
    else:
        k = FAMILIES[psd].n_parameters
        n_parameters, aic, bic = k * blocks.size, 2.0 * k * blocks.size, (k * np.log(n_wavenumbers * blocks)).sum()
    return likelihood, n_parameters, {"aic": float(aic), "bic": float(bic)}
