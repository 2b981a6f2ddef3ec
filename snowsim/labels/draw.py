"""Layers of one scene: their number, mean thicknesses, correlated undulations, accumulated from the surface down."""

import numpy as np

from snowsim.echogram import Scene, scene_height
from snowsim.labels.prepare import LabelModel, prepare
from snowsim.labels.process import draw_nonstationary, draw_series
from snowsim.labels.radiometry import add_radiometry

MINIMUM_THICKNESS_BINS = 1.0  # two layers never share a pixel


def draw(statistics, n_range_lines, *, rng):
    """Layers of one scene.

    Parameters
    ----------
    statistics : xarray.Dataset or LabelModel
        Of `snowsim.statistics.fit`, or of `prepare` when many scenes are drawn.
    n_range_lines : int
    rng : numpy.random.Generator

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
    Yari et al. (2021), section V-B: mean thickness of slab 0, which fixes the zone; mean of deeper slabs = slab 0 x a
    factor from the zone's Gaussian; thickness = mean + Gaussian process of that slab's spectrum in that zone. The paper
    draws slab 0 ~ U(range seen) and the number of layers ~ U{5..40}, below a flat surface; here all three are as in the
    flight, see `prepare`, and so is the trend within a block if its variance is known. Slabs deeper than the flight
    shows take values of its last. Thickness below `MINIMUM_THICKNESS_BINS`, and a mean below it, is mirrored there.

    Examples
    --------
    From two frames of the synthetic reference flight:

    >>> from snowsim.reference import checked_settings, draw_climate, draw_frame
    >>> settings = checked_settings({"radar": {"n_range_bins": 300}})
    >>> common = {"climate": draw_climate(settings, rng=np.random.default_rng(1)), "settings": settings}
    >>> frames = (draw_frame(i, 2, 512, **common, rng=np.random.default_rng(i)) for i in range(2))
    >>> from snowsim.statistics import fit
    >>> layer_bins = draw(fit(frames, estimator="paper"), 256, rng=np.random.default_rng(0))
    >>> layer_bins.shape[1], round(float(layer_bins[0].mean()))
    (256, 50)
    >>> bool((np.diff(layer_bins, axis=0) >= 1).all())  # layers never share a pixel
    True
    """
    return draw_scene(statistics, n_range_lines, name="", rng=rng).layer_bins


def draw_scene(statistics, n_range_lines, *, name, rng):
    """Layers of one scene with its zone and what the rules did to it; parameters as `draw`.

    Returns
    -------
    snowsim.echogram.Scene
        `notes` holds `n_layers` below the surface, `n_slabs_beyond` (deeper than the flight shows),
        `n_samples` of thickness, `n_touched` and `n_means_touched` by the rule for thin slabs,
        `first_thickness_bins` drawn, and mean and variance of thickness before and after that rule,
        `thickness_{mean,variance}_{drawn,kept}`; with trends and folds what `draw_nonstationary`
        notes.
    """
    model = statistics if isinstance(statistics, LabelModel) else prepare(statistics, n_range_lines)
    if model.n_range_lines != n_range_lines:
        msg = f"label model was prepared for {model.n_range_lines} range lines, got {n_range_lines}"
        raise ValueError(msg)
    # Random numbers are drawn in the order of the first release, so that its scenes can be
    # reproduced.
    n_layers = None if model.n_layers is None else int(rng.integers(*model.n_layers, endpoint=True))
    edges = model.zone_edge_bins
    if model.first_quantile_bins is None:
        first = rng.uniform(edges[0], edges[-1])
    else:
        first = np.interp(
            rng.uniform(),
            np.linspace(0, 1, model.first_quantile_bins.size),
            model.first_quantile_bins,
        )
    zone = int(np.searchsorted(edges[1:-1], first, side="right"))
    n_layers = model.draw_n_layers(zone, rng=rng) if n_layers is None else n_layers
    n_slabs = max(n_layers, 1)  # a scene without layers drops its only slab at the end
    slab = np.minimum(np.arange(n_slabs), model.n_slabs - 1)
    anomaly = model.factor("relative", model.relative_correlation, n_slabs) @ rng.standard_normal(
        n_slabs
    )
    factor = model.relative_mean[zone, slab] + model.relative_deviation[zone, slab] * anomaly
    factor[0] = 1
    mean = _mirrored(first * factor)
    variances = model.variances(zone)[slab]
    series = draw_series(
        variances, model.band_factors(n_slabs, variances.shape[1]), n_range_lines, rng=rng
    )
    drawn = mean[:, None] + series
    # Drawn last: without trends and folds, scenes do not change by a byte.
    extra = model.nonstationary
    drawn, moved = draw_nonstationary(drawn, extra, rng=rng) if extra.applies(zone) else (drawn, {})
    drawn = drawn[:n_layers]
    thickness = _mirrored(drawn)
    layer_bins = np.cumsum(np.concatenate([model.draw_surface(rng=rng), thickness]), axis=0)
    notes = {
        **{
            "n_layers": n_layers,
            "n_slabs_beyond": max(n_layers - model.n_slabs, 0),
            "n_samples": drawn.size,
        },
        "n_touched": int((drawn < MINIMUM_THICKNESS_BINS).sum()),
        "n_means_touched": int((first * factor[:n_layers] < MINIMUM_THICKNESS_BINS).sum()),
        "first_thickness_bins": float(first),
        "thickness_mean_drawn": float(drawn.mean()) if n_layers else 0.0,
        "thickness_variance_drawn": float(drawn.var()) if n_layers else 0.0,
        "thickness_mean_kept": float(thickness.mean()) if n_layers else 0.0,
        "thickness_variance_kept": float(thickness.var()) if n_layers else 0.0,
        **moved,
    }
    scene = Scene(
        name=name,
        n_range_bins=scene_height(layer_bins),
        layer_bins=layer_bins,
        zone=zone,
        notes=notes,
    )
    return scene if model.radiometry is None else add_radiometry(scene, model.radiometry, rng=rng)


def _mirrored(thickness):
    """Thickness mirrored at its minimum, where one layer lies one bin below the other."""
    return MINIMUM_THICKNESS_BINS + np.abs(thickness - MINIMUM_THICKNESS_BINS)
