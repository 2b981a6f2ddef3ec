"""The way to the scripts of the main path: what runs those runs these, too."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

from job import ROOT, checkout_files, job, progress  # noqa: F401
