"""Stacks of snow for the coherent solver: density against depth, one profile a look."""

import numpy as np

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
