"""The pretrained tracker in the form in which it comes with the package: ONNX and a card."""

from job import ROOT, job

from lib.tracker_scores import read_tracker
from pretrained.card import commit_of, making, ranges_of, scores_for_card
from pretrained.scenes import EVERY, FirnRanges
from pretrained.scores import read_calibration, read_confidence
from snowsim.io.files import read_dataset
from snowsim.io.models import write_tracker
from snowsim.statistics import Ranges
from snowsim.tracker import make_card, to_onnx

SYNTHETIC = "trained on synthetic scenes only; never scored on an annotated real frame"
LIMITS = (
    "annual layers of dry snow and firn, 2-8 GHz, surface in row 50; no scene held brightness "
    "jumps, roll fades, sidelobes of deconvolution, ice lenses, or layers that percolation breaks"
)

with job(snakemake):
    trained = read_tracker(snakemake.input.network)
    calibration = read_calibration(snakemake.input.calibration)
    settings = trained.settings
    n_scenes = snakemake.params.n_scenes
    n_varied = snakemake.params.n_varied
    n_firn = n_scenes * (snakemake.params.n_variants - n_varied)
    trained_on = (
        f"{SYNTHETIC}: {n_scenes} scenes of each of {n_varied} variants of the statistics "
        "of the reference flight with crusts and bands of noise, one in "
        f"{EVERY} without and the flight's own, as its picks give them, rendered by PHY; "
        f"{n_firn} of clean firn by snowsim.simulate; "
        f"{settings.n_steps} gradients of {settings.batch_size} crops, "
        f"{settings.network}, width {settings.width}"
    )
    made = making(
        trained.network,
        commit_of(ROOT),
        snakemake.params.seed,
        snakemake.params.benchmark,
    )
    card = make_card(
        "universal",
        calibration,
        trained_on=trained_on,
        **snakemake.params.radar,
        ranges=ranges_of(read_dataset(snakemake.input.statistics), Ranges(), FirnRanges()),
        scores=scores_for_card(snakemake.params.scores),
        limits=LIMITS,
        confidence=read_confidence(snakemake.input.confidence),
    )
    about = {name: str(value) for name, value in ({"name": card["name"]} | made).items()}
    about["version"] = card["version"]
    network = to_onnx(trained.network, calibration.offset, about)
    write_tracker(snakemake.output.tracker, network, card | made)
