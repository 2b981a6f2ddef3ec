"""The multi-scale layer tracker: echograms to layer probabilities."""

from snowsim.constants import OUTPUTS
from snowsim.tracker.network import (
    MultiScaleNetwork,
    PublishedNetwork,
    track,
    trained_network,
)
from snowsim.tracker.sampling import Completed, TrainingSet
from snowsim.tracker.settings import Settings, published
from snowsim.tracker.train import Training, annotated_pixels, train_steps

__all__ = [
    "OUTPUTS",
    "Completed",
    "MultiScaleNetwork",
    "PublishedNetwork",
    "Settings",
    "Training",
    "TrainingSet",
    "annotated_pixels",
    "published",
    "track",
    "train_steps",
    "trained_network",
]
