"""The pretrained tracker in the form in which it comes with the package: ONNX and a card."""

from job import job

from lib.tracker_scores import read_tracker
from pretrained.card import ranges_of, scores_for_card
from pretrained.scenes import EVERY
from pretrained.scores import read_calibration, read_confidence
from snowsim.io.files import read_dataset
from snowsim.io.models import write_tracker
from snowsim.statistics import Ranges
from snowsim.tracker.card import SYNTHETIC, make_card
from snowsim.tracker.portable import to_onnx

LIMITS = (
    "annual layers of dry snow and firn, 2-8 GHz, surface in row 50; no scene held brightness "
    "jumps, roll fades, sidelobes of deconvolution, ice lenses, or layers that percolation breaks"
)

with job(snakemake):
    trained = read_tracker(snakemake.input.network)
    calibration = read_calibration(snakemake.input.calibration)
    settings = trained.settings
    n_scenes = snakemake.params.n_scenes
    n_variants = snakemake.params.n_variants
    trained_on = f"{SYNTHETIC}: {n_scenes} scenes of each of {n_variants} variants of the "
    trained_on += "statistics of the reference flight with crusts and bands of noise, one in "
    trained_on += f"{EVERY} without and the flight's own, as its picks give them, rendered by PHY; "
    trained_on += f"{settings.n_steps} gradients of {settings.batch_size} crops, "
    trained_on += f"width {settings.width}"
    card = make_card(
        "universal",
        calibration,
        trained_on=trained_on,
        **snakemake.params.radar,
        ranges=ranges_of(read_dataset(snakemake.input.statistics), Ranges()),
        scores=scores_for_card(snakemake.params.scores),
        limits=LIMITS,
        confidence=read_confidence(snakemake.input.confidence),
    )
    network = to_onnx(trained.network, calibration.offset)
    write_tracker(snakemake.output.tracker, network, card)
