"""The nature run, the renderer it judges, and the solver that judges both share no code but the core."""

import subprocess
import sys

import pytest
from test_imports import CORE, MODULES, PACKAGE

STAGES = ("reference", "phy", "coherent")
SOLVER = ["lib.diagnostics.coherent"]


def loaded_with(stage):
    """Parts of snowsim in memory once every module of a stage is imported, in a process of its own."""
    names = [".".join(("snowsim", *module.parts)) for module in MODULES if module.parts[0] == stage]
    names = SOLVER if stage == "coherent" else names
    assert names
    code = (
        f"import sys\nsys.path.insert(0, {str(PACKAGE.parent / 'workflow')!r})\nfor name in {names!r}: __import__(name)"
    )
    code += "\nprint(*[n for n in sys.modules if n.startswith(('snowsim.', 'lib.diagnostics.'))])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return {"coherent" if name.startswith("lib.") else name.split(".")[1] for name in done.stdout.split()}


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_loads_itself_and_core_alone(stage):
    loaded = loaded_with(stage)
    assert stage in loaded
    assert loaded - {stage, "__init__"} <= CORE
