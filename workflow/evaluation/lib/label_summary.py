"""Synthetic labels beside their flight: counts, moments, spectra, correlation, structure."""

from itertools import pairwise

import numpy as np
import pandas as pd

from snowsim.statistics.blocks import BLOCK_LINES, fourier, thickness_blocks
from snowsim.statistics.zones import place_blocks

LAGS = (1, 2, 4, 8, 16, 32, 64, 128, 255)  # of structure functions [range lines]
STRUCTURE = ["zone", "of", "lag", "observed", "observed_standard_error", "synthetic", "ratio"]


def summarise_labels(scenes, statistics, summary=()):
    """Tables of labels beside the flight, by name.

    `layers`, `moments`, `rule`, `spectra`, `correlation`, `structure`, `histograms`. `scenes` of
    `draw_scene` are read once; there must be one with a layer, and all as wide as a block of the
    statistics. `structure` holds them against the blocks of the flight's own merged `summary`,
    whatever was estimated from them.
    """
    sums = _Sums(statistics)
    for scene in scenes:
        sums.add(scene)
    if not sums.rules:
        got = f"got none of {len(sums.counts)}"
        msg = f"a summary of labels needs at least one scene with a layer, {got}"
        raise ValueError(msg)
    counts = pd.Series(sums.counts, name="n_layers").value_counts().sort_index()
    histograms = pd.concat(sums.histograms).groupby(["zone", "slab", "low_bins"]).sum()
    return {
        "layers": counts.reset_index(name="n_scenes"),
        "moments": _moment_table(sums.moments, sums.spectra, statistics),
        "rule": _rule_table(pd.DataFrame(sums.rules)),
        "spectra": _spectrum_table(sums.moments[0], sums.spectra, statistics),
        "correlation": _correlation_table(sums.pairs, statistics),
        "structure": _structure_table(sums.structure, statistics, summary),
        "histograms": histograms.reset_index(),
    }


def _drawn_layers(scene):
    """All layers of a drawn scene, labelled or not."""
    if scene.complete_layer_bins is None:
        return scene.layer_bins
    return scene.complete_layer_bins[: len(scene.layer_bins)]


class _Sums:
    """Sums over scenes by zone and slab."""

    def __init__(self, statistics):
        self.statistics = statistics
        by_zone = (statistics.sizes["zone"], statistics.sizes["slab"])
        self.n_zones, self.n_slabs = by_zone
        n_wavenumbers = statistics.sizes["wavenumber"]
        self.n_lines = 2 * (n_wavenumbers - 1)
        band_edges = statistics["band_edge_wavenumber"].values
        self.band_edges = np.rint(band_edges * self.n_lines).astype(int)
        self.spectra = np.zeros((*by_zone, n_wavenumbers))
        # Number, sum and sum of squares of relative thickness.
        self.moments = np.zeros((3, *by_zone))
        # Products, squares above and below; bands, then relative means.
        self.pairs = np.zeros((3, band_edges.size, self.n_slabs))
        # Sum and number of mean square differences.
        n_lags = len(LAGS) + 1
        self.structure = {
            "slab": np.zeros((2, *by_zone, n_lags)),
            "layer": np.zeros((2, self.n_zones, self.n_slabs + 1, n_lags)),
        }
        self.counts = []
        self.rules = []
        self.histograms = []

    def add(self, scene):
        """Add a scene; only its number of layers if there is no slab."""
        if scene.n_range_lines != self.n_lines:
            expected = f"expected {self.n_lines} range lines as in a block"
            msg = f"scene {scene.name}: {expected}, got {scene.n_range_lines}"
            raise ValueError(msg)
        self.counts.append(scene.notes["n_layers"])
        layers = _drawn_layers(scene)[: self.n_slabs + 1]
        thickness = np.diff(layers, axis=0)
        if len(thickness) == 0:
            return
        self.rules.append({"zone": scene.zone} | scene.notes)
        self.histograms.append(_histogram(thickness, scene.zone))
        for of, series in {"slab": thickness, "layer": layers}.items():
            total, number = self.structure[of][:, scene.zone, : len(series)]
            total += mean_square_differences(series)
            number += 1
        self._add_means(thickness.mean(axis=1), scene.zone)
        self._add_spectra(thickness, scene.zone)

    def _add_means(self, mean, zone):
        """Add mean thickness (slab,), relative to that of slab 0."""
        relative = mean / mean[0]
        here = zone, slice(mean.size)
        self.moments[:, *here] += [np.ones(mean.size), relative, relative**2]
        expected = self.statistics["relative_thickness_mean"].values[here]
        variance = self.statistics["relative_thickness_variance"].values[here]
        anomaly = (relative - expected) / _root_or_inf(variance)
        _add_pairs(self.pairs[:, -1], anomaly[1:, None])

    def _add_spectra(self, thickness, zone):
        """Add spectra of thickness (slab, range_line), and products of them between slabs."""
        here = zone, slice(len(thickness))
        spectrum = fourier(thickness, "thickness_trend_variance_bins2" in self.statistics)
        density = np.abs(spectrum) ** 2
        density[:, 0] = 0
        density[:, -1] /= 2
        self.spectra[here] += density
        white = spectrum / _root_or_inf(self.statistics["thickness_psd"].values[here])
        for band, (low, high) in enumerate(pairwise(self.band_edges)):
            _add_pairs(self.pairs[:, band], white[:, low:high])


def _root_or_inf(variance):
    """Root of a variance, infinity where there is none: what is divided by it becomes zero."""
    return np.sqrt(np.where(variance > 0, variance, np.inf))


def mean_square_differences(series):
    """Mean squares of differences at `LAGS` and of second differences of series (..., range_line).

    (..., lag and one), NaN where no two, or three, lines are known.
    """
    differences = [series[..., lag:] - series[..., :-lag] for lag in LAGS]
    differences.append(np.diff(series, 2))
    means = []
    for values in differences:
        n = np.isfinite(values).sum(axis=-1)
        total = np.nansum(values**2, axis=-1)
        means.append(np.where(n > 0, total / np.maximum(n, 1), np.nan))
    return np.stack(means, axis=-1)


def _structure_table(synthetic, statistics, summary):
    """Structure functions [bins^2] by zone, of slabs and of layers, of flight and label sets.

    Lag 0 stands for the rms second difference [bins].
    """
    parts = []
    if summary:
        n_layers = statistics.sizes["slab"] + 1
        layers = np.concatenate([_blocks_of(frame, n_layers) for frame in summary])
        thickness = thickness_blocks(summary, n_layers)
        _, _, zones = place_blocks(thickness, statistics["zone_edge_bins"].values)
        for of, series in {"slab": thickness, "layer": layers}.items():
            squares = mean_square_differences(series)
            for zone in range(statistics.sizes["zone"]):
                total, n = synthetic[of][:, zone]
                found = _structure_functions(squares[zones == zone], total, n)
                if found is not None:
                    parts.append(found.assign(zone=zone, of=of))
    return (
        pd.concat(parts, ignore_index=True)[STRUCTURE] if parts else pd.DataFrame(columns=STRUCTURE)
    )


def _structure_functions(observed, total, n):
    """Structure functions of blocks (block, slab, lag) and scenes, sum and number (slab, lag).

    Means over slabs, weighted on both sides as the flight has them; standard errors from its
    blocks. None where a lag is missing.
    """
    held = np.isfinite(observed) & (n > 0)
    weight = held.sum(axis=0)
    if not weight.any(axis=0).all():
        return None
    per_lag = weight.sum(axis=0)
    mean = np.where(held, observed, 0).sum(axis=(0, 1)) / per_lag
    drawn = (total / np.maximum(n, 1) * weight).sum(axis=0) / per_lag
    # Ratio estimator: residual sums of blocks are the independent terms.
    residual = np.where(held, observed - mean, 0).sum(axis=1)
    error = np.sqrt((residual**2).sum(axis=0)) / per_lag
    rms = np.sqrt(mean[-1])
    error[-1] = error[-1] / 2 / rms
    mean[-1] = rms
    drawn[-1] = np.sqrt(drawn[-1])
    table = pd.DataFrame({"lag": [*LAGS, 0], "observed": mean, "observed_standard_error": error})
    return table.assign(synthetic=drawn, ratio=drawn / mean)


def _blocks_of(frame, n_layers):
    """Rows of a frame's layers in its whole blocks, (block, layer, range_line), NaN in gaps."""
    n_blocks = frame.surface_bins.size // BLOCK_LINES
    n_lines = n_blocks * BLOCK_LINES
    rows = np.full((n_layers, n_lines), np.nan)
    held = frame.depth_bins[:n_layers, :n_lines]
    rows[: len(held)] = held + frame.surface_bins[:n_lines]
    return rows.reshape(n_layers, n_blocks, BLOCK_LINES).swapaxes(0, 1)


def _histogram(thickness, zone):
    """Lines of one scene by slab and whole bins of thickness, and its mean of slab 0 as slab -1."""
    whole = np.floor(thickness).astype(int)
    width = whole.max() + 1
    counts = np.bincount((whole + width * np.arange(len(whole))[:, None]).ravel())
    held = np.flatnonzero(counts)
    slab = np.append(held // width, -1)
    low_bins = np.append(held % width, int(thickness[0].mean()))
    n = np.append(counts[held], 1)
    return pd.DataFrame({"zone": zone, "slab": slab, "low_bins": low_bins, "n": n})


def _add_pairs(totals, values):
    """Add products of rows of (row, sample) `separation` apart, and the squares of either.

    To (3, separation).
    """
    square = (np.abs(values) ** 2).sum(axis=1)
    for separation in range(len(values)):
        n = len(values) - separation
        products = values[:n] * values[separation:].conj()
        totals[0, separation] += products.real.sum()
        totals[1, separation] += square[:n].sum()
        totals[2, separation] += square[separation:].sum()


def _moment_table(moments, spectra, statistics):
    """Moments of thickness relative to slab 0, and its variance, the integral of the spectrum."""
    here = zone, slab = np.nonzero(moments[0] > 1)
    n, total, square = moments[:, zone, slab]
    mean = total / n
    variance = (square - n * mean**2) / (n - 1)
    psd = statistics["thickness_psd"].values[here]
    n_lines = 2 * (psd.shape[1] - 1)
    return pd.DataFrame(
        {
            "zone": zone,
            "slab": slab,
            "n_scenes": n.astype(int),
            "relative_mean_observed": statistics["relative_thickness_mean"].values[here],
            "relative_mean_synthetic": mean,
            "relative_variance_observed": statistics["relative_thickness_variance"].values[here],
            # Of slab 0 it is zero but for rounding.
            "relative_variance_synthetic": np.maximum(variance, 0.0),
            "variance_observed": psd.sum(axis=1) / n_lines,
            "variance_synthetic": spectra[here].sum(axis=1) / n / n_lines,
        }
    )


def _rule_table(rules):
    """What the rule for thin slabs touched, by zone; thickness drawn and kept, mean of scenes."""
    by_zone = rules.groupby("zone")
    n_scenes = by_zone.size().rename("n_scenes")
    sums = by_zone[["n_samples", "n_touched", "n_means_touched", "n_slabs_beyond"]].sum()
    kinds = ["mean_drawn", "mean_kept", "variance_drawn", "variance_kept"]
    means = by_zone[[f"thickness_{kind}" for kind in kinds]].mean()
    return pd.concat([n_scenes, sums, means], axis=1).reset_index()


def _spectrum_table(number, spectra, statistics):
    """Spectra of thickness [bins^2 per cycle per line]."""
    zone, slab = np.nonzero(number)
    wavenumber = statistics["wavenumber"].values[1:]
    observed = statistics["thickness_psd"].values[zone, slab, 1:]
    synthetic = spectra[zone, slab, 1:] / number[zone, slab, None]
    return pd.DataFrame(
        {
            "zone": np.repeat(zone, wavenumber.size),
            "slab": np.repeat(slab, wavenumber.size),
            "wavenumber": np.tile(wavenumber, zone.size),
            "observed": observed.ravel(),
            "synthetic": synthetic.ravel(),
        }
    )


def _correlation_table(pairs, statistics):
    """Correlation of slabs by separation and band of wavenumber; band -1: of relative means."""
    by_band = dict(enumerate(statistics["thickness_correlation"].values))
    by_band[-1] = statistics["relative_thickness_correlation"].values
    rows = []
    for band, observed in by_band.items():
        for separation, (product, above, below) in enumerate(pairs[:, band].T):
            if above > 0 and below > 0:
                row = {"band": band, "separation": separation, "observed": observed[separation]}
                rows.append(row | {"synthetic": product / np.sqrt(above * below)})
    return pd.DataFrame(rows)
