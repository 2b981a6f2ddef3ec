"""Label models side by side: how well they explain the flight, what fewer parameters cost."""

import numpy as np
import pandas as pd

from evaluation.lib.spectra import FAINTEST, MODELS, SPECTRA, TABULATED, densities_of, fit_spectrum
from snowsim.labels.draw import draw_scene
from snowsim.statistics.zones import ALL_ZONES, OWN_ZONE

CRITERIA = ("aic", "bic")


def tabulate_models(zone_models):
    """A row for each number of zones and kind of spectrum: likelihood and parameters.

    Means are Gaussian, periodograms exponential about their density (Whittle), cells independent;
    slabs undulate together, so the flight tells less than is counted: both AIC and BIC lean to more
    parameters.
    """
    # Quasi-likelihood, Burnham & Anderson (2002), section 2.5: neighbouring blocks scatter more
    # than by Whittle's law.
    finest = max(zone_models, key=lambda model: model.sizes["zone"])
    dispersion = finest.attrs["dispersion"]
    rows = []
    for model in zone_models:
        for psd in MODELS:
            likelihood, n_parameters, penalty = _spectra_likelihood(model, psd)
            total = model.attrs["means_log_likelihood"] + likelihood / dispersion
            row = {"n_zones": model.sizes["zone"], "psd": psd}
            row |= {
                "n_parameters": model.attrs["means_n_parameters"] + n_parameters,
                "log_likelihood": total,
            }
            row |= {
                name: model.attrs[f"means_{name}_penalty"] + penalty[name] - 2 * total
                for name in CRITERIA
            }
            rows.append(row | {"dispersion": dispersion})
    return pd.DataFrame(rows)


def _spectra_likelihood(model, psd):
    """Log likelihood of block periodograms, number of parameters, and penalties by criterion."""
    tabulated, own, n, source = (
        model[name].values for name in ("thickness_psd", "block_psd", "n_psd_samples", "psd_source")
    )
    # Slabs with too few blocks everywhere take the one above: they tell nothing, and it is the same
    # ones in all models.
    n = np.where(source > ALL_ZONES, 0, n)
    # Tapered ordinates that neighbour each other tell less than independent ones.
    share = model.attrs.get("independent_share", 1.0)
    likelihood = share * whittle_log_likelihood(own, densities_of(tabulated, psd), n)
    # Cells with too few blocks share what all blocks of their slab give.
    blocks = [
        count for count, where in zip(n.ravel(), source.ravel(), strict=True) if where == OWN_ZONE
    ]
    blocks += [
        n[:, slab].sum() for slab in range(n.shape[1]) if (source[:, slab] == ALL_ZONES).any()
    ]
    blocks = np.array(blocks, dtype=float)
    n_wavenumbers = share * (tabulated.shape[-1] - 2)
    if psd == TABULATED:
        # Exact for exponential values: 2 n / (n - 1) a wavenumber.
        n_parameters, aic = (
            round(n_wavenumbers * blocks.size),
            (2 * n_wavenumbers * blocks / (blocks - 1)).sum(),
        )
        bic = (n_wavenumbers * np.log(blocks)).sum()
    else:
        k = SPECTRA[psd].n_parameters
        n_parameters, aic, bic = (
            k * blocks.size,
            2.0 * k * blocks.size,
            (k * np.log(n_wavenumbers * blocks)).sum(),
        )
    return likelihood, n_parameters, {"aic": float(aic), "bic": float(bic)}


def whittle_log_likelihood(periodogram, density, n):
    """Log likelihood of mean periodograms (..., wavenumber) of `n` blocks (...) each.

    Not of wavenumbers 0 and 1/2, nor where the periodogram is faint, as for `fit_spectrum`.
    """
    periodogram, density = periodogram[..., 1:-1], density[..., 1:-1]
    held = (density > 0) & (
        periodogram > FAINTEST * periodogram.max(axis=-1, keepdims=True, initial=0)
    )
    safe = np.where(held, density, 1)
    return float(-(n[..., None] * np.where(held, np.log(safe) + periodogram / safe, 0)).sum())


def choose(table, n_zones, psd):
    """Number of zones and kind of spectrum asked for; "aic" or "bic": the best by it."""
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


def tabulate_spectra(psd):
    """Spectra of a slab (zone, wavenumber) beside laws fitted [bins^2 per cycle per line]."""
    parts = []
    for zone, tabulated in enumerate(psd):
        wavenumber = np.arange(tabulated.size) / (2 * (tabulated.size - 1))
        columns = {"zone": zone, "wavenumber": wavenumber, "tabulated": tabulated}
        parts.append(
            pd.DataFrame(columns | {name: fit_spectrum(name, tabulated)[0] for name in SPECTRA})[1:]
        )
    return pd.concat(parts, ignore_index=True)


def scene_statistics(model, n_scenes, *, rng):
    """Mean and deviation of slab means in drawn scenes, and of thickness about them by band.

    `touched_share` is that of samples under the rule for thin slabs.
    """
    means, variance, touched = [], 0.0, np.zeros(2)
    edges = np.rint(model.band_edge_wavenumber * model.n_range_lines).astype(int)
    bands = np.zeros(edges.size - 1)
    for scene in range(n_scenes):
        drawn = draw_scene(model, model.n_range_lines, name=f"{scene}", rng=rng)
        thickness = np.diff(drawn.layer_bins, axis=0)
        means.append(thickness.mean(axis=1))
        variance += thickness.var(axis=1).sum()
        spectrum = np.abs(np.fft.rfft(thickness)) ** 2 * (2 / model.n_range_lines**2)
        bands += [
            spectrum[:, low:high].sum() for low, high in zip(edges[:-1], edges[1:], strict=True)
        ]
        touched += drawn.notes["n_touched"], drawn.notes["n_samples"]
    means = np.concatenate(means)
    return {
        "thickness_mean_bins": means.mean(),
        "thickness_deviation_bins": means.std(),
        "undulation_deviation_bins": np.sqrt(variance / means.size),
        **{
            f"undulation_{band}_bins": np.sqrt(total / means.size)
            for band, total in enumerate(bands)
        },
        "touched_share": touched[0] / touched[1],
    }


def compare_models(models, selection, n_scenes, stream):
    """Label models (number of zones, kind of spectrum, `LabelModel`) by name, a row each.

    Shares saved and changes are relative to the first; `stream` gives the same random generator for
    every model.
    """
    rows = []
    for name, (n_zones, psd, model) in models.items():
        criterion = selection[(selection["n_zones"] == n_zones) & (selection["psd"] == psd)].iloc[0]
        row = {
            "model": name,
            "n_zones": n_zones,
            "psd": psd,
            "n_parameters": int(criterion["n_parameters"]),
        }
        row |= {"aic": criterion["aic"], "bic": criterion["bic"]}
        rows.append(row | scene_statistics(model, n_scenes, rng=stream()))
    table = pd.DataFrame(rows)
    table.insert(4, "parameters_saved", 1 - table["n_parameters"] / table["n_parameters"].iloc[0])
    for name in [name for name in table.columns if name.endswith("_bins")]:
        table[f"{name}_change"] = table[name] / table[name].iloc[0] - 1
    return table
