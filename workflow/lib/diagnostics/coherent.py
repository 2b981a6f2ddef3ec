"""Stacks of snow for a coherent radar: densities drawn, and plane waves reflected by their layers at normal incidence.

Fields vary as ``exp(-i w t)``: a wave that goes down a layer gains ``exp(i k n d)``, and a medium that absorbs has an
index with a positive imaginary part. Stacks are (look, medium), uppermost first, with thicknesses (look, layer).
"""

import numpy as np

from snowsim.constants import ICE_DENSITY_KG_M3, SPEED_OF_LIGHT_M_S

LOW_KG_M3, HIGH_KG_M3 = 100.0, ICE_DENSITY_KG_M3  # profiles are kept between: fresh snow to ice
MOST_OUTSIDE = 0.02  # share of fluctuating densities that may be set to a border


def fresnel(index_above, index_below):
    """Amplitude reflected at an interface seen from above, ``(n1 - n2) / (n1 + n2)``; arguments broadcast.

    For the electric field; a wave from below is reflected by the negative of it. Born & Wolf (1999), Principles of
    Optics, 7th ed., section 1.5.
    """
    index_above, index_below = np.asarray(index_above), np.asarray(index_below)
    return (index_above - index_below) / (index_above + index_below)


def reflect(index, thickness_m, frequency_hz):
    """Reflection and transmission of stacks, every multiple included: two complex arrays (..., frequency).

    `index` (..., medium) has a half-space above and one below, two media more than `thickness_m` (..., layer).
    Amplitudes are those at the uppermost and below the lowermost interface, relative to the wave that comes in: without
    absorption ``|reflection|^2 + n_below / n_above |transmission|^2 = 1``. Refused: shapes that do not fit, an index
    that is not positive or amplifies, and stacks that let less than 1e-300 of the field through: numbers overflow.

    Transfer matrices: from the wave in the lowermost medium upwards, ``(down, up)`` above an interface is ``((1, r),
    (r, 1)) / t`` times what is below it, with ``t = 2 n1 / (n1 + n2)``, and ``(exp(-i phi) down, exp(i phi) up)`` at
    the top of a layer of phase ``phi = 2 pi f n d / c``: Born & Wolf (1999), section 1.6; Yeh (1988), Optical Waves in
    Layered Media, chapter 5, in the basis of travelling waves.
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
    """Reflection of stacks by single scattering, every interface once and no multiples, complex (..., frequency).

    ``R = sum_k r_k prod_{m < k} (1 - r_m^2) exp(2 i sum_{j <= k} phi_j)``; what is left out begins with the third order
    in r. The product is what interfaces above take from a wave, down and up; without `losses` it is 1: the first Born
    approximation, in the true phases. Refuses what `reflect` refuses.
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
    return 2 / SPEED_OF_LIGHT_M_S * np.concatenate([np.zeros_like(np.real(index)[..., :1]), optical_m], axis=-1)


def _phase(index, thickness_m, layer, frequency_hz):
    """Phase over one layer, (..., frequency)."""
    optical_m = index[..., layer + 1] * thickness_m[..., layer]
    return 2 * np.pi / SPEED_OF_LIGHT_M_S * optical_m[..., None] * frequency_hz


def _checked_stack(index, thickness_m, frequency_hz):
    """The three as arrays; ValueError unless they are a stack of passive media and frequencies."""
    index, thickness_m = np.asarray(index), np.asarray(thickness_m, dtype=float)
    frequency_hz = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
    fits = index.ndim >= 1 and index.shape[-1] >= 2 and thickness_m.shape == (*index.shape[:-1], index.shape[-1] - 2)
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

    Densities are half a contrast above and below the mean; slabs differ by +-40 % from `slab_m`. Looks see the same
    slabs, each interface moved by a roughness of its own (standard deviation `roughness_m`), more than a wavelength in
    all: that is what makes echoes of different interfaces incoherent. Densities that leave [100, 917] are refused.
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
        thickness_m = np.concatenate([thickness_m[:, :slab], pieces, thickness_m[:, slab + 1 :]], axis=1)
        around = density_kg_m3[:, slab, None]
        media = np.concatenate([around, np.full_like(around, ICE_DENSITY_KG_M3), around], axis=1)
        density_kg_m3 = np.concatenate([density_kg_m3[:, :slab], media, density_kg_m3[:, slab + 1 :]], axis=1)
    return _checked(density_kg_m3), thickness_m


def layered(fluctuation_kg_m3, mean_density_kg_m3, cell_m):
    """Stacks of thin cells from fluctuations of density about a mean, (look, cell); the last cell is the half-space.

    Densities beyond [100, 917] are set to these; more than 2 % of the cells are refused.
    """
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
