# What all rules share: the configuration, names of files, checks before the first job.

import hashlib
import math
import os
import sys
from copy import deepcopy
from pathlib import Path

from snakemake.exceptions import WorkflowError

# Folder of this workflow, also where another workflow uses it as a module.
ROOT = Path(workflow.current_basedir.get_path_or_uri(secret_free=False)).parents[1]

# Rules import the same library and package as the scripts of their jobs.
sys.path[:0] = [str(ROOT), str(ROOT / "workflow")]

from lib import checks, sources
from lib.configuration import filled, typed
from lib.targets import described

# Every process has one thread, and processes run side by side: numbers do not depend on the number of cores.
for library in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ[f"{library}_NUM_THREADS"] = "1"
# glibc keeps the memory that a step of training frees for the next step; to ask the system for it again would take a
# fifth of the time. Variables that are set already win.
for name, n_bytes in (("TRIM_THRESHOLD", 2**30), ("MMAP_THRESHOLD", 2**25), ("TOP_PAD", 2**26)):
    os.environ.setdefault(f"MALLOC_{name}_", str(n_bytes))


def training_threads(device):
    """Cores of a training: one; beside a GPU also those that prepare its inputs."""
    return 8 if device == "cuda" else 1


def or_refused(function, *arguments):
    """Result of a function; a ValueError ends the workflow with its line."""
    try:
        return function(*arguments)
    except ValueError as error:
        raise WorkflowError(str(error)) from None


config.update(typed(config, workflow.config_settings.config))
# The configuration as given serves runs beside this one, with other recipes. In `config` all recipes are filled in.
GIVEN = deepcopy(config)
config.update(or_refused(filled, config))
SPLITS = ("train", "validation", "test")


include: "sources.smk"


# Renders that the training sets of Table III add to the train scenes, and those that trackers are trained on alone.
TRAINING_SETS = {"rd": [], "rd_gd": ["cgan"], "rd_pd": ["phy"], "rd_pd_gd": ["phy", "cgan"]}
ALONE = {"gd": ["cgan"], "pd": ["phy"]}
OWN_RENDERERS = config["own"]["renderers"]
OWN_TRACKERS = config["own"]["trackers"]
OWN_SETS = {f"rd_{name}": [name] for name in OWN_RENDERERS}
METHODS = ("cgan", "phy", *OWN_RENDERERS)
# Folder of a method's renders below results/: a name of yours is no other folder's.
FOLDERS = {name: f"own/{name}" for name in OWN_RENDERERS}
LABELS = config["labels"]
TRACKER = config["tracker"]
N_SCENES = {**N_OBSERVED, "labels": LABELS["n_scenes"]}
SHARD_SIZE = dict.fromkeys(SPLITS, OBSERVED_PER_SHARD) | {"labels": LABELS["shard_size"]}
SEEDS = list(range(TRACKER["n_seeds"]))
# Folders in which trainings keep checkpoints and events, which are not their outputs.
CHECKPOINTS = config["checkpoints"]["folder"]
EVENTS = config["checkpoints"]["events"]


wildcard_constraints:
    frame=r"\d{4}",
    shard=r"\d{4}",
    replica=r"\d+",
    split="|".join(SPLITS),
    scenes="labels|test",
    training_set="|".join(TRAINING_SETS | ALONE | OWN_SETS),
    scored_set=r"\w+",
    set="rd|pd|gd",


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
    """Size on disk of the scenes of a shard [MB], for the resource `results_mb` of the rule that writes them."""
    first, end = shard_range(scenes, shard)
    return math.ceil((end - first) * kb_per_scene / 1e3)


def benchmark_files(*splits):
    """Files of splits of the benchmark."""
    return [f"results/benchmark/{split}/{shard}.nc" for split in splits for shard in shards(split)]


def rendered_files(method, *sets):
    """Files of scene sets rendered by one method."""
    folder = FOLDERS.get(method, method)
    return [f"results/{folder}/{scenes}/{shard}.nc" for scenes in sets for shard in shards(scenes)]


def digest(path):
    """SHA-256 of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def finished(paths):
    """Files of `paths` that exist already, each with a digest; no rule makes them for their reader."""
    return {path: digest(path) for path in paths if Path(path).is_file()}


def of_checkout(*names):
    """Files of this checkout by their paths in it, each with a digest, for `params` of a rule.

    As inputs they would have absolute paths, since a run may have a folder of its own: a finished run that is moved
    with its checkout would begin anew.
    """
    return {name: digest(ROOT / name) for name in names}


def added_scenes(method, training_set):
    """Files of label sets rendered by a method, if a training set contains them."""
    joins = method in (TRAINING_SETS | ALONE | OWN_SETS)[training_set]
    return rendered_files(method, "labels") if joins else []


def validation_counts(path):
    """Tables of counts on validation scenes, of every replica of `path`, if there are such scenes."""
    return expand(f"{path}_validation.csv.gz", replica=SEEDS) if shards("validation") else []
