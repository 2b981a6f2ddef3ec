"""Read MAT v5 files with scipy; a child process reads those that are not compressed.

A damaged file can end the process: of 1600 damaged files without compression, 13 gave scipy 1.17 a
segmentation fault. None of 1400 compressed files did, because they have checksums. The child takes
0.3 s a file, and its memory is limited.
"""

import math
import os
import pickle
import resource
import subprocess
import sys
import warnings
from pathlib import Path

import scipy.io
from numpy.exceptions import ComplexWarning

from snowsim.io.guard import MAXIMUM_BYTES, Refused, check_size

HEADER_BYTES = 128
COMPRESSED = 15  # type of a compressed element, in one of the four bytes behind the header
NUMBER_BYTES = 4  # size of a number in most large variables
SECONDS = 120  # limit of a child; no undamaged file takes as long


def read_mat5(path, names):
    """The named variables as a dict; arrays lose axes of length 1, structs become dicts."""
    with Path(path).open("rb") as file:
        if COMPRESSED in file.read(HEADER_BYTES + 4)[HEADER_BYTES:]:
            return load(path, names)
    command = [sys.executable, "-P", "-m", "snowsim.io.mat5", str(path), *names]
    paths = {"PYTHONPATH": os.pathsep.join(sys.path), "OPENBLAS_NUM_THREADS": "1"}
    child = subprocess.run(
        command, capture_output=True, env=os.environ | paths, timeout=SECONDS, check=False
    )
    if child.returncode != 0:
        said = child.stderr.decode(errors="replace").splitlines() or [child.returncode]
        msg = f"expected a whole file, found one that ends its reader: {said[-1]}"
        raise Refused(msg)
    return pickle.loads(child.stdout)


def load(path, names):
    """The named variables as `read_mat5` gives them, read in this process."""
    for name, shape, _ in scipy.io.whosmat(path, appendmat=False):
        if name in names:
            check_size(NUMBER_BYTES * math.prod(shape))
    options = {"mat_dtype": True, "simplify_cells": True, "appendmat": False}
    with warnings.catch_warnings():
        # With `mat_dtype` scipy drops imaginary parts and only warns: make that an error.
        warnings.simplefilter("error", ComplexWarning)
        values = scipy.io.loadmat(path, variable_names=names, **options)
    return {name: values[name] for name in names}


if __name__ == "__main__":
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    room = 4 * MAXIMUM_BYTES if most == resource.RLIM_INFINITY else min(4 * MAXIMUM_BYTES, most)
    resource.setrlimit(resource.RLIMIT_AS, (room, most))
    pickle.dump(load(sys.argv[1], sys.argv[2:]), sys.stdout.buffer, protocol=5)
