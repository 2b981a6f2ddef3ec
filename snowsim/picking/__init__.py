"""Layers picked in any echogram, by a trained network and without annotation."""

from snowsim.picking.canonical import canonical
from snowsim.picking.card import Card, checked_card
from snowsim.picking.linking import Linking
from snowsim.picking.picker import evidence_of, layers_of_frames, pick_layers, probability_of

__all__ = [
    "Card",
    "Linking",
    "canonical",
    "checked_card",
    "evidence_of",
    "layers_of_frames",
    "pick_layers",
    "probability_of",
]
