"""The conditional GAN, pix2pix: layer masks to echograms."""

from snowsim.cgan.guided import guide_of
from snowsim.cgan.health import faults, measure_losses, measure_renders
from snowsim.cgan.render import render, trained_generator, validate
from snowsim.cgan.settings import Settings
from snowsim.cgan.train import Training, least_bytes, networks_of, train_steps

__all__ = ["Settings", "Training", "faults", "guide_of"]
__all__ += ["least_bytes", "measure_losses", "measure_renders", "networks_of", "render"]
__all__ += ["train_steps", "trained_generator", "validate"]
