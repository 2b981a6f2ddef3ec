"""A radar: its sweep, window, height and beam, and what they make of an echo's width, its tail and its speckle."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import get_window

from snowsim.constants import SPEED_OF_LIGHT_M_S

N_FREQUENCIES = 4096  # of the window's integrals; more change them by less than 1e-3
MOST_LAGS = 16  # of correlated speckle, as PHY draws it
UNCORRELATED = 0.01  # correlation of power from which on lags are left out


@dataclass(frozen=True, kw_only=True)
class Radar:
    """An airborne radar that looks straight down.

    Parameters
    ----------
    centre_hz, bandwidth_hz : float
        Of the processed sweep [Hz].
    bin_s : float
        Two-way travel time of a range bin [s].
    window : str or tuple, optional
        Of the sweep, as `scipy.signal.get_window` names it.
    widening : float, optional
        Of the range response over that of the window [1].
    height_m : float, optional
        Antenna over the snow surface [m].
    beamwidth_deg : float, optional
        Two-sided, 3 dB, of one antenna, Gaussian, transmitting and receiving [degrees].
    n_looks : float, optional
        Independent looks averaged into a range line.
    line_spacing_m : float, optional
        Along track [m].
    surface_to_noise_db : float, optional
        Peak of the mean surface echo over thermal noise [dB].

    Raises
    ------
    ValueError
        If a value is not positive or out of range, the sweep reaches zero frequency, or bins are so fine that speckle
        is alike over more than 16 of them.
    """

    centre_hz: float
    bandwidth_hz: float
    bin_s: float
    window: str | tuple = "hann"
    widening: float = 1.0
    height_m: float = 500.0
    beamwidth_deg: float = 40.0
    n_looks: float = 5
    line_spacing_m: float = 5.2
    surface_to_noise_db: float = 27.0

    def __post_init__(self):
        limits = {"centre_hz": (0, np.inf), "bandwidth_hz": (0, 2 * self.centre_hz), "bin_s": (0, np.inf)}
        limits |= {"widening": (0, np.inf), "height_m": (0, np.inf), "beamwidth_deg": (0, 120), "n_looks": (0, np.inf)}
        limits |= {"line_spacing_m": (0, np.inf), "surface_to_noise_db": (-np.inf, np.inf)}
        for name, (low, high) in limits.items():
            if not low < getattr(self, name) < high:
                msg = f"radar: {name} must lie between {low:g} and {high:g}, got {getattr(self, name)}"
                raise ValueError(msg)
        if self._correlation()[-1] > UNCORRELATED:
            msg = f"radar: speckle must be uncorrelated over {MOST_LAGS} bins, is not: bin_s {self.bin_s:g} is too short"
            raise ValueError(msg)

    @classmethod
    def preset(cls, name, **changes):
        """One of `PRESETS`, with changes; ValueError with their names where there is none."""
        if name not in PRESETS:
            msg = f"radar must be one of {', '.join(PRESETS)}, got {name!r}"
            raise ValueError(msg)
        return replace(PRESETS[name], **changes)

    @property
    def cell_s(self):
        """Equivalent width of the range response to power [s], the range cell: 1.5 / B for a Hann window.

        ``widening * mean(w^2) / mean(w)^2 / B``: Harris (1978), Proc. IEEE 66, 51-83.
        """
        weight = get_window(self.window, N_FREQUENCIES)
        return float(self.widening * (weight**2).mean() / weight.mean() ** 2 / self.bandwidth_hz)

    def decay_per_s(self, slope, height_m):
        """Rate [1/s] at which the echo of an interface of Gaussian slopes falls behind its nadir point; broadcasts.

        ``(c / H) (8 ln 2 / beam^2 + 1 / 2 slope^2 - 1/2)``: the logarithmic slope at nadir of the annuli that a pulse
        lights up, ``G(theta)^2 exp(-tan^2 / 2 s^2) / cos^4 / R^3`` with ``cos theta = H / (H + c t / 2)``: Brown (1977),
        IEEE Trans. Antennas Propag. 25, 67-74, with geometric optics. Neglected: diffuse scattering, and that the angle
        grows slower than the root of the delay, which is 1 dB over the first 20 where the beam alone ends the tail.
        """
        beam, facets = self._narrowness(slope)
        return SPEED_OF_LIGHT_M_S / height_m * (beam + facets - 0.5)

    def beam_share(self, slope):
        """Share of a rough interface's reflected power that the beam takes in; a mirror has 1."""
        beam, facets = self._narrowness(slope)
        return facets / (beam + facets)

    def _narrowness(self, slope):
        return 8 * np.log(2) / np.radians(self.beamwidth_deg) ** 2, 1 / (2 * np.asarray(slope, dtype=float) ** 2)

    def speckle_correlation(self):
        """Autocorrelation of power down range where scatterers are many and alike, (lag,), to the last above 1 %.

        ``|integral w^2 exp(2 pi i f lag)|^2``: the field's autocorrelation is the transform of the sweep's spectrum.
        """
        correlation = self._correlation()
        return correlation[: np.flatnonzero(correlation > UNCORRELATED)[-1] + 1]

    def _correlation(self):
        weight = get_window(self.window, N_FREQUENCIES) ** 2
        frequency_hz = (np.arange(N_FREQUENCIES) / N_FREQUENCIES - 0.5) * self.bandwidth_hz / self.widening
        lag_s = np.arange(MOST_LAGS + 1) * self.bin_s
        return np.abs(np.exp(2j * np.pi * np.outer(lag_s, frequency_hz)) @ weight / weight.sum()) ** 2


def _sweep(start_hz, stop_hz, **others):
    """`Radar` of a sweep, with two bins to the 3 dB width of its Hann window, 1.44 / B, where none are given."""
    bandwidth_hz = stop_hz - start_hz
    own = {"centre_hz": (start_hz + stop_hz) / 2, "bandwidth_hz": bandwidth_hz, "bin_s": 0.72 / bandwidth_hz}
    return Radar(**own | others)


# Height 500 m: nominal of Operation IceBridge. Beam 40 degrees, 5 looks, 5.2 m and 27 dB: the reference flight's, see
# config/config.yaml; no published beam was at hand, and on slopes of 0.03 it makes 2 % of the decay.
PRESETS = {
    # Sweep: Table I of Yari et al. (2021), IEEE JSTARS 14; bins: product of 2016, 1.30 cm of air.
    "snow-2-8": _sweep(2e9, 8e9, bin_s=8.67e-11),
    # Sweep: 2012_Greenland_P3 parameter sheet of the radar's group; bins: product of 2012; widening: sea ice 2016.
    "snow-2012": _sweep(2.30016e9, 7.449984e9, bin_s=2.886e-10, widening=1.15),
    # Sweep: the maker's page, cresis.ku.edu/snow-radar.
    "snow-2-18": _sweep(2e9, 18e9),
    # Sweep: Open Polar Radar, processing notes of 2024_Antarctica_TOdtu.
    "ku-12-18": _sweep(12e9, 18e9),
    # Sweep: Rodriguez-Morales et al. (2014), IEEE Trans. Geosci. Remote Sens. 52, 2824-2842.
    "accumulation": _sweep(0.6e9, 0.9e9),
}
