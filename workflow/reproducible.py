"""What "byte-identical" covers, and how two runs compare.

python workflow/reproducible.py [RESULTS] prints a digest of every file that must not differ between
two runs. python workflow/reproducible.py OLD NEW compares two results folders: value by value, and
figures by the numbers they draw. It prints every difference and fails where there is one.

The same configuration and seed give the same bytes for everything under results/ but what states
times: benchmarks, the speed-accuracy and convolution tables and figures, and the report that quotes
them; and but checkpoints of unfinished trainings, which go when these end. Logs lie outside
results/.
"""

import hashlib
import re
import sys
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


def reproducible_files(results):
    """Files under a results folder that must not differ between runs, sorted."""
    return [
        path
        for path in sorted(Path(results).rglob("*"))
        if path.is_file() and not is_timed(path.relative_to(results))
    ]


def is_timed(name):
    """Whether a file, or a folder that it lies in, states times."""
    return any(part.match(pattern) for part in (name, *name.parents) for pattern in TIMED)


def digests(results):
    """SHA-256 of every reproducible file, by its name under the results folder."""
    return {
        str(path.relative_to(results)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in reproducible_files(results)
    }


def compare(old, new):
    """Differences between two results folders, a line each: every value that both must hold."""
    before = {path.relative_to(old) for path in reproducible_files(old)}
    after = {path.relative_to(new) for path in reproducible_files(new)}
    differences = [f"{name}: only in {new}" for name in sorted(after - before)]
    for name in sorted(before):
        if name in after:
            differences += compare_files(old / name, new / name, name)
        else:
            differences.append(f"{name}: missing")
    return differences


def compare_files(old, new, name):
    """Differences between two files of one kind, a line each."""
    if old.read_bytes() == new.read_bytes():
        return []
    before = contents(old)
    after = contents(new)
    lines = [f"{name}: {key}: only in one of them" for key in sorted(before.keys() ^ after.keys())]
    for key in sorted(before.keys() & after.keys()):
        difference = largest_difference(before[key], after[key])
        if difference > 0:
            lines.append(f"{name}: {key}: differs by up to {difference:.3g}")
    return lines


def contents(path):
    """Values of a file by variable, column or tensor; a figure's are the numbers it draws."""
    if path.suffix == ".nc":
        import xarray as xr

        values = {}
        for group, dataset in xr.open_groups(path, decode_cf=False).items():
            for key, variable in dataset.variables.items():
                values[f"{group}/{key}".lstrip("/")] = variable.to_numpy()
            for key, value in dataset.attrs.items():
                values[f"attribute {group}/{key}"] = np.array(str(value))
            dataset.close()
        return values
    if path.suffix in (".csv", ".parquet"):
        table = pd.read_csv(path) if path.suffix == ".csv" else pd.read_parquet(path)
        return {column: table[column].to_numpy() for column in table}
    if path.suffix == ".safetensors":
        from safetensors.numpy import load_file

        return load_file(path)
    if path.suffix == ".svg":
        text = path.read_text()
        _, _, after_date = text.partition("</metadata>")
        drawn = re.findall(r' (?:d|x|y|points|transform|xlink:href)="([^"#]*)"', text)
        texts = re.findall(r">([^<>]+)<", after_date)
        return {"drawn": np.array(drawn), "texts": np.array(texts)}
    if path.suffix == ".png":
        from PIL import Image

        return {"pixels": np.asarray(Image.open(path))}
    return {"bytes": np.frombuffer(path.read_bytes(), dtype=np.uint8)}


def largest_difference(before, after):
    """Largest difference of two arrays; infinite if shapes, text or places of NaN differ."""
    if before.shape != after.shape:
        return np.inf
    missing = pd.isna(before)
    if not np.array_equal(missing, pd.isna(after)):
        return np.inf
    before = before[~missing]
    after = after[~missing]
    if np.array_equal(before, after):
        return 0
    if not (np.issubdtype(before.dtype, np.number) and np.issubdtype(after.dtype, np.number)):
        return np.inf
    differ = before != after
    distance = np.abs(before[differ].astype(float) - after[differ].astype(float))
    return float(np.max(distance))


if __name__ == "__main__":
    folders = [Path(word) for word in sys.argv[1:]] or [Path("results")]
    if len(folders) == 2:
        found = compare(*folders)
        sys.stdout.write("".join(f"{line}\n" for line in found) or "no difference\n")
        sys.exit(bool(found))
    for name, digest in digests(folders[0]).items():
        sys.stdout.write(f"{digest}  {name}\n")
