"""Synthetic labels beside the flight they were drawn from: counts, moments, spectra, correlation."""

import numpy as np
import pandas as pd

from snowsim.labels.radiometry import labelled_or_not


def summarise_labels(scenes, statistics):
    """Tables of labels beside the flight, by name: `layers`, `moments`, `rule`, `spectra`, `correlation`, `histograms`.

    `scenes` of `draw_scene` are read once; there must be one, and all as wide as a block of the statistics.
    """
    n_zones, n_slabs, n_wavenumbers = (statistics.sizes[dim] for dim in ("zone", "slab", "wavenumber"))
    n_lines = 2 * (n_wavenumbers - 1)
    spectra = np.zeros((n_zones, n_slabs, n_wavenumbers))
    moments = np.zeros((3, n_zones, n_slabs))  # number, sum and sum of squares of relative thickness
    edges = np.rint(statistics["band_edge_wavenumber"].values * n_lines).astype(int)
    pairs = np.zeros((3, edges.size, n_slabs))  # products, squares above and below; bands, then relative means
    counts, rules, histograms = [], [], []
    for scene in scenes:
        if scene.n_range_lines != n_lines:
            msg = f"scene {scene.name}: expected {n_lines} range lines as in a block, got {scene.n_range_lines}"
            raise ValueError(msg)
        thickness = np.diff(labelled_or_not(scene), axis=0)[:n_slabs]
        held, zone = len(thickness), scene.zone
        mean = thickness.mean(axis=1)
        spectrum = np.fft.rfft(thickness - mean[:, None])
        density = 2 * np.abs(spectrum) ** 2 / n_lines
        density[:, -1] /= 2
        spectra[zone, :held] += density
        relative = mean / mean[0]
        moments[:, zone, :held] += np.array([np.ones(held), relative, relative**2])
        target = statistics["thickness_psd"].values[zone, :held]
        white = spectrum / np.sqrt(np.where(target > 0, target, np.inf))
        for band, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
            _add_pairs(pairs[:, band], white[:, low:high])
        expected, variance = (
            statistics[f"relative_thickness_{kind}"].values[zone, :held] for kind in ("mean", "variance")
        )
        anomaly = (relative - expected) / np.sqrt(np.where(variance > 0, variance, np.inf))
        _add_pairs(pairs[:, -1], anomaly[1:, None])
        counts.append(scene.notes["n_layers"])
        histograms.append(_histogram(thickness, zone))
        rules.append({"zone": zone} | {key: value for key, value in scene.notes.items() if key != "n_layers"})
    if not counts:
        msg = "a summary of labels needs at least one scene, got none"
        raise ValueError(msg)
    return {
        "layers": pd.Series(counts).value_counts().sort_index().rename_axis("n_layers").reset_index(name="n_scenes"),
        "moments": _moment_table(moments, spectra, statistics),
        "rule": _rule_table(pd.DataFrame(rules)),
        "spectra": _spectrum_table(moments[0], spectra, statistics),
        "correlation": _correlation_table(pairs, statistics),
        "histograms": pd.concat(histograms).groupby(["zone", "slab", "low_bins"]).sum().reset_index(),
    }


def _histogram(thickness, zone):
    """Lines of one scene by slab and whole bins of thickness, and its mean of slab 0 as slab -1."""
    whole = np.floor(thickness).astype(int)
    width = whole.max() + 1
    counts = np.bincount((whole + width * np.arange(len(whole))[:, None]).ravel())
    held = np.flatnonzero(counts)
    return pd.DataFrame(
        {
            "zone": zone,
            "slab": np.append(held // width, -1),
            "low_bins": np.append(held % width, int(thickness[0].mean())),
            "n": np.append(counts[held], 1),
        }
    )


def _add_pairs(totals, values):
    """Add products of rows of (row, sample) `separation` apart, and the squares of either, to (3, separation)."""
    square = (np.abs(values) ** 2).sum(axis=1)
    for separation in range(len(values)):
        upper, lower = values[: len(values) - separation], values[separation:]
        totals[0, separation] += (upper * lower.conj()).real.sum()
        totals[1:, separation] += square[: len(values) - separation].sum(), square[separation:].sum()


def _moment_table(moments, spectra, statistics):
    """Moments of thickness relative to slab 0, and its variance about the mean, the integral of the spectrum."""
    zone, slab = np.nonzero(moments[0] > 1)
    n, total, square = moments[:, zone, slab]
    mean = total / n
    psd = statistics["thickness_psd"].values[zone, slab]
    n_lines = 2 * (psd.shape[1] - 1)
    return pd.DataFrame(
        {
            "zone": zone,
            "slab": slab,
            "n_scenes": n.astype(int),
            "relative_mean_observed": statistics["relative_thickness_mean"].values[zone, slab],
            "relative_mean_synthetic": mean,
            "relative_variance_observed": statistics["relative_thickness_variance"].values[zone, slab],
            # Of slab 0 it is zero but for rounding.
            "relative_variance_synthetic": np.maximum((square - n * mean**2) / (n - 1), 0.0),
            "variance_observed": psd.sum(axis=1) / n_lines,
            "variance_synthetic": spectra[zone, slab].sum(axis=1) / n / n_lines,
        }
    )


def _rule_table(rules):
    """What the rule for thin slabs touched, by zone; thickness drawn and kept, means over scenes of those of each."""
    by_zone = rules.groupby("zone")
    sums = by_zone[["n_samples", "n_touched", "n_means_touched", "n_slabs_beyond"]].sum()
    kinds = [f"thickness_{moment}_{when}" for moment in ("mean", "variance") for when in ("drawn", "kept")]
    return pd.concat([by_zone.size().rename("n_scenes"), sums, by_zone[kinds].mean()], axis=1).reset_index()


def _spectrum_table(number, spectra, statistics):
    """Spectra of thickness [bins^2 per cycle per line]."""
    zone, slab = np.nonzero(number)
    wavenumber = statistics["wavenumber"].values[1:]
    return pd.DataFrame(
        {
            "zone": np.repeat(zone, wavenumber.size),
            "slab": np.repeat(slab, wavenumber.size),
            "wavenumber": np.tile(wavenumber, zone.size),
            "observed": statistics["thickness_psd"].values[zone, slab, 1:].ravel(),
            "synthetic": (spectra[zone, slab, 1:] / number[zone, slab, None]).ravel(),
        }
    )


def _correlation_table(pairs, statistics):
    """Correlation of slabs by their separation and band of wavenumber; band -1: of relative means."""
    n_bands, n_slabs = pairs.shape[1] - 1, pairs.shape[2]
    observed = [*statistics["thickness_correlation"].values, statistics["relative_thickness_correlation"].values]
    rows = [
        {
            "band": band if band < n_bands else -1,
            "separation": separation,
            "observed": observed[band][separation],
            "synthetic": pairs[0, band, separation] / np.sqrt(pairs[1:, band, separation].prod()),
        }
        for band in range(n_bands + 1)
        for separation in range(n_slabs)
        if (pairs[1:, band, separation] > 0).all()
    ]
    return pd.DataFrame(rows)
