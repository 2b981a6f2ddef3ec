"""Stacks of snow for a coherent radar, what they reflect at nadir, and simpler models of the echo.

Fields vary as ``exp(-i w t)``: a wave that goes down a layer gains ``exp(i k n d)``, and a medium
that absorbs has an index with a positive imaginary part. Stacks are (look, medium), uppermost
first, with thicknesses (look, layer).
"""

import numpy as np

from snowsim.constants import ICE_DENSITY_KG_M3, SPEED_OF_LIGHT_M_S

LOW_KG_M3 = 100.0  # fresh snow; profiles are kept between it and ice
MOST_OUTSIDE = 0.02  # share of fluctuating densities that may be set to a border
LIMITS = f"densities must lie in [{LOW_KG_M3:g}, {ICE_DENSITY_KG_M3:g}] kg m-3"
MODELS = ("transfer matrix", "Born", "single scattering", "convolution")


def fresnel(index_above, index_below):
    """Electric field reflected at an interface, seen from above.

    Born & Wolf (1999), Principles of Optics, section 1.5.
    """
    return (index_above - index_below) / (index_above + index_below)


def reflect(index, thickness_m, frequency_hz):
    """Reflection and transmission of stacks, every multiple included: complex (..., frequency).

    `index` (..., medium) has a half-space above and one below, two media more than `thickness_m`
    (..., layer). Transfer matrices of travelling waves, ``(down, up)`` above an interface ``((1,
    r), (r, 1)) / t`` times that below: Born & Wolf (1999), section 1.6; Yeh (1988), Optical Waves
    in Layered Media, chapter 5.
    """
    index, thickness_m, frequency_hz = _checked_stack(index, thickness_m, frequency_hz)
    above = index[..., :-1]
    below = index[..., 1:]
    r = fresnel(above, below)
    t = 2 * above / (above + below)
    shape = (*index.shape[:-1], frequency_hz.size)
    down = np.ones(shape, dtype=complex)
    up = np.zeros(shape, dtype=complex)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for interface in reversed(range(above.shape[-1])):
            r_here = r[..., interface, None]
            t_here = t[..., interface, None]
            down, up = (down + r_here * up) / t_here, (r_here * down + up) / t_here
            if interface > 0:
                phase = _phase(index, thickness_m, interface - 1, frequency_hz)
                turn = np.exp(1j * phase)
                down = down / turn
                up = up * turn
        reflection = up / down
        transmission = 1 / down
    if not np.isfinite(reflection).all() or not np.isfinite(down).all():
        n_layers = thickness_m.shape[-1]
        msg = f"less than 1e-300 of the field comes through {n_layers} layers: numbers overflow"
        raise ValueError(msg)
    return reflection, transmission


def reflect_once(index, thickness_m, frequency_hz, *, losses=True):
    """Reflection of stacks by single scattering, complex (..., frequency): up to second order in r.

    ``R = sum_k r_k prod_{m < k} (1 - r_m^2) exp(2 i sum_{j <= k} phi_j)``. The product is what
    interfaces above take from a wave, down and up; without `losses` it is 1: the first Born
    approximation, in the true phases.
    """
    index, thickness_m, frequency_hz = _checked_stack(index, thickness_m, frequency_hz)
    amplitude = interface_amplitudes(index, losses=losses)
    total = np.zeros((*index.shape[:-1], frequency_hz.size), dtype=complex)
    turn = np.ones_like(total)
    for interface in range(amplitude.shape[-1]):
        if interface > 0:
            phase = _phase(index, thickness_m, interface - 1, frequency_hz)
            turn *= np.exp(2j * phase)
        total += amplitude[..., interface, None] * turn
    return total


def interface_amplitudes(index, *, losses=True):
    """Amplitude with which each interface is seen from above, (..., interface): `reflect_once`."""
    r = fresnel(index[..., :-1], index[..., 1:])
    if not losses:
        return r
    passed = np.cumprod(1 - r**2, axis=-1)
    first = np.ones_like(r[..., :1])
    return r * np.concatenate([first, passed[..., :-1]], axis=-1)


def interface_delays_s(index, thickness_m):
    """Two-way travel time from the uppermost interface to each [s], by the real index."""
    index = np.real(index)
    optical_m = np.cumsum(index[..., 1:-1] * thickness_m, axis=-1)
    from_top_m = np.concatenate([np.zeros_like(index[..., :1]), optical_m], axis=-1)
    return 2 / SPEED_OF_LIGHT_M_S * from_top_m


def _phase(index, thickness_m, layer, frequency_hz):
    """Phase over one layer, (..., frequency)."""
    optical_m = index[..., layer + 1] * thickness_m[..., layer]
    return 2 * np.pi / SPEED_OF_LIGHT_M_S * optical_m[..., None] * frequency_hz


def _checked_stack(index, thickness_m, frequency_hz):
    """The three as arrays; ValueError unless they are a stack of passive media and frequencies."""
    index = np.asarray(index)
    thickness_m = np.asarray(thickness_m, dtype=float)
    frequency_hz = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
    *n_stacks, n_media = index.shape
    if n_media < 2 or thickness_m.shape != (*n_stacks, n_media - 2):
        shapes = f"{index.shape} and {thickness_m.shape}"
        msg = f"index must have two media more than thickness_m has layers, got {shapes}"
        raise ValueError(msg)
    if not np.isfinite(index).all() or (np.real(index) <= 0).any() or (np.imag(index) < 0).any():
        msg = "index must be finite, its real part positive and its imaginary part not negative"
        raise ValueError(msg)
    for name, values in {"thickness_m": thickness_m, "frequency_hz": frequency_hz}.items():
        good = np.isfinite(values) & (values >= 0)
        if not good.all():
            msg = f"{name} must be finite and not negative, got {values[~good][0]:g}"
            raise ValueError(msg)
    if np.imag(index).any():
        return index, thickness_m, frequency_hz
    return np.real(index).astype(float), thickness_m, frequency_hz


def draw_years(n_looks, n_slabs, contrast_kg_m3, *, mean_density_kg_m3, slab_m, roughness_m, rng):
    """Stacks of slabs of alternating density, as dense autumn and light summer snow.

    Returns density and thickness. Slabs differ by +-40 % from `slab_m`. In each look every
    interface is moved by a roughness of its own (standard deviation `roughness_m`): more than a
    wavelength in all makes echoes of different interfaces incoherent.
    """
    is_light = np.arange(n_slabs + 1) % 2 == 0
    density = mean_density_kg_m3 + np.where(is_light, -0.5, 0.5) * contrast_kg_m3
    depth_m = np.cumsum(slab_m * rng.uniform(0.6, 1.4, n_slabs))
    rough_m = depth_m + roughness_m * rng.standard_normal((n_looks, n_slabs))
    rough_m = np.sort(np.maximum(rough_m, 1e-3), axis=1)
    thickness_m = np.diff(rough_m, axis=1, prepend=0)
    return _checked(np.tile(density, (n_looks, 1))), thickness_m


def draw_lenses(density_kg_m3, thickness_m, n_lenses, *, lens_m, rng):
    """The same stacks with an ice lens in each of `n_lenses` slabs: two media more each.

    A lens is at most half a slab thick.
    """
    n_slabs = thickness_m.shape[1]
    if not 0 <= n_lenses <= n_slabs:
        msg = f"n_lenses must lie in [0, {n_slabs}], got {n_lenses}"
        raise ValueError(msg)
    chosen = np.sort(rng.permutation(n_slabs)[:n_lenses])
    # From the deepest to the uppermost, so that positions found stay where they are.
    for slab in chosen[::-1]:
        whole = thickness_m[:, slab]
        lens = np.minimum(lens_m, 0.5 * whole)
        above = (whole - lens) * rng.uniform(0.2, 0.8, whole.size)
        below = whole - lens - above
        thickness_m = _with_column_as(thickness_m, slab, [above, lens, below])
        around = density_kg_m3[:, slab]
        ice = np.full_like(around, ICE_DENSITY_KG_M3)
        density_kg_m3 = _with_column_as(density_kg_m3, slab, [around, ice, around])
    return _checked(density_kg_m3), thickness_m


def _with_column_as(values, place, columns):
    """Values (look, column) with one column replaced by several."""
    parts = [values[:, :place], np.stack(columns, axis=1), values[:, place + 1 :]]
    return np.concatenate(parts, axis=1)


def layered(fluctuation_kg_m3, mean_density_kg_m3, cell_m):
    """Stacks of thin cells from fluctuations of density about a mean, (look, cell).

    The last cell is the half-space.
    """
    unbounded = mean_density_kg_m3 + fluctuation_kg_m3
    density = np.clip(unbounded, LOW_KG_M3, ICE_DENSITY_KG_M3)
    outside = np.mean(density != unbounded)
    if outside > MOST_OUTSIDE:
        msg = f"{LIMITS} but for {MOST_OUTSIDE:.0%}, {outside:.1%} do not"
        raise ValueError(msg)
    n_looks, n_cells = density.shape
    return density, np.full((n_looks, n_cells - 1), cell_m)


def _checked(density_kg_m3):
    inside = (density_kg_m3 >= LOW_KG_M3) & (density_kg_m3 <= ICE_DENSITY_KG_M3)
    if not inside.all():
        msg = f"{LIMITS}, got {density_kg_m3[~inside][0]:g}"
        raise ValueError(msg)
    return density_kg_m3


def sweep_frequencies_hz(start_hz, stop_hz, longest_delay_s):
    """Frequencies of a sweep, (frequency,): so close that no echo up to the delay folds back."""
    if not (0 < start_hz < stop_hz and longest_delay_s > 0):
        got = f"got {start_hz:g}, {stop_hz:g} Hz, {longest_delay_s:g} s"
        msg = f"expected 0 < start < stop and a positive delay, {got}"
        raise ValueError(msg)
    span_hz = stop_hz - start_hz
    n_steps = int(np.ceil(span_hz * longest_delay_s)) + 1
    # Half a step inside both ends: a Hann window without zeros.
    return start_hz + (np.arange(n_steps) + 0.5) / n_steps * span_hz


def mean_profile(reflection, frequency_hz, delay_s):
    """Power of Hann-weighted range profiles, averaged over looks, (delay,); a mirror has 1.

    ``p(t) = |sum_f w R exp(-2 pi i f t) / sum_f w|^2`` at two-way travel times, over even
    frequencies: an FMCW beat signal, R (look, frequency).
    """
    n = frequency_hz.size
    weight = np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 2
    turn = np.exp(-2j * np.pi * np.multiply.outer(frequency_hz, delay_s))
    profile = (reflection * (weight / weight.sum())) @ turn
    return np.mean(np.abs(profile) ** 2, axis=0)


def incoherent_profile(power, at_s, delay_s, bandwidth_hz):
    """The convolution model: Hann range responses of points, added by power, averaged over looks.

    The response, ``sinc(x) + (sinc(x - 1) + sinc(x + 1)) / 2`` with ``x = B t``, is left out beyond
    ``|x| = 8``, where it is below -60 dB. `power` and `at_s` are (look, point), delays even.
    """
    power = np.asarray(power, dtype=float)
    at_s = np.ravel(at_s)[:, None]
    first_s = delay_s[0]
    step_s = (delay_s[-1] - first_s) / (delay_s.size - 1)
    reach = int(np.ceil(8 / bandwidth_hz / step_s))
    nearest = np.rint((at_s - first_s) / step_s).astype(int)
    rows = nearest + np.arange(-reach, reach + 1)
    x = (first_s + rows * step_s - at_s) * bandwidth_hz
    amplitude = np.sinc(x) + 0.5 * (np.sinc(x - 1) + np.sinc(x + 1))
    response = amplitude**2 * power.ravel()[:, None]
    inside = (rows >= 0) & (rows < delay_s.size)
    total = np.bincount(rows[inside], response[inside], minlength=delay_s.size)
    return total / power.shape[0]


def model_works(index, thickness_m, frequency_hz, delay_s, bandwidth_hz):
    """What each of `MODELS` does for an ensemble of stacks: callables for its mean power, (delay,).

    ``convolution`` adds powers of the echoes of single scattering without their phases, which is
    what eq. (1) of Yari et al. (2021), IEEE JSTARS 14, and the nature run do.
    """
    stack = (index, thickness_m, frequency_hz)
    sweep = (frequency_hz, delay_s)

    def convolution():
        power = interface_amplitudes(index) ** 2
        at_s = interface_delays_s(index, thickness_m)
        return incoherent_profile(power, at_s, delay_s, bandwidth_hz)

    return {
        "transfer matrix": lambda: mean_profile(reflect(*stack)[0], *sweep),
        "Born": lambda: mean_profile(reflect_once(*stack, losses=False), *sweep),
        "single scattering": lambda: mean_profile(reflect_once(*stack), *sweep),
        "convolution": convolution,
    }


def error_db(power, reference, noise_power=0.0):
    """Root mean square of the ratio of two mean powers [dB], noise added to both.

    What lies below the noise does not count.
    """
    ratio = _ratio(np.add(power, noise_power), np.add(reference, noise_power))
    return float(np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)))


def bias_db(power, reference):
    """Ratio of the sums of two mean powers [dB]."""
    return float(10 * np.log10(_ratio(np.sum(power), np.sum(reference))))


def _ratio(power, reference):
    same_shape = power.shape == reference.shape
    if not (same_shape and (_is_power(power) & _is_power(reference)).all()):
        shapes = f"{power.shape} and {reference.shape}"
        msg = f"expected two positive, finite powers of one shape, got shapes {shapes}"
        raise ValueError(msg)
    return power / reference


def _is_power(values):
    return np.isfinite(values) & (values > 0)
