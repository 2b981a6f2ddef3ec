"""Stacks of snow for a coherent radar, what they reflect at normal incidence, and simpler models of their echo.

Fields vary as ``exp(-i w t)``: a wave that goes down a layer gains ``exp(i k n d)``, and a medium
that absorbs has an index with a positive imaginary part. Stacks are (look, medium), uppermost
first, with thicknesses (look, layer).
"""

import numpy as np

from snowsim.constants import ICE_DENSITY_KG_M3, SPEED_OF_LIGHT_M_S

LOW_KG_M3, HIGH_KG_M3 = 100.0, ICE_DENSITY_KG_M3  # profiles are kept between: fresh snow to ice
MOST_OUTSIDE = 0.02  # share of fluctuating densities that may be set to a border
MODELS = ("transfer matrix", "Born", "single scattering", "convolution")


def fresnel(index_above, index_below):
    """Electric field reflected at an interface, from above: Born & Wolf (1999), Principles of Optics, section 1.5."""
    return (index_above - index_below) / (index_above + index_below)


def reflect(index, thickness_m, frequency_hz):
    """Reflection and transmission of stacks, every multiple included: two complex arrays (..., frequency).

    `index` (..., medium) has a half-space above and one below, two media more than `thickness_m`
    (..., layer). Transfer matrices of travelling waves, ``(down, up)`` above an interface ``((1,
    r), (r, 1)) / t`` times that below: Born & Wolf (1999), section 1.6; Yeh (1988), Optical Waves
    in Layered Media, chapter 5.
    """
    index, thickness_m, frequency_hz = _checked_stack(index, thickness_m, frequency_hz)
    r = fresnel(index[..., :-1], index[..., 1:])
    t = 2 * index[..., :-1] / (index[..., :-1] + index[..., 1:])
    shape = (*index.shape[:-1], frequency_hz.size)
    down, up = np.ones(shape, dtype=complex), np.zeros(shape, dtype=complex)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for layer in range(index.shape[-1] - 2, -1, -1):
            r_here, t_here = r[..., layer, None], t[..., layer, None]
            down, up = (down + r_here * up) / t_here, (r_here * down + up) / t_here
            if layer > 0:
                turn = np.exp(1j * _phase(index, thickness_m, layer - 1, frequency_hz))
                down, up = down / turn, up * turn
        reflection, transmission = up / down, 1 / down
    if not np.isfinite(reflection).all() or not np.isfinite(down).all():
        msg = f"less than 1e-300 of the field comes through {thickness_m.shape[-1]} layers: numbers overflow"
        raise ValueError(msg)
    return reflection, transmission


def reflect_once(index, thickness_m, frequency_hz, *, losses=True):
    """Reflection of stacks by single scattering, complex (..., frequency); what it leaves out is of third order in r.

    ``R = sum_k r_k prod_{m < k} (1 - r_m^2) exp(2 i sum_{j <= k} phi_j)``. The product is what
    interfaces above take from a wave, down and up; without `losses` it is 1: the first Born
    approximation, in the true phases.
    """
    index, thickness_m, frequency_hz = _checked_stack(index, thickness_m, frequency_hz)
    amplitude = interface_amplitudes(index, losses=losses)
    total = np.zeros((*index.shape[:-1], frequency_hz.size), dtype=complex)
    turn = np.ones_like(total)
    for k in range(index.shape[-1] - 1):
        if k > 0:
            turn *= np.exp(2j * _phase(index, thickness_m, k - 1, frequency_hz))
        total += amplitude[..., k, None] * turn
    return total


def interface_amplitudes(index, *, losses=True):
    """Amplitude with which each interface is seen from above, (..., interface); see `reflect_once`."""
    index = np.asarray(index)
    r = fresnel(index[..., :-1], index[..., 1:])
    if not losses:
        return r
    passed = np.cumprod(1 - r**2, axis=-1)
    return r * np.concatenate([np.ones_like(r[..., :1]), passed[..., :-1]], axis=-1)


def interface_delays_s(index, thickness_m):
    """Two-way travel time [s] from the uppermost interface to each interface, by the real part of the index."""
    optical_m = np.cumsum(np.real(index)[..., 1:-1] * np.asarray(thickness_m, dtype=float), axis=-1)
    return (
        2
        / SPEED_OF_LIGHT_M_S
        * np.concatenate([np.zeros_like(np.real(index)[..., :1]), optical_m], axis=-1)
    )


def _phase(index, thickness_m, layer, frequency_hz):
    """Phase over one layer, (..., frequency)."""
    optical_m = index[..., layer + 1] * thickness_m[..., layer]
    return 2 * np.pi / SPEED_OF_LIGHT_M_S * optical_m[..., None] * frequency_hz


def _checked_stack(index, thickness_m, frequency_hz):
    """The three as arrays; ValueError unless they are a stack of passive media and frequencies."""
    index, thickness_m = np.asarray(index), np.asarray(thickness_m, dtype=float)
    frequency_hz = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
    fits = (
        index.ndim >= 1
        and index.shape[-1] >= 2
        and thickness_m.shape == (*index.shape[:-1], index.shape[-1] - 2)
    )
    if not fits:
        msg = f"index must have two media more than thickness_m has layers, got {index.shape} and {thickness_m.shape}"
        raise ValueError(msg)
    if not np.isfinite(index).all() or (np.real(index) <= 0).any() or (np.imag(index) < 0).any():
        msg = "index must be finite, its real part positive and its imaginary part not negative"
        raise ValueError(msg)
    for name, values in (("thickness_m", thickness_m), ("frequency_hz", frequency_hz)):
        if not (np.isfinite(values) & (values >= 0)).all():
            msg = f"{name} must be finite and not negative, got {values[~(np.isfinite(values) & (values >= 0))][0]:g}"
            raise ValueError(msg)
    if np.iscomplexobj(index) and not np.imag(index).any():
        index = np.real(index)
    return index.astype(complex if np.iscomplexobj(index) else float), thickness_m, frequency_hz


def draw_years(n_looks, n_slabs, contrast_kg_m3, *, mean_density_kg_m3, slab_m, roughness_m, rng):
    """Stacks of slabs of alternating density, as dense autumn and light summer snow: density and thickness.

    Slabs differ by +-40 % from `slab_m`. In each look every interface is moved by a roughness of
    its own (standard deviation `roughness_m`): more than a wavelength in all makes echoes of
    different interfaces incoherent.
    """
    step = np.where(np.arange(n_slabs + 1) % 2 == 0, -0.5, 0.5) * contrast_kg_m3
    density = np.tile(mean_density_kg_m3 + step, (n_looks, 1))
    depth_m = np.cumsum(slab_m * rng.uniform(0.6, 1.4, n_slabs))
    rough_m = depth_m + roughness_m * rng.standard_normal((n_looks, n_slabs))
    rough_m = np.sort(np.maximum(rough_m, 1e-3), axis=1)
    return _checked(density), np.diff(rough_m, axis=1, prepend=0)


def draw_lenses(density_kg_m3, thickness_m, n_lenses, *, lens_m, rng):
    """The same stacks with an ice lens, at most half a slab thick, in each of `n_lenses` slabs: two media more each."""
    n_slabs = thickness_m.shape[1]
    if not 0 <= n_lenses <= n_slabs:
        msg = f"n_lenses must lie in [0, {n_slabs}], got {n_lenses}"
        raise ValueError(msg)
    # From the deepest to the uppermost, so that positions found stay where they are.
    for slab in np.sort(rng.permutation(n_slabs)[:n_lenses])[::-1]:
        whole, inside = thickness_m[:, slab], np.minimum(lens_m, 0.5 * thickness_m[:, slab])
        above = (whole - inside) * rng.uniform(0.2, 0.8, whole.size)
        pieces = np.stack([above, inside, whole - inside - above], axis=1)
        thickness_m = np.concatenate(
            [thickness_m[:, :slab], pieces, thickness_m[:, slab + 1 :]], axis=1
        )
        around = density_kg_m3[:, slab, None]
        media = np.concatenate([around, np.full_like(around, ICE_DENSITY_KG_M3), around], axis=1)
        density_kg_m3 = np.concatenate(
            [density_kg_m3[:, :slab], media, density_kg_m3[:, slab + 1 :]], axis=1
        )
    return _checked(density_kg_m3), thickness_m


def layered(fluctuation_kg_m3, mean_density_kg_m3, cell_m):
    """Stacks of thin cells from fluctuations of density about a mean, (look, cell); the last cell is the half-space."""
    unbounded = mean_density_kg_m3 + fluctuation_kg_m3
    density = np.clip(unbounded, LOW_KG_M3, HIGH_KG_M3)
    outside = np.mean(density != unbounded)
    if outside > MOST_OUTSIDE:
        limits = f"[{LOW_KG_M3:g}, {HIGH_KG_M3:g}] kg m-3"
        msg = f"densities must lie in {limits} but for {MOST_OUTSIDE:.0%}, {outside:.1%} do not"
        raise ValueError(msg)
    return density, np.full((density.shape[0], density.shape[1] - 1), cell_m)


def _checked(density_kg_m3):
    outside = ~((density_kg_m3 >= LOW_KG_M3) & (density_kg_m3 <= HIGH_KG_M3))
    if outside.any():
        msg = f"densities must lie in [{LOW_KG_M3:g}, {HIGH_KG_M3:g}] kg m-3, got {density_kg_m3[outside][0]:g}"
        raise ValueError(msg)
    return density_kg_m3


def sweep_frequencies_hz(start_hz, stop_hz, longest_delay_s):
    """Frequencies of a sweep, (frequency,), so close that no echo up to `longest_delay_s` is folded back."""
    if not (0 < start_hz < stop_hz and longest_delay_s > 0):
        msg = f"expected 0 < start < stop and a positive delay, got {start_hz:g}, {stop_hz:g} Hz, {longest_delay_s:g} s"
        raise ValueError(msg)
    n_steps = int(np.ceil((stop_hz - start_hz) * longest_delay_s)) + 1
    # Half a step inside both ends: a Hann window without zeros.
    return start_hz + (np.arange(n_steps) + 0.5) / n_steps * (stop_hz - start_hz)


def mean_profile(reflection, frequency_hz, delay_s):
    """Power of Hann-weighted range profiles at two-way travel times, averaged over looks, (delay,); a mirror has 1.

    ``p(t) = |sum_f w R exp(-2 pi i f t) / sum_f w|^2`` over even frequencies: an FMCW beat signal,
    R (look, frequency).
    """
    frequency_hz = np.asarray(frequency_hz, dtype=float)
    weight = np.sin(np.pi * (np.arange(frequency_hz.size) + 0.5) / frequency_hz.size) ** 2
    turn = np.exp(-2j * np.pi * np.multiply.outer(frequency_hz, np.asarray(delay_s, dtype=float)))
    profile = (np.asarray(reflection) * (weight / weight.sum())) @ turn
    return np.mean(np.abs(profile) ** 2, axis=0)


def incoherent_profile(power, at_s, delay_s, bandwidth_hz):
    """Sum of Hann range responses of points, by power and averaged over looks, at even delays: the convolution model.

    The response, ``sinc(x) + (sinc(x - 1) + sinc(x + 1)) / 2`` with ``x = B t``, is left out beyond
    ``|x| = 8``, where it is below -60 dB. `power` and `at_s` (look, point) broadcast.
    """
    power, at_s = np.broadcast_arrays(np.asarray(power, dtype=float), np.asarray(at_s, dtype=float))
    delay_s = np.asarray(delay_s, dtype=float)
    step_s = (delay_s[-1] - delay_s[0]) / (delay_s.size - 1)
    reach = int(np.ceil(8 / bandwidth_hz / step_s))
    nearest = np.rint((at_s.ravel() - delay_s[0]) / step_s).astype(int)
    rows = nearest[:, None] + np.arange(-reach, reach + 1)
    x = (delay_s[0] + rows * step_s - at_s.ravel()[:, None]) * bandwidth_hz
    response = (np.sinc(x) + 0.5 * (np.sinc(x - 1) + np.sinc(x + 1))) ** 2 * power.ravel()[:, None]
    inside = (rows >= 0) & (rows < delay_s.size)
    return np.bincount(rows[inside], response[inside], minlength=delay_s.size) / power.shape[0]


def model_works(index, thickness_m, frequency_hz, delay_s, bandwidth_hz):
    """What each of `MODELS` does for one ensemble of stacks, as callables that return its mean power, (delay,).

    ``convolution`` adds powers of the echoes of single scattering without their phases, which is
    what eq. (1) of Yari et al. (2021), IEEE JSTARS 14, and the nature run do.
    """
    stack = (index, thickness_m, frequency_hz)
    sweep = (frequency_hz, delay_s)

    def convolution():
        power, at_s = interface_amplitudes(index) ** 2, interface_delays_s(index, thickness_m)
        return incoherent_profile(power, at_s, delay_s, bandwidth_hz)

    return {
        "transfer matrix": lambda: mean_profile(reflect(*stack)[0], *sweep),
        "Born": lambda: mean_profile(reflect_once(*stack, losses=False), *sweep),
        "single scattering": lambda: mean_profile(reflect_once(*stack), *sweep),
        "convolution": convolution,
    }


def error_db(power, reference, noise_power=0.0):
    """Root mean square of the ratio of two mean powers, noise added to both [dB]: what lies below it does not count."""
    power, reference = (
        np.asarray(values, dtype=float) + noise_power for values in (power, reference)
    )
    _check(power, reference)
    return float(np.sqrt(np.mean((10 * np.log10(power / reference)) ** 2)))


def bias_db(power, reference):
    """Ratio of the sums of two mean powers [dB]."""
    power, reference = np.asarray(power, dtype=float), np.asarray(reference, dtype=float)
    _check(power.sum(), reference.sum())
    return float(10 * np.log10(power.sum() / reference.sum()))


def _check(power, reference):
    good = power.shape == reference.shape and all(
        (np.isfinite(p) & (p > 0)).all() for p in (power, reference)
    )
    if not good:
        msg = f"expected two positive, finite powers of one shape, got shapes {power.shape} and {reference.shape}"
        raise ValueError(msg)
