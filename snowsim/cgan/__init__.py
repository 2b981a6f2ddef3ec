"""The conditional GAN, pix2pix: layer masks to echograms."""

from snowsim.cgan.health import faults, measure_losses, measure_renders
from snowsim.cgan.networks import PatchDiscriminator, UNetGenerator
from snowsim.cgan.render import Collapsed, held_out, render, trained_generator, validate
from snowsim.cgan.settings import Settings
from snowsim.cgan.train import Training, least_bytes, settle_statistics, train_steps

__all__ = ["Collapsed", "PatchDiscriminator", "Settings", "Training", "UNetGenerator", "faults", "held_out"]
__all__ += ["least_bytes", "measure_losses", "measure_renders", "render", "settle_statistics", "train_steps"]
__all__ += ["trained_generator", "validate"]
