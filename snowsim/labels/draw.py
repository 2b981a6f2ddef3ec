"""Layers of one scene: their number, mean thicknesses, correlated undulations, accumulated from the surface down."""

from dataclasses import dataclass, field

import numpy as np

from snowsim.echogram import SURFACE_ROW, Scene, scene_height
from snowsim.labels.nonstationary import Beyond, draw_beyond
from snowsim.labels.process import correlation_factor, draw_series, lengthened, line_variances
from snowsim.labels.radiometry import RADIOMETRY, RadiometryModel, add_radiometry, radiometry_model
from snowsim.labels.values import values_of

N_LAYERS = (5, 40)  # layers below the surface, Yari et al. (2021), section V-B
MINIMUM_THICKNESS_BINS = 1.0  # two layers never share a pixel
CORRELATIONS = ("measured", "none")


@dataclass(frozen=True)
class LabelModel:
    """Flight statistics made ready to draw many scenes of one width; see `prepare`.

    What a scene needs of it is worked out when the first scene needs it and kept: no result depends on the order.
    """

    n_range_lines: int
    n_layers: tuple  # fewest and most below the surface
    zone_edge_bins: np.ndarray  # (edge,)
    relative_mean: np.ndarray  # of thickness relative to slab 0, a Gaussian, (zone, slab)
    relative_deviation: np.ndarray  # its s.d., (zone, slab)
    psd: np.ndarray  # (zone, slab, wavenumber)
    relative_correlation: np.ndarray  # of relative thickness, by separation in slabs, (separation,)
    band_correlation: np.ndarray  # of undulations about the mean, (band, separation)
    band_edge_wavenumber: np.ndarray  # (band_edge,)
    beyond: Beyond = Beyond()  # what leaves the paper's stationary process; by default nothing
    radiometry: RadiometryModel | None = None  # how powers vary; None: not at all, and every layer is labelled
    _kept: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def n_slabs(self):
        """Slabs the flight shows."""
        return self.relative_mean.shape[1]

    def variances(self, zone):
        """Variance at the wavenumbers of the series a scene is cut from, (slab, long wavenumber)."""
        if ("variances", zone) not in self._kept:
            block = 2 * (self.psd.shape[2] - 1)
            # Narrow scenes are cut from a series for a whole block: they hold the part of its undulations they should.
            variances = line_variances(self.psd[zone], 2 * block)
            if self.n_range_lines > block:
                variances = lengthened(variances, 2 * (self.n_range_lines + self.n_range_lines % 2))
            self._kept["variances", zone] = variances
        return self._kept["variances", zone]

    def relative_factor(self, n):
        """Factor of the correlation matrix of relative thickness of `n` slabs."""
        if ("relative", n) not in self._kept:
            self._kept["relative", n] = correlation_factor(self.relative_correlation, n)
        return self._kept["relative", n]

    def band_factors(self, n, n_wavenumbers):
        """The same of undulations, one (slice of long wavenumbers, factor) a band."""
        if ("bands", n) not in self._kept:
            edges = np.ceil(self.band_edge_wavenumber * 2 * n_wavenumbers - 1e-9).astype(int) - 1
            edges[0], edges[-1] = 0, n_wavenumbers  # the first band reaches down to the lowest wavenumber
            factors = [correlation_factor(row, n) for row in self.band_correlation]
            self._kept["bands", n] = [(slice(*edges[i : i + 2]), factor) for i, factor in enumerate(factors)]
        return self._kept["bands", n]


def prepare(
    statistics, n_range_lines, *, n_layers=N_LAYERS, correlation="measured", beyond=None, radiometry="constant"
):
    """Make flight statistics ready to draw many scenes.

    Parameters
    ----------
    statistics : xarray.Dataset
        Of `snowsim.statistics.fit`.
    n_range_lines : int
    n_layers : (int, int)
        Fewest and most layers below the surface.
    correlation : {"measured", "none"}
        Whether thickness of different slabs is correlated as in the flight, or only through slab 0 as in the paper.
    beyond : Beyond, optional
        Trends and folds; by default none, as in the paper.
    radiometry : {"constant", "measured"}
        Whether scenes have powers of their own, unlabelled layers, and labels only where they show: `add_radiometry`.

    Returns
    -------
    LabelModel

    Raises
    ------
    ValueError
        If statistics needed are missing or not finite, a scene is narrower than 2 lines, or a range is not one.
    """
    if n_range_lines < 2:
        msg = f"a scene needs at least 2 range lines, got {n_range_lines}"
        raise ValueError(msg)
    if not 1 <= n_layers[0] <= n_layers[1]:
        msg = f"n_layers must be two counts in order, from 1, got {tuple(n_layers)}"
        raise ValueError(msg)
    if correlation not in CORRELATIONS:
        msg = f"correlation must be one of {', '.join(CORRELATIONS)}, got {correlation!r}"
        raise ValueError(msg)
    if radiometry not in RADIOMETRY:
        msg = f"radiometry must be one of {', '.join(RADIOMETRY)}, got {radiometry!r}"
        raise ValueError(msg)
    if correlation == "measured":
        by_band = values_of(statistics, "thickness_correlation", ("band", "separation"))
        by_separation = values_of(statistics, "relative_thickness_correlation", ("separation",))
        band_edges = values_of(statistics, "band_edge_wavenumber", ("band_edge",))
    else:
        by_separation, by_band, band_edges = np.array([1.0, 0.0]), np.array([[1.0, 0.0]]), np.array([0, 0.5])
    return LabelModel(
        n_range_lines=n_range_lines,
        n_layers=tuple(n_layers),
        zone_edge_bins=values_of(statistics, "zone_edge_bins", ("edge",)),
        relative_mean=values_of(statistics, "relative_thickness_mean", ("zone", "slab")),
        relative_deviation=np.sqrt(values_of(statistics, "relative_thickness_variance", ("zone", "slab"))),
        psd=values_of(statistics, "thickness_psd", ("zone", "slab", "wavenumber")),
        relative_correlation=by_separation,
        band_correlation=by_band,
        band_edge_wavenumber=band_edges,
        beyond=beyond or Beyond(),
        radiometry=radiometry_model(statistics) if radiometry == "measured" else None,
    )


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
        Range bins, row 0 the surface at bin 50, strictly increasing with depth.

    Raises
    ------
    ValueError
        If statistics are missing or not finite, or a `LabelModel` was prepared for another width.

    Notes
    -----
    Yari et al. (2021), section V-B: number of layers ~ U{5..40}, mean thickness of slab 0 ~ U(range seen), which
    fixes the zone; mean of deeper slabs = slab 0 x a factor from the zone's Gaussian; thickness = mean + Gaussian
    process of that slab's spectrum in that zone. Slabs deeper than the flight shows take its last. Thickness below
    `MINIMUM_THICKNESS_BINS`, and a mean below it, is mirrored at that value.

    Examples
    --------
    From two frames of the synthetic reference flight:

    >>> from snowsim.reference import checked_settings, draw_climate, draw_frame
    >>> settings = checked_settings({"radar": {"n_range_bins": 300}})
    >>> common = {"climate": draw_climate(settings, rng=np.random.default_rng(1)), "settings": settings}
    >>> frames = (draw_frame(i, 2, 512, **common, rng=np.random.default_rng(i)) for i in range(2))
    >>> from snowsim.statistics import fit
    >>> layer_bins = draw(fit(frames, estimator="paper"), 256, rng=np.random.default_rng(0))
    >>> layer_bins.shape[1], float(layer_bins[0, 0])
    (256, 50.0)
    >>> bool((np.diff(layer_bins, axis=0) >= 1).all())  # layers never share a pixel
    True
    """
    return draw_scene(statistics, n_range_lines, name="", rng=rng).layer_bins


def draw_scene(statistics, n_range_lines, *, name, rng):
    """Layers of one scene with its zone and what the rules did to it; parameters as `draw`.

    Returns
    -------
    snowsim.echogram.Scene
        `notes` holds `n_layers` below the surface, `n_slabs_beyond` (deeper than the flight shows), `n_samples` of
        thickness, `n_touched` and `n_means_touched` by the rule for thin slabs, `first_thickness_bins` drawn, and mean
        and variance of thickness before and after that rule, `thickness_{mean,variance}_{drawn,kept}`; with trends
        and folds what `draw_beyond` notes.
    """
    model = statistics if isinstance(statistics, LabelModel) else prepare(statistics, n_range_lines)
    if model.n_range_lines != n_range_lines:
        msg = f"label model was prepared for {model.n_range_lines} range lines, asked for {n_range_lines}"
        raise ValueError(msg)
    n_layers = int(rng.integers(*model.n_layers, endpoint=True))
    edges = model.zone_edge_bins
    first = rng.uniform(edges[0], edges[-1])
    zone = int(np.searchsorted(edges[1:-1], first, side="right"))
    slab = np.minimum(np.arange(n_layers), model.n_slabs - 1)
    anomaly = model.relative_factor(n_layers) @ rng.standard_normal(n_layers)
    factor = model.relative_mean[zone, slab] + model.relative_deviation[zone, slab] * anomaly
    factor[0] = 1
    mean = _mirrored(first * factor)
    variances = model.variances(zone)[slab]
    series = draw_series(variances, model.band_factors(n_layers, variances.shape[1]), n_range_lines, rng=rng)
    drawn = mean[:, None] + series
    # Last of all numbers drawn: without trends and folds, scenes are those of the paper to the byte.
    drawn, beyond = draw_beyond(drawn, model.beyond, rng=rng) if model.beyond.applies(zone) else (drawn, {})
    thickness = _mirrored(drawn)
    surface = np.full((1, n_range_lines), float(SURFACE_ROW))
    layer_bins = np.cumsum(np.concatenate([surface, thickness]), axis=0)
    notes = {
        "n_layers": n_layers,
        "n_slabs_beyond": max(n_layers - model.n_slabs, 0),
        "n_samples": drawn.size,
        "n_touched": int((drawn < MINIMUM_THICKNESS_BINS).sum()),
        "n_means_touched": int((first * factor < MINIMUM_THICKNESS_BINS).sum()),
        "first_thickness_bins": float(first),
        "thickness_mean_drawn": float(drawn.mean()),
        "thickness_variance_drawn": float(drawn.var()),
        "thickness_mean_kept": float(thickness.mean()),
        "thickness_variance_kept": float(thickness.var()),
        **beyond,
    }
    scene = Scene(name=name, n_range_bins=scene_height(layer_bins), layer_bins=layer_bins, zone=zone, notes=notes)
    return scene if model.radiometry is None else add_radiometry(scene, model.radiometry, rng=rng)


def _mirrored(thickness):
    """Thickness mirrored at its minimum, at which it can still touch: then one layer lies one bin below the other."""
    return MINIMUM_THICKNESS_BINS + np.abs(thickness - MINIMUM_THICKNESS_BINS)
