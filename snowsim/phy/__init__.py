"""PHY, the physics-driven renderer: layers to echograms."""

from snowsim.phy.power import mean_power, mean_power_of
from snowsim.phy.rendering import render, render_echoes, render_scene
from snowsim.phy.speckle import draw_speckle

__all__ = ["draw_speckle", "mean_power", "mean_power_of", "render", "render_echoes", "render_scene"]
