"""Plan of a scene: from a tolerance in dB, which parts of eq. (1) to compute, and their cost."""

from dataclasses import dataclass, replace

import numpy as np

from snowsim.limits import check_values
from snowsim.phy.correlated import correlating_taps
from snowsim.phy.parameters import EXACT_BOUND_DB, Waveforms, checked_waveforms
from snowsim.phy.speckle import check_method
from snowsim.phy.tables import Supports, allowed_error, find_supports

NEEDED = ("peak_power", "variance_bins2", "decay_rate", "noise_power", "n_looks")
OPTIONAL = ("speckle_correlation", "texture", "textured_layers", "line_gain_spread_db")
LEAST = {"noise_power": 0, "n_looks": 1, "line_gain_spread_db": 0, "tolerance_db": EXACT_BOUND_DB}

# Nanoseconds measured on one core beside those for one float32 normal, COST_NORMAL: their ratios
# carry over to other machines.
COST_NORMAL = 8.6
COST_SCENE = 3e5
COST_NODE = 100.0
COST_CLOSED_FORM = 45.0
COST_TABLE_TERM = 0.8
COST_EXPONENTIAL_TERM = 0.3
COST_PIXEL = 1.0
COST_SPECKLE = {"gamma": 16.0, "quantile": 2.0, "correlated": 6.0}
COST_LOOK = 18.0
COST_TEXTURE = 6.0
MOST_NODES = 1_000_000  # of tables, 48 bytes each; beyond, the closed form is used


@dataclass(frozen=True)
class Plan:
    """How one scene is modelled: `planned_power` and `render_plan` follow it.

    `noise_power` is what errors are measured against and what rendering adds; `n_looks` is NaN
    where only mean power is wanted; `supports` is None for the closed form on every pixel. No pixel
    of ``P_s + noise_power`` is further than `bound_db` from exact. `n_terms` counts pixels times
    layers computed, `cost_normals` is the predicted cost per pixel in draws of one float32 normal.
    `correlation` (lag,) of speckle down range is None where range bins are independent; drawn
    speckle differs by at most `correlation_error` at any lag. `texture`, or None, goes to
    `draw_texture` for the echo of `textured_layers`; range lines differ in gain by
    `line_gain_spread_db`. Neither is an error of the mean.
    """

    waveforms: Waveforms
    noise_power: float
    n_looks: float
    tolerance_db: float | None
    speckle: str
    supports: Supports | None
    bound_db: float
    n_terms: int
    cost_normals: float
    correlation: np.ndarray | None = None
    correlation_error: float = 0.0
    texture: tuple | None = None
    textured_layers: np.ndarray | None = None
    line_gain_spread_db: float = 0.0

    @property
    def method(self):
        """How the mean power is computed: ``exact`` or ``table``."""
        return "exact" if self.supports is None else "table"

    @property
    def n_dropped(self):
        """Layers left out because the noise hides them."""
        return 0 if self.supports is None else int((~self.supports.kept).sum())

    @property
    def share(self):
        """Pixels times layers computed, as a share of the full model's."""
        return self.n_terms / max(_n_terms_full(self.waveforms), 1)

    def notes(self):
        """Numbers to keep with the scene, JSON-able."""
        speckle = self.speckle
        if self.correlation is not None:
            speckle += ", correlated"
        return {
            "plan_method": self.method,
            "plan_speckle": speckle,
            "plan_correlation_error": self.correlation_error,
            "plan_tolerance_db": self.tolerance_db,
            "plan_bound_db": self.bound_db,
            "plan_cost_normals": self.cost_normals,
            "plan_terms": self.n_terms,
            "plan_terms_full": _n_terms_full(self.waveforms),
            "plan_share": self.share,
            "plan_layers": int(self.waveforms.amplitude.size),
            "plan_layers_dropped": self.n_dropped,
        }


def plan(
    layer_bins,
    parameters,
    n_range_bins,
    *,
    tolerance_db,
    speckle=None,
    normalise="peak",
    align="peak",
):
    """`Plan` of a scene, before any pixel is computed; arguments as for `render`, refusals too.

    `speckle` is a method of `draw_speckle`, by default `gamma` without a tolerance and `quantile`
    with one. Where `parameters` hold a `speckle_correlation`, `quantile` replaces `gamma`: only it
    draws correlated range bins.
    """
    given = dict.fromkeys(OPTIONAL) | dict(parameters)
    if given.keys() != {*NEEDED, *OPTIONAL}:
        got = ", ".join(map(str, parameters)) or "none"
        msg = f"parameters: expected {', '.join(NEEDED)}, got {got}"
        raise ValueError(msg)
    waveforms = checked_waveforms(
        layer_bins,
        given["peak_power"],
        given["variance_bins2"],
        given["decay_rate"],
        n_range_bins,
        normalise,
        align,
    )
    gain_db = float(given["line_gain_spread_db"] or 0.0)
    numbers = given | {"line_gain_spread_db": gain_db, "tolerance_db": tolerance_db}
    for name, least in LEAST.items():
        if numbers[name] is not None:
            check_values(name, numbers[name], least, number=True)
    noise_power = float(given["noise_power"])
    n_looks = float(given["n_looks"])
    correlation = given["speckle_correlation"]
    if speckle is None:
        speckle = "gamma" if tolerance_db is None else "quantile"
    if correlation is not None and speckle == "gamma":
        speckle = "quantile"
    check_method(speckle, n_looks, correlation)
    planned = plan_power(waveforms, noise_power, tolerance_db, n_looks, speckle, correlation)
    planned = replace(planned, line_gain_spread_db=gain_db)
    texture, textured = _checked_texture(given, waveforms.amplitude.size)
    if texture is None or texture[0] == 0:
        return planned
    cost = planned.cost_normals + COST_TEXTURE / COST_NORMAL
    return replace(planned, texture=texture, textured_layers=textured, cost_normals=cost)


def _checked_texture(given, n_layers):
    """Texture as floats, or None, and indices of the layers whose tails have it."""
    textured = given["textured_layers"]
    textured = np.ones(n_layers, dtype=bool) if textured is None else np.asarray(textured)
    lengths = (0, 1, 0) if given["texture"] is None else given["texture"]
    check_values("texture: variance, length in range bins and in range lines", lengths, 0)
    are_layers = textured.shape == (n_layers,) and textured.dtype == bool
    if np.shape(lengths) != (3,) or lengths[1] == 0 or not are_layers:
        msg = "texture must be a variance and lengths in range bins, above 0, and in range lines, "
        msg += f"textured_layers true or false for each of {n_layers} layers, "
        msg += f"got {lengths} and {textured.dtype} of shape {textured.shape}"
        raise ValueError(msg)
    texture = None if given["texture"] is None else tuple(map(float, lengths))
    return texture, np.flatnonzero(textured)


def plan_power(
    waveforms, noise_power, tolerance_db, n_looks=np.nan, speckle="gamma", correlation=None
):
    """Plan for what is checked already. Without noise nothing can be left out."""
    tolerance_db = None if tolerance_db is None else float(tolerance_db)
    n_pixels = waveforms.n_range_bins * waveforms.centre_bins.shape[1]
    supports = None
    bound_db = EXACT_BOUND_DB
    n_terms = _n_terms_full(waveforms)
    cost = COST_CLOSED_FORM * n_terms
    found = None
    if tolerance_db is not None and noise_power > 0:
        found = find_supports(waveforms, noise_power, allowed_error(tolerance_db))
    if found is not None:
        n_table, n_exponential = found.n_rows(waveforms.centre_bins, waveforms.n_range_bins)
        n_nodes = found.n_nodes()
        cost_found = COST_NODE * n_nodes + COST_TABLE_TERM * n_table
        cost_found += COST_EXPONENTIAL_TERM * n_exponential
        if cost_found < cost and n_nodes <= MOST_NODES:
            supports = found
            bound_db = float(-10 * np.log10(1 - found.error))
            n_terms = n_table + n_exponential
            cost = cost_found
    cost += COST_SCENE + n_pixels * COST_PIXEL
    correlation_error = 0.0
    if correlation is not None:
        cost += n_pixels * COST_SPECKLE["correlated"]
        _, correlation_error = correlating_taps(correlation, n_looks)
    elif np.isfinite(n_looks):
        cost += n_pixels * COST_SPECKLE.get(speckle, COST_LOOK * n_looks)
    return Plan(
        waveforms=waveforms,
        noise_power=noise_power,
        n_looks=n_looks,
        tolerance_db=tolerance_db,
        speckle=speckle,
        supports=supports,
        bound_db=bound_db,
        n_terms=n_terms,
        cost_normals=float(cost / (max(n_pixels, 1) * COST_NORMAL)),
        correlation=correlation,
        correlation_error=correlation_error,
    )


def _n_terms_full(waveforms):
    """Pixels times present layers: what the full model computes."""
    return int(np.isfinite(waveforms.centre_bins).sum()) * waveforms.n_range_bins
