"""Arrows between modules point one way."""

import ast
import importlib
import sys
from importlib.util import find_spec

import pytest
from processes import ROOT, run_in

PACKAGE = ROOT / "snowsim"
CORE = {
    "compiling",
    "constants",
    "echogram",
    "alignment",
    "limits",
    "patches",
    "progress",
    "seeding",
    "settings",
    "training",
}
# For people who script: they may import any stage, and nothing imports them.
FRONT = {"cli", "front", "learning", "scoring", "tracking"}
# A stage never imports another stage, but for these.
ALLOWED = {
    ("statistics", "phy.waveform"),
    # PHY's mean power tells how bright a scene is.
    ("cgan", "phy"),
    # What PHY renders of a snowpack; the rest of snowpack stands on the core alone.
    ("snowpack/simulation", "phy"),
    ("tracker", "metrics"),
}
# What only some stages or modules may import.
NETWORKS = {f"tracker/{module}" for module in ("network", "portable", "published", "train")}
ONLY = {
    "torch": {"cgan", "learning", "patches", "training", *NETWORKS},
    "onnxruntime": {"tracker/windows"},
    "netCDF4": {"io"},
    "h5py": {"io"},
    "PIL": {"io"},
    "safetensors": {"io"},
    "matplotlib": {"io"},
    "snakemake": set(),
}
# Folders of the workflow, and which others each may import; nothing in snowsim imports any.
WORKFLOW = {
    "reference": set(),
    "lib": {"reference"},
    "pretrained": {"lib", "reference"},
    "scripts": {"lib", "pretrained", "reference"},
    "evaluation": {"lib", "pretrained", "reference", "scripts"},
}
BELOW_REFERENCE = tuple(
    f"snowsim.{name}." for name in (*CORE, "snowpack.firn", "snowpack.along_track")
)
MODULES = sorted(path.relative_to(PACKAGE).with_suffix("") for path in PACKAGE.rglob("*.py"))


def nodes(module):
    return ast.walk(ast.parse((PACKAGE / module).with_suffix(".py").read_text()))


def imported_names(module):
    """Full dotted names that a module imports, anywhere in it."""
    names = set()
    for node in nodes(module):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: write imports in full"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_module_imports_only_what_its_place_allows(module):
    stage = module.parts[0]
    for name in imported_names(module):
        parts = name.split(".")
        assert parts[0] not in WORKFLOW, f"{module} imports {name}"
        if parts[0] in ONLY:
            assert {stage, str(module)} & ONLY[parts[0]], f"{module} imports {name}"
        if parts[0] != "snowsim" or len(parts) == 1 or stage == "__init__":
            continue
        other = parts[1]
        if other in CORE | {stage, "__version__"} or stage in FRONT:
            continue
        allowed = [
            f"snowsim.{target}." for source, target in ALLOWED if source in (stage, str(module))
        ]
        assert f"{name}.".startswith(tuple(allowed)), f"{module} imports {name}"


def test_only_io_opens_files():
    for module in MODULES:
        functions = [node.func for node in nodes(module) if isinstance(node, ast.Call)]
        calls = {function.id for function in functions if isinstance(function, ast.Name)}
        assert module.parts[0] == "io" or "open" not in calls, f"{module} opens a file"


# Imports modules in a process of its own and tells what of snowsim is in memory then.
CHILD = """
import sys
sys.path.insert(0, "workflow")
for name in sys.argv[1:]:
    __import__(name)
print(*sys.modules)
"""


def loaded_with(*names):
    """Modules that are loaded where some are imported."""
    return set(run_in(ROOT, sys.executable, "-c", CHILD, *names).split())


def test_the_configuration_is_checked_without_what_draws_and_trains():
    # Every start of the workflow checks it, dry runs included.
    loaded = loaded_with("lib.configuration")
    assert {"snowsim.settings", "reference.settings"} <= loaded
    assert not loaded & {"scipy", "torch", "xarray", "numba", "pandas", "reference.echo"}


def test_tracking_and_scoring_load_nothing_of_trainings_and_nothing_loads_onnxruntime_early():
    loaded = loaded_with("snowsim.tracking", "snowsim.scoring")
    assert not loaded & {"torch", "safetensors", "onnxruntime"}
    # Few runs need these, and every start of the command would wait for them.
    loaded = loaded_with("snowsim.tracking.files")
    assert "snowsim.tracker.picks" in loaded
    assert not loaded & {"h5py", "PIL", "snowsim.tracking.processes"}
    loaded = loaded_with("snowsim.learning")
    assert "torch" in loaded
    assert "onnxruntime" not in loaded


@pytest.mark.parametrize("folder", WORKFLOW)
def test_folders_of_the_workflow_import_only_those_below_them(folder):
    for path in (ROOT / "workflow" / folder).rglob("*.py"):
        names = imported_names(path)
        roots = {name.partition(".")[0] for name in names}
        assert roots & WORKFLOW.keys() <= WORKFLOW[folder] | {folder}, path
        if folder == "reference":
            # The synthetic flight stands on the core and the physics of firn.
            used = {name for name in names if name.startswith("snowsim.")}
            assert all(name.startswith(BELOW_REFERENCE) for name in used), f"{path.name}: {used}"


SCRIPTS = sorted(
    path.relative_to(ROOT)
    for folder in ("workflow", "docs", "benchmarks")
    for path in (ROOT / folder).rglob("*.py")
)


@pytest.mark.parametrize("script", SCRIPTS, ids=str)
def test_what_a_script_imports_exists(script, monkeypatch):
    """Scripts are run by slow tests alone, so a name that is gone would be found late."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    own_folders = ["workflow", "workflow/scripts", "workflow/evaluation", "docs"]
    sys.path[:0] = [str((ROOT / script).parent), *(str(ROOT / name) for name in own_folders)]
    ours = ("snowsim", "lib", "pretrained", "reference", "evaluation", "main_path", "job")
    for node in ast.walk(ast.parse((ROOT / script).read_text())):
        if isinstance(node, ast.ImportFrom) and node.module.split(".")[0] in ours:
            module = importlib.import_module(node.module)
            for name in node.names:
                assert hasattr(module, name.name) or find_spec(f"{node.module}.{name.name}"), (
                    name.name
                )


@pytest.mark.parametrize(
    "package", ["snowsim", "snowsim.io", "snowsim.snowpack", "snowsim.tracker", "snowsim.tracking"]
)
def test_stubs_name_what_is_loaded_on_first_use(package):
    """A type checker reads the stub alone: a name that it lacks would be an error for others."""
    module = importlib.import_module(package)
    tables = (getattr(module, name, {}) for name in ("FRONT", "MODULES", "FACE"))
    loaded = {(f"{package}.{of}", name) for table in tables for of in table for name in table[of]}
    stub = ast.parse((ROOT / package.replace(".", "/") / "__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    named = {(node.module, name.name) for node in imports for name in node.names}
    assert loaded <= named
    assert all(name in dir(importlib.import_module(of)) for of, name in named)
