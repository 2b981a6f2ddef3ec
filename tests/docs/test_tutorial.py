"""What the tutorials tell a reader to do works, word for word, in a fresh copy with a small configuration."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
NOT_COPIED = shutil.ignore_patterns(
    ".git",
    ".venv",
    ".snakemake",
    "results",
    "logs",
    "build",
    "__pycache__",
    ".pytest_cache",
    ".ruff_cache",
    "*.egg-info",
)
SLOWEST_S = 3600  # against a command that hangs, not a measure of speed


def blocks(page):
    """(language, code) of every block of commands on a page, in order."""
    return re.findall(r"^```(bash|python)\n(.*?)^```$", page.read_text(), flags=re.MULTILINE | re.DOTALL)


def merged(base, other):
    """Configuration with what differs laid over it, section by section."""
    both = {key: merged(base[key], other[key]) for key in base if isinstance(base[key], dict) and key in other}
    return base | other | both


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A copy of the project, set up, whose default configuration is the tiny one."""
    folder = tmp_path_factory.mktemp("clone") / "snowsim"
    shutil.copytree(ROOT, folder, ignore=NOT_COPIED, symlinks=True)
    (folder / ".venv").symlink_to(Path(sys.executable).parents[1])
    installed = folder / ".venv/.installed"
    if not installed.is_file():
        pytest.skip("the tests do not run in the .venv that make setup makes")
    for name in ("requirements.lock", "pyproject.toml", "Makefile"):  # else make would set up anew
        os.utime(folder / name, (0, 0))
    default, tiny = (yaml.safe_load((folder / f"config/{name}.yaml").read_text()) for name in ("config", "tiny"))
    small = merged(default, tiny)
    small["flight"] = default["flight"] | {"n_frames": 3}  # scenes for training are cut from frames of its length
    (folder / "config/config.yaml").write_text(yaml.safe_dump(small))
    return folder


def run_block(language, code, folder):
    """Run one block as a reader would, from the root of the clone."""
    shell = ["bash", "-euo", "pipefail", "-c", code]
    command = shell if language == "bash" else [folder / ".venv/bin/python", "-c", code]
    environment = os.environ | {"PYTHONPATH": str(folder)}
    with subprocess.Popen(
        command,
        cwd=folder,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as running:
        try:
            output = running.communicate(timeout=SLOWEST_S)
        except subprocess.TimeoutExpired:
            os.killpg(running.pid, signal.SIGKILL)  # and all that it started
            raise
    return subprocess.CompletedProcess(command, running.returncode, *output)


@pytest.mark.slow
def test_every_command_of_the_tutorial_works_in_order(clone):
    found = blocks(ROOT / "docs/start/tutorial.md")
    assert len(found) > 10
    for number, (language, code) in enumerate(found):
        done = run_block(language, code, clone)
        assert done.returncode == 0, f"block {number}:\n{code}\n{done.stdout[-2000:]}\n{done.stderr[-3000:]}"
        # Stages asked for one by one leave nothing to do for the whole.
        if code.rstrip().endswith("snakemake -n"):
            assert "Nothing to be done" in done.stdout + done.stderr
    assert (clone / "results/tables/table2.csv").is_file()
    assert (clone / "results/tables/table3.csv").is_file()
    assert (clone / "snakemake_report.html").stat().st_size > 1e5


@pytest.mark.slow
def test_every_command_of_the_tutorial_on_own_data_works_in_order(clone):
    for number, (language, code) in enumerate(blocks(ROOT / "docs/start/tutorial-own-data.md")):
        done = run_block(language, code, clone)
        assert done.returncode == 0, f"block {number}:\n{code}\n{done.stdout[-2000:]}\n{done.stderr[-3000:]}"
    assert (clone / "my_flight/results/export/pairs/pd/train.lst").is_file()
    assert (clone / "my_pairs/results/tables/table2.csv").is_file()


def test_code_on_the_pages_of_stages_runs():
    pages = sorted((ROOT / "docs/stages").glob("*.md"))
    code = [(page.name, code) for page in pages for language, code in blocks(page) if language == "python"]
    assert code
    for page, block in code:
        done = subprocess.run([sys.executable, "-c", block], capture_output=True, text=True, check=False, cwd=ROOT)
        assert done.returncode == 0, f"{page}:\n{block}\n{done.stderr[-2000:]}"
