"""Checked before the first job of a run: may it write where its results and logs go, is there room for them."""

import os
import shutil
from pathlib import Path


def check_folders(*names):
    """Refuse folders that cannot be written; root may write anywhere but on a read-only disk."""
    for name in names:
        folder = Path(name).absolute()
        while not folder.exists():
            folder = folder.parent
        if not os.access(folder, os.W_OK):
            msg = f"disk: {name}/ cannot be written: {folder} is read-only"
            raise ValueError(msg)


def check_disk(needed_bytes, name="results"):
    """Refuse to start what the disk that holds a folder has no room for."""
    folder = Path(name).absolute()
    folder = folder if folder.exists() else folder.parent
    free_bytes = shutil.disk_usage(folder).free
    if free_bytes < needed_bytes:
        msg = f"disk: this run writes about {needed_bytes / 1e6:.0f} MB, {folder} has {free_bytes / 1e6:.0f} MB left"
        raise ValueError(msg)
