"""Flight statistics made ready to draw label sets: what a scene takes from them, computed once and kept."""

from dataclasses import dataclass, field

import numpy as np

from snowsim.echogram import SURFACE_ROW, check_choice
from snowsim.labels.process import (
    Nonstationary,
    correlation_factor,
    draw_series,
    lengthened,
    line_variances,
    plain_variances,
)
from snowsim.labels.radiometry import RadiometryModel, radiometry_model, values_of

N_LAYERS = (5, 40)  # layers below the surface, Yari et al. (2021), section V-B
ROUNDED_SHARE = (
    0.5  # of the steps that whole-bin levelling makes, above which a product is taken to do so
)


@dataclass(frozen=True)
class LabelModel:
    """Flight statistics made ready to draw many scenes of one width; see `prepare`.

    What a scene needs is computed when the first scene needs it, and kept: no result depends on the
    order.
    """

    n_range_lines: int
    n_layers: tuple | None  # fewest and most below the surface; None: as `blocks_by_layers`
    zone_edge_bins: np.ndarray  # (edge,)
    relative_mean: np.ndarray  # of thickness relative to slab 0, a Gaussian, (zone, slab)
    relative_deviation: np.ndarray  # its s.d., (zone, slab)
    psd: np.ndarray  # (zone, slab, wavenumber)
    relative_correlation: np.ndarray  # of relative thickness, by separation in slabs, (separation,)
    band_correlation: np.ndarray  # of undulations about the mean, (band, separation)
    band_edge_wavenumber: np.ndarray  # (band_edge,)
    blocks_by_layers: np.ndarray | None = (
        None  # of the flight, by number of layers from 0, (zone, n_layers)
    )
    share_without_layers: float = 0.0  # of its blocks, which are in no zone
    first_quantile_bins: np.ndarray | None = (
        None  # of slab 0, evenly from probability 0 to 1; None: uniform
    )
    trend_variance: np.ndarray | None = (
        None  # of the rise over a block, (zone, slab); None: `psd` is plain and leaks
    )
    trend_correlation: np.ndarray | None = None  # of that rise, (separation,)
    surface: dict | None = None  # its statistics by name; None: flat
    nonstationary: Nonstationary = Nonstationary()  # trends and folds; by default none
    radiometry: RadiometryModel | None = (
        None  # how powers vary; None: not at all, and every layer is labelled
    )
    _kept: dict = field(default_factory=dict, repr=False, compare=False)

    @property
    def n_slabs(self):
        """Slabs the flight shows."""
        return self.relative_mean.shape[1]

    def variances(self, zone):
        """Variance at the wavenumbers of the series a scene is cut from, (slab, long wavenumber)."""
        if ("variances", zone) not in self._kept:
            trend = None if self.trend_variance is None else self.trend_variance[zone]
            self._kept["variances", zone] = self._spread(self.psd[zone], trend)
        return self._kept["variances", zone]

    def _spread(self, psd, trend_variance):
        """Variances from spectra (row, wavenumber) about trends, or from plain ones."""
        block = 2 * (psd.shape[1] - 1)
        # Narrow scenes are cut from the series of a whole block, so they contain the right part of
        # its undulations.
        plain = trend_variance is None
        variances = (
            line_variances(psd, 2 * block)
            if plain
            else plain_variances(psd, trend_variance, 2 * block)
        )
        if self.n_range_lines <= block:
            return variances
        return lengthened(variances, 2 * (self.n_range_lines + self.n_range_lines % 2))

    def draw_n_layers(self, zone, *, rng):
        """Number of layers below the surface: zero as often as in the flight, otherwise as in the zone's blocks.

        Numbers between those seen are interpolated in the logarithm between mid-quantiles (Parzen
        2004, Statist. Sci. 19, 652); a zone without layers uses all zones.
        """
        if rng.uniform() < self.share_without_layers:
            return 0
        counts = self.blocks_by_layers[zone, 1:]
        counts = counts if counts.any() else self.blocks_by_layers[:, 1:].sum(axis=0)
        seen = np.flatnonzero(counts)
        middle = (np.cumsum(counts) - counts / 2)[seen] / counts.sum()
        return int(np.rint(np.exp(np.interp(rng.uniform(), middle, np.log(seen + 1)))))

    def draw_surface(self, *, rng):
        """Row of the surface, (1, range_line): flat, or a slow error and what levelling in whole bins leaves."""
        row = np.full((1, self.n_range_lines), float(SURFACE_ROW))
        if self.surface is None:
            return row
        if "surface" not in self._kept:
            slow = (
                self.surface["surface_psd"][None],
                self.surface["surface_trend_variance_bins2"][None],
            )
            self._kept["surface"] = (
                self._spread(*slow),
                self._spread(self.surface["surface_movement_psd"][None], 0.0),
            )
        slow, movement = self._kept["surface"]
        row += draw_series(slow, [], self.n_range_lines, rng=rng)
        if self.surface["surface_fraction"] > ROUNDED_SHARE:
            way = rng.uniform() + np.cumsum(
                draw_series(movement, [], self.n_range_lines, rng=rng), axis=1
            )
            row += way - np.rint(way)
        return row

    def factor(self, name, correlation, n):
        """Factor of the correlation matrix of `n` slabs, by separation, kept by name."""
        if (name, n) not in self._kept:
            self._kept[name, n] = correlation_factor(correlation, n)
        return self._kept[name, n]

    def band_factors(self, n, n_wavenumbers):
        """Factors of the correlation of undulations, one (slice of long wavenumbers, factor) per band."""
        if ("bands", n) not in self._kept:
            edges = np.ceil(self.band_edge_wavenumber * 2 * n_wavenumbers - 1e-9).astype(int) - 1
            edges[0], edges[-1] = (
                0,
                n_wavenumbers,
            )  # the first band reaches down to the lowest wavenumber
            rows = list(self.band_correlation)
            if self.trend_variance is not None:
                # Undulations slower than three quarters of a cycle per block are its trend.
                edges = np.insert(edges, 1, int(0.75 * n_wavenumbers / (self.psd.shape[2] - 1)))
                rows.insert(0, self.trend_correlation)
            factors = [correlation_factor(row, n) for row in rows]
            self._kept["bands", n] = [
                (slice(*edges[i : i + 2]), factor) for i, factor in enumerate(factors)
            ]
        return self._kept["bands", n]


def prepare(
    statistics,
    n_range_lines,
    *,
    n_layers=None,
    correlation="measured",
    first_slab=None,
    surface=None,
    nonstationary=None,
    radiometry="constant",
):
    """Make flight statistics ready to draw many scenes.

    Parameters
    ----------
    statistics : xarray.Dataset
        Of `snowsim.statistics.fit`.
    n_range_lines : int
    n_layers : "measured" or (int, int), optional
        Layers below the surface: as many as in the flight's zone, or evenly between fewest and
        most. By default measured if the statistics hold it, which those of version 0.1 do not, else
        the paper's (5, 40).
    correlation : {"measured", "none"}
        Whether thickness of different slabs is correlated as in the flight, or only through slab 0
        as in the paper.
    first_slab : {"measured", "uniform"}, optional
        Mean thickness of slab 0: as in the flight, or evenly over its range as in the paper;
        default as of `n_layers`.
    surface : {"measured", "flat"}, optional
        Default as of `n_layers`.
    nonstationary : Nonstationary, optional
        Trends and folds; by default none, as in the paper.
    radiometry : {"constant", "measured"}
        Whether powers vary by scene and labels end at the deepest visible layer: see
        `add_radiometry`.

    Returns
    -------
    LabelModel

    Raises
    ------
    ValueError
        If statistics are missing or not finite, a scene is narrower than 2 lines, a range is empty,
        a choice unknown.
    """
    if n_range_lines < 2:
        msg = f"a scene needs at least 2 range lines, got {n_range_lines}"
        raise ValueError(msg)
    released = "n_blocks_by_layers" not in statistics  # by version 0.1
    n_layers = n_layers or (N_LAYERS if released else "measured")
    first_slab = first_slab or ("uniform" if released else "measured")
    surface = surface or ("measured" if "surface_psd" in statistics else "flat")
    if n_layers != "measured" and (
        isinstance(n_layers, str) or not 1 <= n_layers[0] <= n_layers[1]
    ):
        msg = f"n_layers must be measured or two counts in order, from 1, got {n_layers}"
        raise ValueError(msg)
    choices = (
        ("correlation", correlation, "none"),
        ("first_slab", first_slab, "uniform"),
        ("surface", surface, "flat"),
    )
    choices += (("radiometry", radiometry, "constant"),)
    for name, value, other in choices:
        check_choice(name, value, ("measured", other))
    # In the paper, slabs correlate only through slab 0.
    alone, correlated = np.array([1.0, 0.0]), correlation == "measured"
    trends = "thickness_trend_variance_bins2" in statistics

    def measured(choice, name, *dims, other=None):
        return values_of(statistics, name, dims) if choice else other

    by_layers = measured(n_layers == "measured", "n_blocks_by_layers", "zone", "n_layers")
    if by_layers is not None and not by_layers[:, 1:].any():
        msg = (
            "flight statistics: n_blocks_by_layers must hold a block with a layer below the surface"
        )
        raise ValueError(msg)
    rough = surface == "measured"
    spectra = {
        name: measured(rough, name, "wavenumber")
        for name in ("surface_psd", "surface_movement_psd")
    }
    spectra |= {
        name: measured(rough, name) for name in ("surface_trend_variance_bins2", "surface_fraction")
    }
    return LabelModel(
        n_range_lines=n_range_lines,
        n_layers=None if n_layers == "measured" else tuple(n_layers),
        zone_edge_bins=values_of(statistics, "zone_edge_bins", ("edge",)),
        relative_mean=values_of(statistics, "relative_thickness_mean", ("zone", "slab")),
        relative_deviation=np.sqrt(
            values_of(statistics, "relative_thickness_variance", ("zone", "slab"))
        ),
        psd=values_of(statistics, "thickness_psd", ("zone", "slab", "wavenumber")),
        relative_correlation=measured(
            correlated, "relative_thickness_correlation", "separation", other=alone
        ),
        band_correlation=measured(
            correlated, "thickness_correlation", "band", "separation", other=alone[None]
        ),
        band_edge_wavenumber=measured(
            correlated, "band_edge_wavenumber", "band_edge", other=np.array([0, 0.5])
        ),
        blocks_by_layers=by_layers,
        share_without_layers=statistics.attrs.get("n_blocks_without_layers", 0)
        / statistics.attrs.get("n_blocks", 1),
        first_quantile_bins=measured(
            first_slab == "measured", "first_thickness_quantile_bins", "quantile"
        ),
        trend_variance=measured(trends, "thickness_trend_variance_bins2", "zone", "slab"),
        trend_correlation=measured(trends, "trend_correlation", "separation")
        if correlated
        else alone,
        surface=spectra if rough else None,
        nonstationary=nonstationary or Nonstationary(),
        radiometry=radiometry_model(statistics) if radiometry == "measured" else None,
    )
