"""The multi-scale layer tracker: probabilities of layers from echograms."""

from snowsim.constants import OUTPUTS
from snowsim.settings.tracker import Settings, published_settings
from snowsim.tracker.network import MultiScaleNetwork, track
from snowsim.tracker.published import PublishedNetwork
from snowsim.tracker.sampling import Completed, TrainingSet
from snowsim.tracker.train import Training, train_steps, trained_network

__all__ = [
    "OUTPUTS",
    "Completed",
    "MultiScaleNetwork",
    "PublishedNetwork",
    "Settings",
    "Training",
    "TrainingSet",
    "published_settings",
    "track",
    "train_steps",
    "trained_network",
]
