"""Synthetic labels beside the flight they were drawn from: counts, moments, spectra, correlation, structure."""

import numpy as np
import pandas as pd

from snowsim.statistics.blocks import BLOCK_LINES, fourier, thickness_blocks
from snowsim.statistics.zones import place_blocks

LAGS = (1, 2, 4, 8, 16, 32, 64, 128, 255)  # of structure functions [range lines]


def summarise_labels(scenes, statistics, summary=()):
    """Tables of labels beside the flight, by name: `layers`, `moments`, `rule`, `spectra`, `correlation`, `histograms`.

    `scenes` of `draw_scene` are read once; there must be one, and all as wide as a block of the
    statistics. `structure` holds them against the blocks of the flight's own merged `summary`,
    whatever was estimated from them.
    """
    n_zones, n_slabs, n_wavenumbers = (
        statistics.sizes[dim] for dim in ("zone", "slab", "wavenumber")
    )
    n_lines = 2 * (n_wavenumbers - 1)
    spectra = np.zeros((n_zones, n_slabs, n_wavenumbers))
    moments = np.zeros(
        (3, n_zones, n_slabs)
    )  # number, sum and sum of squares of relative thickness
    edges = np.rint(statistics["band_edge_wavenumber"].values * n_lines).astype(int)
    pairs = np.zeros(
        (3, edges.size, n_slabs)
    )  # products, squares above and below; bands, then relative means
    tapered = "thickness_trend_variance_bins2" in statistics
    counts, rules, histograms = [], [], []
    structure = {
        of: np.zeros((2, n_zones, n_slabs + (of == "layer"), len(LAGS) + 1))
        for of in ("slab", "layer")
    }
    for scene in scenes:
        if scene.n_range_lines != n_lines:
            msg = f"scene {scene.name}: expected {n_lines} range lines as in a block, got {scene.n_range_lines}"
            raise ValueError(msg)
        counts.append(scene.notes["n_layers"])
        layers = _drawn_layers(scene)[: n_slabs + 1]
        thickness = np.diff(layers, axis=0)
        held, zone = len(thickness), scene.zone
        if held == 0:
            continue
        mean = thickness.mean(axis=1)
        for of, rows in (("slab", thickness), ("layer", layers)):
            structure[of][0, zone, : len(rows)] += mean_square_differences(rows)
            structure[of][1, zone, : len(rows)] += 1
        spectrum = fourier(thickness, tapered)
        density = np.abs(spectrum) ** 2
        density[:, 0], density[:, -1] = 0, density[:, -1] / 2
        spectra[zone, :held] += density
        relative = mean / mean[0]
        moments[:, zone, :held] += np.array([np.ones(held), relative, relative**2])
        target = statistics["thickness_psd"].values[zone, :held]
        white = spectrum / np.sqrt(np.where(target > 0, target, np.inf))
        for band, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
            _add_pairs(pairs[:, band], white[:, low:high])
        expected, variance = (
            statistics[f"relative_thickness_{kind}"].values[zone, :held]
            for kind in ("mean", "variance")
        )
        anomaly = (relative - expected) / np.sqrt(np.where(variance > 0, variance, np.inf))
        _add_pairs(pairs[:, -1], anomaly[1:, None])
        histograms.append(_histogram(thickness, zone))
        rules.append(
            {"zone": zone} | {key: value for key, value in scene.notes.items() if key != "n_layers"}
        )
    if not rules:
        msg = (
            f"a summary of labels needs at least one scene with a layer, got none of {len(counts)}"
        )
        raise ValueError(msg)
    return {
        "layers": pd.Series(counts)
        .value_counts()
        .sort_index()
        .rename_axis("n_layers")
        .reset_index(name="n_scenes"),
        "moments": _moment_table(moments, spectra, statistics),
        "rule": _rule_table(pd.DataFrame(rules)),
        "spectra": _spectrum_table(moments[0], spectra, statistics),
        "correlation": _correlation_table(pairs, statistics),
        "structure": _structure_table(structure, statistics, summary),
        "histograms": pd.concat(histograms)
        .groupby(["zone", "slab", "low_bins"])
        .sum()
        .reset_index(),
    }


def _drawn_layers(scene):
    """All layers of a drawn scene, labelled or not."""
    if scene.complete_layer_bins is None:
        return scene.layer_bins
    return scene.complete_layer_bins[: len(scene.layer_bins)]


def mean_square_differences(series):
    """Mean squares of differences at `LAGS` and of second differences of series (..., range_line), (..., lag and one).

    NaN where no two, or three, lines are known.
    """
    differences = [series[..., lag:] - series[..., :-lag] for lag in LAGS] + [np.diff(series, 2)]
    n = [np.isfinite(values).sum(axis=-1) for values in differences]
    total = [np.nansum(values**2, axis=-1) for values in differences]
    return np.stack(
        [np.where(k > 0, t / np.maximum(k, 1), np.nan) for t, k in zip(total, n, strict=True)],
        axis=-1,
    )


def _structure_table(synthetic, statistics, summary):
    """Structure functions [bins^2] by zone, of slabs and of layers, of the flight's own blocks and of label sets.

    Lag 0 stands for the rms second difference [bins]. Means over slabs, weighted on both sides as
    the flight has them; standard errors from its blocks.
    """
    columns = ["zone", "of", "lag", "observed", "observed_standard_error", "synthetic", "ratio"]
    if not summary:
        return pd.DataFrame(columns=columns)
    n_layers = statistics.sizes["slab"] + 1
    rows = [_rows_of(frame, n_layers) for frame in summary]
    rows = np.concatenate([part.reshape(n_layers, -1, BLOCK_LINES).swapaxes(0, 1) for part in rows])
    thickness = thickness_blocks(summary, n_layers)
    zones = place_blocks(thickness, statistics["zone_edge_bins"].values)[2]
    parts = []
    for of, series in (("slab", thickness), ("layer", rows)):
        squares = mean_square_differences(series)
        for zone in range(synthetic[of].shape[1]):
            observed, (total, n) = squares[zones == zone], synthetic[of][:, zone]
            held = np.isfinite(observed) & (n > 0)
            weight = held.sum(axis=0)
            if not weight.any(axis=0).all():
                continue
            per_lag = weight.sum(axis=0)
            mean = np.where(held, observed, 0).sum(axis=(0, 1)) / per_lag
            drawn = (total / np.maximum(n, 1) * weight).sum(axis=0) / per_lag
            # Ratio estimator: residual sums of blocks are the independent terms.
            residual = np.where(held, observed - mean, 0).sum(axis=1)
            error = np.sqrt((residual**2).sum(axis=0)) / per_lag
            mean[-1], drawn[-1], error[-1] = (
                np.sqrt(mean[-1]),
                np.sqrt(drawn[-1]),
                error[-1] / 2 / np.sqrt(mean[-1]),
            )
            values = dict(zip(columns[3:], (mean, error, drawn, drawn / mean), strict=True))
            parts.append(pd.DataFrame({"zone": zone, "of": of, "lag": [*LAGS, 0]} | values))
    return pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=columns)


def _rows_of(frame, n_layers):
    """Rows of a frame's layers in its whole blocks, (layer, range_line), NaN in gaps."""
    n_lines = frame.surface_bins.size // BLOCK_LINES * BLOCK_LINES
    rows = np.full((n_layers, n_lines), np.nan)
    held = frame.depth_bins[:n_layers, :n_lines]
    rows[: len(held)] = held + frame.surface_bins[:n_lines]
    return rows


def _histogram(thickness, zone):
    """Lines of one scene by slab and whole bins of thickness, and its mean of slab 0 as slab -1."""
    whole = np.floor(thickness).astype(int)
    width = whole.max() + 1
    counts = np.bincount((whole + width * np.arange(len(whole))[:, None]).ravel())
    held = np.flatnonzero(counts)
    slab, low_bins = np.append(held // width, -1), np.append(held % width, int(thickness[0].mean()))
    return pd.DataFrame(
        {"zone": zone, "slab": slab, "low_bins": low_bins, "n": np.append(counts[held], 1)}
    )


def _add_pairs(totals, values):
    """Add products of rows of (row, sample) `separation` apart, and the squares of either, to (3, separation)."""
    square = (np.abs(values) ** 2).sum(axis=1)
    for separation in range(len(values)):
        upper, lower = values[: len(values) - separation], values[separation:]
        totals[0, separation] += (upper * lower.conj()).real.sum()
        totals[1:, separation] += (
            square[: len(values) - separation].sum(),
            square[separation:].sum(),
        )


def _moment_table(moments, spectra, statistics):
    """Moments of thickness relative to slab 0, and its variance about the mean, the integral of the spectrum."""
    zone, slab = np.nonzero(moments[0] > 1)
    n, total, square = moments[:, zone, slab]
    mean = total / n
    psd = statistics["thickness_psd"].values[zone, slab]
    n_lines = 2 * (psd.shape[1] - 1)
    observed = {
        kind: statistics[f"relative_thickness_{kind}"].values[zone, slab]
        for kind in ("mean", "variance")
    }
    columns = {"zone": zone, "slab": slab, "n_scenes": n.astype(int)}
    columns |= {"relative_mean_observed": observed["mean"], "relative_mean_synthetic": mean}
    columns["relative_variance_observed"] = observed["variance"]
    # Of slab 0 it is zero but for rounding.
    columns["relative_variance_synthetic"] = np.maximum((square - n * mean**2) / (n - 1), 0.0)
    columns["variance_observed"] = psd.sum(axis=1) / n_lines
    return pd.DataFrame(
        columns | {"variance_synthetic": spectra[zone, slab].sum(axis=1) / n / n_lines}
    )


def _rule_table(rules):
    """What the rule for thin slabs touched, by zone; thickness drawn and kept, means over scenes of those of each."""
    by_zone = rules.groupby("zone")
    sums = by_zone[["n_samples", "n_touched", "n_means_touched", "n_slabs_beyond"]].sum()
    kinds = [
        f"thickness_{moment}_{when}"
        for moment in ("mean", "variance")
        for when in ("drawn", "kept")
    ]
    return pd.concat(
        [by_zone.size().rename("n_scenes"), sums, by_zone[kinds].mean()], axis=1
    ).reset_index()


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
    observed = [
        *statistics["thickness_correlation"].values,
        statistics["relative_thickness_correlation"].values,
    ]
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
