"""Card beside a tracker's weights: its calibration and the echograms that it was made for."""

from dataclasses import dataclass

import numpy as np

from snowsim.limits import BIN_S_LIMITS, LINE_SPACING_M_LIMITS, check_values

# Numbers that a card must hold, with their limits.
NUMBERS = {
    "bin_s": BIN_S_LIMITS,
    "line_spacing_m": LINE_SPACING_M_LIMITS,
    "temperature": (1e-3, 1e3),
    "threshold": (1e-6, 1 - 1e-6),
    "echo_db": (-np.inf, np.inf),
}
SHAPES = dict.fromkeys(NUMBERS, ()) | {"confidence": (3,)}
RANGED = ("bin_s", "line_spacing_m", "n_looks")
# Coefficients of `snowsim.tracker.confidence` for a card without its own, fitted on the synthetic
# flights of seeds 1000 to 1004.
CONFIDENCE = (-0.62, 0.1, 1.08)
# Mean power above the noise floor, over 5 rows and 33 range lines, below which no pick was right in
# simulations whose surface is at least 15 dB above noise.
ECHO_DB = 1.0
# Texts for people in a card that is written.
CARD_VERSION = "4"
INPUT_TEXT = (
    "image: float32 (n, 1, range_bin, range_line), 2 / 255 * grey - 1 of an 8-bit image, surface "
    "near row 50; grey is linear in dB, 0 at 10 dB below the noise floor (the least mean of a row "
    "in dB), 255 at the maximum"
)
QUALITY_TEXT = (
    "quality 1: confidence of 0.8 or more that a layer lies within 2 of the tracker's range bins, "
    "as calibrated on synthetic flights; never where bin_s, line_spacing_m or n_looks lie outside "
    "the ranges"
)
OUTPUT_TEXT = "logit: the same shape; probability of a layer is sigmoid(logit / temperature)"


@dataclass(frozen=True)
class Card:
    """The part of a tracker's card that picking uses.

    Attributes
    ----------
    name, version : str
    bin_s, line_spacing_m : float
        Range bin [s] and distance of range lines [m] of its training.
    temperature : float
        Divisor of its log-odds.
    threshold : float
        Calibrated probability above which a pixel counts as a layer.
    ranges : dict
        Least and largest `bin_s`, `line_spacing_m` and `n_looks` of the echograms that it was made
        for.
    confidence : tuple of float
        Coefficients of `snowsim.tracker.confidence`.
    echo_db : float
        Picks end at the deepest row whose mean power is this far above the noise floor.
    """

    name: str
    version: str
    bin_s: float
    line_spacing_m: float
    temperature: float
    threshold: float
    ranges: dict
    confidence: tuple
    echo_db: float

    @property
    def threshold_log_odds(self):
        """`threshold` as log-odds."""
        return float(np.log(self.threshold / (1 - self.threshold)))

    def outside(self, values):
        """One line for each value, given by name, outside the card's ranges, or without ranges."""
        if not self.ranges:
            return ["the tracker's card has no ranges"]
        return [
            f"{name} {values[name]:.4g} lies outside the tracker's {low:g} to {high:g}"
            for name, (low, high) in self.ranges.items()
            if name in values and (values[name] < low or values[name] > high)
        ]


def checked_card(content, where):
    """`Card` from the content of a JSON file; ValueError for missing or impossible numbers."""
    content = {"confidence": CONFIDENCE, "echo_db": ECHO_DB} | content
    held = content.get("ranges") or {}
    if not isinstance(held, dict):
        msg = f"{where}: ranges: expected limits by name, got {held!r}"
        raise ValueError(msg)
    ranges = {name: held[name] for name in RANGED if name in held}
    numbers = {name: content.get(name) for name in SHAPES}
    numbers |= {f"range of {name}": limits for name, limits in ranges.items()}
    for name, values in numbers.items():
        check_values(f"{where}: {name}", values, *NUMBERS.get(name, ()))
        shape = SHAPES.get(name, (2,))
        if np.shape(values) != shape or (shape == (2,) and values[0] > values[1]):
            msg = (
                f"{where}: {name}: expected numbers of shape {shape}, limits in order, got {values}"
            )
            raise ValueError(msg)
    return Card(
        str(content.get("name")),
        str(content.get("version")),
        **{name: float(content[name]) for name in NUMBERS},
        ranges={name: tuple(limits) for name, limits in ranges.items()},
        confidence=tuple(content["confidence"]),
    )


def make_card(
    name,
    calibration,
    *,
    trained_on,
    bin_s,
    line_spacing_m,
    limits,
    n_looks=None,
    ranges=None,
    scores=None,
    confidence=None,
):
    """Content of a tracker's card, a dict that JSON can hold, from its `Calibration`.

    `bin_s` [s], `line_spacing_m` [m] and `n_looks` are those of most scenes of its training;
    `ranges` has the least and the largest of all scenes by name. `scores` are those on unseen
    flights. `confidence` has the coefficients of `snowsim.tracker.confidence`, None for those of
    the package. Other values are None if they are not known.
    """
    card = {
        "name": name,
        "version": CARD_VERSION,
        "trained_on": trained_on,
        "input": INPUT_TEXT,
        "output": OUTPUT_TEXT,
        "quality": QUALITY_TEXT,
        "bin_s": bin_s,
        "line_spacing_m": line_spacing_m,
        "n_looks": n_looks,
        "temperature": round(calibration.temperature, 6),
        "threshold": round(calibration.threshold, 6),
        "calibration_ods": round(calibration.ods, 4),
        "calibration_deviation": round(calibration.deviation, 4),
        "ranges": ranges,
        "scores": scores,
        "limits": limits,
    }
    if confidence is not None:
        card["confidence"] = [round(value, 4) for value in confidence]
    return card
