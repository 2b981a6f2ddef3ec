"""The multi-scale layer tracker: echograms to layer probabilities."""

from snowsim.constants import OUTPUTS
from snowsim.settings import tracker as settings
from snowsim.settings.tracker import Settings
from snowsim.tracker.loss import annotated_pixels
from snowsim.tracker.network import MultiScaleNetwork, track
from snowsim.tracker.published import PublishedNetwork
from snowsim.tracker.sampling import Completed, TrainingSet
from snowsim.tracker.train import Training, train_steps, trained_network

# Over the module of the same name, which holds its network.
published = settings.published

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
