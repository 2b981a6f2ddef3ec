"""The conditional GAN, pix2pix: layer masks to echograms."""

from snowsim.cgan.train import (
    Training,
    least_bytes,
    networks_of,
    render,
    train_steps,
    trained_generator,
)
from snowsim.settings import CganSettings as Settings

__all__ = [
    "Settings",
    "Training",
    "least_bytes",
    "networks_of",
    "render",
    "train_steps",
    "trained_generator",
]
