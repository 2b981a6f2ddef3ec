"""No more parameters than a flight needs: numbers of zones and families of spectra by information criteria."""

import numpy as np
import pandas as pd

from snowsim.labels.families import FAMILIES, fit_family, whittle_log_likelihood

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
