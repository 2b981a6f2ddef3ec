"""Plane waves in a stack of homogeneous layers at normal incidence: all orders of reflection, or the first alone.

Fields vary as ``exp(-i w t)``: a wave that goes down a layer gains ``exp(i k n d)``, and a medium that absorbs has an
index with a positive imaginary part.
Stacks of snow for the coherent solver: density against depth, one profile a look.
"""

import numpy as np

from snowsim.constants import SPEED_OF_LIGHT_M_S


def fresnel(index_above, index_below):
    """Amplitude reflected at an interface seen from above, ``(n1 - n2) / (n1 + n2)``; arguments broadcast.

    Notes
    -----
    Fresnel's formula at normal incidence for the electric field: Born & Wolf (1999), Principles of Optics, 7th ed.,
    section 1.5. A wave from below is reflected by the negative of it.
    """
    index_above, index_below = np.asarray(index_above), np.asarray(index_below)
    return (index_above - index_below) / (index_above + index_below)


def reflect(index, thickness_m, frequency_hz):
    """Reflection and transmission of a stack, every multiple included, by transfer matrices.

    Layers are homogeneous, flat and without end; the wave comes straight down from the uppermost medium.

    Parameters
    ----------
    index : array_like, (..., medium)
        Refractive index of the half-space above, of every layer and of the half-space below; real, or complex with an
        imaginary part of at least 0.
    thickness_m : array_like, (..., layer)
        Of the layers between the half-spaces; two less than there are media.
    frequency_hz : array_like, (frequency,)

    Returns
    -------
    reflection, transmission : ndarray of complex, (..., frequency)
        Amplitudes at the uppermost and below the lowermost interface, relative to the wave that comes in. Without
        absorption ``|reflection|^2 + n_below / n_above |transmission|^2 = 1``.

    Raises
    ------
    ValueError
        If shapes do not fit, an index is not positive or amplifies, a thickness or frequency is negative or not finite,
        or if less than 1e-300 of the field comes through, so that numbers overflow.

    Notes
    -----
    From the wave in the lowermost medium upwards, ``(down, up)`` above an interface is ``((1, r), (r, 1)) / t`` times
    what is below it, with ``t = 2 n1 / (n1 + n2)``, and ``(exp(-i phi) down, exp(i phi) up)`` at the top of a layer of
    phase ``phi = 2 pi f n d / c``: Born & Wolf (1999), section 1.6; Yeh (1988), Optical Waves in Layered Media,
    chapter 5, in the basis of travelling waves.
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
    """Reflection of a stack by single scattering: every interface once, no multiples.

    Parameters
    ----------
    index, thickness_m, frequency_hz : array_like
        As for `reflect`.
    losses : bool
        Whether a wave loses on its way, down and up, what interfaces above reflect; without, this is the first Born
        approximation, in the true phases.

    Returns
    -------
    ndarray of complex, (..., frequency)

    Raises
    ------
    ValueError
        As for `reflect`.

    Notes
    -----
    ``R = sum_k r_k prod_{m < k} (1 - r_m^2) exp(2 i sum_{j <= k} phi_j)``; the product is 1 without losses. What is
    left out begins with the third order in r.
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
    """Two-way travel time from the uppermost interface to each interface [s], (..., interface); real part of index."""
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


LEAST_DENSITY_KG_M3 = 100.0  # profiles are kept in [100, 917]: fresh snow to ice
ICE_KG_M3 = 917.0
MOST_OUTSIDE = 0.02  # share of fluctuating densities that may be set to a border


def draw_years(n_looks, n_slabs, contrast_kg_m3, *, mean_density_kg_m3, slab_m, roughness_m, rng):
    """Slabs of alternating density, as dense autumn and light summer snow.

    Looks see the same slabs, each interface moved by its own roughness, more than a wavelength in all: that is what
    makes echoes of different interfaces incoherent.

    Parameters
    ----------
    n_looks, n_slabs : int
    contrast_kg_m3 : float
        Density step between one slab and the next.
    mean_density_kg_m3 : float
        Half way between the two densities.
    slab_m : float
        Mean thickness of a slab; slabs differ by +-40 %.
    roughness_m : float
        Standard deviation of an interface's height.
    rng : numpy.random.Generator

    Returns
    -------
    density_kg_m3 : ndarray, (look, medium)
        Of all media below the air: slabs, then the half-space.
    thickness_m : ndarray, (look, slab)

    Raises
    ------
    ValueError
        If a density leaves [100, 917].
    """
    step = np.where(np.arange(n_slabs + 1) % 2 == 0, -0.5, 0.5) * contrast_kg_m3
    density = np.tile(mean_density_kg_m3 + step, (n_looks, 1))
    depth_m = np.cumsum(slab_m * rng.uniform(0.6, 1.4, n_slabs))
    rough_m = depth_m + roughness_m * rng.standard_normal((n_looks, n_slabs))
    rough_m = np.sort(np.maximum(rough_m, 1e-3), axis=1)
    return _checked(density), np.diff(rough_m, axis=1, prepend=0)


def draw_lenses(density_kg_m3, thickness_m, n_lenses, *, lens_m, rng):
    """The same stacks with ice lenses in as many of their slabs.

    Parameters
    ----------
    density_kg_m3, thickness_m : ndarray
        See `draw_years`.
    n_lenses : int
        At most one a slab.
    lens_m : float
        Thickness of a lens; slabs it does not fit into are left without.
    rng : numpy.random.Generator

    Returns
    -------
    density_kg_m3, thickness_m : ndarray
        With two more media for every lens.
    """
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
        media = np.concatenate([around, np.full_like(around, ICE_KG_M3), around], axis=1)
        density_kg_m3 = np.concatenate([density_kg_m3[:, :slab], media, density_kg_m3[:, slab + 1 :]], axis=1)
    return _checked(density_kg_m3), thickness_m


def layered(fluctuation_kg_m3, mean_density_kg_m3, cell_m):
    """Stack of thin cells from a fluctuating density profile.

    Parameters
    ----------
    fluctuation_kg_m3 : ndarray, (look, cell)
        About the mean. Densities beyond [100, 917], at most 2 % of the cells, are set to these.
    mean_density_kg_m3, cell_m : float

    Returns
    -------
    density_kg_m3 : ndarray, (look, medium)
        The last cell goes on as the half-space.
    thickness_m : ndarray, (look, layer)

    Raises
    ------
    ValueError
        If more than 2 % of the cells would leave [100, 917].
    """
    unbounded = mean_density_kg_m3 + fluctuation_kg_m3
    density = np.clip(unbounded, LEAST_DENSITY_KG_M3, ICE_KG_M3)
    outside = np.mean(density != unbounded)
    if outside > MOST_OUTSIDE:
        low, high = LEAST_DENSITY_KG_M3, ICE_KG_M3
        msg = f"densities must lie in [{low:g}, {high:g}] kg m-3 but for {MOST_OUTSIDE:.0%}, {outside:.1%} do not"
        raise ValueError(msg)
    return density, np.full((density.shape[0], density.shape[1] - 1), cell_m)


def _checked(density_kg_m3):
    outside = ~((density_kg_m3 >= LEAST_DENSITY_KG_M3) & (density_kg_m3 <= ICE_KG_M3))
    if outside.any():
        low, high = LEAST_DENSITY_KG_M3, ICE_KG_M3
        msg = f"densities must lie in [{low:g}, {high:g}] kg m-3, got {density_kg_m3[outside][0]:g}"
        raise ValueError(msg)
    return density_kg_m3
