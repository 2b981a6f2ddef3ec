"""Checks before the first job: space for results, and code that is newer than results."""

import logging
import os
import shutil
from pathlib import Path

# Nearly all of a run's disk holds frames and scenes, whose rules state it; this is for the rest.
SMALL_FILES_MB = 20
# Code that scripts import.
IMPORTED = (
    "snowsim/**/*.py",
    "workflow/**/lib/**/*.py",
    "workflow/pretrained/*.py",
    "workflow/reference/*.py",
)
# First and last results on the way from the flight to both tables.
LANDMARKS = ("statistics.nc", "tables/table2.csv", "tables/table3.csv")


def warn_of_edits(root, results):
    """Warn, in one line, of code that was edited after results were made.

    An edit of the code that scripts import reruns nothing, since rules do not name it.
    """
    made = [path for name in LANDMARKS if (path := Path(results, name)).exists()]
    code = [path for pattern in IMPORTED for path in root.glob(pattern)]
    if not made:
        return
    oldest = min(made, key=_time)
    newest = max(code, key=_time)
    if _time(newest) > _time(oldest):
        words = (
            f"{newest.relative_to(root)} is newer than {oldest}; edited code reruns nothing by "
            "itself: snakemake --forcerun RULE, or --touch if no result depends on the edit"
        )
        logging.getLogger("snakemake.logging").warning(words)


def warn_of_left_over(results, shards):
    """Warn, in one line, of scenes of an earlier configuration that had more of them.

    `shards` are the names of the files of each scene set, as "labels". No job reads the others, but
    ``snowsim export results/phy/labels/*.nc`` would.
    """
    left = [
        path
        for scenes, names in shards.items()
        for folder in (".", "benchmark", "phy", "cgan", "own/*")
        for path in sorted(Path(results).glob(f"{folder}/{scenes}/[0-9]*.nc"))
        if path.stem not in names
    ]
    if left:
        words = (
            f"{left[0]}, one of {len(left)} files of scenes that this configuration does not have: "
            "they are of an earlier one, and may be deleted"
        )
        logging.getLogger("snakemake.logging").warning(words)


def _time(path):
    return path.stat().st_mtime


def _existing(name):
    """A folder, or what there is of the way to it."""
    folder = Path(name).absolute()
    while not folder.exists():
        folder = folder.parent
    return folder


def check_folders(*names):
    """ValueError if a folder cannot be written."""
    for name in names:
        folder = _existing(name)
        if not os.access(folder, os.W_OK):
            msg = f"disk: {name}/ cannot be written: {folder} is read-only"
            raise ValueError(msg)


def check_disk(scenes_mb, name="results"):
    """ValueError unless results fit on a folder's disk; `scenes_mb`: frames and scenes [MB]."""
    needed_mb = scenes_mb + SMALL_FILES_MB
    folder = _existing(name)
    free_mb = shutil.disk_usage(folder).free / 1e6
    if free_mb < needed_mb:
        msg = f"disk: this run writes about {needed_mb:.0f} MB, {folder} has {free_mb:.0f} MB left"
        raise ValueError(msg)
