"""The conditional GAN, pix2pix: layer masks to echograms."""

from snowsim.cgan.networks import PatchDiscriminator, UNetGenerator
from snowsim.cgan.render import render, trained_generator
from snowsim.cgan.settings import Settings
from snowsim.cgan.train import Training, settle_statistics, train_steps

__all__ = [
    "PatchDiscriminator",
    "Settings",
    "Training",
    "UNetGenerator",
    "render",
    "settle_statistics",
    "train_steps",
    "trained_generator",
]
