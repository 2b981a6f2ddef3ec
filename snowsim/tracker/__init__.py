"""The multi-scale layer tracker: echograms to layer probabilities."""

from snowsim.tracker.network import OUTPUTS, MultiScaleNetwork
from snowsim.tracker.sampling import TrainingSet
from snowsim.tracker.settings import Settings, published
from snowsim.tracker.track import track, trained_network
from snowsim.tracker.train import Training, train_steps

__all__ = [
    "OUTPUTS",
    "MultiScaleNetwork",
    "Settings",
    "Training",
    "TrainingSet",
    "published",
    "track",
    "train_steps",
    "trained_network",
]
