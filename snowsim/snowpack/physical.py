"""Radars and snow in physical units, and the terms of eq. (1) that follow from them."""

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import get_window

from snowsim.constants import (
    ICE_DENSITY_KG_M3,
    SPEED_OF_LIGHT_M_S,
    WATER_DENSITY_KG_M3,
)
from snowsim.echogram import check_choice
from snowsim.limits import check_count, check_values
from snowsim.snowpack.along_track import draw_along_track
from snowsim.snowpack.firn import (
    density_herron_langway80,
    depth_herron_langway80,
    refractive_index_kovacs95,
    travel_time_s,
)
from snowsim.snowpack.profile import Sweep, combine, interfaces

# Least share of the sweep that a window uses; a narrower window would have too few samples.
LEAST_SHARE_OF_SWEEP = 0.05
N_FREQUENCIES = 4096  # of the window's integrals; more change them by less than 1e-3
# Of these frequencies, the 32 that a profile's echoes are summed over.
COMBINED_FREQUENCIES = slice(64, None, 128)
TAIL_DB = 15.0  # an exponential replaces the tail of an echo over this fall of power
MOST_LAGS = 16  # of correlated speckle, as PHY draws it
# Range cells in a range bin; with 1.5, a peak midway between two bins is 8 dB low in both.
MOST_CELLS = 1.5
# Loss to reflections above, from which on multiples, which are neglected, would add 1 dB.
MOST_LOST_DB = 4.0
# Limits of radars. Those in hertz refuse numbers in GHz.
RADAR_LIMITS = {"centre_hz": (1e6,), "bandwidth_hz": (1e6,), "beamwidth_deg": (0, 120)}
# Limits of density, which refuse numbers in g cm-3.
LAYER_DENSITIES_KG_M3 = (1.0, ICE_DENSITY_KG_M3)
MOST_ROUGHNESS_M = 1.0  # refuses centimetres; sastrugi within a footprint are decimetres
FAR_SURFACE_M = 0.1  # mean depth of the surface from which on it may be another interface
# Variations along track, as in the reference flight.
DRIFT_SD = 0.1  # standard deviation of the logarithm of a year's accumulation along track
DRIFT_LENGTH_M = 3000.0  # correlation length of that accumulation
DENSITY_LENGTH_M = 900.0  # correlation length of density
# Limits of climates, far beyond those where dry snow is known. Outside them firn is ice, or layers
# vanish, by rounding.
CLIMATE_LIMITS = {
    "accumulation_m": (0.001, 10),
    "variability": (0, 2),
    "n_years": (1, 1000),
    "temperature_k": (200, 273.15),
    "surface_density_kg_m3": (50, 549),
    "density_sd_kg_m3": (0, 200),
}


@dataclass(frozen=True, kw_only=True)
class Radar:
    """An airborne radar that looks straight down; `preset` returns radars in use.

    ValueError if a number is not positive, bins are so short that speckle is correlated over 16 of
    them, or bins are longer than 1.5 range cells.

    Attributes
    ----------
    centre_hz, bandwidth_hz : float
        Centre and bandwidth of the processed sweep [Hz].
    bin_s : float
        Two-way travel time of a range bin [s].
    window : str or tuple
        Window of the sweep, as `scipy.signal.get_window` names it.
    widening : float
        Width of the range response, divided by that of the window.
    height_m : float
        Height of the antenna above the snow [m].
    beamwidth_deg : float
        Two-sided 3 dB width of the Gaussian beam, below 120 [degrees].
    n_looks : float
        Number of looks averaged into a range line.
    line_spacing_m : float
        Distance between range lines [m].
    surface_to_noise_db : float
        Peak of the mean surface echo over the noise [dB].
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
        for name, value in vars(self).items():
            if name != "window":
                what = f"radar: {name}" + " in hertz" * name.endswith("_hz")
                check_values(what, value, *RADAR_LIMITS.get(name, (0,)), above=True, number=True)
        used = self.widening / (self.cell_s * self.bandwidth_hz)
        together = {
            # The sweep begins above 0 Hz.
            "bandwidth_hz": (self.bandwidth_hz, 0, np.nextafter(2 * self.centre_hz, 0)),
            f"share of the sweep that window {self.window} uses": (used, LEAST_SHARE_OF_SWEEP),
            f"bin_s, up to {MOST_CELLS:g} range cells,": (self.bin_s, 0, MOST_CELLS * self.cell_s),
        }
        for what, within in together.items():
            check_values(f"radar: {what}", *within)
        self.speckle_correlation()

    def __repr__(self):
        sweep = f"{self.bandwidth_hz / 1e9:g} GHz about {self.centre_hz / 1e9:g} GHz"
        samples = f"{self.window} window, bins of {1e9 * self.bin_s:g} ns, {self.n_looks:g} looks"
        return f"Radar({sweep}, {samples}, {self.height_m:g} m above the snow)"

    @classmethod
    def preset(cls, name, **changes):
        """One of `PRESETS` with changes; ValueError that lists their names for any other name."""
        check_choice("radar", name, PRESETS)
        return replace(PRESETS[name], **changes)

    def _weight(self):
        """The window over the sweep, (`N_FREQUENCIES`,)."""
        # Windows are periodic, as for transforms; Kaiser-Bessel's exists only as symmetric.
        name = self.window if isinstance(self.window, str) else self.window[0]
        return get_window(self.window, N_FREQUENCIES, fftbins=name != "kaiser_bessel_derived")

    def _offsets_hz(self):
        """Frequencies of the range response about the centre, (`N_FREQUENCIES`,) [Hz]."""
        place = np.arange(N_FREQUENCIES) / N_FREQUENCIES - 0.5
        return place * self.bandwidth_hz / self.widening

    @property
    def cell_s(self):
        """Range cell [s]: the equivalent width of the range response in power.

        ``mean(w^2) / mean(w)^2 / B``, Hann 1.5 / B: Harris (1978), Proc. IEEE 66, 51-83.
        """
        weight = self._weight()
        widened = self.widening * (weight**2).mean() / weight.mean() ** 2
        return float(widened / self.bandwidth_hz)

    @property
    def sweep(self):
        """Frequencies of the range response's band, as `snowsim.snowpack.combine` takes them."""
        frequency_hz = self.centre_hz + self._offsets_hz()
        return Sweep(
            frequency_hz[COMBINED_FREQUENCIES], self._weight()[COMBINED_FREQUENCIES], self.cell_s
        )

    def tail(self, slope, height_m):
        """Decay rate [1/s] of the echo off Gaussian slopes, and the share of it within the beam.

        A pulse lights up annuli with the power ``G^2 exp(-tan^2 / 2 s^2) / (cos^4 R^3)``, where
        ``cos = H / R, R = H + c t / 2``: Brown (1977), IEEE Trans. Antennas Propag. 25, 67-74, and
        geometric optics. An exponential replaces it, its chord over about `TAIL_DB`; at nadir the
        rate is ``(c / H) (8 ln 2 / beam^2 + 1 / 2 s^2 - 1/2)``. Diffuse scattering is neglected.
        Over 20 dB the error of the exponential is 0.01 dB on slopes of 0.03, and 0.7 dB on slopes
        of 0.5, where the beam of 40 degrees limits the echo.
        """
        beam = 8 * np.log(2) / np.radians(self.beamwidth_deg) ** 2
        facets = 1 / (2 * np.square(slope, dtype=float))
        nadir_rate = SPEED_OF_LIGHT_M_S / height_m * (beam + facets - 0.5)
        fall_s = TAIL_DB * np.log(10) / 10 / nadir_rate
        stretch = 1 + SPEED_OF_LIGHT_M_S * fall_s / (2 * height_m)
        fallen = beam * np.arccos(1 / stretch) ** 2 + facets * (stretch**2 - 1) - np.log(stretch)
        return fallen / fall_s, facets / (beam + facets)

    def speckle_correlation(self):
        """Autocorrelation of the power of many equal scatterers, (lag,).

        It is the squared transform of w^2.
        """
        weight = self._weight() ** 2
        phase = np.outer(np.arange(MOST_LAGS + 1), self._offsets_hz())
        turn = np.exp(2j * np.pi * self.bin_s * phase)
        power = np.abs(turn @ weight / weight.sum()) ** 2
        power /= power[0]  # 1 but for rounding
        held = np.trim_zeros(np.where(power > 0.01, power, 0), "b")
        if held.size > MOST_LAGS:
            longer_s = 0.72 / self.bandwidth_hz
            msg = (
                f"radar: bin_s must be longer, such as {longer_s:g} s, got {self.bin_s:g} s: "
                f"speckle is alike over {MOST_LAGS} bins"
            )
            raise ValueError(msg)
        return held


def _sweep(start_hz, stop_hz, bin_s=None, **others):
    """`Radar` of a sweep; by default a bin is half the 3 dB width of its Hann window, 1.44 / B."""
    width_hz = stop_hz - start_hz
    bin_s = bin_s or 0.72 / width_hz
    return Radar(centre_hz=start_hz + width_hz / 2, bandwidth_hz=width_hz, bin_s=bin_s, **others)


# The height of 500 m is the nominal one of Operation IceBridge. The beam of 40 degrees, 5 looks,
# 5.2 m and 27 dB are those of workflow/reference/settings.py. No published beam was at hand; on
# slopes of 0.03 the beam makes 2 % of the decay.
PRESETS = {
    # Sweep: Table I of Yari et al. (2021), IEEE JSTARS 14; bins: product of 2016, 1.30 cm of air.
    "snow-2-8": _sweep(2e9, 8e9, bin_s=8.67e-11),
    # Sweep: 2012_Greenland_P3 parameter sheet of the radar's group; bins: product of 2012;
    # widening: sea ice 2016.
    "snow-2012": _sweep(2.30016e9, 7.449984e9, bin_s=2.886e-10, widening=1.15),
    # Sweep: the maker's page, cresis.ku.edu/snow-radar.
    "snow-2-18": _sweep(2e9, 18e9),
    # Sweep: Open Polar Radar, processing notes of 2024_Antarctica_TOdtu.
    "ku-12-18": _sweep(12e9, 18e9),
    # Sweep: Rodriguez-Morales et al. (2014), IEEE Trans. Geosci. Remote Sens. 52, 2824-2842.
    "accumulation": _sweep(0.6e9, 0.9e9),
}


@dataclass(frozen=True, eq=False)
class Snowpack:
    """Layers of dry snow below its surface.

    Depths that do not increase and values out of range are refused. Speckle is fully developed at
    any roughness, also at 0: specular echoes of smooth surfaces are not simulated.

    Attributes
    ----------
    depth_m : array_like, (layer,) or (layer, range_line)
        Depth of interfaces below the level of the mean surface [m], the surface first, at 0 or at
        its own height, down positive.
    density_kg_m3 : array_like, (layer,) or (layer, range_line)
        Density of the snow below each interface [kg m-3], at most that of ice.
    roughness_m : array_like, (layer,) or ()
        Standard deviation of the height of an interface within a footprint [m].
    slope : array_like, (layer,) or ()
        Rms slope of an interface along one axis as seen from the air, in (0, 1].
    attenuation_db_m : float
        Two-way attenuation [dB/m], beside the reflections at interfaces.
    coherent : bool, optional
        Whether interfaces within a range cell of each other add in amplitude, as those of one
        measured profile do, or in power, as they do on average if their distances vary along track.
        By default they add in power, with a warning if there are such interfaces. They add in
        amplitude on a single range line only.
    """

    depth_m: np.ndarray
    density_kg_m3: np.ndarray
    roughness_m: np.ndarray = 0.02
    slope: np.ndarray = 0.03
    attenuation_db_m: float = 0.0
    coherent: bool | None = None

    def __post_init__(self):
        names = [name for name in vars(self) if name != "coherent"]
        held = {name: _as_floats(name, getattr(self, name)) for name in names}
        for name in ("depth_m", "density_kg_m3"):
            if held[name].ndim == 1:
                held[name] = held[name][:, None]
        shapes = [held[name].shape for name in ("depth_m", "density_kg_m3")]
        try:
            shape = np.broadcast_shapes(*shapes)
        except ValueError:
            msg = (
                "snowpack: depth_m and density_kg_m3 must be of the same layers (and range lines), "
                f"got {shapes[0]} and {shapes[1]}"
            )
            raise ValueError(msg) from None
        limits = {
            "depth_m": (shape, ()),
            "density_kg_m3": (shape, LAYER_DENSITIES_KG_M3),
            "roughness_m": (shape[:1], (0, MOST_ROUGHNESS_M)),
            "slope": (shape[:1], (np.finfo(float).tiny, 1)),
            "attenuation_db_m": ((), (0,)),
        }
        for name, (to, within) in limits.items():
            try:
                value = np.broadcast_to(held[name], to)
            except ValueError:
                msg = f"snowpack: {name} must fit {to}, of the layers, got {held[name].shape}"
                raise ValueError(msg) from None
            check_values(f"snowpack: {name}", value, *within)
            object.__setattr__(self, name, value)
        what = "snowpack: depth_m must increase with layer: its steps"
        check_values(what, np.diff(self.depth_m, axis=0), 0, above=True)
        surface_m = self.depth_m[0].mean()
        if abs(surface_m) > FAR_SURFACE_M:
            msg = (
                f"snowpack: depth_m begins {surface_m:.3g} m below the mean surface, as a mean "
                "over range lines: is the surface, at 0, left out? Its first row is the surface"
            )
            warnings.warn(msg, UserWarning, stacklevel=3)
        if self.coherent and shape[1] > 1:
            msg = (
                "snowpack: depth_m must be of one range line where interfaces add in amplitude, "
                f"got {shape[1]}: coherent=False adds them in power"
            )
            raise ValueError(msg)

    @classmethod
    def from_profile(cls, depth_m, density_kg_m3, *, thickness_m=None, **others):
        """Snowpack of a measured profile: that of a pit, a core or a penetrometer.

        Steps may be a millimetre to decimetres. Interfaces stay as measured; a radar combines those
        within a range cell, see `snowsim.snowpack.combine`.

        Parameters
        ----------
        depth_m : array_like, (sample,)
            Depth of the middle of every sample [m], increasing, from 0 on.
        density_kg_m3 : array_like, (sample,)
            Density of every sample [kg m-3]; leave samples without a density out.
        thickness_m : array_like, (sample,), optional
            Thickness of every sample [m]. By default, and across gaps, samples reach half-way to
            their neighbours. The first sample reaches up to the surface, and the snow of the last
            one goes on below.
        others
            Other attributes of `Snowpack`.
        """
        given = {"depth_m": depth_m, "density_kg_m3": density_kg_m3, "thickness_m": thickness_m}
        given = {
            name: _as_floats(name, value) for name, value in given.items() if value is not None
        }
        return cls(*interfaces(**given), coherent=True, **others)

    def __repr__(self):
        n_layers, n_lines = self.depth_m.shape
        depth = f"{n_layers} layers down to {self.depth_m.max():.4g} m"
        density = f"{self.density_kg_m3.min():.4g} to {self.density_kg_m3.max():.4g} kg m-3"
        return f"Snowpack({depth}, {density}, range lines: {n_lines})"


def _as_floats(name, value):
    """A copy of values as floats, NaN where masked; ValueError if they are no numbers or none."""
    try:
        filled = np.ma.filled(np.ma.array(value, dtype=float, copy=True), np.nan)
        _ = filled.flat[0]
        return filled
    except (TypeError, ValueError, IndexError):
        msg = f"snowpack: {name} must be numbers, got {value!r}"
        raise ValueError(msg) from None


@dataclass(frozen=True, kw_only=True)
class Climate:
    """Climate from which annual layers of dry snow are drawn; ValueError outside these limits.

    Attributes
    ----------
    accumulation_m : float
        Mean accumulation [m w.e. / yr], 0.001 to 10.
    variability : float
        Standard deviation of the logarithm of accumulation from year to year, at most 2; 0.17 to
        0.28 in cores. It is the same all along the track; drift of the snow, 0.1, which changes
        every 3 km, adds to it in squares.
    n_years : int
        Number of annual layers, at most 1000.
    temperature_k : float
        Annual mean temperature, 200 to 273.15 [K]; by default that of Summit, Greenland.
    surface_density_kg_m3 : float
        Density at the surface, 50 to 549 [kg m-3].
    density_sd_kg_m3 : float
        Standard deviation of density about the mean, at most 200 [kg m-3]; 18 to 39 in cores.
    """

    accumulation_m: float
    variability: float = 0.2
    n_years: int = 20
    temperature_k: float = 243.0
    surface_density_kg_m3: float = 340.0
    density_sd_kg_m3: float = 30.0

    def __post_init__(self):
        for name, (low, high) in CLIMATE_LIMITS.items():
            check_values(f"climate: {name}", getattr(self, name), low, high, number=True)
        check_count("climate: n_years", self.n_years)

    def draw(self, n_range_lines, line_spacing_m, *, rng, first_year=1.0):
        """`Snowpack` of annual layers below a flat surface.

        Depth and mean density follow Herron & Langway (1980). Only the share `first_year` of the
        uppermost year's snow has fallen yet.
        """
        firn = (self.accumulation_m, self.temperature_k, self.surface_density_kg_m3)
        drift_lines = DRIFT_LENGTH_M / line_spacing_m
        drift = draw_along_track(self.n_years, n_range_lines, drift_lines, rng=rng)
        logs = self.variability * rng.standard_normal((self.n_years, 1)) + DRIFT_SD * drift
        half_variance = (self.variability**2 + DRIFT_SD**2) / 2
        year_m = self.accumulation_m * np.exp(logs - half_variance)
        year_m[0] *= first_year
        water_m = np.cumsum(np.r_[np.zeros((1, n_range_lines)), year_m], axis=0)
        middle_m = water_m.copy()
        middle_m[:-1] = (water_m[:-1] + water_m[1:]) / 2
        share = density_herron_langway80(middle_m, *firn) / ICE_DENSITY_KG_M3
        density_lines = DENSITY_LENGTH_M / line_spacing_m
        anomaly = draw_along_track(self.n_years + 1, n_range_lines, density_lines, rng=rng)
        # Logits give the standard deviation at the top, and keep density between 0 and that of ice.
        width = self.density_sd_kg_m3 / ICE_DENSITY_KG_M3 / (share[0] * (1 - share[0]))
        density = ICE_DENSITY_KG_M3 / (1 + (1 - share) / share * np.exp(-width * anomaly))
        # The accumulation of years varies along track, and so do distances between interfaces.
        return Snowpack(depth_herron_langway80(water_m, *firn), density, coherent=False)


def physical_parameters(snowpack, radar):
    """Travel times of echoes below the mean surface [s], and their parameters, as PHY takes them.

    Travel times are on (layer, range_line). The parameters are `peak_power` (layer, range_line),
    relative to a flat mirror at the radar's height, `variance_bins2` and `decay_rate` (layer,).
    They are meant for PHY's ``as_printed=True``: the Gaussian lies at the interface's own travel
    time, and width and tail lower its height.

    Interfaces are incoherent with each other, and multiples are neglected. Power follows from
    Fresnel reflection at normal incidence with ``n = 1 + 0.845 rho``, Kovacs et al. (1995), losses
    at the interfaces above, attenuation, spherical spreading, and the share of the scattered power
    within the beam. The width is that of a Gaussian of the range response's height and area, wider
    by the roughness, ``2 n r / c``. The tail is that of `Radar.tail`.
    """
    echoes = _combined(snowpack, radar) if snowpack.coherent else _one_by_one(snowpack, radar)
    depth_m = echoes.depth_m
    buried_m = depth_m - depth_m[:1]
    attenuated = 10 ** (-snowpack.attenuation_db_m * buried_m / 10)
    spread = (radar.height_m / (radar.height_m + depth_m)) ** 2

    response = (radar.cell_s / radar.bin_s) ** 2 / (2 * np.pi)
    rough_s = 2 * echoes.index_above * echoes.roughness_m / SPEED_OF_LIGHT_M_S
    variance_bins2 = response + (rough_s / radar.bin_s) ** 2
    decay_per_s, share = radar.tail(echoes.slope, radar.height_m + depth_m.mean(axis=1))
    decay_rate = decay_per_s * radar.bin_s
    height = share * decay_rate * np.sqrt(response / variance_bins2)
    power = echoes.power * (attenuated * spread) * height[:, None]
    return echoes.below_s, {
        "peak_power": power,
        "variance_bins2": variance_bins2,
        "decay_rate": decay_rate,
    }


@dataclass(frozen=True)
class _Echoes:
    """Echoes of a plane wave: delay, depth and power, (layer, range_line), and their interfaces.

    Refractive index above, roughness and slope are on (layer,).
    """

    below_s: np.ndarray
    depth_m: np.ndarray
    power: np.ndarray
    index_above: np.ndarray
    roughness_m: np.ndarray
    slope: np.ndarray


def _one_by_one(snowpack, radar):
    """`_Echoes` of interfaces that add in power."""
    index, below_s = _index_and_delay(snowpack)
    if snowpack.coherent is None:
        _warn_of_close(below_s, radar)
    reflected = _reflection(index) ** 2
    passed = np.cumprod(np.r_[np.ones_like(reflected[:1]), (1 - reflected[:-1]) ** 2], axis=0)
    return _Echoes(
        below_s=below_s,
        depth_m=snowpack.depth_m,
        power=reflected * passed,
        index_above=index[:-1].mean(axis=1),
        roughness_m=snowpack.roughness_m,
        slope=snowpack.slope,
    )


def _combined(snowpack, radar):
    """`_Echoes` of a profile whose interfaces within a range cell add in amplitude."""
    index, below_s = _index_and_delay(snowpack)
    reflection = _reflection(index)[:, 0]
    found = combine(below_s[:, 0], reflection, radar.sweep)
    depth_m = np.interp(found.delay_s, below_s[:, 0], snowpack.depth_m[:, 0])
    faint = found.lost_db > MOST_LOST_DB
    if faint.any():
        msg = (
            f"snowpack: below {depth_m[faint][0]:.3g} m more than {MOST_LOST_DB:g} dB are lost "
            "to reflections above: multiples, left out, make mean power there 1 dB or more low"
        )
        warnings.warn(msg, UserWarning, stacklevel=4)
    return _Echoes(
        below_s=found.delay_s[:, None],
        depth_m=depth_m[:, None],
        power=found.power[:, None],
        index_above=index[found.first, 0],
        roughness_m=snowpack.roughness_m[found.first],
        slope=snowpack.slope[found.first],
    )


def _index_and_delay(snowpack):
    """Refractive index, air first, and two-way travel time to every interface [s]."""
    density = snowpack.density_kg_m3
    index = refractive_index_kovacs95(np.r_[0 * density[:1], density])
    depth_m = snowpack.depth_m
    optical_m = np.r_[depth_m[:1], index[1:-1] * np.diff(depth_m, axis=0)]
    return index, 2 / SPEED_OF_LIGHT_M_S * np.cumsum(optical_m, axis=0)


def depth_and_water(snowpack, below_s):
    """Depth of echoes below the surface, `depth_m` [m], and the mass above, `water_m` [m w.e.].

    `below_s` (echo, range_line) are travel times of `physical_parameters`.
    """
    depth_m = snowpack.depth_m - snowpack.depth_m[0]
    slab_kg_m2 = snowpack.density_kg_m3[:-1] * np.diff(depth_m, axis=0)
    water_m = np.cumsum(np.r_[0 * depth_m[:1], slab_kg_m2], axis=0) / WATER_DENSITY_KG_M3
    found = {"depth_m": depth_m, "water_m": water_m}
    if not snowpack.coherent:
        return found
    # Echoes of a profile lie between its interfaces; it has one range line.
    delay_s = travel_time_s(depth_m, water_m)[:, 0]
    at_s = below_s[:, 0] - below_s[0, 0]
    return {name: np.interp(at_s, delay_s, value[:, 0])[:, None] for name, value in found.items()}


def _reflection(index):
    """Share of the field that every interface reflects."""
    above = index[:-1]
    below = index[1:]
    return (above - below) / (above + below)


def _warn_of_close(below_s, radar):
    """Warn of interfaces within a range cell whose phases do not average along track."""
    apart_s = np.diff(below_s, axis=0)
    varied = np.ptp(apart_s, axis=1) > 0.5 / radar.centre_hz
    close = (apart_s.min(axis=1, initial=np.inf) < radar.cell_s) & ~varied
    if close.any():
        msg = (
            f"snowpack: {close.sum()} interfaces lie within a range cell, "
            f"{1e9 * radar.cell_s:.2g} ns, of the one above, and add in power: "
            "coherent=True adds their fields, coherent=False keeps this without a warning"
        )
        warnings.warn(msg, UserWarning, stacklevel=4)
