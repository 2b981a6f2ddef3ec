"""The way to the module that plants statistics."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
