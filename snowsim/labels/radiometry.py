"""Radiometry of one scene: powers that vary along track, noise, decay, unlabelled echoes, and layers to label."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from snowsim.echogram import ROWS_BELOW_LAST_LAYER
from snowsim.phy.parameters import row_waveforms
from snowsim.phy.power import mean_power

NEPERS = np.log(10) / 10  # per dB
WINDOW_LINES = (
    80  # over which the rise of a layer is averaged: four averaged lines, as for the deepest picks
)
STEPS_BETWEEN = 10  # samples from a layer above to a layer, where the valley is sought
TOLERANCE_DB = 0.05  # of the mean power that contrast is read off


SPREADS = (
    *(
        "noise_spread_db",
        "surface_to_noise_spread_db",
        "common_spread_db",
        "layer_spread_db",
        "decay_spread",
    ),
    *("background_spread_db", "further_spacing_bins", "further_rise_db", "end_contrast_db"),
)
FADING = ("fading_spread_db", "fading_length_lines", "fading_exponent")
# What a label model needs of the flight's statistics beside thickness.
NEEDED = (
    *SPREADS,
    *FADING,
    "background_power",
    "noise_power",
    "peak_power",
    "variance_bins2",
    "decay_rate",
)


@dataclass(frozen=True)
class RadiometryModel:
    """What `add_radiometry` draws from, of `snowsim.statistics`; see there for the names."""

    peak_power: np.ndarray  # (layer,)
    variance_bins2: np.ndarray
    decay_rate: np.ndarray
    noise_power: float
    fading: np.ndarray  # (surface or buried; spread [dB], length [lines], exponent)
    background_power: np.ndarray  # (fall,)
    fall: np.ndarray  # [bins]
    spread: dict  # by name, see `SPREADS`
    missing: str  # names of quantities for which the flight was too short


def radiometry_model(statistics):
    """`RadiometryModel` of flight statistics; ValueError that names what they lack."""
    spread = {name: values_of(statistics, name, ()).item() for name in SPREADS}
    fading = np.array([values_of(statistics, name, ("interface",)) for name in FADING]).T
    peak_power, variance, decay = (
        _without_gaps(statistics, name) for name in ("peak_power", "variance_bins2", "decay_rate")
    )
    return RadiometryModel(
        *(peak_power, variance, decay, values_of(statistics, "noise_power", ()).item(), fading),
        background_power=values_of(statistics, "background_power", ("fall",)),
        fall=values_of(statistics, "fall", ("fall",)),
        spread=spread,
        missing=statistics.attrs.get("radiometry_missing", ""),
    )


def _without_gaps(statistics, name):
    """Values by layer; the last of `paper` has no decay rate and takes the one above."""
    values = statistics[name].values.astype(float)
    held = np.flatnonzero(np.isfinite(values) & (values > 0))
    if held.size == 0 or held[0] != 0:
        msg = f"flight statistics: {name} must be positive and finite at layer 0, got {values[:1]}"
        raise ValueError(msg)
    return values[held[np.searchsorted(held, np.arange(values.size), side="right") - 1]]


def add_radiometry(scene, model, *, rng):
    """The scene with `peak_power`, every layer drawn in `complete_layer_bins`, and labels only where they show.

    Power varies in dB about the flight's mean, which each layer keeps: surface and noise; buried
    layers together; each layer; and its fading along track, a Gaussian process of autocorrelation
    ``exp(-(h / l)^p)`` about its mean. Unpicked snow is a background, one row just below the
    surface for each of its e-folding depths, and echoes at random distances below the last label,
    which rise out of it as in the flight. Layers are labelled down to the deepest that shows, see
    `_labelled`; weaker ones between are labelled too, as a reader who follows the years would.
    `notes` hold `noise_power`, `decay_factor`, `waveform_row` (the layer of the statistics a row
    takes its waveform from, or -1 - k for e-folding depth k of the background), and counts.
    """
    spread, n_layers, n_lines = model.spread, *scene.layer_bins.shape
    level = np.minimum(np.arange(n_layers), model.peak_power.size - 1)
    noise_db = spread["noise_spread_db"]
    surface_db = np.sqrt(max(spread["surface_to_noise_spread_db"] ** 2 - noise_db**2, 0.0))
    common_db = spread["common_spread_db"] * rng.standard_normal()
    block_db = common_db + spread["layer_spread_db"] * rng.standard_normal((n_layers, 1))
    block_db[0] = surface_db * rng.standard_normal()
    variance = np.full(
        (n_layers, 1), spread["common_spread_db"] ** 2 + spread["layer_spread_db"] ** 2
    )
    variance[0] = surface_db**2
    faded, fading_variance = _faded(model, n_layers, n_lines, rng=rng)
    labelled = model.peak_power[level, None] * _about_mean(
        block_db + faded, variance + fading_variance
    )
    noise_power = model.noise_power * _about_mean(noise_db * rng.standard_normal(), noise_db**2)
    decay_factor = float(np.exp(spread["decay_spread"] * rng.standard_normal()))

    background_db = spread["background_spread_db"]
    strength = _about_mean(background_db * rng.standard_normal(), background_db**2)
    falls = np.flatnonzero(model.background_power > 0)
    below = _distances(spread["further_spacing_bins"], rng=rng)
    further = scene.layer_bins[-1] + below[:, None]
    depth = below + (scene.layer_bins[-1] - scene.layer_bins[0]).mean()
    behind = strength * (model.background_power * np.exp(-depth[:, None] / model.fall)).sum(axis=1)
    rise = 10 ** (spread["further_rise_db"] / 10) - 1
    faded, fading_variance = _faded(model, below.size + 1, n_lines, rng=rng)
    echoes = rise * (behind + noise_power)[:, None] * _about_mean(faded, fading_variance)[1:]
    just_below = scene.layer_bins[:1] + (1 + np.arange(falls.size)[:, None]) / (falls.size + 1)

    rows = np.concatenate([scene.layer_bins[:1], just_below, scene.layer_bins[1:], further])
    power = [
        labelled[:1],
        np.tile(strength * model.background_power[falls, None], n_lines),
        labelled[1:],
        echoes,
    ]
    waveform_row = np.concatenate(
        [[0], -1 - falls, level[1:], np.full(below.size, level[-1] if n_layers > 1 else 0)]
    )
    dressed = dataclasses.replace(
        scene,
        complete_layer_bins=rows,
        peak_power=np.concatenate(power),
        notes=scene.notes
        | {
            "noise_power": float(noise_power),
            "decay_factor": decay_factor,
            "waveform_row": [int(row) for row in waveform_row],
            "background_falls": [float(fall) for fall in model.fall],
            "radiometry_missing": model.missing,
        },
    )
    layer_bins, rise_db = _labelled(dressed, model)
    notes = {
        "n_pixels_unlabelled": int(np.isnan(layer_bins).sum()),
        "median_rise_db": float(np.median(rise_db)),
    }
    return dataclasses.replace(dressed, layer_bins=layer_bins, notes=dressed.notes | notes)


def labelled_or_not(scene):
    """All layers of a drawn scene, labelled or not, (layer, range_line), without background."""
    if scene.peak_power is None:
        return scene.layer_bins
    n_background = sum(row < 0 for row in scene.notes["waveform_row"])
    return np.delete(scene.complete_layer_bins, 1 + np.arange(n_background), axis=0)[
        : len(scene.layer_bins)
    ]


def _about_mean(deviation_db, variance_db2):
    """Factors of power with mean 1 for Gaussian deviations in dB of that variance."""
    return np.exp(NEPERS * deviation_db - NEPERS**2 * variance_db2 / 2)


def _distances(spacing, *, rng):
    """Distances below the last label of echoes `spacing` bins apart on average, down to the end of the image."""
    distances = np.cumsum(
        1 + rng.exponential(max(spacing - 1, 0.1), int(4 * ROWS_BELOW_LAST_LAYER / spacing) + 8)
    )
    return distances[distances < ROWS_BELOW_LAST_LAYER]


def _faded(model, n_layers, n_lines, *, rng):
    """Fading [dB] of the surface and the layers below it, (layer, range_line), about their means, and its variance."""
    n_long = 2 * max(n_lines, int(4 * model.fading[:, 1].max()))
    lag = np.minimum(np.arange(n_long), n_long - np.arange(n_long))
    shapes = [np.exp(-((lag / length) ** exponent)) for _, length, exponent in model.fading]
    # The kernel is wrapped around a long circle: negative parts of its spectrum are negligible.
    density = np.maximum(np.fft.fft(shapes).real, 0)
    kind = np.minimum(np.arange(n_layers), 1)
    white = np.fft.fft(rng.standard_normal((n_layers, n_long)))
    series = (
        np.fft.ifft(white * np.sqrt(density[kind])).real[:, :n_lines] * model.fading[kind, 0, None]
    )
    lines = np.arange(n_lines)
    pairs = np.where(lines > 0, 2, 1) * (n_lines - lines) / n_lines**2
    kept = np.array([1 - (pairs * shape[:n_lines]).sum() for shape in shapes])
    return series - series.mean(axis=1, keepdims=True), (model.fading[kind, 0] ** 2 * kept[kind])[
        :, None
    ]


def _labelled(scene, model):
    """Layers, NaN below the deepest that shows, and the rise of the buried ones [dB], (layer, range_line).

    A layer shows if in half or more of its lines its mean power, averaged along it over
    `WINDOW_LINES`, rises over the minimum between it and the layer above by `end_contrast_db`.
    """
    noise_power = scene.notes["noise_power"]
    shapes = row_waveforms(scene.notes, model.variance_bins2, model.decay_rate)
    power = mean_power(
        *(scene.complete_layer_bins, scene.peak_power, *shapes, scene.n_range_bins),
        tolerance_db=TOLERANCE_DB,
        noise_power=noise_power,
    )
    power += noise_power
    layer_bins = scene.layer_bins.copy()
    n_lines = layer_bins.shape[1]
    step = np.arange(1, STEPS_BETWEEN + 1) / STEPS_BETWEEN
    rows = (
        layer_bins[:-1, None] + step[:, None] * np.diff(layer_bins, axis=0)[:, None]
    )  # (slab, step, line)
    whole = np.clip(np.floor(rows).astype(int), 0, scene.n_range_bins - 2)
    share = rows - whole
    lines = np.arange(n_lines)
    sampled = (1 - share) * power[whole, lines] + share * power[whole + 1, lines]
    edges = np.linspace(0, n_lines, max(n_lines // WINDOW_LINES, 1) + 1).astype(int)
    profile = np.add.reduceat(sampled, edges[:-1], axis=2) / np.diff(edges)
    rise = 10 * np.log10(profile[:, -1] / profile.min(axis=1))
    centres = (edges[:-1] + edges[1:] - 1) / 2
    rise = np.array([np.interp(lines, centres, row) for row in rise]).reshape(-1, n_lines)
    shows = np.flatnonzero(2 * (rise >= model.spread["end_contrast_db"]).sum(axis=1) >= n_lines)
    layer_bins[2 + shows[-1] if shows.size else 1 :] = np.nan
    return layer_bins, rise if rise.size else np.zeros((1, n_lines))


def values_of(statistics, name, dims):
    """A variable or coordinate of the statistics as float array on `dims`, finite."""
    if name not in statistics:
        msg = f"flight statistics need {name}, hold {', '.join(map(str, statistics.variables))}"
        raise ValueError(msg)
    values = statistics[name].transpose(*dims).values.astype(float)
    if values.size == 0 or not np.isfinite(values).all():
        msg = f"flight statistics: {name} must be finite and not empty, got shape {values.shape} with NaN or infinity"
        raise ValueError(msg)
    return values
