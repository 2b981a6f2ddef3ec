"""Statistics of another climate and radar, drawn within stated ranges about those of a flight."""

from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from snowsim.echogram import check_choice
from snowsim.limits import check_statistics
from snowsim.seeding import generator

# A statistic grows with this power of the factor of thickness, or (below) of pulse length.
OF_THICKNESS = {
    "zone_edge_bins": 1,
    "first_thickness_quantile_bins": 1,
    "thickness_mean_bins": 1,
    "thickness_variance_bins2": 2,
    "relief_variance_bins2": 2,
    "slab_change_bins2": 2,
    "thickness_psd": 2,
    "further_spacing_bins": 1,
}
# Statistics that only one of the two estimators gives.
OF_ONE_ESTIMATOR = ("relief_variance_bins2", "slab_change_bins2", "thickness_psd")
OF_PULSE_LENGTH = {
    "variance_bins2": 2,
    "width_bins": 1,
    "decay_rate": -1,
}
# Ranges whose values are uniform in the logarithm.
LOG_UNIFORM = ("thickness", "pulse_length", "n_looks", "tail_length", "line_spacing", "bin_size")


@dataclass(frozen=True)
class Ranges:
    """Ranges (least, most) within which `varied` draws.

    Attributes
    ----------
    thickness : (float, float)
        Factor of every thickness, log-uniform.
    pulse_length : (float, float)
        Factor of the length of the waveform and its tail, log-uniform.
    noise_db : (float, float)
        Change of the noise [dB].
    background_db : (float, float)
        Change of the power of unpicked snow [dB].
    line_gain_spread_db : (float, float)
        Standard deviation of gain from range line to range line [dB].
    n_looks : (float, float)
        Looks, log-uniform.
    correlated_share : float
        Probability that speckle is correlated down range as in the flight; else bins are
        independent.
    crusts_per_slab, crust_db, bands_per_100_bins, band_db : (float, float)
        Crusts between two layers, their mean number and median power over that of the layer below
        [dB]; bands of coherent noise, the same of their mean power over the noise [dB].
    tail_length : (float, float)
        Factor of the length of the tail alone, log-uniform: it grows with height over the snow.
    line_spacing : (float, float)
        Factor of the distance between range lines, log-uniform, at least 1.
    bin_size : (float, float)
        Range bins that scenes are drawn in, of those that they are resampled to, log-uniform.
    """

    thickness: tuple = (0.4, 2.8)
    pulse_length: tuple = (0.7, 2.5)
    noise_db: tuple = (-4.0, 8.0)
    background_db: tuple = (-5.0, 3.0)
    line_gain_spread_db: tuple = (0.0, 1.2)
    n_looks: tuple = (4.0, 40.0)
    correlated_share: float = 0.5
    crusts_per_slab: tuple = (0.0, 2.0)
    crust_db: tuple = (-16.0, -6.0)
    bands_per_100_bins: tuple = (0.0, 1.5)
    band_db: tuple = (-10.0, 2.0)
    tail_length: tuple = (0.7, 3.0)
    line_spacing: tuple = (1.0, 2.0)
    bin_size: tuple = (0.5, 1.0)


@dataclass(frozen=True)
class Variation:
    """One draw from `Ranges`: the changes of climate and radar from those of the flight.

    Crusts, bands, and distances of range lines and bins are in no statistic; whoever draws scenes
    applies them.
    """

    thickness: float = 1.0
    pulse_length: float = 1.0
    noise_db: float = 0.0
    background_db: float = 0.0
    line_gain_spread_db: float | None = None  # None: the flight's
    n_looks: float | None = None  # None: the flight's
    correlated: bool = True
    crusts_per_slab: float = 0.0
    crust_db: float = 0.0
    bands_per_100_bins: float = 0.0
    band_db: float = 0.0
    tail_length: float = 1.0
    line_spacing: float = 1.0
    bin_size: float = 1.0

    @classmethod
    def draw(cls, ranges, *, rng):
        """One draw of independent values."""
        drawn = {}
        for name, bounds in asdict(ranges).items():
            if name == "correlated_share":
                drawn["correlated"] = bool(rng.uniform() < bounds)
            elif name in LOG_UNIFORM:
                drawn[name] = float(np.exp(rng.uniform(*np.log(bounds))))
            else:
                drawn[name] = rng.uniform(*bounds)
        return cls(**drawn)


def varied(
    statistics: xr.Dataset, *, rng: int | np.random.Generator, ranges: "Ranges | None" = None
) -> xr.Dataset:
    """Statistics of another climate and radar, drawn about those of a flight.

    Drawn are thickness of snow, lengths of pulse and tail, noise, power of unpicked snow, gain from
    line to line, looks, size of range bins, and whether speckle is correlated; see `Ranges`. What
    no statistic holds is drawn, too, and stands in the attributes alone: crusts, bands of noise,
    and the distance of range lines. What label sets and PHY read changes consistently: a factor of
    thickness moves means, zones and relief alike. Neglected: numbers of layers, powers of layers
    relative to the surface stay the flight's, and so do, in range bins, the depths over which the
    power of unpicked snow falls and the movement of the surface.
    Correlation of speckle follows the size of bins, not the pulse. Statistics that nothing is drawn
    from, as measured waveforms, stay, too.

    Parameters
    ----------
    statistics : xarray.Dataset
        Statistics as from `fit`.
    rng : int or numpy.random.Generator
    ranges : Ranges, optional

    Returns
    -------
    xarray.Dataset
        The same variables; attributes ``varied_thickness``, ``varied_noise_db`` and so on say what
        was drawn.

    Raises
    ------
    ValueError
        If the statistics lack thickness, waveforms or noise, or are of an earlier version.

    Examples
    --------
    >>> import numpy as np
    >>> from snowsim.front import REFERENCE
    >>> from snowsim.io.files import read_dataset
    >>> flight = read_dataset(REFERENCE)
    >>> other = varied(flight, rng=np.random.default_rng(1))
    >>> ratio = other["zone_edge_bins"] / flight["zone_edge_bins"] * other.attrs["varied_bin_size"]
    >>> bool(np.allclose(ratio, other.attrs["varied_thickness"]))
    True
    """
    return changed(statistics, Variation.draw(ranges or Ranges(), rng=generator(rng)))


def changed(statistics, variation):
    """Statistics of a flight changed by a `Variation`; ValueError where they lack what changes."""
    check_statistics(statistics)
    thickness = variation.thickness / variation.bin_size
    pulse_length = variation.pulse_length / variation.bin_size
    factors = {name: thickness**power for name, power in OF_THICKNESS.items()}
    factors |= {name: pulse_length**power for name, power in OF_PULSE_LENGTH.items()}
    factors["decay_rate"] /= variation.tail_length
    factors["noise_power"] = 10 ** (variation.noise_db / 10)
    factors["background_power"] = 10 ** (variation.background_db / 10)
    other = statistics.copy()
    for name, factor in factors.items():
        if name in OF_ONE_ESTIMATOR and name not in statistics:
            continue
        check_choice("a flight statistic", name, list(map(str, statistics.variables)))
        other[name].data = statistics[name].values * factor
    # Statistics of images hold neither gain nor correlation.
    if variation.line_gain_spread_db is not None and "line_gain_spread_db" in statistics:
        other["line_gain_spread_db"].data = np.array(variation.line_gain_spread_db)
    if "speckle_correlation" in statistics:
        correlation = statistics["speckle_correlation"].values
        lag = np.arange(correlation.size)
        of_bins = np.interp(lag * variation.bin_size, lag, correlation)
        # Without correlation a bin is correlated with itself alone.
        other["speckle_correlation"].data = of_bins if variation.correlated else 1.0 * (lag == 0)
    for name, value in asdict(variation).items():
        # Files hold no booleans.
        number = int(value) if isinstance(value, bool) else value
        other.attrs[f"varied_{name}"] = "flight" if value is None else number
    if variation.n_looks is not None:
        other.attrs["n_looks"] = variation.n_looks
    return other
