"""What "byte-identical" covers, and how two runs compare.

python workflow/reproducible.py [RESULTS] prints a digest of every file that must not differ between
two runs. python workflow/reproducible.py OLD NEW compares two results folders, also where files and
columns have other names since: value by value, and figures by the numbers they draw. It prints
every difference and fails where there is one.

The same configuration and seed give the same bytes for everything under results/ but what states
times: benchmarks, the speed-accuracy and convolution tables and figures, and the report that quotes
them; and but checkpoints of unfinished trainings, which go when these end. Logs lie outside
results/.
"""

import hashlib
import re
import sys
from fnmatch import fnmatch
from functools import reduce
from pathlib import Path

import numpy as np
import pandas as pd

TIMED = (
    "benchmarks/*",
    "checkpoints/*",
    "tables/speed_accuracy_*",
    "figures/speed_accuracy_*",
    "tables/convolution_accuracy.csv",
    "figures/convolution_accuracy.*",
    "studies/convolution/*",
    "studies/cgan/renderers.csv",
    "report.html",
)
# Since release 0.1.0: parts of names of files, old -> new; then of columns, in any file.
MOVED_FILES = {
    "/stability": "/atlas",
    "label_criteria": "model_selection",
    "label_savings": "model_selection_scenes",
    "label_families": "model_selection_spectra",
}
MOVED_COLUMNS = {"verdict": "outcome"}
# Largest difference of values that may have moved, by file and column: SSIM is scikit-image's now.
ALLOWED = {"similarity*: ssim": 5e-13, "tables/*: ssim*": 5e-13}


def reproducible_files(results):
    """Files under a results folder that must not differ between runs, sorted."""
    results = Path(results)
    names = (path.relative_to(results) for path in sorted(results.rglob("*")) if path.is_file())
    return [
        results / name
        for name in names
        if not any(part.match(p) for part in (name, *name.parents) for p in TIMED)
    ]


def digests(results):
    """SHA-256 of every reproducible file, by its name under the results folder."""
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in reproducible_files(results)
    }


def compare(old, new):
    """Differences between two results folders, a line each: every value of every file that both must hold."""
    names = {str(path.relative_to(old)) for path in reproducible_files(old)}
    moved = {
        name: reduce(lambda part, move: part.replace(*move), MOVED_FILES.items(), name)
        for name in sorted(names)
    }
    added = {str(path.relative_to(new)) for path in reproducible_files(new)} - set(moved.values())
    differences = [f"{name}: only in {new}" for name in sorted(added)]
    for name, new_name in moved.items():
        path = Path(new) / new_name
        differences += (
            compare_files(Path(old) / name, path, new_name)
            if path.is_file()
            else [f"{new_name}: missing"]
        )
    return differences


def compare_files(old, new, name):
    """Differences between two files of one kind, a line each."""
    if old.read_bytes() == new.read_bytes():
        return []
    before = {MOVED_COLUMNS.get(key, key): value for key, value in contents(old).items()}
    after = contents(new)
    lines = [f"{name}: {key}: only in one of them" for key in sorted(before.keys() ^ after.keys())]
    for key in sorted(before.keys() & after.keys()):
        difference = largest_difference(before[key], after[key])
        allowed = max(
            (bound for pattern, bound in ALLOWED.items() if fnmatch(f"{name}: {key}", pattern)),
            default=0,
        )
        if difference > allowed:
            lines.append(f"{name}: {key}: differs by up to {difference:.3g}")
    return lines


def contents(path):
    """Values of a file by the names of its variables, columns or tensors; a figure's are the numbers it draws."""
    if path.suffix == ".nc":
        import xarray as xr

        with xr.open_dataset(path, decode_cf=False) as dataset:
            attributes = {
                f"attribute {key}": np.array(str(value)) for key, value in dataset.attrs.items()
            }
            return attributes | {
                str(key): variable.to_numpy() for key, variable in dataset.variables.items()
            }
    if path.suffix in (".csv", ".parquet"):
        table = pd.read_csv(path) if path.suffix == ".csv" else pd.read_parquet(path)
        return {column: table[column].to_numpy() for column in table}
    if path.suffix == ".safetensors":
        from safetensors.numpy import load_file

        return load_file(path)
    if path.suffix == ".svg":
        drawn = re.findall(r' (?:d|x|y|points|transform|xlink:href)="([^"#]*)"', path.read_text())
        texts = re.findall(r">([^<>]+)<", path.read_text().partition("</metadata>")[2])
        return {"drawn": np.array(drawn), "texts": np.array(texts)}
    if path.suffix == ".png":
        from PIL import Image

        return {"pixels": np.asarray(Image.open(path))}
    return {"bytes": np.frombuffer(path.read_bytes(), dtype=np.uint8)}


def largest_difference(before, after):
    """Largest difference of two arrays; infinite where shapes differ, or what is no number or NaN in one of them."""
    if before.shape != after.shape:
        return np.inf
    if not (np.issubdtype(before.dtype, np.number) and np.issubdtype(after.dtype, np.number)):
        same = (before == after) | (pd.isna(before) & pd.isna(after))
        return 0 if np.all(same) else np.inf
    before, after = before.astype(float), after.astype(float)
    if not np.array_equal(np.isnan(before), np.isnan(after)):
        return np.inf
    differ = (before != after) & ~np.isnan(before)
    return float(np.max(np.abs(before[differ] - after[differ]), initial=0))


if __name__ == "__main__":
    if len(sys.argv) == 3:
        found = compare(*sys.argv[1:])
        sys.stdout.write("".join(f"{line}\n" for line in found) or "no difference\n")
        sys.exit(bool(found))
    for name, digest in digests(sys.argv[1] if len(sys.argv) > 1 else "results").items():
        sys.stdout.write(f"{digest}  {name}\n")
