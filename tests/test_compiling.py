"""Compiled functions work wherever the package is installed."""

import os
import shutil
import subprocess
import sys

from processes import ROOT


def test_functions_compile_where_no_folder_can_hold_their_cache(tmp_path):
    package = tmp_path / "snowsim"
    shutil.copytree(ROOT / "snowsim", package, ignore=shutil.ignore_patterns("__pycache__"))
    # Also root, who may write everywhere, can make no folder below a file.
    for folder in [package, *(path for path in package.rglob("*") if path.is_dir())]:
        (folder / "__pycache__").touch()
    code = (
        "import numpy as np, snowsim.phy.power, snowsim.phy.speckle, snowsim.metrics.picks\n"
        "from snowsim.metrics.edges import thinning, matching, suppression\n"
        "from snowsim.tracker import Linking, find_candidates\n"
        "peak = np.array([[-9, 3, -9]], dtype=np.float32).T\n"
        "print(snowsim.__file__, find_candidates(peak, Linking(), 0.0).row)"
    )
    kept = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA")}
    changed = {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", "PYTHONPATH": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, "-B", "-c", code],
        cwd=tmp_path,
        env=kept | changed,
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout == f"{package / '__init__.py'} [1.]\n"
