"""Draw a scene from flight statistics: number of layers, thicknesses, relief, surface, echoes."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from snowsim.echogram import Scene, scene_height, zone_of
from snowsim.labels.echoes import VARIES, add_echoes, echoes_of_layers, values_of
from snowsim.labels.undulations import (
    Nonstationary,
    draw_surface,
    draw_undulations,
    layers_below,
    mirrored,
    notes_of,
)
from snowsim.limits import check_count, check_statistics, check_values
from snowsim.seeding import generator

RELIEF_STATISTICS = (
    "relief_variance_bins2",
    "relief_length_m",
    "relief_exponent",
    "slab_change_bins2",
    "slab_exponent",
)
SURFACE_STATISTICS = (
    "surface_error_bins",
    "surface_error_length_m",
    "surface_movement_bins",
    "surface_movement_length_m",
)
# Flight statistics that scenes are drawn from, with their dimensions.
DRAWN_FROM = {
    "n_blocks_by_layers": ("zone", "n_layers"),
    "zone_edge_bins": ("edge",),
    "first_thickness_quantile_bins": ("quantile",),
    "relative_thickness_mean": ("zone", "slab"),
    "relative_thickness_variance": ("zone", "slab"),
}
DRAWN_FROM |= dict.fromkeys(RELIEF_STATISTICS, ("zone",))
DRAWN_FROM |= dict.fromkeys((*SURFACE_STATISTICS, *VARIES), ())


@dataclass(frozen=True, eq=False)
class LabelModel:
    """Flight statistics made ready to draw many scenes of one width; see `prepare`."""

    n_range_lines: int
    statistics: xr.Dataset
    values: dict  # the statistics in `DRAWN_FROM` by name, and gain from line to line if known
    nonstationary: Nonstationary

    @property
    def spacing_m(self):
        """Distance between range lines [m]."""
        return self.statistics.attrs["line_spacing_m"]

    def draw_n_layers(self, zone, *, rng):
        """Number of layers below the surface, distributed as in the blocks of the zone.

        Zero is as frequent as in the whole flight. Between observed numbers the logarithm is
        interpolated between mid-quantiles (Parzen 2004, Statist. Sci. 19, 652). A zone without
        layers uses the blocks of all zones.
        """
        # Blocks without layers belong to no zone.
        attrs = self.statistics.attrs
        if rng.uniform() < attrs.get("n_blocks_without_layers", 0) / attrs.get("n_blocks", 1):
            return 0
        by_layers = self.values["n_blocks_by_layers"][:, 1:]
        counts = by_layers[zone]
        if not counts.any():
            counts = by_layers.sum(axis=0)
        seen = np.flatnonzero(counts)
        middle = (np.cumsum(counts) - counts / 2)[seen] / counts.sum()
        log_number = np.interp(rng.uniform(), middle, np.log(seen + 1))
        return int(np.rint(np.exp(log_number)))

    def draw_means(self, zone, first_bins, n_slabs, *, rng):
        """Mean thickness of slabs [bins], (slab,).

        Slabs below the flight's last are drawn as that one.
        """
        mean = self.values["relative_thickness_mean"][zone]
        deviation = np.sqrt(self.values["relative_thickness_variance"][zone])
        slab = np.minimum(np.arange(n_slabs), mean.size - 1)
        relative = mean[slab] + deviation[slab] * rng.standard_normal(n_slabs)
        relative[0] = 1
        return first_bins * relative


def prepare(
    statistics: xr.Dataset, n_range_lines: int, *, nonstationary: Nonstationary | None = None
) -> LabelModel:
    """Model from which many scenes are drawn, made of flight statistics.

    Parameters
    ----------
    statistics : xarray.Dataset
        Statistics as from `snowsim.statistics.fit`.
    n_range_lines : int
    nonstationary : Nonstationary, optional
        Trends and folds of the layers; none if left out.

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
    values = {name: values_of(statistics, name, dims) for name, dims in DRAWN_FROM.items()}
    # Statistics of images do not hold gain.
    if "line_gain_spread_db" in statistics:
        values["line_gain_spread_db"] = values_of(statistics, "line_gain_spread_db")
    what = "flight statistics: n_blocks_by_layers: blocks with a layer below the surface"
    check_values(what, values["n_blocks_by_layers"][:, 1:].sum(), 0, above=True)
    echoes_of_layers(np.zeros((1, 1)), statistics)  # refuses what every scene would
    return LabelModel(n_range_lines, statistics, values, nonstationary or Nonstationary())


def draw(
    statistics: xr.Dataset | LabelModel, n_range_lines: int, *, rng: int | np.random.Generator
) -> NDArray[np.floating]:
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


def draw_scene(
    statistics: xr.Dataset | LabelModel,
    n_range_lines: int,
    *,
    name: str,
    rng: int | np.random.Generator,
) -> Scene:
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
    values = model.values
    quantiles = values["first_thickness_quantile_bins"]
    probability = np.linspace(0, 1, quantiles.size)
    first_bins = float(np.interp(rng.uniform(), probability, quantiles))
    zone = int(zone_of(first_bins, values["zone_edge_bins"]))
    n_layers = model.draw_n_layers(zone, rng=rng)
    n_slabs = max(n_layers, 1)  # a scene without layers drops its only slab at the end
    mean = model.draw_means(zone, first_bins, n_slabs, rng=rng)
    relief = {name: values[name][zone] for name in RELIEF_STATISTICS}
    drawn = draw_undulations(relief, n_slabs, n_range_lines, model.spacing_m, rng=rng)
    drawn += mirrored(mean)[:, None]
    drawn, bent = model.nonstationary.bend(drawn, zone, rng=rng)
    drawn = drawn[:n_layers]
    surface = draw_surface(values, n_range_lines, model.spacing_m, rng=rng)
    layer_bins = layers_below(surface, mirrored(drawn))
    notes = notes_of(drawn, mean[:n_layers], first_bins) | bent
    scene = Scene(
        name=name,
        n_range_bins=scene_height(layer_bins),
        layer_bins=layer_bins,
        complete_layer_bins=layer_bins,
        zone=zone,
        notes=notes,
    )
    return add_echoes(scene, model.statistics, values, rng=rng)
