# Helpers that all rules of the evaluation share.

import yaml
from snakemake.logging import logger
from snakemake.utils import update_config

if SOURCE == "png_pairs":
    logger.info(
        "left out: figures of the flight and Doppler spectra: images hold no positions, no phase"
    )
elif SOURCE != "reference":
    logger.info("left out: Doppler spectra: files of detected power hold no phase")


# Stage of every figure, by its path.
FIGURES = {}


def caption_file(figure):
    """Path of a figure's caption in the checkout."""
    return f"workflow/evaluation/report/captions/{Path(figure).stem}.rst"


def drawn(stage, *files):
    """Outputs of a rule that draws figures of a stage, with captions for Snakemake's own report."""
    outputs = {}
    for file in files:
        path = Path("results/figures") / file
        FIGURES[str(path)] = stage
        outputs[file.replace(".", "_")] = report(
            path, caption=str(ROOT / caption_file(file)), category=stage
        )
    return outputs
