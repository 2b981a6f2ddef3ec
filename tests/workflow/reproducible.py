"""What "byte-identical" covers: all of results/ but what states times.

That are benchmarks, speed-accuracy tables and figures, and the report that quotes them; and
checkpoints of unfinished trainings, which go when these end. Logs lie outside results/.
"""

import hashlib

TIMED = (
    "benchmarks/*",
    "checkpoints/*",
    "tables/speed_accuracy*",
    "figures/speed_accuracy*",
    "report.html",
)


def is_timed(name):
    """Whether a file, or a folder that it lies in, states times."""
    return any(part.match(pattern) for part in (name, *name.parents) for pattern in TIMED)


def digests(results):
    """SHA-256 of every file that must not differ between runs, by its name under the results."""
    found = {}
    for path in sorted(results.rglob("*")):
        name = path.relative_to(results)
        if path.is_file() and not is_timed(name):
            found[str(name)] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found
