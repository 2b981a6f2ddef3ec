"""Tests of this folder share the writers in `formats`."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
