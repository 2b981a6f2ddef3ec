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


def drawn_range(w):
    """First scene of a shard of `n_drawn` label sets and the one after its last, from wildcards."""
    first = int(w.shard) * SHARD_SIZE["labels"]
    return first, min(first + SHARD_SIZE["labels"], int(w.n_drawn))


def drawn_mb(w, kb_per_scene):
    """Size on disk of the scenes of such a shard [MB]."""
    first, end = drawn_range(w)
    return math.ceil((end - first) * kb_per_scene / 1e3)
