"""Draw a scene from flight statistics: number of layers, thicknesses, relief, surface, echoes."""

from dataclasses import dataclass

import numpy as np

from snowsim.echogram import SURFACE_ROW, Scene, scene_height, zone_of
from snowsim.labels.echoes import PowerModel, add_echoes, power_model, values_of
from snowsim.labels.undulations import (
    MINIMUM_THICKNESS_BINS,
    Nonstationary,
    Relief,
    draw_stationary,
    draw_undulations,
    lags_on_circle,
    layers_below,
    mirrored,
)
from snowsim.limits import check_count, check_statistics, check_values
from snowsim.seeding import generator

RELIEF = (
    "relief_variance_bins2",
    "relief_length_m",
    "relief_exponent",
    "slab_change_bins2",
    "slab_exponent",
)  # in the order of `Relief`
SURFACE = (
    "surface_error_bins",
    "surface_error_length_m",
    "surface_movement_bins",
    "surface_movement_length_m",
)


@dataclass(frozen=True, eq=False)
class LabelModel:
    """Flight statistics made ready to draw many scenes of one width; see `prepare`."""

    n_range_lines: int
    spacing_m: float  # distance between range lines
    zone_edge_bins: np.ndarray  # (edge,)
    first_quantile_bins: np.ndarray  # thickness of slab 0, at even probabilities from 0 to 1
    blocks_by_layers: np.ndarray  # number of blocks with 0, 1, 2 ... layers, (zone, n_layers)
    share_without_layers: float  # share of blocks without layers, which belong to no zone
    relative_mean: np.ndarray  # mean of thickness over that of slab 0, (zone, slab)
    relative_deviation: np.ndarray  # standard deviation of that ratio, (zone, slab)
    relief: tuple  # `Relief` of each zone
    surface: tuple  # values of the statistics named in `SURFACE`
    powers: PowerModel
    nonstationary: Nonstationary

    def draw_n_layers(self, zone, *, rng):
        """Draw the number of layers below the surface as in the blocks of the zone.

        Zero is as frequent as in the whole flight. Numbers between those observed are interpolated
        in the logarithm between mid-quantiles (Parzen 2004, Statist. Sci. 19, 652). A zone without
        layers uses the blocks of all zones.
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

    def draw_means(self, zone, first_bins, n_slabs, *, rng):
        """Mean thickness of slabs [bins], (slab,); those below the flight's last follow its law."""
        slab = np.minimum(np.arange(n_slabs), self.relative_mean.shape[1] - 1)
        anomaly = rng.standard_normal(n_slabs)
        relative = self.relative_mean[zone, slab] + self.relative_deviation[zone, slab] * anomaly
        relative[0] = 1
        return first_bins * relative

    def draw_surface(self, *, rng):
        """Row of the surface (range_line,): a slow error, and what whole-bin levelling leaves."""
        error_bins, error_length_m, movement_bins, movement_length_m = self.surface
        slow = self._slow(error_bins, error_length_m, rng=rng)
        height = rng.uniform() + np.cumsum(self._slow(movement_bins, movement_length_m, rng=rng))
        left = height - np.rint(height) if movement_bins > 0 else 0.0
        return SURFACE_ROW + slow - slow.mean() + left

    def _slow(self, deviation, length_m, *, rng):
        """Gaussian series (range_line,) of a deviation and of Gaussian correlation."""
        lag = lags_on_circle(self.n_range_lines, length_m / self.spacing_m)
        falls = np.exp(-((lag * self.spacing_m / max(length_m, 1e-100)) ** 2))
        return draw_stationary(deviation**2 * falls[None], self.n_range_lines, rng=rng)[0]


def prepare(statistics, n_range_lines, *, nonstationary=None):
    """Make flight statistics ready to draw many scenes.

    Parameters
    ----------
    statistics : xarray.Dataset
        Statistics as from `snowsim.statistics.fit`.
    n_range_lines : int
    nonstationary : Nonstationary, optional
        Trends and folds of the layers; by default none.

    Returns
    -------
    LabelModel

    Raises
    ------
    ValueError
        If statistics are of an earlier version, missing or not finite, or a scene is narrower than
        2 lines.
    """
    check_count("n_range_lines", n_range_lines, 2)
    check_statistics(statistics)
    by_layers = values_of(statistics, "n_blocks_by_layers", ("zone", "n_layers"))
    what = "flight statistics: n_blocks_by_layers: blocks with a layer below the surface"
    check_values(what, by_layers[:, 1:].sum(), 0, above=True)
    attrs = statistics.attrs
    variance = values_of(statistics, "relative_thickness_variance", ("zone", "slab"))
    relief = np.transpose([values_of(statistics, name, ("zone",)) for name in RELIEF])
    quantiles = values_of(statistics, "first_thickness_quantile_bins", ("quantile",))
    return LabelModel(
        n_range_lines=n_range_lines,
        spacing_m=attrs["line_spacing_m"],
        zone_edge_bins=values_of(statistics, "zone_edge_bins", ("edge",)),
        first_quantile_bins=quantiles,
        blocks_by_layers=by_layers,
        share_without_layers=attrs.get("n_blocks_without_layers", 0) / attrs.get("n_blocks", 1),
        relative_mean=values_of(statistics, "relative_thickness_mean", ("zone", "slab")),
        relative_deviation=np.sqrt(variance),
        relief=tuple(Relief(*of_zone) for of_zone in relief),
        surface=tuple(values_of(statistics, name, ()).item() for name in SURFACE),
        powers=power_model(statistics),
        nonstationary=nonstationary or Nonstationary(),
    )


def draw(statistics, n_range_lines, *, rng):
    """Layers of one scene.

    Parameters
    ----------
    statistics : xarray.Dataset or LabelModel
        Statistics of `snowsim.statistics.fit`, or what `prepare` makes of them for many scenes.
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
    The steps are those of Yari et al. (2021), section V-B. The mean thickness of slab 0 is drawn
    first and fixes the zone; the mean of a deeper slab is that of slab 0 times a factor from the
    zone's Gaussian; thickness is this mean plus a Gaussian process. Three things differ from the
    paper, which `snowsim.labels.draw_paper_scene` follows throughout. Slab 0 and the number of
    layers are distributed as in the flight's blocks; the process follows the zone's relief, see
    `draw_undulations`; and the surface moves. Slabs below the flight's last follow its law. A
    thickness or a mean below 1 bin is mirrored at 1 bin.

    Examples
    --------
    >>> from snowsim.front import REFERENCE
    >>> from snowsim.io.files import read_dataset
    >>> layer_bins = draw(read_dataset(REFERENCE), 256, rng=1)
    >>> layer_bins.shape[1], round(float(layer_bins[0].mean()))
    (256, 50)
    >>> bool((np.diff(layer_bins, axis=0) >= 1).all())  # layers never share a pixel
    True
    """
    return draw_scene(statistics, n_range_lines, name="", rng=generator(rng)).layer_bins


def draw_scene(statistics, n_range_lines, *, name, rng):
    """One scene with all layers labelled, its zone, its echoes and notes.

    Returns
    -------
    snowsim.echogram.Scene
        `notes` holds `n_layers` below the surface; `n_samples`, values of thickness; `n_touched`
        and `n_means_touched`, values and means that were mirrored at 1 bin; `first_thickness_bins`,
        the mean of slab 0; and parameters of trends and folds, see `Nonstationary`.
    """
    model = statistics
    if not isinstance(statistics, LabelModel):
        model = prepare(statistics, n_range_lines)
    if model.n_range_lines != n_range_lines:
        msg = f"label model was prepared for {model.n_range_lines} range lines, got {n_range_lines}"
        raise ValueError(msg)
    probability = np.linspace(0, 1, model.first_quantile_bins.size)
    first_bins = float(np.interp(rng.uniform(), probability, model.first_quantile_bins))
    zone = int(zone_of(first_bins, model.zone_edge_bins))
    n_layers = model.draw_n_layers(zone, rng=rng)
    n_slabs = max(n_layers, 1)  # a scene without layers drops its only slab at the end
    mean = model.draw_means(zone, first_bins, n_slabs, rng=rng)
    drawn = mirrored(mean)[:, None] + draw_undulations(
        model.relief[zone], n_slabs, n_range_lines, model.spacing_m, rng=rng
    )
    drawn, bent = model.nonstationary.bend(drawn, zone, rng=rng)
    drawn = drawn[:n_layers]
    layer_bins = layers_below(model.draw_surface(rng=rng), mirrored(drawn))
    scene = Scene(
        name=name,
        n_range_bins=scene_height(layer_bins),
        layer_bins=layer_bins,
        complete_layer_bins=layer_bins,
        zone=zone,
        notes=notes_of(drawn, mean[:n_layers], first_bins) | bent,
    )
    return add_echoes(scene, model.powers, rng=rng)


def notes_of(drawn, mean, first_bins):
    """Counts for the notes of a scene, from thickness (slab, range_line) and means as drawn."""
    return {
        "n_layers": len(drawn),
        "n_samples": drawn.size,
        "n_touched": int((drawn < MINIMUM_THICKNESS_BINS).sum()),
        "n_means_touched": int((mean < MINIMUM_THICKNESS_BINS).sum()),
        "first_thickness_bins": first_bins,
    }
