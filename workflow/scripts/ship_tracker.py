"""The pretrained tracker in the form in which it comes with the package: ONNX and a card."""

from job import run

from lib.pretraining import EVERY, scores_for_card
from lib.tracker_scores import read_calibration, read_confidence, read_tracker
from snowsim.io.files import read_dataset
from snowsim.io.trackers import write_tracker
from snowsim.statistics import Ranges
from snowsim.tracker.card import SYNTHETIC, make_card, ranges_of
from snowsim.tracker.portable import to_onnx

LIMITS = (
    "annual layers of dry snow and firn, 2-8 GHz, surface in row 50; no scene held brightness "
    "jumps, roll fades, sidelobes of deconvolution, ice lenses, or layers that percolation breaks"
)


def ship(
    network, calibration, confidence, statistics, tracker, card,
    *, n_scenes, n_variants, radar, scores,
):  # fmt: skip
    trained = read_tracker(network)
    calibrated = read_calibration(calibration)
    settings = trained.settings
    trained_on = f"{SYNTHETIC}: {n_scenes} scenes of each of {n_variants} variants of the "
    trained_on += "statistics of the reference flight with crusts and bands of noise, one in "
    trained_on += f"{EVERY} without and the flight's own but for short undulations, rendered by "
    trained_on += "PHY; "
    trained_on += f"{settings.n_steps} gradients of {settings.batch_size} crops, "
    trained_on += f"width {settings.width}"
    written = make_card(
        "universal",
        calibrated,
        trained_on=trained_on,
        **radar,
        ranges=ranges_of(read_dataset(statistics), Ranges()),
        scores=scores_for_card(scores),
        limits=LIMITS,
        confidence=read_confidence(confidence),
    )
    write_tracker(tracker, to_onnx(trained.network, calibrated.offset), written)


run(ship)
