"""Seconds that each job of a run spends on imports, wherever they stand, in its logs/imports.tsv.

``PYTHONPATH=benchmarks/import_clock make run``: Python executes this file in every process before
anything else. A row is the life of a process and the imports in it [s].
"""

import atexit
import importlib._bootstrap as bootstrap
import sys
import time
from pathlib import Path


class ImportClock:
    """Adds up the time of imports; those that an import brings with it are within it."""

    def __init__(self):
        self.begin = time.perf_counter()
        self.seconds = 0.0
        self._within = False
        self._find_and_load = bootstrap._find_and_load

    def find_and_load(self, name, import_):
        """Stands in for the function that Python calls for every module that is not yet loaded."""
        if self._within:
            return self._find_and_load(name, import_)
        self._within = True
        begin = time.perf_counter()
        try:
            return self._find_and_load(name, import_)
        finally:
            self._within = False
            self.seconds += time.perf_counter() - begin

    def write(self):
        """A row for a job; other processes leave none."""
        if "/.snakemake/scripts/" in sys.argv[0]:
            life = time.perf_counter() - self.begin
            with Path("logs/imports.tsv").open("a") as file:
                file.write(f"{life:.3f}\t{self.seconds:.3f}\n")


clock = ImportClock()
bootstrap._find_and_load = clock.find_and_load
atexit.register(clock.write)
