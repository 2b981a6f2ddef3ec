"""Accuracy of trackers on flights for development, against what training cost and their speed.

``PYTHONPATH=workflow python benchmarks/bench_pretrained.py [NETWORK.safetensors...]`` scores
networks that the rule `train_pretrained` made, by default results/pretrained/network.safetensors,
on eight flights whose seeds nothing else uses (12 scenes each) and on 36 scenes of clean firn.
Prints network, width and gradients, F of picks and false pieces of each true layer at the threshold
that the rule would choose on these flights, the same on clean firn, and range lines that one thread
tracks a second of processor time. The choice of these three rests on it, never on flights of
`transfer`.
"""

import dataclasses
import sys
import time

import pandas as pd
import torch

from lib.tracker_scores import read_tracker
from pretrained.confidence import fit_confidence, pick_curve, threshold_of
from pretrained.resizing import in_bins
from pretrained.scenes import firn_scenes
from pretrained.scores import Calibrated, followed, pick_scores
from pretrained.transfer import reference_of, scale_of
from reference import checked_settings, draw_climate, draw_scene
from reference.settings import Settings
from snowsim.io.files import read_dataset
from snowsim.seeding import random_stream
from snowsim.tracker import calibrate, fused_logits

N_SCENES = 12
N_FIRN, FIRN_SEED = 36, 1177
N_ROUNDS = 20
LINE_SEED, LOOKS = 20120429, 16  # of the default configuration
FLIGHTS = [
    {"seed": 1101},
    {"seed": 1102, "reference": {"climate": {"accumulation_factor": 1.75}}},
    {"seed": 1103, "reference": {"climate": {"accumulation_factor": 0.55}}},
    {"seed": 1104, "reference": {"radar": {"bandwidth_hz": 2.7e9}}},
    {
        "seed": 1105,
        "n_looks": 5,
        "reference": {
            "radar": {"surface_to_noise_db": 21.0, "band_noise_db": 0.0, "sidelobe_db": -29.0}
        },
    },
    {"seed": 1106, "reference": {"firn": {"percolation_elevation_m": 2500.0}}},
    {"seed": 1107, "reference": {"radar": {"height_m": 1200.0, "line_spacing_m": 9.0}}},
    {"seed": 1108, "reference": {"radar": {"bin_size_s": 1.7e-10, "n_range_bins": 1360}}},
]


def scenes_of(flight):
    """Scenes of a flight, in the range bins that the tracker was trained on."""
    default = dataclasses.asdict(Settings())
    settings = checked_settings(reference_of(flight, default))
    climate, own = (
        draw_climate(settings, rng=random_stream(seed, "climate"))
        for seed in (LINE_SEED, flight["seed"])
    )
    climate = dataclasses.replace(climate, track_seed=own.track_seed)
    share, _ = scale_of(flight, default)
    common = {"climate": climate, "settings": settings, "n_looks": flight.get("n_looks", LOOKS)}
    for number in range(N_SCENES):
        rng = random_stream(flight["seed"], "reference_scenes", "test", number)
        yield in_bins(draw_scene(number, "test", **common, rng=rng), share)


def scored(network, flights, firn):
    """Row of scores of a network."""
    held = [scene for scenes in flights for scene in scenes]
    logits = [fused_logits(network, scene.image) for scene in held]
    times = []
    for _ in range(N_ROUNDS):
        start = time.process_time()
        fused_logits(network, held[0].image)
        times.append(time.process_time() - start)
    calibration = calibrate(logits, held)
    curve = pick_curve(logits, held, calibration)
    calibration = dataclasses.replace(calibration, threshold=threshold_of(curve))
    tracker = Calibrated(network, calibration, fit_confidence(logits, held, calibration))

    def of_picks(logits, scenes):
        """F and share of false pieces."""
        pairs = zip(logits, scenes, strict=True)
        picks = [followed(each, tracker, scene.image.shape) for each, scene in pairs]
        scores = pick_scores(picks, scenes)
        return scores["f"], scores["false_share"]

    bounds = [N_SCENES * n for n in range(len(flights) + 1)]
    parts = zip(flights, bounds[:-1], bounds[1:], strict=True)
    own = pd.DataFrame([of_picks(logits[first:end], scenes) for scenes, first, end in parts])
    f, false_share = own.mean()
    firn_f, _ = of_picks([fused_logits(network, scene.image) for scene in firn], firn)
    return {
        "threshold": calibration.threshold,
        "flights: F": f,
        "false": false_share,
        "firn: F": firn_f,
        "lines/s": held[0].image.shape[1] / min(times),
    }


def main():
    """Print the table."""
    torch.set_num_threads(1)
    paths = sys.argv[1:] or ["results/pretrained/network.safetensors"]
    flights = [list(scenes_of(flight)) for flight in FLIGHTS]
    statistics = read_dataset("snowsim/data/reference_flight.nc")
    firn = list(firn_scenes(statistics, 0, N_FIRN, n_range_lines=256, seed=FIRN_SEED))
    rows = []
    for path in paths:
        tracker = read_tracker(path)
        names = ("network", "width", "n_steps")
        kept = {name: getattr(tracker.settings, name) for name in names}
        rows.append({"file": path} | kept | scored(tracker.network, flights, firn))
    print(pd.DataFrame(rows).to_string(index=False, float_format="{:.3f}".format))  # noqa: T201


if __name__ == "__main__":
    main()
