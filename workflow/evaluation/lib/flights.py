"""Flights of the study of flights: their settings, and the trainings that each is made of.

A run is a training set by name: those of Table III, drawn scenes alone, `CONTROLS`, those of the
learning curve, `Few`, and `UNIVERSAL`, which was trained on nothing of the flight.
"""

import copy
import csv
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from snowsim.seeding import random_stream

FIRST_SEED = 2000  # 1000 to 1999 serve for choosing settings
# What differs between flights, drawn uniformly: about each default, as far as flights over dry snow
# of Greenland and radars of this kind differ. What is not named stays as it is configured.
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
# Sets with real scenes or drawn ones, their networks made by the rules of the main path.
MAIN = ("rd", "pd", "gd", "rd_pd", "rd_gd", "rd_pd_gd")
WITH_CGAN = ("gd", "rd_gd", "rd_pd_gd")  # each training has a generator of its own
GENERATOR_SEEDS = 1_000_000  # apart, so that no generator has the seed of another flight

UNIVERSAL = "universal"  # the tracker that comes with the package


@dataclass(frozen=True)
class Control:
    """A training set that no run but this study has.

    `labels` are those of the real scenes, `with_phy` adds label sets rendered by PHY, `with_own`
    the annotated blocks that the statistics come from.
    """

    labels: str = "picked"
    with_phy: bool = False
    with_own: bool = False


CONTROLS = {
    "rd_full": Control(labels="complete"),
    "rd_full_pd": Control(labels="complete", with_phy=True),
    "rd_own": Control(with_own=True),
}


@dataclass(frozen=True)
class Few:
    """A training set of the learning curve: `training_set` made from `n` annotated scenes alone."""

    training_set: str
    n: int

    @property
    def name(self):
        """Its name among the runs of a flight."""
        return f"{self.training_set}_of_{self.n}"

    def real_files(self):
        """The file of the annotated scenes, where they are trained on."""
        return [] if self.training_set == "pd" else [f"results/one_flight/few/{self.n}/scenes.nc"]

    def drawn_files(self, shards):
        """Files of the scenes drawn from their statistics, where those are trained on."""
        if self.training_set == "rd":
            return []
        return [f"results/one_flight/few/{self.n}/phy/{shard}.nc" for shard in shards]


CURVE_SETS = ("rd", "pd", "rd_pd")


def few_of(study):
    """Runs of the learning curve by name; a single number is no curve and needs no RD."""
    made = CURVE_SETS if len(study["curve"]) > 1 else CURVE_SETS[1:]
    runs = [Few(training_set, n) for n in study["curve"] for training_set in made]
    return {run.name: run for run in runs}


def whole_runs(study):
    """Trainings on the whole of a flight, and the universal tracker, (run, replica)."""
    trained = product([*MAIN, *CONTROLS], range(study["n_trainings"]))
    return [*trained, (UNIVERSAL, 0)]


def few_runs(choices, study):
    """Trainings of the learning curve that can be made, (run, replica).

    `choices` are the files that say what can be drawn from few scenes.
    """
    refused = set()
    for path in choices:
        (row,) = csv.DictReader(Path(path).read_text().splitlines())
        if row["radiometry"] == "refused":
            refused.add(int(row["n_scenes"]))
    runs = []
    for name, run in few_of(study).items():
        if run.training_set == "rd" or run.n not in refused:
            runs.append(name)
    return list(product(runs, range(study["n_trainings"])))


def count_files(runs):
    """Where the counts of trainings lie."""
    return [f"results/one_flight/{run}/{replica}_counts.parquet" for run, replica in runs]


def generator_seed(seed, generator):
    """Seed of a flight's generator by its number; 0 is the flight's own."""
    return seed + GENERATOR_SEEDS * int(generator)


def network_files(run, replicas):
    """Where the networks of a run lie: of the main path's training sets, or of this study's.

    Of sets with scenes of the cGAN the main path has those by its one generator, the first replica.
    """
    files = []
    for replica in replicas:
        by_main_path = run in MAIN and (replica == 0 or run not in WITH_CGAN)
        folder = "tracker" if by_main_path else "one_flight"
        files.append(f"results/{folder}/{run}/{replica}.safetensors")
    return files


def flights_of(study):
    """Names of the flights, which are their seeds."""
    return [str(FIRST_SEED + number) for number in range(study["n_flights"])]


def with_curve(study):
    """Names of those flights that have a learning curve; the others have its last number alone."""
    return flights_of(study)[: study["n_curve_flights"]]


def draw_reference(reference, seed):
    """Section `reference` of a flight: what `RANGES` names drawn anew, by group and name."""
    drawn = copy.deepcopy(reference)
    for group, ranges in RANGES.items():
        for name, (low, high) in ranges.items():
            rng = random_stream(seed, "flights", group, name)
            value = float(f"{rng.uniform(low, high):.4g}")
            drawn.setdefault(group, {})[name] = value
    return drawn


def flight_config(config, flight):
    """Configuration of a whole run for one flight of the study: seed, climate, radar are its own.

    All else is as configured, so that settings are the same for every flight.
    """
    own = copy.deepcopy(config)
    study = own["studies"]["flights"]
    own["seed"] = int(flight)
    own["reference"] = draw_reference(config["reference"], own["seed"])
    # Each run keeps what is unfinished in its own folder.
    own["checkpoints"]["folder"] = "results/checkpoints"
    own["checkpoints"]["events"] = "logs/tensorboard"
    # A flight left out because its cGAN collapsed would be one chosen by its result.
    own["cgan"]["on_collapse"] = "go_on"
    if flight not in with_curve(study):
        study["curve"] = study["curve"][-1:]
    return own


def check_curve(study, n_train):
    """ValueError unless there are as many train scenes as the learning curve asks for."""
    most = max(study["curve"], default=0)
    if most > n_train:
        wanted = f"at most benchmark.n_scenes.train = {n_train}"
        msg = f"config: studies.flights.curve: expected {wanted}, got {most}"
        raise ValueError(msg)


def drawn_rows(reference, flight):
    """What was drawn for a flight: a row of its name and the settings that `RANGES` names."""
    row = {"flight": flight}
    for group, ranges in RANGES.items():
        for name in ranges:
            row[name] = reference[group][name]
    return row
