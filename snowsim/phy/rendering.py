"""Layers and their parameters to one scene's power after M looks."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from snowsim.constants import NEPERS
from snowsim.echogram import to_uint8
from snowsim.limits import check_values
from snowsim.phy.power import checked_waveforms, echoes_of_parameters, power_of
from snowsim.phy.speckle import check_looks, draw_unchecked
from snowsim.seeding import generator

REQUIRED = ("peak_power", "variance_bins2", "decay_rate", "noise_power", "n_looks")
OPTIONAL = ("speckle_correlation", "line_gain_spread_db")


def render(
    layer_bins: ArrayLike,
    parameters: Mapping[str, Any],
    n_range_bins: int,
    *,
    rng: int | np.random.Generator,
    exact: bool = False,
    as_printed: bool = False,
) -> NDArray[np.floating]:
    """Power of one scene after M looks.

    Parameters
    ----------
    layer_bins : array_like, (layer, range_line)
        Fractional range bins; NaN where absent.
    parameters : mapping
        `peak_power` (layer) or (layer, range_line), `variance_bins2`, `decay_rate` (layer),
        `noise_power` and `n_looks`; optional: `speckle_correlation` (lag) down range, see
        `draw_speckle`, and `line_gain_spread_db`, the standard deviation of gain from range line to
        range line.
    n_range_bins : int
        Height of the scene.
    rng : int or numpy.random.Generator
    exact, as_printed : bool, optional
        See `mean_power`. Speckle is drawn by `gamma` if exact and not correlated, else by
        `quantile`.

    Returns
    -------
    ndarray, (range_bin, range_line)
        Linear power, float64 if exact, else float32.

    Raises
    ------
    ValueError
        If an argument or parameter is missing, unknown, out of range or of the wrong shape.

    Examples
    --------
    >>> import numpy as np
    >>> parameters = {"peak_power": [1.0, 0.1], "noise_power": 1e-3, "n_looks": 16}
    >>> parameters |= {"variance_bins2": [2.0, 2.0], "decay_rate": [0.3, 0.1]}
    >>> layer_bins = np.array([[50.0] * 64, [70.0] * 64])
    >>> power = render(layer_bins, parameters, 120, rng=np.random.default_rng(1))
    >>> power.shape
    (120, 64)
    >>> int(power.mean(axis=1).argmax())  # the range bin of the surface
    50
    """
    if {*parameters, *OPTIONAL} != {*REQUIRED, *OPTIONAL}:
        got = ", ".join(map(str, parameters)) or "none"
        msg = f"parameters: expected {', '.join(REQUIRED)}, got {got}"
        raise ValueError(msg)
    echoes = echoes_of_parameters(layer_bins, **parameters)
    conventions = {"exact": exact, "as_printed": as_printed}
    return render_echoes(echoes, n_range_bins, rng=generator(rng), **conventions)


def render_echoes(echoes, n_range_bins, *, rng, added_power=0.0, exact=False, as_printed=False):
    """Power of `Echoes` after M looks, (range_bin, range_line), as `render` gives it.

    `added_power` (range_bin, range_line) is added to the mean power of the echoes and the noise.
    """
    for name in ("noise_power", "line_gain_spread_db"):
        check_values(name, getattr(echoes, name), 0, number=True)
    correlation = echoes.speckle_correlation
    method = "gamma" if exact and correlation is None else "quantile"
    check_looks(method, echoes.n_looks, correlation)
    power = power_of(checked_waveforms(echoes, n_range_bins, as_printed=as_printed), exact=exact)
    power += echoes.noise_power
    power += added_power
    if echoes.line_gain_spread_db > 0:
        power *= draw_gain(power.shape[1], echoes.line_gain_spread_db, rng=rng)
    return draw_unchecked(power, echoes.n_looks, method=method, correlation=correlation, rng=rng)


def draw_gain(n_range_lines, spread_db, *, rng):
    """Factors of power by range line, lognormal of mean 1, float32 (range_line,)."""
    spread = NEPERS * spread_db
    log_gain = spread * rng.standard_normal(n_range_lines) - spread**2 / 2
    return np.exp(log_gain).astype(np.float32)


def render_scene(scene, *, rng, echoes=None, **options):
    """The scene with its image, without echoes and complete layers.

    Renders the scene's own `echoes` unless others are given: `snowsim.labels.echoes_of_layers`
    makes them. Further options are those of `render_echoes`.
    """
    power = render_echoes(echoes or scene.echoes, scene.n_range_bins, rng=rng, **options)
    image, noise_floor_db, maximum_db = to_uint8(power)
    return dataclasses.replace(
        scene,
        image=image,
        noise_floor_db=noise_floor_db,
        maximum_db=maximum_db,
        complete_layer_bins=None,
        echoes=None,
    )
