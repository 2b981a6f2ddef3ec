"""The nature run, the renderer it judges, and the solver that judges both share no code but the core."""

import subprocess
import sys

import pytest
from test_imports import CORE, MODULES, PACKAGE

# Imports modules in a process of its own and tells what of snowsim is in memory then.
CHILD = """
import sys
sys.path.insert(0, "workflow")
for name in sys.argv[1:]:
    __import__(name)
print(*[name for name in sys.modules if name.startswith(("snowsim.", "lib.diagnostics."))])
"""


@pytest.mark.parametrize("stage", ["reference", "phy", "coherent"])
def test_a_stage_loads_itself_and_core_alone(stage):
    names = [".".join(("snowsim", *module.parts)) for module in MODULES if module.parts[0] == stage]
    names = names or ["lib.diagnostics.coherent"]
    command = [sys.executable, "-c", CHILD, *names]
    done = subprocess.run(command, cwd=PACKAGE.parent, capture_output=True, text=True, check=True)
    loaded = {"coherent" if name.startswith("lib.") else name.split(".")[1] for name in done.stdout.split()}
    assert stage in loaded
    assert loaded - {stage, "__init__"} <= CORE
