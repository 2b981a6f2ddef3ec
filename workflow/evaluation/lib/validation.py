"""Distributions of the flight beside laws, labels and renders, and one line as a sum of layers."""

from functools import lru_cache

import numpy as np
import pandas as pd
from scipy.special import betainc, ndtr

from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.blocks import periodogram, thickness_blocks
from snowsim.statistics.paper import is_present
from snowsim.statistics.speckle import compare_with_gamma
from snowsim.statistics.summaries import FIRST_ROW, GROUP_LINES, stacked, stacked_tracked
from snowsim.statistics.zones import MINIMUM_BLOCKS, place_blocks

TEST_COLUMNS = [
    "of",
    "zone",
    "slab",
    "n",
    "n_effective",
    "mean",
    "deviation",
    "distance",
    "p_value",
    "p_value_correlated",
]
# Of the law under the null hypothesis; the seed is its own, the result a constant.
NULL_VALUES = 50
NULL_DRAWS = 20_000
NULL_SEED = 1967
FLIGHT_DRAWS = 199
FEWEST_GROUPS = 20  # of 20 whole lines: they tell looks to 7 %


def validate(summary, statistics, rendered, labels, zone_edge_bins, *, rng):
    """Tables of the flight beside what was made of it: `thickness`, `tests`, `distributions`.

    `rendered` are statistics of PHY's renders of the labels; `labels` the tables `layers` and
    `histograms` of `summarise_labels`, drawn in the zones of `zone_edge_bins`.
    """
    label_layers, label_histograms = labels
    edges = np.asarray(zone_edge_bins, dtype=float)
    thickness = thickness_blocks(summary, statistics.sizes["layer"])
    tests = thickness_tests(thickness, edges, rng=rng)
    distributions = [_layer_counts(statistics, label_layers), _width_counts(statistics, rendered)]
    return {
        "thickness": _thickness_histograms(thickness, edges, label_histograms),
        "tests": pd.DataFrame(tests, columns=TEST_COLUMNS),
        "distributions": pd.concat(distributions, ignore_index=True),
    }


def _thickness_histograms(thickness, edges, synthetic):
    """Numbers of lines by zone, slab and whole bins.

    Slab -1: of blocks and scenes by mean thickness of slab 0.
    """
    _, level, zone_of_block = place_blocks(thickness, edges)
    observed = []
    for zone in range(edges.size - 1):
        inside = zone_of_block == zone
        for slab in range(thickness.shape[1]):
            observed.append(_counts(zone, slab, thickness[inside, slab]))
        observed.append(_counts(zone, -1, level[inside]))
    keys = ["zone", "slab", "low_bins"]
    synthetic = synthetic[[*keys, "n"]].rename(columns={"n": "n_synthetic"})
    table = pd.concat(observed).merge(synthetic, how="outer", on=keys)
    return table.fillna(0).astype(int)


def _counts(zone, slab, values):
    """How many values lie in each whole bin that holds any; NaN left out."""
    counts = np.bincount(np.floor(values[np.isfinite(values)]).astype(int))
    held = np.flatnonzero(counts)
    return pd.DataFrame({"zone": zone, "slab": slab, "low_bins": held, "n_observed": counts[held]})


def _layer_counts(statistics, label_layers):
    """Layers below the surface of blocks, beside those of label scenes."""
    observed = statistics["n_blocks_by_layers"].sum("zone").values
    observed[0] += statistics.attrs["n_blocks_without_layers"]
    synthetic = np.bincount(label_layers["n_layers"], weights=label_layers["n_scenes"])
    n_counts = max(observed.size, synthetic.size)
    edges = np.arange(n_counts + 1) - 0.5
    observed = np.pad(observed, (0, n_counts - observed.size))
    synthetic = np.pad(synthetic.astype(int), (0, n_counts - synthetic.size))
    return _distribution("n_layers", edges, observed, synthetic)


def _width_counts(statistics, rendered):
    """1/e widths of averaged lines, of the flight and of the renders."""
    # Two bins of the histogram as one: crossings of 1/e gather between rows.
    edges = statistics["width_edge_bins"].values[::2]
    counts = []
    for dataset in (statistics, rendered):
        of_all = dataset["width_histogram"].sum("layer").values
        counts.append(of_all.reshape(-1, 2).sum(axis=1))
    return _distribution("width_bins", edges, *counts)


def _distribution(quantity, edges, observed, synthetic):
    """Numbers observed and synthetic of a quantity by bin."""
    columns = {"quantity": quantity, "low": edges[:-1], "high": edges[1:]}
    return pd.DataFrame(columns | {"n_observed": observed, "n_synthetic": synthetic})


def superposition(summary, statistics):
    """One averaged range line with the layers fitted to it (Figs 6 and 7): that with most layers.

    Powers are those of this line, by least squares with weights 1 / P^2; shapes are the flight's,
    and where `paper` gives a layer no decay rate, that of the layer above.
    """
    present = is_present(stacked(summary, "n_picks"))[:, : statistics.sizes["layer"]]
    group = int(present.sum(axis=1).argmax())
    layers = np.flatnonzero(present[group])
    position = stacked(summary, "position")[group, layers].astype(float).mean(axis=1)
    observed = stacked(summary, "power")[group].astype(float)
    row = np.arange(observed.size) + FIRST_ROW
    kept = np.isfinite(observed) & (row < position[-1] + 40)
    row = row[kept]
    observed = pd.Series(observed[kept])

    shapes = statistics[["decay_rate", "variance_bins2", "offset_bins"]].to_dataframe()
    shapes = shapes.ffill().iloc[layers]
    decay = shapes["decay_rate"].to_numpy()
    variance = shapes["variance_bins2"].to_numpy()
    below, height = waveform_peak(variance, decay)
    start = position + shapes["offset_bins"].to_numpy() - below
    waveforms = waveform_exact(row - start[:, None], variance[:, None], decay[:, None])
    waveforms = waveforms / height[:, None]

    noise = float(statistics["noise_power"])
    smooth = observed.rolling(9, center=True, min_periods=1).mean().to_numpy()
    weight = 1 / np.maximum(smooth, noise)
    above_noise = (observed.to_numpy() - noise) * weight
    power, *_ = np.linalg.lstsq((waveforms * weight).T, above_noise, rcond=None)
    table = pd.DataFrame({"row": row, "observed": observed, "model": power @ waveforms + noise})
    for layer, line in zip(layers, power[:, None] * waveforms, strict=True):
        table[f"layer_{layer}"] = line
    return table


def independence(summary, statistics):
    """How far the flight departs from what PHY assumes, by layer: eq. (1) as fitted, and Gamma(M).

    `waveform_rms_db` and `waveform_largest_db` are of the mean waveform about the picks over that
    of the fitted model of all layers. `looks` and their error are those that fit tracked power,
    `gamma_distance` is Kolmogorov's between it and the law of the flight's own looks, on the
    quantiles that are kept; NaN where a layer has too few lines.
    """
    tracked = stacked_tracked(summary)
    ratio = statistics["mean_waveform"] / statistics["model_waveform"]
    residual_db = 10 * np.log10(ratio.transpose("layer", "lag").values)
    n_looks = float(statistics.attrs["n_looks"])
    rows = []
    for layer, of_layer_db in enumerate(residual_db):
        known_db = of_layer_db[np.isfinite(of_layer_db)]
        rms_db = largest_db = looks = error = distance = np.nan
        if known_db.size:
            rms_db = np.sqrt(np.mean(known_db**2))
            largest_db = np.abs(known_db).max()
        n_whole = int(np.isfinite(tracked[:, layer]).all(axis=1).sum())
        if n_whole >= FEWEST_GROUPS:
            fitted = compare_with_gamma(tracked[:, [layer]])
            looks = fitted.n_looks
            error = fitted.standard_error
            share = np.clip(fitted.tracked_quantile / GROUP_LINES, 0, 1)
            law = betainc(n_looks, (GROUP_LINES - 1) * n_looks, share)
            distance = np.abs(law - fitted.probability).max()
        row = {
            "layer": layer,
            "n_groups": n_whole,
            "waveform_rms_db": rms_db,
            "waveform_largest_db": largest_db,
            "looks": looks,
            "looks_standard_error": error,
            "gamma_distance": distance,
        }
        rows.append(row)
    return pd.DataFrame(rows)


def lilliefors(values, n_effective=None):
    """Kolmogorov's distance of values from a Gaussian of their mean and variance, and the p-value.

    Lilliefors (1967), J. Am. Stat. Assoc. 62, 399-402; its law for any (effective) n from that of
    ``D (sqrt n - 0.01 + 0.85 / sqrt n)``, Stephens (1974), J. Am. Stat. Assoc. 69, 730-737, by
    20,000 draws: p-values to 0.003.
    """
    values = np.sort(np.asarray(values, dtype=float))
    if values.size < 4 or values[0] == values[-1]:
        got = f"got {values.size} from {values[0]:g} to {values[-1]:g}"
        msg = f"a test of normality needs 4 values that differ, {got}"
        raise ValueError(msg)
    [distance] = _distance(values[None])
    n = values.size if n_effective is None else float(n_effective)
    null = _null()
    n_larger = null.size - np.searchsorted(null, _modified(distance, n))
    return float(distance), float((n_larger + 1) / (null.size + 1))


def _distance(values):
    """Kolmogorov's distance of sorted rows (row, value) from Gaussians of their moments, (row,)."""
    n = values.shape[1]
    mean = values.mean(axis=1, keepdims=True)
    expected = ndtr((values - mean) / values.std(axis=1, ddof=1, keepdims=True))
    step = np.arange(n + 1) / n
    above = (step[1:] - expected).max(axis=1)
    below = (expected - step[:-1]).max(axis=1)
    return np.maximum(above, below)


def _modified(distance, n):
    return distance * (np.sqrt(n) - 0.01 + 0.85 / np.sqrt(n))


@lru_cache(maxsize=1)
def _null():
    """Sorted draws of the modified distance of Gaussian values."""
    rng = np.random.Generator(np.random.PCG64(NULL_SEED))
    drawn = np.sort(rng.standard_normal((NULL_DRAWS, NULL_VALUES)), axis=1)
    return np.sort(_modified(_distance(drawn), NULL_VALUES))


def thickness_tests(thickness, zone_edge_bins, *, rng):
    """Tests of the two Gaussian laws labels are drawn from, by zone and slab: a dict each.

    `thickness (block, slab, range_line)` [bins] has NaN in gaps; blocks of a frame stand together,
    in order. `p_value` holds if all `n` values were independent, `p_value_correlated` as they are.
    """
    mean, level, zone_of_block = place_blocks(thickness, zone_edge_bins)
    whole = np.isfinite(thickness).all(axis=2)
    rows = []
    for zone, slab in np.ndindex(len(zone_edge_bins) - 1, mean.shape[1]):
        inside = zone_of_block == zone
        known = inside & np.isfinite(mean[:, slab])
        if slab > 0 and known.sum() >= MINIMUM_BLOCKS:
            share = np.where(known, mean[:, slab] / level, np.nan)
            rows += _means_row(share, zone, slab)
        held = inside & whole[:, slab]
        if held.sum() >= MINIMUM_BLOCKS:
            rows += _undulations_row(thickness[held, slab], zone, slab, rng)
    return rows


def _means_row(share, zone, slab):
    """The row of relative block means with NaN between; none where they do not differ."""
    values = share[np.isfinite(share)]
    if values.min() == values.max():
        return []
    # Neighbouring blocks share kilometre undulations.
    n_effective = max(values.size * _independent_share(share), 4.0)
    _, p_value = lilliefors(values, n_effective)
    return [_row("relative block mean", zone, slab, values, n_effective, p_value)]


def _undulations_row(thickness, zone, slab, rng):
    """The row of the lines of whole blocks (block, range_line); none where a block is level.

    Worth ``2 (sum P)^2 / sum P^2`` values a block for the mean periodogram P; p-value by Gaussian
    flights of that P.
    """
    if not (thickness.std(axis=1) > 0).all():
        return []
    n_blocks, n_lines = thickness.shape
    density = periodogram(thickness).mean(axis=0)
    n_effective = n_blocks * 2 * density.sum() ** 2 / (density**2).sum()
    values = _standardised(thickness)
    [distance] = _distance(np.sort(values)[None])
    n_larger = 0
    for _ in range(FLIGHT_DRAWS):
        real, imaginary = rng.standard_normal((2, n_blocks, density.size))
        spectrum = (real + 1j * imaginary) * np.sqrt(density)
        gaussian = _standardised(np.fft.irfft(spectrum, n_lines))
        [of_gaussian] = _distance(np.sort(gaussian)[None])
        n_larger += of_gaussian >= distance
    p_value = (n_larger + 1) / (FLIGHT_DRAWS + 1)
    return [_row("undulation", zone, slab, values, n_effective, p_value)]


def _standardised(thickness):
    """Thickness about the mean of its block over its s.d., all blocks one after the other."""
    anomaly = thickness - thickness.mean(axis=1, keepdims=True)
    return (anomaly / thickness.std(axis=1, keepdims=True)).ravel()


def _row(of, zone, slab, values, n_effective, p_value_correlated):
    distance, p_value = lilliefors(values)
    return {
        "of": of,
        "zone": zone,
        "slab": slab,
        "n": values.size,
        "n_effective": float(n_effective),
        "mean": values.mean(),
        "deviation": values.std(ddof=1),
        "distance": distance,
        "p_value": p_value,
        "p_value_correlated": float(p_value_correlated),
    }


def _independent_share(values):
    """Share of values worth an independent one, ``(1 - r) / (1 + r)``, r their correlation.

    From block to block.
    """
    anomaly = values - np.nanmean(values)
    pairs = anomaly[1:] * anomaly[:-1]
    pairs = pairs[np.isfinite(pairs)]
    if pairs.size < MINIMUM_BLOCKS or not np.nanmax(np.abs(anomaly)) > 0:
        return 1.0
    correlation = np.clip(pairs.mean() / np.nanmean(anomaly**2), 0, 0.95)
    return (1 - correlation) / (1 + correlation)
