"""The conditional GAN, pix2pix: layer masks to echograms."""

from snowsim.cgan.inputs import Levels
from snowsim.cgan.render import render, render_as_expected, trained_generator
from snowsim.cgan.train import Training, least_bytes, networks_of, train_steps
from snowsim.settings.cgan import Settings

__all__ = [
    "Levels",
    "Settings",
    "Training",
    "least_bytes",
    "networks_of",
    "render",
    "render_as_expected",
    "train_steps",
    "trained_generator",
]
