"""What "byte-identical" covers, and a digest of it: python workflow/reproducible.py [RESULTS].

The same configuration and seed give the same bytes for everything under results/ but what states times: benchmarks,
the speed-accuracy and convolution tables and figures, and the report that quotes them; and but checkpoints of
unfinished trainings, which go when these end. Logs lie outside results/.
"""

import hashlib
import sys
from pathlib import Path

TIMED = (
    "benchmarks/*",
    "checkpoints/*",
    "tables/speed_accuracy_*",
    "figures/speed_accuracy_*",
    "tables/convolution_accuracy.csv",
    "figures/convolution_accuracy.*",
    "studies/convolution/*",
    "studies/cgan/speed.csv",
    "studies/cgan/widths.csv",
    "studies/cgan/equal_time_*",
    "report.html",
)


def reproducible_files(results):
    """Files under a results folder that must not differ between runs, sorted."""
    results = Path(results)
    files = (path for path in sorted(results.rglob("*")) if path.is_file())
    return [path for path in files if not any(_matches(path.relative_to(results), pattern) for pattern in TIMED)]


def _matches(path, pattern):
    return any(parent.match(pattern) for parent in (path, *path.parents))


def digests(results):
    """SHA-256 of every reproducible file, by its name under the results folder."""
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in reproducible_files(results)
    }


if __name__ == "__main__":
    for name, digest in digests(sys.argv[1] if len(sys.argv) > 1 else "results").items():
        sys.stdout.write(f"{digest}  {name}\n")
