# What all rules share: the configuration, names of files, checks before the first job.

import hashlib
import math
import os
import sys
from copy import deepcopy
from pathlib import Path

from snakemake.exceptions import WorkflowError

# Where this workflow lies, also where another uses it as a module.
ROOT = Path(workflow.current_basedir.get_path_or_uri(secret_free=False)).parents[1]
# Rules name their scripts by it if others are made of them.
SCRIPTS = ROOT / "workflow/scripts"

# What scripts import is read by the code that tests use, too; tables of own data by the package that the jobs use.
sys.path[:0] = [str(ROOT), str(ROOT / "workflow")]

from lib import checks, sources
from lib.configuration import filled
from lib.targets import described

# One thread a process, processes side by side: numbers then do not depend on how many cores there are.
for library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ[f"{library}_NUM_THREADS"] = "1"
# Memory that a step of training gives back is kept for the next: to ask the system for it anew took a fifth of the time.
# Of glibc alone; whoever starts the workflow may say otherwise.
for name, n_bytes in (("TRIM_THRESHOLD", 2**30), ("MMAP_THRESHOLD", 2**25), ("TOP_PAD", 2**26)):
    os.environ.setdefault(f"MALLOC_{name}_", str(n_bytes))


def or_refused(function, *arguments):
    """What a function gives; its complaint as one line of the workflow's."""
    try:
        return function(*arguments)
    except ValueError as error:
        raise WorkflowError(str(error)) from None


# As given, for a run beside this one with other recipes; then with all settings of the recipes.
GIVEN = deepcopy(config)
config.update(or_refused(filled, config))
SPLITS = ("train", "validation", "test")


include: "sources.smk"


# What is added to the train scenes in Table III's training sets; then what is trained on alone, without them.
TRAINING_SETS = {"rd": [], "rd_gd": ["cgan"], "rd_pd": ["phy"], "rd_pd_gd": ["phy", "cgan"]}
ALONE = {"gd": ["cgan"], "pd": ["phy"]}
METHODS = ("cgan", "phy")
LABELS = config["labels"]
TRACKER = config["tracker"]
N_SCENES = {**N_OBSERVED, "labels": LABELS["n_scenes"]}
SHARD_SIZE = dict.fromkeys(SPLITS, OBSERVED_PER_SHARD) | {"labels": LABELS["shard_size"]}
SEEDS = list(range(TRACKER["n_seeds"]))
# Where trainings keep what is no output of theirs.
CHECKPOINTS = config["checkpoints"]["folder"]
EVENTS = config["checkpoints"]["events"]


wildcard_constraints:
    frame=r"\d{4}",
    shard=r"\d{4}",
    replica=r"\d+",
    split="|".join(SPLITS),
    scenes="labels|test",
    training_set="|".join(TRAINING_SETS | ALONE),
    set="rd|pd|gd",
    format="pairs|netcdf",


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


def scenes_mb(scenes, shard, kb_per_scene):
    """What the scenes of a shard take on disk [MB], for the resource `results_mb` of the rule that writes them."""
    first, end = shard_range(scenes, shard)
    return math.ceil((end - first) * kb_per_scene / 1e3)


def benchmark_files(*splits):
    """The files of splits of the benchmark."""
    return [f"results/benchmark/{split}/{shard}.nc" for split in splits for shard in shards(split)]


def rendered_files(method, *sets):
    """The files of scene sets as one method rendered them."""
    return [f"results/{method}/{scenes}/{shard}.nc" for scenes in sets for shard in shards(scenes)]


def finished(paths):
    """Those of some files that no rule asks for and that have been made, with a digest of each."""
    made = [path for path in paths if Path(path).is_file()]
    return {path: hashlib.sha256(Path(path).read_bytes()).hexdigest() for path in made}


def added_scenes(method, training_set):
    """The label sets rendered by a method, if they join the real scenes in a training set."""
    joins = method in (TRAINING_SETS | ALONE)[training_set]
    return rendered_files(method, "labels") if joins else []
