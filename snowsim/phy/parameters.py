"""Parameters of one scene's layers from the statistics of a flight."""

import numpy as np

WIDTHS = ("paper", "fitted")


def draw_parameters(statistics, n_layers, *, width="fitted", n_looks=None, rng):
    """Parameters of `render` for one scene.

    Parameters
    ----------
    statistics : xarray.Dataset
        Of a flight: `peak_power`, `decay_rate`, `variance_bins2` (layer), `width_bound_bins` (bound), `noise_power`.
    n_layers : int
        Layers of the scene, surface included.
    width : {"paper", "fitted"}
        ``paper``: each layer's variance is drawn from U(bounds), the bounds of the measured 1/e width passed on as
        they are, as printed; ``fitted``: the layer's variance that fits.
    n_looks : float, optional
        Looks averaged; by default those of the flight, ``statistics.attrs["n_looks"]``.
    rng : numpy.random.Generator
        Source of randomness; used by ``paper`` only.

    Returns
    -------
    dict
        `peak_power`, `variance_bins2`, `decay_rate`: ndarray (layer,); `noise_power`, `n_looks`: float.

    Raises
    ------
    ValueError
        If `width` is unknown, a number is not positive, or the statistics hold no value for the surface.

    Notes
    -----
    A layer for which the flight has no positive, finite value takes that of the layer above it: so layers deeper than
    the flight shows look like its deepest.
    """
    if width not in WIDTHS:
        msg = f"width must be one of {', '.join(WIDTHS)}, got {width!r}"
        raise ValueError(msg)
    n_layers = int(n_layers)
    if n_layers < 1:
        msg = f"n_layers must be at least 1, got {n_layers}"
        raise ValueError(msg)
    if width == "paper":
        low, high = (float(bound) for bound in statistics["width_bound_bins"].values)
        if not 0 < low <= high < np.inf:
            msg = f"width_bound_bins must be positive and increase, got {low:g}, {high:g}"
            raise ValueError(msg)
        variance_bins2 = rng.uniform(low, high, n_layers)
    else:
        variance_bins2 = _down_to(statistics, "variance_bins2", n_layers)
    noise_power = float(statistics["noise_power"])
    if not 0 < noise_power < np.inf:
        msg = f"noise_power of the statistics must be positive and finite, got {noise_power}"
        raise ValueError(msg)
    return {
        "peak_power": _down_to(statistics, "peak_power", n_layers),
        "variance_bins2": variance_bins2,
        "decay_rate": _down_to(statistics, "decay_rate", n_layers),
        "noise_power": noise_power,
        "n_looks": float(statistics.attrs["n_looks"] if n_looks is None else n_looks),
    }


def _down_to(statistics, name, n_layers):
    """Values of the uppermost `n_layers` layers; where there is none, that of the nearest layer above with one."""
    values = statistics[name].transpose("layer").values.astype(float)
    usable = np.isfinite(values) & (values > 0)
    if not (usable.size and usable[0]):
        msg = f"{name} of the statistics must be positive and finite at layer 0, got {values[:1].tolist()}"
        raise ValueError(msg)
    above = np.maximum.accumulate(np.where(usable, np.arange(values.size), 0))
    return values[above[np.minimum(np.arange(n_layers), values.size - 1)]]
