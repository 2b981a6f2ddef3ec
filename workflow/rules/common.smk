# What all rules share: the check of the configuration, names of files, code as input, the list of targets, guards.

import math
import os
import sys
from functools import cache
from pathlib import Path

import jsonschema
import yaml
from snakemake.exceptions import WorkflowError

# Where this workflow lies, also where another uses it as a module.
ROOT = Path(workflow.current_basedir.get_path_or_uri(secret_free=False)).parents[1]

# What scripts import is read by the code that tests use, too; tables of own data by the package that the jobs use.
sys.path[:0] = [str(ROOT), str(ROOT / "workflow")]

from lib.configuration import filled, whole_schema
from lib.sources import check_disk, check_folders
from lib.imports import SCRIPTS, closure

# One thread a process, processes side by side: numbers then do not depend on how many cores there are.
for library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ[f"{library}_NUM_THREADS"] = "1"
# Memory that a step of training gives back is kept for the next: to ask the system for it anew took a fifth of the time.
# Of glibc alone; whoever starts the workflow may say otherwise.
for name, n_bytes in (
    ("TRIM_THRESHOLD", 2**30),
    ("MMAP_THRESHOLD", 2**25),
    ("TOP_PAD", 2**26),
):
    os.environ.setdefault(f"MALLOC_{name}_", str(n_bytes))


def read_yaml(path):
    """What a file of the workflow's own says, by the parser in C: every start of the workflow reads some."""
    return yaml.load((ROOT / path).read_text(), Loader=yaml.CSafeLoader)


def or_refused(function, *arguments):
    """What a function gives; its complaint as one line of the workflow's."""
    try:
        return function(*arguments)
    except ValueError as error:
        raise WorkflowError(str(error)) from None


# Settings of the tracker's training that `network: published` now chooses together.
GONE = [
    "optimiser",
    "loss",
    "reduction",
    "schedule",
    "augmentation",
    "published_multipliers",
]


def check_config(config):
    """Refuse unknown keys, wrong types and impossible values before any job starts, in one line."""
    error = jsonschema.exceptions.best_match(
        jsonschema.Draft202012Validator(whole_schema()).iter_errors(config)
    )
    if error is not None:
        key = ".".join(str(part) for part in error.absolute_path) or "top level"
        expected = error.schema.get("description", "")
        if error.validator == "additionalProperties":
            expected = ", ".join(error.schema["properties"])
            gone = [name for name in GONE if name in error.instance]
            if key == "tracker.training" and gone:
                expected = f"tracker.training.network: published, in place of {', '.join(gone)}"
        hint = f" (expected: {expected})" if expected else ""
        raise WorkflowError(f"config: {key}: {error.message}{hint}")
    labels = config["labels"]
    if labels["n_layers_min"] > labels["n_layers_max"]:
        raise WorkflowError(
            f"config: labels.n_layers_min: expected at most labels.n_layers_max = {labels['n_layers_max']}, "
            f"got {labels['n_layers_min']}"
        )
    n_held = config["cgan"]["validation"]["n_scenes"]
    n_train = config["benchmark"]["n_scenes"]["train"]
    if config["source"] == "reference" and n_held >= n_train:
        raise WorkflowError(
            f"config: cgan.validation.n_scenes: expected fewer than benchmark.n_scenes.train = {n_train}, got {n_held}"
        )


# As given, for a run beside this one with other recipes; then with all settings of the recipes.
GIVEN = copy.deepcopy(config)
config.update(or_refused(filled, config))
check_config(config)

SPLITS = ("train", "validation", "test")


include: "sources.smk"


# What is added to the train scenes in Table III's training sets; then what is trained on alone, without them.
TRAINING_SETS = {
    "rd": [],
    "rd_gd": ["cgan"],
    "rd_pd": ["phy"],
    "rd_pd_gd": ["phy", "cgan"],
}
ALONE = {"gd": ["cgan"], "pd": ["phy"]}
METHODS = ("cgan", "phy")
CGAN_SETTINGS = config["cgan"]["training"] | {
    "statistics": config["cgan"]["statistics"]
}
N_SCENES = {**N_OBSERVED, "labels": config["labels"]["n_scenes"]}
SHARD_SIZE = dict.fromkeys(SPLITS, OBSERVED_PER_SHARD) | {
    "labels": config["labels"]["shard_size"]
}
TRACKER = config["tracker"]
SEEDS = list(range(TRACKER["n_seeds"]))


wildcard_constraints:
    frame=r"\d{4}",
    shard=r"\d{4}",
    replica=r"\d+",
    split="|".join(SPLITS),
    scenes="labels|test",
    training_set="|".join(TRAINING_SETS | ALONE),


def shards(scenes):
    """Names of the files a scene set is divided into."""
    return numbered(math.ceil(N_SCENES[scenes] / SHARD_SIZE[scenes]))


def first_shards(n_scenes):
    """Names of the files that hold the first label sets."""
    return shards("labels")[: math.ceil(n_scenes / SHARD_SIZE["labels"])]


def shard_range(scenes, shard):
    """First scene of a shard and the one after its last."""
    first = int(shard) * SHARD_SIZE[scenes]
    return first, min(first + SHARD_SIZE[scenes], N_SCENES[scenes])


def benchmark_files(*splits):
    """The files of splits of the benchmark."""
    return [
        f"results/benchmark/{split}/{shard}.nc"
        for split in splits
        for shard in shards(split)
    ]


def cgan_train_files():
    """The files of the scenes that the cGAN is trained on, with their picks or with completed ones."""
    if config["cgan"]["picks"] == "as_picked":
        return benchmark_files("train")
    return [f"results/cgan/train/{shard}.nc" for shard in shards("train")]


def rendered_files(method, scenes):
    """The files of one scene set as one method rendered it."""
    return [f"results/{method}/{scenes}/{shard}.nc" for shard in shards(scenes)]


def layers_of(wildcards):
    """Where the layers of a scene set to render come from."""
    folder = {"labels": "labels", "test": "benchmark/test"}[wildcards.scenes]
    return f"results/{folder}/{wildcards.shard}.nc"


def real_scenes(wildcards):
    """The train scenes if a training set has them."""
    return benchmark_files("train") if wildcards.training_set in TRAINING_SETS else []


def added_scenes(method):
    """Input function: the label sets rendered by a method if they join the real scenes in the training set."""

    def files(wildcards):
        joins = method in (TRAINING_SETS | ALONE)[wildcards.training_set]
        return rendered_files(method, "labels") if joins else []

    return files


# Where trainings keep what is no output of theirs.
CHECKPOINTS = config["checkpoints"]["folder"]
EVENTS = config["checkpoints"]["events"]


# The table is read only where this target is asked for.
@cache
def frames_by_job():
    """Frames to track, by the number of the job."""
    jobs = or_refused(sources.frames_to_track, OWN["frames"], FRAMES_PER_JOB)
    return dict(zip(numbered(len(jobs)), jobs))


def imported_by(script):
    """Input function: files that a script imports, and that those import; asked for jobs that are planned alone.

    A script of the main path is called by its name, another one by its path.
    """
    return lambda wildcards: list(map(str, closure(SCRIPTS / script)))


def finished(paths):
    """Those of some files of studies that have been made, with a digest of each.

    No input of a rule: the default run must not start a study, nor decide whether one is up to date.
    """
    made = [path for path in paths if Path(path).is_file()]
    return {path: hashlib.sha256(Path(path).read_bytes()).hexdigest() for path in made}


def targets(prefix=""):
    """Rules that only collect what others make: what people ask for by name."""
    return [
        item
        for item in workflow.rules
        if not item.output and item.name.startswith(prefix) and item.name != "help"
    ]


TARGET_GROUPS = {
    "main": "from the flight to Tables II and III",
    "pretrained": "the tracker that comes with the package, and what it picks; not part of the default run",
    "evaluation": "what judges and shows; nothing on the main path depends on it",
    "studies": "many trainings each, not part of the default run",
}


def group_of(item):
    """The group of a target, by where its rule stands."""
    file = Path(os.path.relpath(item.snakefile, ROOT / "workflow"))
    if item.name.startswith("stud"):
        return "studies"
    if file.stem in ("pretrained", "picks"):
        return "pretrained"
    return "evaluation" if file.parts[0] == "evaluation" else "main"


def describe_targets():
    """The targets with a line each, in groups."""
    width = max(len(item.name) for item in targets())
    lines = ["snakemake --cores N TARGET; targets are:"]
    for group, about in TARGET_GROUPS.items():
        members = [item for item in targets() if group_of(item) == group]
        if members:
            lines.append(f"{group}: {about}")
        lines += [f"  {item.name:<{width}}  {item.message}" for item in members]
    return "\n".join(lines)


# Frames and scenes take nearly all of a run's disk: their rules say how much, by the sizes in docs/scale.md.
SMALL_FILES_MB = 20


def scenes_mb(scenes, shard, kb_per_scene):
    """What the scenes of a shard take on disk [MB], for the resource `results_mb` of the rule that writes them."""
    first, end = shard_range(scenes, shard)
    return math.ceil((end - first) * kb_per_scene / 1e3)


onstart:
    or_refused(check_folders, "results", "logs")
    jobs = workflow.dag.needrun_jobs()
    results_mb = sum(job.resources.get("results_mb", 0) for job in jobs)
    or_refused(check_disk, 1e6 * (results_mb + SMALL_FILES_MB))
