"""What label models with fewer parameters cost: thickness statistics of scenes drawn from each."""

import numpy as np
import pandas as pd

from snowsim.labels.draw import draw_scene


def scene_statistics(model, n_scenes, *, rng):
    """Thickness statistics of scenes drawn from a label model.

    Parameters
    ----------
    model : LabelModel
    n_scenes : int
    rng : numpy.random.Generator

    Returns
    -------
    dict
        `thickness_mean_bins`, over all slabs of all scenes; `thickness_deviation_bins`, of slab means about it;
        `undulation_deviation_bins`, of thickness about slab means, all bands of wavenumber; `undulation_<band>_bins`,
        the same of one band; `touched_share` of samples under the rule for thin slabs.
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
        bands += [spectrum[:, low:high].sum() for low, high in zip(edges[:-1], edges[1:], strict=True)]
        touched += drawn.notes["n_touched"], drawn.notes["n_samples"]
    means = np.concatenate(means)
    return {
        "thickness_mean_bins": means.mean(),
        "thickness_deviation_bins": means.std(),
        "undulation_deviation_bins": np.sqrt(variance / means.size),
        **{f"undulation_{band}_bins": np.sqrt(total / means.size) for band, total in enumerate(bands)},
        "touched_share": touched[0] / touched[1],
    }


def compare_models(models, criteria, n_scenes, stream):
    """Label models side by side.

    Parameters
    ----------
    models : dict of str to (int, str, LabelModel)
        Number of zones, kind of spectrum and model by what chose it; the first is what others are compared with.
    criteria : pandas.DataFrame
        Of `snowsim.labels.models.tabulate_criteria`.
    n_scenes : int
    stream : callable
        Gives the same fresh random generator for every model.

    Returns
    -------
    pandas.DataFrame
        A row a model: `model`, `n_zones`, `psd`, `n_parameters`, `parameters_saved` (share of the first's),
        `aic`, `bic`, and `scene_statistics` with `<name>_change`, relative to the first.
    """
    rows = []
    for name, (n_zones, psd, model) in models.items():
        criterion = criteria[(criteria["n_zones"] == n_zones) & (criteria["psd"] == psd)].iloc[0]
        row = {"model": name, "n_zones": n_zones, "psd": psd, "n_parameters": int(criterion["n_parameters"])}
        row |= {"aic": criterion["aic"], "bic": criterion["bic"]}
        rows.append(row | scene_statistics(model, n_scenes, rng=stream()))
    table = pd.DataFrame(rows)
    table.insert(4, "parameters_saved", 1 - table["n_parameters"] / table["n_parameters"].iloc[0])
    for name in [name for name in table.columns if name.endswith("_bins")]:
        table[f"{name}_change"] = table[name] / table[name].iloc[0] - 1
    return table
