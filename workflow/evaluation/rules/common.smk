# What the rules of the evaluation share.

import copy

import yaml
from snakemake.logging import logger
from snakemake.utils import update_config

# What the source cannot give, and why.
LEFT_OUT = {}
if SOURCE == "png_pairs":
    LEFT_OUT["Doppler spectra"] = "images hold no phase"
    LEFT_OUT["map and echogram of the flight"] = (
        "images hold no positions; statistics come from the train scenes"
    )
elif SOURCE != "reference":
    LEFT_OUT["Doppler spectra"] = "files of detected power hold no phase"
for what, reason in LEFT_OUT.items():
    logger.info(f"source {SOURCE}: left out: {what}: {reason}")


def read_yaml(path):
    """What a file of the workflow's own says."""
    return yaml.load((ROOT / path).read_text(), Loader=yaml.CSafeLoader)


def flight_files(pattern):
    """Input function: files of all frames; where there are only images, a line that says so."""

    def files(wildcards):
        if not FRAMES:
            reason = LEFT_OUT["map and echogram of the flight"]
            raise WorkflowError(f"source {SOURCE}: there are no frames: {reason}")
        return expand(pattern, frame=FRAMES)

    return files


def middle_frame(pattern):
    """Input function: file of the frame in the middle of the flight."""
    files = flight_files(pattern)
    return lambda wildcards: files(wildcards)[len(FRAMES) // 2]


def tables(*names):
    """Tables of results by their names."""
    return [f"results/tables/{name}.csv" for name in names]


# Stage of every figure.
FIGURES = {}


def caption_file(figure):
    """Where the caption of a figure stands."""
    return ROOT / f"workflow/evaluation/report/captions/{Path(figure).stem}.rst"


def drawn(stage, *files):
    """Outputs that are figures of a stage, with captions for Snakemake's own report."""
    outputs = {}
    for file in files:
        path = Path("results/figures") / file
        FIGURES[str(path)] = stage
        outputs[file.replace(".", "_")] = report(
            path, caption=str(caption_file(file)), category=stage
        )
    return outputs
