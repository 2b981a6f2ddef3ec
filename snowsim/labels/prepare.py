"""Flight statistics made ready to draw label sets: computed once, kept for all scenes."""

from dataclasses import dataclass, field

import numpy as np

from snowsim.echogram import SURFACE_ROW, check_choice
from snowsim.labels.dress import Dress
from snowsim.labels.given import values_of
from snowsim.labels.process import (
    Nonstationary,
    correlation_factor,
    draw_series,
    lengthened,
    line_variances,
    plain_variances,
)
from snowsim.labels.radiometry import RadiometryModel, radiometry_model
from snowsim.limits import check_count, check_values

# Of the steps that whole-bin levelling makes, above which a product is taken to do so.
ROUNDED_SHARE = 0.5


@dataclass(frozen=True)
class LabelModel:
    """Flight statistics made ready to draw many scenes of one width; see `prepare`.

    What a scene needs is computed when the first scene needs it, and kept: no result depends on the
    order.
    """

    n_range_lines: int
    zone_edge_bins: np.ndarray  # (edge,)
    relative_mean: np.ndarray  # of thickness relative to slab 0, a Gaussian, (zone, slab)
    relative_deviation: np.ndarray  # its s.d., (zone, slab)
    psd: np.ndarray  # (zone, slab, wavenumber)
    relative_correlation: np.ndarray  # of relative thickness, by separation in slabs, (separation,)
    band_correlation: np.ndarray  # of undulations about the mean, (band, separation)
    band_edge_wavenumber: np.ndarray  # (band_edge,)
    # Fewest and most layers below the surface; None: as `blocks_by_layers`.
    n_layers: tuple | None = None
    # Of the flight, by number of layers from 0, (zone, n_layers).
    blocks_by_layers: np.ndarray | None = None
    share_without_layers: float = 0.0  # of its blocks, which are in no zone
    # Of slab 0, evenly from probability 0 to 1; None: uniform.
    first_quantile_bins: np.ndarray | None = None
    # Of the rise over a block, (zone, slab); None: `psd` is plain and leaks.
    trend_variance: np.ndarray | None = None
    trend_correlation: np.ndarray | None = None  # of that rise, (separation,)
    surface: dict | None = None  # its statistics by name; None: flat
    nonstationary: Nonstationary = Nonstationary()  # trends and folds; by default none
    # How powers vary; None: not at all, and every layer is labelled.
    radiometry: RadiometryModel | None = None
    _kept: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def n_slabs(self):
        """Slabs the flight shows."""
        return self.relative_mean.shape[1]

    def variances(self, zone):
        """Variance of the series a scene is cut from, (slab, long wavenumber)."""
        if ("variances", zone) not in self._kept:
            trend = None if self.trend_variance is None else self.trend_variance[zone]
            self._kept["variances", zone] = self._long_variances(self.psd[zone], trend)
        return self._kept["variances", zone]

    def _long_variances(self, psd, trend_variance):
        """Variances from spectra (row, wavenumber) about trends, or from plain ones."""
        block = 2 * (psd.shape[1] - 1)
        # Narrow scenes are cut from the series of a whole block, so they contain the right part of
        # its undulations.
        if trend_variance is None:
            variances = line_variances(psd, 2 * block)
        else:
            variances = plain_variances(psd, trend_variance, 2 * block)
        if self.n_range_lines <= block:
            return variances
        even = self.n_range_lines + self.n_range_lines % 2
        return lengthened(variances, 2 * even)

    def draw_n_layers(self, zone, *, rng):
        """Number of layers below the surface, as in the blocks of the zone; zero as in the flight.

        Numbers between those seen are interpolated in the logarithm between mid-quantiles (Parzen
        2004, Statist. Sci. 19, 652); a zone without layers uses all zones.
        """
        if rng.uniform() < self.share_without_layers:
            return 0
        counts = self.blocks_by_layers[zone, 1:]
        if not counts.any():
            counts = self.blocks_by_layers[:, 1:].sum(axis=0)
        seen = np.flatnonzero(counts)
        middle = (np.cumsum(counts) - counts / 2)[seen] / counts.sum()
        log_number = np.interp(rng.uniform(), middle, np.log(seen + 1))
        return int(np.rint(np.exp(log_number)))

    def draw_surface(self, *, rng):
        """Row of the surface, (1, range_line): flat, or as levelling in whole bins leaves it."""
        row = np.full((1, self.n_range_lines), float(SURFACE_ROW))
        if self.surface is None:
            return row
        slow, movement = self._surface_variances()
        row += draw_series(slow, [], self.n_range_lines, rng=rng)
        if self.surface["surface_fraction"] > ROUNDED_SHARE:
            start = rng.uniform()
            steps = draw_series(movement, [], self.n_range_lines, rng=rng)
            way = start + np.cumsum(steps, axis=1)
            row += way - np.rint(way)
        return row

    def _surface_variances(self):
        """Variances of slow error and of movement to level, each (1, long wavenumber)."""
        if "surface" not in self._kept:
            trend_variance = self.surface["surface_trend_variance_bins2"][None]
            slow = self._long_variances(self.surface["surface_psd"][None], trend_variance)
            movement = self._long_variances(self.surface["surface_movement_psd"][None], 0.0)
            self._kept["surface"] = (slow, movement)
        return self._kept["surface"]

    def factor(self, name, correlation, n):
        """Factor of the correlation matrix of `n` slabs, by separation, kept by name."""
        if (name, n) not in self._kept:
            self._kept[name, n] = correlation_factor(correlation, n)
        return self._kept[name, n]

    def band_factors(self, n, n_wavenumbers):
        """Factors of the correlation of undulations by band, (long wavenumbers, factor)."""
        if ("bands", n) not in self._kept:
            edges = np.ceil(self.band_edge_wavenumber * 2 * n_wavenumbers - 1e-9).astype(int) - 1
            edges[0] = 0  # the first band reaches down to the lowest wavenumber
            edges[-1] = n_wavenumbers
            correlations = list(self.band_correlation)
            if self.trend_variance is not None:
                # Undulations slower than three quarters of a cycle per block are its trend.
                per_cycle = n_wavenumbers / (self.psd.shape[2] - 1)
                edges = np.insert(edges, 1, int(0.75 * per_cycle))
                correlations.insert(0, self.trend_correlation)
            bands = [slice(low, high) for low, high in zip(edges[:-1], edges[1:], strict=True)]
            factors = [correlation_factor(correlation, n) for correlation in correlations]
            self._kept["bands", n] = list(zip(bands, factors, strict=True))
        return self._kept["bands", n]


def prepare(
    statistics,
    n_range_lines,
    *,
    n_layers="measured",
    correlation="measured",
    first_slab="measured",
    surface="measured",
    nonstationary=None,
    radiometry="measured",
    dress=None,
):
    """Make flight statistics ready to draw many scenes.

    Parameters
    ----------
    statistics : xarray.Dataset
        Of `snowsim.statistics.fit`.
    n_range_lines : int
    n_layers : "measured" or (int, int)
        Layers below the surface: as many as in the flight's zone, or evenly between fewest and
        most, in the paper (5, 40).
    correlation : {"measured", "none"}
        Whether thickness of different slabs is correlated as in the flight, or only through slab 0
        as in the paper.
    first_slab : {"measured", "uniform"}
        Mean thickness of slab 0: as in the flight, or evenly over its range as in the paper.
    surface : {"measured", "flat"}
    nonstationary : Nonstationary, optional
        Trends and folds; by default none, as in the paper.
    radiometry : {"measured", "constant"}
        Whether powers vary by scene and labels end at the deepest visible layer, see
        `add_radiometry`; with constant radiometry, as in the paper, scenes have no `echoes`.
    dress : Dress, optional
        Choices for the echoes of scenes with measured radiometry.

    Returns
    -------
    LabelModel

    Raises
    ------
    ValueError
        If statistics are missing or not finite, a scene is narrower than 2 lines, a range is empty,
        a choice unknown.
    """
    check_count("n_range_lines", n_range_lines, 2)
    choices = {
        "correlation": (correlation, ("measured", "none")),
        "first_slab": (first_slab, ("measured", "uniform")),
        "surface": (surface, ("measured", "flat")),
        "radiometry": (radiometry, ("measured", "constant")),
    }
    for name, (value, known) in choices.items():
        check_choice(name, value, known)
    chosen = {"n_layers": None}
    if n_layers == "measured":
        chosen |= _counts_of_layers(statistics)
    else:
        check_values("n_layers, measured or two counts,", n_layers, 1)
        if np.shape(n_layers) != (2,) or n_layers[0] > n_layers[1]:
            msg = f"n_layers must be measured or two counts in order, got {n_layers}"
            raise ValueError(msg)
        chosen["n_layers"] = tuple(n_layers)
    if first_slab == "measured":
        quantiles = values_of(statistics, "first_thickness_quantile_bins", ("quantile",))
        chosen["first_quantile_bins"] = quantiles
    if surface == "measured":
        chosen["surface"] = _surface(statistics)
    if radiometry == "measured":
        chosen["radiometry"] = radiometry_model(statistics, dress or Dress())
    variance = values_of(statistics, "relative_thickness_variance", ("zone", "slab"))
    return LabelModel(
        n_range_lines=n_range_lines,
        zone_edge_bins=values_of(statistics, "zone_edge_bins", ("edge",)),
        relative_mean=values_of(statistics, "relative_thickness_mean", ("zone", "slab")),
        relative_deviation=np.sqrt(variance),
        psd=values_of(statistics, "thickness_psd", ("zone", "slab", "wavenumber")),
        nonstationary=nonstationary or Nonstationary(),
        **_correlations(statistics, correlation),
        **chosen,
    )


def _counts_of_layers(statistics):
    """How many layers blocks of the flight have, as arguments of `LabelModel`."""
    by_layers = values_of(statistics, "n_blocks_by_layers", ("zone", "n_layers"))
    n_layered = by_layers[:, 1:].sum()
    what = "flight statistics: n_blocks_by_layers: blocks with a layer below the surface"
    check_values(what, n_layered, 0, above=True)
    n_blocks = statistics.attrs.get("n_blocks", 1)
    n_without = statistics.attrs.get("n_blocks_without_layers", 0)
    return {"blocks_by_layers": by_layers, "share_without_layers": n_without / n_blocks}


def _surface(statistics):
    """What `LabelModel.draw_surface` needs."""
    spectra = ("surface_psd", "surface_movement_psd")
    numbers = ("surface_trend_variance_bins2", "surface_fraction")
    measured = {name: values_of(statistics, name, ("wavenumber",)) for name in spectra}
    return measured | {name: values_of(statistics, name, ()) for name in numbers}


def _correlations(statistics, correlation):
    """Correlations between slabs as arguments of `LabelModel`; the paper has none."""
    trend = {}
    # Plain spectra have no trend.
    if "thickness_trend_variance_bins2" in statistics:
        variance = values_of(statistics, "thickness_trend_variance_bins2", ("zone", "slab"))
        trend["trend_variance"] = variance
    if correlation == "none":
        alone = np.array([1.0, 0.0])
        return trend | {
            "relative_correlation": alone,
            "band_correlation": alone[None],
            "band_edge_wavenumber": np.array([0, 0.5]),
            "trend_correlation": alone,
        }
    if trend:
        trend["trend_correlation"] = values_of(statistics, "trend_correlation", ("separation",))
    relative = values_of(statistics, "relative_thickness_correlation", ("separation",))
    return trend | {
        "relative_correlation": relative,
        "band_correlation": values_of(statistics, "thickness_correlation", ("band", "separation")),
        "band_edge_wavenumber": values_of(statistics, "band_edge_wavenumber", ("band_edge",)),
    }
