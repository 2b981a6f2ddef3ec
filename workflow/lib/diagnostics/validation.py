"""Distributions of the flight beside those of labels and their renders, and one averaged line as a sum of layers."""

import numpy as np
import pandas as pd

from lib.diagnostics.thickness_tests import thickness_tests
from snowsim.phy.waveform import waveform_exact, waveform_peak
from snowsim.statistics.blocks import BLOCK_LINES, thickness_blocks
from snowsim.statistics.paper import is_present
from snowsim.statistics.summaries import FIRST_ROW, stacked
from snowsim.statistics.zones import place_blocks

TEST_COLUMNS = (
    *("of", "zone", "slab", "n", "n_effective", "mean", "deviation"),
    *("distance", "p_value", "p_value_correlated"),
)


def validate(summary, statistics, rendered, labels, zone_edge_bins, *, rng):
    """Tables of the flight beside what was made of its statistics: `thickness`, `tests`, `distributions`.

    `summary` is the flight's; `statistics` and `rendered` are of `estimate`, of the flight and of PHY's renders of the
    labels; `labels` are the tables `layers` and `histograms` of `summarise_labels`, drawn in the zones of
    `zone_edge_bins`.

    `thickness`: histograms by `zone`, `slab` and `low_bins` (bins one range bin wide): lines `n_observed` in the
    flight's whole and broken blocks, `n_synthetic` in the labels; slab -1: mean thickness of slab 0, of blocks and of
    label scenes. `tests`: `thickness_tests`. `distributions`: by `quantity` and bin from `low` to `high`, numbers
    observed and synthetic: `n_layers` below the surface (of blocks: layers picked in half of the lines), `width_bins`
    of averaged lines.
    """
    label_layers, label_histograms = labels
    edges = np.asarray(zone_edge_bins, dtype=float)
    thickness = thickness_blocks(summary, statistics.sizes["layer"])
    return {
        "thickness": _thickness_histograms(thickness, edges, label_histograms),
        "tests": pd.DataFrame(thickness_tests(thickness, edges, rng=rng), columns=list(TEST_COLUMNS)),
        "distributions": pd.concat(
            [_layer_counts(summary, label_layers), _width_counts(statistics, rendered)], ignore_index=True
        ),
    }


def _thickness_histograms(thickness, edges, synthetic):
    """Histograms of thickness by zone and slab beside those of labels."""
    _, level, zone = place_blocks(thickness, edges)
    parts = []
    for z in range(edges.size - 1):
        inside = np.flatnonzero(zone == z)
        parts += [_counts(z, slab, thickness[inside, slab].ravel()) for slab in range(thickness.shape[1])]
        parts.append(_counts(z, -1, level[inside]))
    keys = ["zone", "slab", "low_bins"]
    observed = pd.concat(parts).set_index(keys)["n_observed"]
    table = synthetic.set_index(keys)["n"].rename("n_synthetic").to_frame().join(observed, how="outer")
    return table.fillna(0).astype(int).sort_index().reset_index()[[*keys, "n_observed", "n_synthetic"]]


def _counts(zone, slab, values):
    """How many values lie in each whole bin that holds any; NaN left out."""
    counts = np.bincount(np.floor(values[np.isfinite(values)]).astype(int))
    held = np.flatnonzero(counts)
    return pd.DataFrame({"zone": zone, "slab": slab, "low_bins": held, "n_observed": counts[held]})


def _layer_counts(summary, label_layers):
    """Layers below the surface picked in at least half of the lines of a block, beside those of label scenes."""
    counts = []
    for frame in summary:
        n_blocks = frame.depth_bins.shape[1] // BLOCK_LINES
        picked = np.isfinite(frame.depth_bins[1:, : n_blocks * BLOCK_LINES]).reshape(-1, n_blocks, BLOCK_LINES)
        counts += (2 * picked.sum(axis=2) >= BLOCK_LINES).sum(axis=0).tolist()
    most = max([*counts, int(label_layers["n_layers"].max())])
    synthetic = np.bincount(label_layers["n_layers"], weights=label_layers["n_scenes"], minlength=most + 1)
    return _distribution(
        "n_layers", np.arange(most + 2) - 0.5, np.bincount(counts, minlength=most + 1), synthetic.astype(int)
    )


def _width_counts(statistics, rendered):
    """1/e widths of averaged lines, of the flight and of the renders."""
    # Two bins of the histogram as one: crossings of 1/e gather between rows.
    edges = statistics["width_edge_bins"].values[::2]
    counts = [dataset["width_histogram"].sum("layer").values for dataset in (statistics, rendered)]
    counts = [count.reshape(-1, 2).sum(axis=1) for count in counts]
    return _distribution("width_bins", edges, *counts)


def _distribution(quantity, edges, observed, synthetic):
    """Numbers observed and synthetic of a quantity by bin."""
    columns = {"quantity": quantity, "low": edges[:-1], "high": edges[1:]}
    return pd.DataFrame(columns | {"n_observed": observed, "n_synthetic": synthetic})


def superposition(summary, statistics):
    """One averaged range line with the layers fitted to it (Figs 6 and 7 of the paper): the first with most layers.

    `row` below the surface, `observed`, `model` with its noise, and a column ``layer_<i>`` a layer that was picked.
    Powers are those of this line, by least squares with weights 1 / P^2; shapes are the flight's. Where `paper` gives a
    layer no decay rate, it is that of the layer above.
    """
    present = is_present(stacked(summary, "n_picks"))[:, : statistics.sizes["layer"]]
    group = int(present.sum(axis=1).argmax())
    layers = np.flatnonzero(present[group])
    position = stacked(summary, "position")[group, layers].astype(float).mean(axis=1)
    observed = stacked(summary, "power")[group].astype(float)
    row = np.arange(observed.size) + FIRST_ROW
    kept = np.isfinite(observed) & (row < position[-1] + 40)
    row, observed = row[kept], observed[kept]
    names = ("decay_rate", "variance_bins2", "offset_bins")
    decay, variance, offset = (pd.Series(statistics[name].values).ffill().to_numpy()[layers] for name in names)
    below, height = waveform_peak(variance, decay)
    lag = row - (position + offset - below)[:, None]
    columns = waveform_exact(lag, variance[:, None], decay[:, None]) / height[:, None]
    noise = float(statistics["noise_power"])
    weight = 1 / np.maximum(pd.Series(observed).rolling(9, center=True, min_periods=1).mean().to_numpy(), noise)
    power = np.linalg.lstsq((columns * weight).T, (observed - noise) * weight, rcond=None)[0]
    alone = {f"layer_{layer}": line for layer, line in zip(layers, power[:, None] * columns, strict=True)}
    return pd.DataFrame({"row": row, "observed": observed, "model": power @ columns + noise} | alone)
