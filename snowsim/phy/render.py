"""Layers and their parameters to one scene's power after M looks."""

import dataclasses

from snowsim.echogram import to_uint8
from snowsim.phy.plan import plan
from snowsim.phy.power import planned_power, tail_power
from snowsim.phy.speckle import draw_speckle
from snowsim.phy.texture import draw_gain, draw_texture
from snowsim.seeding import generator

LEAST_TAIL = 1e-3  # of the noise: what has less has no texture


def render(
    layer_bins,
    parameters,
    n_range_bins,
    *,
    tolerance_db,
    rng,
    speckle=None,
    normalise="peak",
    align="peak",
):
    """Power of one scene after M looks.

    Parameters
    ----------
    layer_bins : array_like, (layer, range_line)
        Fractional range bins; NaN where absent.
    parameters : mapping
        `peak_power` (layer) or (layer, range_line), `variance_bins2`, `decay_rate` (layer),
        `noise_power` and `n_looks`; optional: `speckle_correlation` (lag) down range, see
        `draw_speckle`; `texture` (variance, length in bins, in lines), see `snowsim.phy.texture`,
        and the `textured_layers` (layer) whose tail it multiplies, by default all;
        `line_gain_spread_db`.
    n_range_bins : int
        Height of the scene.
    tolerance_db : float or None
        Largest error of the mean power, noise included, at any pixel [dB]; None for exact.
    rng : int or numpy.random.Generator
    speckle : str, optional
        Method of `draw_speckle`; by default `gamma` without a tolerance, `quantile` with one.
        Correlated speckle is drawn by `quantile` for `gamma` and refused for the others.
    normalise, align : str
        See `mean_power`.

    Returns
    -------
    ndarray, (range_bin, range_line)
        Linear power; float32 where that is accurate enough for the plan, else float64.

    Raises
    ------
    ValueError
        If an argument or parameter is missing, unknown, out of range or of the wrong shape.

    Notes
    -----
    ``render(...)`` is ``render_plan(plan(...))``: plan first to keep the plan's notes.

    Examples
    --------
    >>> import numpy as np
    >>> parameters = {"peak_power": [1.0, 0.1], "noise_power": 1e-3, "n_looks": 16}
    >>> parameters |= {"variance_bins2": [2.0, 2.0], "decay_rate": [0.3, 0.1]}
    >>> layer_bins = np.array([[50.0] * 64, [70.0] * 64])
    >>> power = render(layer_bins, parameters, 120, tolerance_db=0.05, rng=np.random.default_rng(1))
    >>> power.shape
    (120, 64)
    >>> int(power.mean(axis=1).argmax())  # the range bin of the surface
    50
    """
    options = {"speckle": speckle, "normalise": normalise, "align": align}
    return render_plan(
        plan(layer_bins, parameters, n_range_bins, tolerance_db=tolerance_db, **options),
        rng=generator(rng),
    )


def mean_field(scene_plan, *, rng, added_power=None):
    """Mean power of a planned scene with texture and gain, (range_bin, range_line).

    `added_power`, of the same shape, is of no echo in the plan.
    """
    power = planned_power(scene_plan, added_power=scene_plan.noise_power)
    if scene_plan.texture is not None:
        texture = draw_texture(*power.shape, scene_plan.texture, rng=rng)
        texture -= 1
        texture *= tail_power(
            scene_plan.waveforms, scene_plan.textured_layers, LEAST_TAIL * scene_plan.noise_power
        )
        power += texture
    if added_power is not None:
        power += added_power
    if scene_plan.line_gain_spread_db > 0:
        power *= draw_gain(power.shape[1], scene_plan.line_gain_spread_db, rng=rng)
    return power


def render_plan(scene_plan, *, rng, mean=None):
    """Power of a planned scene after M looks about its `mean` field, (range_bin, range_line)."""
    power = mean_field(scene_plan, rng=rng) if mean is None else mean
    options = {"method": scene_plan.speckle, "correlation": scene_plan.correlation}
    return draw_speckle(power, scene_plan.n_looks, **options, rng=rng)


def render_scene(
    scene,
    *,
    rng,
    tolerance_db,
    echoes=None,
    added_power=None,
    speckle=None,
    normalise="peak",
    align="peak",
):
    """The scene with its image and its plan's notes, without echoes and complete layers.

    Rendered are the scene's own `echoes` unless others are given, `snowsim.labels.dress` makes
    them; mean power `added_power` (range_bin, range_line) of what is no echo is added to theirs.
    Further options are those of `render`.
    """
    echoes = echoes or scene.echoes
    planned = plan(
        echoes.bins,
        echoes.parameters(),
        scene.n_range_bins,
        tolerance_db=tolerance_db,
        speckle=speckle,
        normalise=normalise,
        align=align,
    )
    mean = mean_field(planned, rng=rng, added_power=added_power)
    image, noise_floor_db, maximum_db = to_uint8(render_plan(planned, rng=rng, mean=mean))
    return dataclasses.replace(
        scene,
        image=image,
        noise_floor_db=noise_floor_db,
        maximum_db=maximum_db,
        complete_layer_bins=None,
        echoes=None,
        notes=scene.notes | planned.notes(),
    )
