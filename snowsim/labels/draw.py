"""Layers of one scene: number, mean thicknesses and undulations, summed from the surface down."""

import numpy as np

from snowsim.echogram import Scene, scene_height, zone_of
from snowsim.labels.prepare import LabelModel, prepare
from snowsim.labels.process import draw_nonstationary, draw_series
from snowsim.labels.radiometry import add_radiometry
from snowsim.rounding import on_grid, rounded
from snowsim.seeding import generator

MINIMUM_THICKNESS_BINS = 1.0  # two layers never share a pixel
GRID_BITS = 16  # thickness is drawn to 2^-16 of a range bin, 1.5e-5
NOTE_BITS = 20  # binary digits of numbers in notes
N_TRIALS = 20  # scenes that tell whether layers are labelled


def draw(statistics, n_range_lines, *, rng):
    """Layers of one scene.

    Parameters
    ----------
    statistics : xarray.Dataset or LabelModel
        Of `snowsim.statistics.fit`, or of `prepare` when many scenes are drawn.
    n_range_lines : int
    rng : int or numpy.random.Generator
        Seed or generator.

    Returns
    -------
    ndarray, (layer, range_line)
        Range bins, row 0 the surface about bin 50, strictly increasing with depth.

    Raises
    ------
    ValueError
        If statistics are missing or not finite, or a `LabelModel` was prepared for another width.

    Notes
    -----
    Yari et al. (2021), section V-B: mean thickness of slab 0, which fixes the zone; mean of deeper
    slabs = slab 0 x a factor from the zone's Gaussian; thickness = mean + Gaussian process of that
    slab's spectrum in that zone. The paper draws slab 0 ~ U(range seen) and the number of layers ~
    U{5..40}, below a flat surface; here all three are as in the flight, see `prepare`, and so is
    the trend within a block if its variance is known. Slabs deeper than the flight shows take
    values of its last. Thickness below `MINIMUM_THICKNESS_BINS`, and a mean below it, is mirrored
    there.

    Examples
    --------
    From two frames of the synthetic reference flight:

    >>> from snowsim.reference import checked_settings, draw_climate, draw_frame
    >>> settings = checked_settings({"radar": {"n_range_bins": 300}})
    >>> climate = draw_climate(settings, rng=np.random.default_rng(1))
    >>> common = {"climate": climate, "settings": settings}
    >>> frames = (draw_frame(i, 2, 512, **common, rng=np.random.default_rng(i)) for i in range(2))
    >>> from snowsim.statistics import fit
    >>> layer_bins = draw(fit(frames, estimator="paper"), 256, rng=np.random.default_rng(0))
    >>> layer_bins.shape[1], round(float(layer_bins[0].mean()))
    (256, 50)
    >>> bool((np.diff(layer_bins, axis=0) >= 1).all())  # layers never share a pixel
    True
    """
    model = statistics
    if not isinstance(statistics, LabelModel):
        # Layers alone need no powers.
        model = prepare(statistics, n_range_lines, radiometry="constant")
    return draw_scene(model, n_range_lines, name="", rng=generator(rng)).layer_bins


def draw_scene(statistics, n_range_lines, *, name, rng):
    """Layers of one scene with its zone, its echoes and what the rules did to it.

    Returns
    -------
    snowsim.echogram.Scene
        `notes` holds `n_layers` below the surface, `n_slabs_beyond` (deeper than the flight shows),
        `n_samples` of thickness, `n_touched` and `n_means_touched` by the rule for thin slabs,
        `first_thickness_bins` drawn, and mean and variance of thickness before and after that rule,
        `thickness_{mean,variance}_{drawn,kept}`; with trends and folds what `draw_nonstationary`
        notes.
    """
    model = statistics
    if not isinstance(statistics, LabelModel):
        model = prepare(statistics, n_range_lines)
    if model.n_range_lines != n_range_lines:
        msg = f"label model was prepared for {model.n_range_lines} range lines, got {n_range_lines}"
        raise ValueError(msg)
    # Before slab 0, as in the first version: scenes with as many layers as printed stay the same.
    n_layers = None
    if model.n_layers is not None:
        n_layers = int(rng.integers(*model.n_layers, endpoint=True))
    first_bins = _draw_first_slab(model, rng=rng)
    zone = int(zone_of(first_bins, model.zone_edge_bins))
    if n_layers is None:
        n_layers = model.draw_n_layers(zone, rng=rng)
    n_slabs = max(n_layers, 1)  # a scene without layers drops its only slab at the end
    mean = first_bins * _draw_relative_means(model, zone, n_slabs, rng=rng)
    drawn = _mirrored(mean)[:, None] + _draw_undulations(model, zone, n_slabs, rng=rng)
    # Drawn last: without trends and folds, scenes do not change by a byte.
    moved = {}
    if model.nonstationary.applies(zone):
        drawn, moved = draw_nonstationary(drawn, model.nonstationary, rng=rng)
    drawn = drawn[:n_layers]
    # Sums of multiples are exact: layers are the same on any processor, and one bin apart.
    thickness = on_grid(_mirrored(drawn), GRID_BITS)
    surface = on_grid(model.draw_surface(rng=rng), GRID_BITS)
    layer_bins = np.cumsum(np.concatenate([surface, thickness]), axis=0)
    notes = {
        "n_layers": n_layers,
        "n_slabs_beyond": max(n_layers - model.n_slabs, 0),
        "n_samples": drawn.size,
        "n_touched": int((drawn < MINIMUM_THICKNESS_BINS).sum()),
        "n_means_touched": int((mean[:n_layers] < MINIMUM_THICKNESS_BINS).sum()),
        "first_thickness_bins": float(rounded(first_bins, NOTE_BITS)),
        "thickness_mean_drawn": _noted(np.mean, drawn),
        "thickness_variance_drawn": _noted(np.var, drawn),
        "thickness_mean_kept": _noted(np.mean, thickness),
        "thickness_variance_kept": _noted(np.var, thickness),
    }
    scene = Scene(
        name=name,
        n_range_bins=scene_height(layer_bins),
        layer_bins=layer_bins,
        zone=zone,
        notes=notes | moved,
    )
    if model.radiometry is None:
        return scene
    return add_radiometry(scene, model.radiometry, rng=rng)


def _noted(moment, thickness):
    """A moment of thickness as notes hold it; 0 of none."""
    return float(rounded(moment(thickness), NOTE_BITS)) if len(thickness) else 0.0


def check_labels(model, *, rng):
    """Draw a few scenes and refuse statistics by which most are labelled at the surface alone.

    ValueError where that is so of most scenes with layers.
    """
    if model.radiometry is None:
        return
    n_scenes = 0
    n_bare = 0
    for _ in range(N_TRIALS):
        scene = draw_scene(model, model.n_range_lines, name="trial", rng=rng)
        if len(scene.layer_bins) > 1:
            n_scenes += 1
            n_bare += not np.isfinite(scene.layer_bins[1:]).any()
    if 2 * n_bare > n_scenes:
        contrast_db = model.radiometry.spread["end_contrast_db"]
        msg = f"labels: {n_bare} of {n_scenes} scenes with layers would be labelled at the surface "
        msg += f"alone, as few layers rise by end_contrast_db, {contrast_db:.3g} dB: "
        msg += "fit more of the flight, or radiometry: constant"
        raise ValueError(msg)


def _draw_first_slab(model, *, rng):
    """Mean thickness of slab 0 [bins]."""
    quantiles = model.first_quantile_bins
    if quantiles is None:
        return rng.uniform(model.zone_edge_bins[0], model.zone_edge_bins[-1])
    probability = np.linspace(0, 1, quantiles.size)
    return np.interp(rng.uniform(), probability, quantiles)


def _draw_relative_means(model, zone, n_slabs, *, rng):
    """Mean thickness of each slab relative to slab 0, (slab,)."""
    slab = np.minimum(np.arange(n_slabs), model.n_slabs - 1)
    mixing = model.factor("relative", model.relative_correlation, n_slabs)
    anomaly = mixing @ rng.standard_normal(n_slabs)
    relative = model.relative_mean[zone, slab] + model.relative_deviation[zone, slab] * anomaly
    relative[0] = 1
    return relative


def _draw_undulations(model, zone, n_slabs, *, rng):
    """Thickness of each slab about its mean [bins], (slab, range_line)."""
    slab = np.minimum(np.arange(n_slabs), model.n_slabs - 1)
    variances = model.variances(zone)[slab]
    mixing = model.band_factors(n_slabs, variances.shape[1])
    return draw_series(variances, mixing, model.n_range_lines, rng=rng)


def _mirrored(thickness):
    """Thickness mirrored at its minimum, where one layer lies one bin below the other."""
    return MINIMUM_THICKNESS_BINS + np.abs(thickness - MINIMUM_THICKNESS_BINS)
