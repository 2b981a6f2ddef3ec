"""PHY, the physics-driven renderer: layers to echograms, as exact as asked for."""

from snowsim.phy.plan import Plan, plan
from snowsim.phy.power import mean_power
from snowsim.phy.render import mean_field, render, render_plan, render_scene
from snowsim.phy.speckle import draw_speckle

__all__ = [
    "Plan",
    "draw_speckle",
    "mean_field",
    "mean_power",
    "plan",
    "render",
    "render_plan",
    "render_scene",
]
