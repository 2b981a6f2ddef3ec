"""The trained tracker, for echograms in memory."""

import warnings
from os import PathLike
from pathlib import Path
from typing import Self

import xarray as xr

from snowsim.echogram import SURFACE_NAME, check_choice
from snowsim.io.files import refusal
from snowsim.io.layers import TRACKED_PREFIX
from snowsim.io.models import read_tracker, shipped_trackers
from snowsim.tracker import (
    canonical,
    checked_card,
    evidence_of,
    layers_of_frames,
    probability_of,
    runner,
)


def list_pretrained() -> list[str]:
    """Names that `Tracker.from_pretrained` knows."""
    return sorted(shipped_trackers())


class Tracker:
    """A trained tracker that picks layers in echograms of `snowsim.io.read_echogram`.

    It was trained on synthetic scenes and needs no annotation of the echogram. It resamples range
    bins, averages range lines and levels the surface as in its training; picks are given on the
    echogram's own axes.

    Attributes
    ----------
    card : snowsim.tracker.Card
        Range bins, line spacing and looks that the tracker was made for, and its calibration.

    Examples
    --------
    >>> tracker = Tracker.from_pretrained("universal")  # doctest: +SKIP
    >>> layers = tracker.pick(read_echogram("frame.nc"))  # doctest: +SKIP
    """

    def __init__(self, weights, card, where="weights"):
        self._given = (weights, card, where)
        self.card = checked_card(card, Path(where).with_suffix(".json"))
        self._run = runner(weights, self.card.temperature, where)

    def __repr__(self):
        made_for = f"bins of {1e9 * self.card.bin_s:g} ns, lines {self.card.line_spacing_m:g} m"
        return f"Tracker({self.card.name} {self.card.version}, made for {made_for} apart)"

    def __reduce__(self):
        """How to make it again from a pickle, in another process: onnxruntime's session cannot."""
        return type(self), self._given

    @classmethod
    def from_pretrained(cls, name: str = "universal") -> Self:
        """Load one of the trackers that `list_pretrained` names."""
        shipped = shipped_trackers()
        check_choice("a tracker that comes with the package", name, shipped)
        return cls.load(shipped[name])

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Load a tracker from an ONNX file and the card beside it, NAME.json.

        ValueError unless both files are whole, belong together and are of this version.
        """
        if not Path(path).is_file():
            known = ", ".join(list_pretrained()) or "none"
            wanted = f"an ONNX file (or for --model and Tracker.from_pretrained one of: {known})"
            raise refusal(path, "tracker", wanted, "nothing")
        weights, card = read_tracker(path)
        return cls(weights, card, str(path))

    def annotate(self, echogram: xr.Dataset) -> xr.DataArray:
        """Probability of a layer at every pixel, DataArray on the echogram's own axes.

        It is NaN above and below the rows that the tracker was given.
        """
        seen = canonical(echogram, self.card)
        _warn_of(seen.notes)
        probability = probability_of(self._run, seen)
        coordinates = {name: echogram[name] for name in ("twtt", "slow_time")}
        attributes = {"units": "1", "long_name": "probability of a layer"}
        return xr.DataArray(
            probability, coordinates, ("twtt", "slow_time"), "probability", attributes
        )

    def pick(self, echogram: xr.Dataset) -> xr.Dataset:
        """Layers of an echogram, a dataset like that of `snowsim.io.read_layers`.

        `twtt` [s] is (layer, slow_time): layer 0 is the surface, NaN means no pick. `confidence` is
        the probability that a layer lies within 2 of the tracker's range bins of the pick;
        `quality` (1 good, 2 moderate, 3 bad) follows it. Nine of ten layers lie between `twtt_low`
        and `twtt_high`. Notes about the echogram are given as warnings and in `attrs["notes"]`.
        """
        evidence = self.detect(echogram)
        _warn_of(evidence.notes)
        (layers,) = self.pick_together([evidence])
        return layers

    def detect(self, echogram, where="echogram"):
        """Candidates for layers in one frame, for `pick_together`, without the frame's samples."""
        return evidence_of(self._run, canonical(echogram, self.card, where), self.card)

    def pick_together(self, evidence):
        """Layers of frames that follow one another: the same name is the same layer in all frames.

        `evidence` is a list of what `detect` gives for each frame. Datasets are those of `pick`;
        each has only the layers that were picked in its frame.
        """
        found = layers_of_frames(evidence, self.card)
        for frame, layers in zip(evidence, found, strict=True):
            layers.coords["layer"] = layer_names(layers["layer"].values)
            layers.attrs["tracker"] = f"{self.card.name} {self.card.version}"
            layers.attrs["notes"] = "; ".join(frame.notes)
        return found


def _warn_of(notes):
    """Issue each note as a UserWarning of the calling public function."""
    for note in notes:
        warnings.warn(note, UserWarning, stacklevel=3)


def layer_names(numbers):
    """Names of layers by number; the first is the surface."""
    return [SURFACE_NAME, *(f"{TRACKED_PREFIX}{number}" for number in numbers[1:])]
