"""A radar: its sweep, window, height and beam, and what they make of an echo's width, its tail and its speckle."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import get_window

from snowsim.constants import SPEED_OF_LIGHT_M_S

N_FREQUENCIES = 4096  # of the window's integrals; more change them by less than 1e-3
TAIL_DB = 15.0  # over which an exponential stands for the tail
MOST_LAGS = 16  # of correlated speckle, as PHY draws it


@dataclass(frozen=True, kw_only=True)
class Radar:
    """An airborne radar that looks straight down; `preset` has some that fly.

    Of the processed sweep `centre_hz`, `bandwidth_hz` [Hz] and `window`, as `scipy.signal.get_window` names it; two-way
    travel time of a range bin `bin_s` [s]; `widening` of the range response over the window's; antenna over the snow
    `height_m` [m]; its two-sided 3 dB beam `beamwidth_deg`, Gaussian, below 120 [degrees]; `n_looks` averaged into a
    range line; `line_spacing_m` [m]; `surface_to_noise_db`, of the peak of the mean surface echo [dB]. ValueError where
    one is not positive, or bins are so short that speckle is alike over 16 of them.
    """

    centre_hz: float
    bandwidth_hz: float
    bin_s: float
    window: str = "hann"
    widening: float = 1.0
    height_m: float = 500.0
    beamwidth_deg: float = 40.0
    n_looks: float = 5
    line_spacing_m: float = 5.2
    surface_to_noise_db: float = 27.0

    def __post_init__(self):
        most = {"bandwidth_hz": 2 * self.centre_hz, "beamwidth_deg": 120}
        for name, value in vars(self).items():
            if name != "window" and not 0 < value < most.get(name, np.inf):
                msg = f"radar: {name} must be positive and below {most.get(name, np.inf):g}, got {value}"
                raise ValueError(msg)
        self.speckle_correlation()

    @classmethod
    def preset(cls, name, **changes):
        """One of `PRESETS` with changes; ValueError with their names where there is none."""
        if name not in PRESETS:
            msg = f"radar must be one of {', '.join(PRESETS)}, got {name!r}"
            raise ValueError(msg)
        return replace(PRESETS[name], **changes)

    @property
    def cell_s(self):
        """Range cell [s]: equivalent width of the response to power, ``mean(w^2) / mean(w)^2 / B``, Hann 1.5 / B.

        Harris (1978), Proc. IEEE 66, 51-83.
        """
        weight = get_window(self.window, N_FREQUENCIES)
        return float(self.widening * (weight**2).mean() / weight.mean() ** 2 / self.bandwidth_hz)

    def tail(self, slope, height_m):
        """Decay rate [1/s] of the echo of an interface of Gaussian slopes, and the share of it that the beam takes in.

        The chord over about `TAIL_DB` of the annuli that a pulse lights up, ``G^2 exp(-tan^2 / 2 s^2) / (cos^4 R^3)``
        with ``cos = H / R, R = H + c t / 2``: Brown (1977), IEEE Trans. Antennas Propag. 25, 67-74, and geometric
        optics; at nadir ``(c / H) (8 ln 2 / beam^2 + 1 / 2 s^2 - 1/2)``. Diffuse scattering is neglected. Over 20 dB
        the annuli leave it by 0.01 dB on slopes of 0.03, by 0.7 dB where slopes of 0.5 leave it to 40 degrees.
        """
        beam, facets = 8 * np.log(2) / np.radians(self.beamwidth_deg) ** 2, 1 / (2 * np.square(slope, dtype=float))
        fall_s = TAIL_DB * np.log(10) / 10 / (SPEED_OF_LIGHT_M_S / height_m * (beam + facets - 0.5))
        stretch = 1 + SPEED_OF_LIGHT_M_S * fall_s / (2 * height_m)
        fallen = beam * np.arccos(1 / stretch) ** 2 + facets * (stretch**2 - 1) - np.log(stretch)
        return fallen / fall_s, facets / (beam + facets)

    def speckle_correlation(self):
        """Autocorrelation of power where scatterers are many and alike, (lag,): the squared transform of w^2."""
        weight = get_window(self.window, N_FREQUENCIES) ** 2
        frequency_hz = (np.arange(N_FREQUENCIES) / N_FREQUENCIES - 0.5) * self.bandwidth_hz / self.widening
        turn = np.exp(2j * np.pi * self.bin_s * np.outer(np.arange(MOST_LAGS + 1), frequency_hz))
        held = np.trim_zeros(np.where((power := np.abs(turn @ weight / weight.sum()) ** 2) > 0.01, power, 0), "b")
        if held.size > MOST_LAGS:
            msg = f"radar: bin_s must be longer, speckle is alike over {MOST_LAGS} bins of {self.bin_s:g} s"
            raise ValueError(msg)
        return held


def _sweep(start_hz, stop_hz, **others):
    """`Radar` of a sweep, with two bins to the 3 dB width of its Hann window, 1.44 / B, where none are given."""
    width_hz = stop_hz - start_hz
    return Radar(centre_hz=start_hz + width_hz / 2, bandwidth_hz=width_hz, **{"bin_s": 0.72 / width_hz} | others)


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
