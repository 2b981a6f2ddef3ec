"""Reflectors equivalent to a measured profile, whose close interfaces add in amplitude."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from snowsim.limits import check_values

# A range response ends so many times 1 / bandwidth from its peak; Hann's sidelobes are below -70 dB
# there.
RESPONSE_REACH = 10
SAMPLES_PER_CELL = 6  # samples of power in a range cell
SAMPLES_PER_GROUP = 12  # samples of power over which a group is centred
LARGEST_OVERLAP_M = 0.001  # of samples of a profile, whose depths are rounded
N_FIT_ROUNDS = 30  # 200 rounds change no cell of half a metre by 0.1 dB


@dataclass(frozen=True)
class Sweep:
    """Evenly spaced frequencies of a radar's band, their weights, and the radar's range cell."""

    frequency_hz: np.ndarray
    weight: np.ndarray
    cell_s: float

    @property
    def bandwidth_hz(self):
        """Width of the band [Hz]."""
        return self.frequency_hz.size * (self.frequency_hz[1] - self.frequency_hz[0])

    @property
    def centre_hz(self):
        """Middle of the band [Hz]."""
        return self.frequency_hz.mean()

    @property
    def step_s(self):
        """Time between samples of power [s]."""
        return self.cell_s / SAMPLES_PER_CELL

    @property
    def reach(self):
        """Number of samples from the peak of a range response to its end."""
        return int(np.ceil(RESPONSE_REACH / self.bandwidth_hz / self.step_s))


@dataclass(frozen=True)
class Reflectors:
    """At most one equivalent reflector per range cell; the powers of reflectors add.

    `first` is the number of the uppermost interface of each reflector, `delay_s` its two-way travel
    time [s], `power` its echo's power at the radar, relative to a mirror in place of the snow, and
    `reflected` the share of power that it reflects.
    """

    first: np.ndarray
    delay_s: np.ndarray
    power: np.ndarray
    reflected: np.ndarray

    @property
    def lost_db(self):
        """Two-way loss of power to the reflectors above each reflector [dB]."""
        passed = np.cumprod(np.append(1, 1 - self.reflected[:-1]))
        return -20 * np.log10(passed)


def combine(delay_s, reflection, sweep):
    """`Reflectors` whose mean power is that of a profile's interfaces added in amplitude.

    Interfaces (interface,) lie at two-way travel times [s], the surface first, and reflect a share
    of the field. Interfaces further than a range cell from both neighbours stay as they are. The
    others are grouped by range cell. The power that a group reflects, on average over the band, is
    lost to all groups below it; multiples are neglected otherwise. The sum of all fields gives mean
    power against travel time. The powers of the groups are fitted to it by multiplicative updates,
    which keep them positive: Richardson (1972), J. Opt. Soc. Am. 62, 55-59; Lucy (1974), Astron. J.
    79, 745-754. ValueError if travel times fall or the surface reflects nothing.
    """
    delay_s, reflection = (np.asarray(values, dtype=float) for values in (delay_s, reflection))
    if delay_s.ndim != 1 or delay_s.shape != reflection.shape or not reflection[:1].any():
        msg = (
            "delay_s and reflection must be of one size (interface,), the surface's not 0, "
            f"got shapes {delay_s.shape} and {reflection.shape}, {reflection[:1]} of the surface"
        )
        raise ValueError(msg)
    check_values("delay_s must not fall: its steps", np.diff(delay_s), 0)
    interfaces = np.flatnonzero(reflection)
    surface_s = delay_s[0]
    delay_s = delay_s[interfaces] - surface_s
    reflection = reflection[interfaces]
    first = _first_of_groups(delay_s, sweep.cell_s)
    size = np.diff(first, append=delay_s.size)

    reflected = _band_power(delay_s, reflection, first, sweep)
    passed = np.cumprod(np.append(1, 1 - reflected[:-1]))
    turn = np.exp(2j * np.pi * sweep.centre_hz * delay_s)
    field = reflection * np.repeat(passed, size) * turn
    profile = np.abs(_responses(delay_s, delay_s[-1], sweep) @ field) ** 2

    centre_s = _centres(delay_s, first, size, profile, sweep)
    single = reflected * passed**2
    power = _fitted(single, size > 1, centre_s, profile, delay_s[-1], sweep)
    return Reflectors(interfaces[first], surface_s + centre_s, power, reflected)


def _first_of_groups(delay_s, cell_s):
    """Number of the first interface of every range cell, (group,).

    Cells are counted from the first interface of a run of interfaces less than a cell apart.
    """
    run = np.cumsum(np.diff(delay_s, prepend=delay_s[0]) > cell_s)
    start_s = delay_s[np.searchsorted(run, run)]
    cell = np.floor((delay_s - start_s) / cell_s)
    begins = (np.diff(run, prepend=-1) != 0) | (np.diff(cell, prepend=-1) != 0)
    return np.flatnonzero(begins)


def _band_power(delay_s, reflection, first, sweep):
    """Share of power that each group reflects, on average over the band, (group,)."""
    total = 0
    for frequency_hz, weight in zip(sweep.frequency_hz, sweep.weight**2, strict=True):
        field = reflection * np.exp(2j * np.pi * frequency_hz * delay_s)
        total = total + weight * np.abs(np.add.reduceat(field, first)) ** 2
    return total / np.sum(sweep.weight**2)


def _responses(at_s, last_s, sweep):
    """Range responses of unit peak, a sparse array (sample, echo).

    Samples are `Sweep.step_s` apart. They begin the reach of a response above the surface and end
    as far below the last travel time.
    """
    reach = sweep.reach
    nearest = np.rint(at_s / sweep.step_s).astype(int)
    around = np.arange(-reach, reach + 1)
    samples = nearest[:, None] + around
    away_s = np.abs(samples * sweep.step_s - at_s[:, None])
    known_s = np.linspace(0, (reach + 1) * sweep.step_s, 32 * reach)
    offset_hz = sweep.frequency_hz - sweep.centre_hz
    known = np.cos(2 * np.pi * np.outer(known_s, offset_hz)) @ sweep.weight / sweep.weight.sum()
    values = np.interp(away_s, known_s, known)
    columns = samples + reach
    starts = np.arange(0, values.size + 1, around.size)
    n_samples = int(np.rint(last_s / sweep.step_s)) + 2 * reach + 1
    by_echo = csr_array((values.ravel(), columns.ravel(), starts), (at_s.size, n_samples))
    return by_echo.T


def _centres(delay_s, first, size, profile, sweep):
    """Travel time at the centre of a group's power, (group,) [s].

    The power between the group's outer interfaces counts.
    """
    top_s = delay_s[first, None]
    base_s = delay_s[first + size - 1, None]
    sample_s = (np.arange(profile.size) - sweep.reach) * sweep.step_s
    share = (np.arange(SAMPLES_PER_GROUP) + 0.5) / SAMPLES_PER_GROUP
    within_s = top_s + share * (base_s - top_s)
    weight = np.interp(within_s, sample_s, profile)
    centre_s = np.sum(weight * within_s, axis=1) / np.sum(weight, axis=1)
    centre_s[size == 1] = delay_s[first[size == 1]]
    centre_s[0] = delay_s[0]
    return centre_s


def _fitted(power, grouped, centre_s, profile, last_s, sweep):
    """Powers of the reflectors, (group,); those of groups are fitted to a profile of power."""
    responses = _responses(centre_s, last_s, sweep).power(2)
    area = responses.sum(axis=0)
    for _ in range(N_FIT_ROUNDS):
        modelled = responses @ power
        ratio = np.zeros_like(profile)
        np.divide(profile, modelled, out=ratio, where=modelled > 0)
        updated = power * (responses.T @ ratio) / area
        power = np.where(grouped, updated, power)
    return power


def interfaces(depth_m, density_kg_m3, thickness_m=None):
    """Depth of the interfaces of a measured profile, and density of the snow below each.

    Samples (sample,) are homogeneous, and `depth_m` is their middle [m]. Each interface lies
    half-way between two samples: between their middles, or, with `thickness_m`, between the base of
    one and the top of the next; then samples may not overlap. The first sample reaches up to the
    surface, and the snow of the last one goes on below. Two arrays (interface,) are returned: depth
    [m], the surface first, and density [kg m-3].
    """
    shapes = [np.shape(each) for each in (depth_m, density_kg_m3, thickness_m) if each is not None]
    if len(set(shapes)) > 1 or len(shapes[0]) != 1 or 0 in shapes[0]:
        msg = (
            "profile: depth_m, density_kg_m3 and thickness_m must be one value a sample, "
            f"got shapes {', '.join(map(str, shapes))}"
        )
        raise ValueError(msg)
    check_values("profile: depth_m", depth_m, 0)
    check_values("profile: density_kg_m3", density_kg_m3)
    check_values("profile: depth_m must increase: its steps", np.diff(depth_m), 0, above=True)
    half_m = 0
    if thickness_m is not None:
        check_values("profile: thickness_m", thickness_m, 0, above=True)
        half_m = thickness_m / 2
    top_m = (depth_m - half_m)[1:]
    base_m = (depth_m + half_m)[:-1]
    if thickness_m is not None:
        what = "profile: samples must not overlap: distances"
        check_values(what, top_m - base_m, -LARGEST_OVERLAP_M)
    return np.append(0.0, (base_m + top_m) / 2), density_kg_m3
