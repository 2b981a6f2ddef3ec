"""Flights beside the default's, which the shipped tracker is tuned or scored on."""

import copy
from collections import Counter

from snakemake.utils import update_config

from reference import checked_settings

TUNING_SEEDS = range(1000, 2000)


def n_varied(pretrained):
    """Variants of the flight's statistics; those after them are clean firn."""
    return round(pretrained["n_variants"] * (1 - pretrained["firn_share"]))


def reference_of(flight, reference):
    """Settings of the reference flight as another flight has them."""
    changed = copy.deepcopy(dict(reference))
    update_config(changed, flight.get("reference", {}))
    return changed


def scale_of(flight, reference):
    """Factors that bring an image of a flight to the default's bins and lines: (bin, line).

    Lines farther apart than the default's are used as they are, as `snowsim track` does.
    """
    own = reference_of(flight, reference)["radar"]
    radar = reference["radar"]
    lines = own["line_spacing_m"] / radar["line_spacing_m"]
    return own["bin_size_s"] / radar["bin_size_s"], min(lines, 1)


def check_flights(tuning, unseen, config):
    """ValueError unless names differ, seeds are those of their use, and settings are possible."""
    flights = [*tuning, *unseen]
    [(name, times)] = Counter(flight["name"] for flight in flights).most_common(1)
    if times > 1:
        msg = f"config: flights: expected every name once, got {name} {times} times"
        raise ValueError(msg)
    for flight in flights:
        seed = flight["seed"]
        if (seed in TUNING_SEEDS) != (flight in tuning) or seed == config["seed"]:
            msg = (
                f"config: flight {flight['name']}: expected a seed from 1000 to 1999 for tuning, "
                f"for scores another, and not the configuration's own, got {seed}"
            )
            raise ValueError(msg)
        try:
            checked_settings(reference_of(flight, config["reference"]))
        except ValueError as error:
            msg = f"config: flight {flight['name']}: {error}"
            raise ValueError(msg) from None
