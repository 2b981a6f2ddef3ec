"""The conditional GAN, pix2pix: layer masks to echograms."""

from snowsim.cgan.guided import guide_of
from snowsim.cgan.render import render, trained_generator, validate
from snowsim.cgan.settings import Settings
from snowsim.cgan.train import Training, least_bytes, networks_of, train_steps

__all__ = [
    "Settings",
    "Training",
    "guide_of",
    "least_bytes",
    "networks_of",
    "render",
    "train_steps",
]
__all__ += ["trained_generator", "validate"]
