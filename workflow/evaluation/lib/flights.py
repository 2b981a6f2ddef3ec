"""Configurations of the flights in the study of flights, with settings drawn for each."""

import copy

from snowsim.seeding import random_stream

# Ranges from which settings of a flight are drawn uniformly. They lie about the defaults, as far as
# flights over dry snow of Greenland and radars of this kind differ. Other settings stay as
# configured.
RANGES = {
    "climate": {
        "accumulation_factor": (0.70, 1.25),
        "anomaly_sd": (0.12, 0.24),
        "undulation_sd": (0.05, 0.10),
        "drift_sd": (0.06, 0.11),
        "relief_sd": (0.03, 0.06),
        "open_year": (0.6, 1.0),
    },
    "firn": {
        "surface_density_kg_m3": (310.0, 370.0),
        "horizon_jump_kg_m3": (120.0, 200.0),
        "horizon_year_sd": (0.30, 0.54),
        "crusts_per_year": (0.6, 1.8),
        "crust_jump_kg_m3": (30.0, 50.0),
        "layering_sd_kg_m3": (46.0, 56.0),
        "fade_depth_m": (1.8, 3.6),
    },
    "radar": {
        "bandwidth_hz": (4.5e9, 6.0e9),
        "surface_slope": (0.016, 0.030),
        "horizon_slope": (0.022, 0.036),
        "roughness_m": (0.012, 0.028),
        "surface_to_noise_db": (23.0, 31.0),
        "sidelobe_db": (-38.0, -30.0),
        "band_noise_db": (-7.0, -2.0),
        "line_gain_sd_db": (0.2, 0.6),
    },
}


def flights_of(first_seed, n_flights):
    """Names of the flights, each its seed."""
    return [str(first_seed + number) for number in range(n_flights)]


def draw_reference(reference, seed):
    """Section `reference` of the configuration for a flight, with settings of `RANGES` drawn."""
    drawn = copy.deepcopy(reference)
    for group, ranges in RANGES.items():
        for name, (low, high) in ranges.items():
            rng = random_stream(seed, "flights", group, name)
            value = float(f"{rng.uniform(low, high):.4g}")
            drawn.setdefault(group, {})[name] = value
    return drawn


def flight_config(config, study, flight):
    """Configuration of a whole run for one flight of a study, with its seed, climate and radar.

    The study says how many train and validation scenes there are, if it needs others. The flight
    with the seed of `config` is the default one. All other settings are those of `config` and so
    the same for every flight.
    """
    studied = config["studies"][study]
    own = copy.deepcopy(config)
    n_scenes = own["benchmark"]["n_scenes"]
    for split in ("train", "validation"):
        n_scenes[split] = studied.get(f"n_{split}", n_scenes[split])
    if int(flight) != config["seed"]:
        own["seed"] = int(flight)
        own["benchmark"]["test_seed"] = own["seed"]
        own["reference"] = draw_reference(config["reference"], own["seed"])
    own["own"] = {}
    # Each run keeps its unfinished trainings in its own folder.
    own["checkpoints"]["folder"] = "results/checkpoints"
    own["checkpoints"]["events"] = "logs/tensorboard"
    return own
