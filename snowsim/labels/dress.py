"""Layers dressed with the physics of a flight: the record of echoes that PHY renders."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from snowsim.echoes import Echoes, Kind
from snowsim.echogram import check_choice
from snowsim.labels.given import values_by_layer, values_of
from snowsim.limits import check_values

CHOICES = {
    "width": ("paper", "fitted"),
    "speckle_correlation": ("measured", "none"),
    "background": ("measured", "none"),
}


@dataclass(frozen=True)
class Dress:
    """Choices that the paper leaves open or makes otherwise; ValueError for others.

    Attributes
    ----------
    width : {"fitted", "paper"}
        Variance of each layer's Gaussian: the one that fits the flight, or U(bounds), the bounds of
        the measured 1/e width taken as variances, as printed.
    width_bounds : (float, float), optional
        Those bounds [bins^2]; by default as measured in the flight.
    n_looks : float, optional
        By default the flight's.
    speckle_correlation : {"measured", "none"}
        Down range as in the flight, or independent range bins, as printed.
    background : {"measured", "none"}
        For layers without drawn powers: the flight's mean power of unpicked snow, or layers alone,
        as printed.
    """

    width: str = "fitted"
    width_bounds: tuple | None = None
    n_looks: float | None = None
    speckle_correlation: str = "measured"
    background: str = "measured"

    def __post_init__(self):
        for name, choices in CHOICES.items():
            check_choice(name, getattr(self, name), choices)
        if self.n_looks is not None:
            check_values("n_looks", self.n_looks, 1)
        if self.width_bounds is not None:
            _check_bounds("width_bounds", self.width_bounds)

    @classmethod
    def split(cls, settings):
        """`Dress` of settings of PHY, and those that are left: of `snowsim.phy.render_scene`."""
        names = {field.name for field in dataclasses.fields(cls)}
        own = {name: value for name, value in settings.items() if name in names}
        rest = {name: value for name, value in settings.items() if name not in names}
        return cls(**own), rest

    def variance_bins2(self, statistics, n_layers, *, rng):
        """Variances of the uppermost layers [bins^2], (layer,); only `paper` uses `rng`."""
        if self.width == "fitted":
            return _uppermost(statistics, "variance_bins2", n_layers)
        bounds = self.width_bounds
        if bounds is None:
            bounds = values_of(statistics, "width_bound_bins", ("bound",))
            _check_bounds("flight statistics: width_bound_bins", bounds)
        return rng.uniform(*bounds, n_layers)

    def radar(self, statistics):
        """Looks and correlation of speckle, as arguments of `Echoes`."""
        n_looks = statistics.attrs["n_looks"] if self.n_looks is None else self.n_looks
        correlation = None
        # Statistics of images, which show no air, do not hold it.
        if self.speckle_correlation == "measured" and "speckle_correlation" in statistics:
            correlation = statistics["speckle_correlation"].values
        return {"n_looks": float(n_looks), "speckle_correlation": correlation}


def dress(layer_bins, statistics, choices=None, *, rng=None):
    """Echoes of layers that come without powers, by the mean powers of a flight.

    Below the surface lies the flight's mean power of unpicked snow, one row for each e-folding
    depth. Layers deeper than the flight shows look like its deepest. Neglected: how powers vary
    from scene to scene and along track, texture, gain from line to line.

    Parameters
    ----------
    layer_bins : ndarray, (layer, range_line)
        Range bins, row 0 the surface; NaN where absent.
    statistics : xarray.Dataset
        Of `snowsim.statistics.fit`.
    choices : Dress, optional
    rng : numpy.random.Generator, optional
        Needed where widths are drawn.

    Returns
    -------
    Echoes

    Raises
    ------
    ValueError
        If statistics are missing, not finite or not positive.
    """
    choices = choices or Dress()
    n_layers = len(layer_bins)
    variance = choices.variance_bins2(statistics, n_layers, rng=rng)
    noise_power = values_of(statistics, "noise_power", ()).item()
    check_values("flight statistics: noise_power", noise_power, 0, above=True)
    power = _uppermost(statistics, "peak_power", n_layers)
    layers = Echoes(
        bins=layer_bins,
        power=np.repeat(power[:, None], layer_bins.shape[1], axis=1),
        variance_bins2=variance,
        decay_rate=_uppermost(statistics, "decay_rate", n_layers),
        kind=np.full(n_layers, Kind.LAYER, dtype=np.int8),
        noise_power=noise_power,
        **choices.radar(statistics),
    )
    # Statistics of images hold no background.
    if choices.background == "none" or "background_power" not in statistics:
        return layers
    power, fall = (statistics[name].values for name in ("background_power", "fall"))
    # Background must not cross the first layer, wherever it is picked.
    gap = np.fmin(1.0, layer_bins[1] - layer_bins[0]) if n_layers > 1 else 1.0
    return with_background(layers, power, fall, gap)


def with_background(layers, background_power, fall_bins, gap=1.0):
    """The echoes with a row within `gap` below the surface for each e-folding depth with power."""
    held = background_power > 0
    power = background_power[held]
    place = 1 + np.arange(power.size)[:, None]
    below = layers.bins[:1] + gap * place / (power.size + 1)
    rows = {
        "bins": below,
        "power": np.broadcast_to(power[:, None], below.shape),
        "variance_bins2": np.full(power.size, layers.variance_bins2[0]),
        "decay_rate": 1 / fall_bins[held],
        "kind": np.full(power.size, Kind.BACKGROUND, dtype=np.int8),
    }
    inserted = {
        name: np.concatenate([getattr(layers, name)[:1], values, getattr(layers, name)[1:]])
        for name, values in rows.items()
    }
    return dataclasses.replace(layers, **inserted)


def redress(scene, statistics, choices=None, *, rng=None):
    """Echoes of a scene by other statistics: waveforms and radar are theirs.

    Rows, powers and noise that the scene was drawn with stay; one without is dressed.
    """
    if scene.echoes is None:
        return dress(scene.layer_bins, statistics, choices, rng=rng)
    choices = choices or Dress()
    drawn = scene.echoes
    is_layer = drawn.kind != Kind.BACKGROUND
    deepest = min(len(scene.layer_bins), statistics.sizes["layer"]) - 1
    level = np.minimum(np.cumsum(is_layer) - 1, deepest)
    # Background has the surface's width.
    level[~is_layer] = 0
    n_levels = int(level.max()) + 1
    variance = choices.variance_bins2(statistics, n_levels, rng=rng)
    decay = _uppermost(statistics, "decay_rate", n_levels)[level] * drawn.decay_factor
    return dataclasses.replace(
        drawn,
        variance_bins2=variance[level],
        decay_rate=np.where(is_layer, decay, drawn.decay_rate),
        **choices.radar(statistics),
    )


def _check_bounds(name, bounds):
    check_values(name, bounds, 0, above=True)
    if np.shape(bounds) != (2,) or bounds[0] > bounds[1]:
        msg = f"{name} must be two numbers in order, got {bounds}"
        raise ValueError(msg)


def _uppermost(statistics, name, n_layers):
    """Values of the uppermost layers, (layer,); deeper than the flight shows, the last one's."""
    values = values_by_layer(statistics, name)
    return values[np.minimum(np.arange(n_layers), values.size - 1)]
