"""What the tutorials tell a reader to do works, word for word, in a fresh copy."""

import os
import re
import shlex
import shutil
import sys
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
import yaml
from click.testing import CliRunner
from pages import blocks, save_named
from processes import ROOT, run_in
from snakemake.utils import update_config

import snowsim
from snowsim.cli import commands

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
EXPORTED = "results/export/pairs/pd/train.lst"


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A copy of the project, set up, whose default configuration is the tiny one.

    Its flight is the default one: the pages name frames of it.
    """
    folder = tmp_path_factory.mktemp("clone") / "snowsim"
    shutil.copytree(ROOT, folder, ignore=NOT_COPIED, symlinks=True)
    (folder / ".venv").symlink_to(Path(sys.executable).parents[1])
    installed = folder / ".venv/.installed"
    if not installed.is_file():
        pytest.skip("the tests do not run in the .venv that make setup makes")
    for name in ("requirements.lock", "pyproject.toml", "Makefile"):  # else make would set up anew
        os.utime(folder / name, (0, 0))
    config = yaml.safe_load((folder / "config/config.yaml").read_text())
    tiny = yaml.safe_load((folder / "config/tiny.yaml").read_text())
    del tiny["flight"]
    update_config(config, tiny)
    (folder / "config/config.yaml").write_text(yaml.safe_dump(config))
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "made"),  # files, and how many bytes they have at least
    [
        (
            "start/tutorial",
            {
                "results/tables/table2.csv": 1,
                "results/tables/table3.csv": 1,
                "snakemake_report.html": 1e5,
                "moved/results/labels/0000.nc": 1,
            },
        ),
        (
            "own-data",
            {f"my_flight/{EXPORTED}": 1, "my_pairs/results/tables/table2.csv": 1},
        ),
    ],
)
def test_every_command_of_a_tutorial_works_in_order(clone, page, made, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(clone))
    found = blocks(ROOT / f"docs/{page}.md")
    assert len(found) >= 9
    for language, code in found:
        shell = ["bash", "-euo", "pipefail", "-c", f"exec 2>&1\n{code}"]
        python = [clone / ".venv/bin/python", "-c", code]
        printed = run_in(clone, *(shell if language == "bash" else python))
        # Stages asked for one by one leave nothing to do for the whole.
        if re.search(r"snakemake -n( --directory moved -- labels)?$", code.rstrip()):
            assert "Nothing to be done" in printed
    assert all((clone / name).stat().st_size >= least for name, least in made.items())


def commands_of(code, folder):
    """Arguments of every `snowsim` command of a block, names of files expanded."""
    for line in code.replace("\\\n", " ").splitlines():
        if line.startswith("snowsim "):
            words = shlex.split(line)[1:]
            yield [
                name
                for word in words
                for name in (
                    sorted(path.name for path in folder.glob(word)) if "*" in word else [word]
                )
            ]


def test_the_tutorial_of_layers_leads_to_dated_accumulation(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for language, code in blocks(ROOT / "docs/start/layers.md"):
        if language == "python":
            exec(compile(code, "layers.md", "exec"), {})
            continue
        # In this process, on less than half of the lines and without pictures: it is quick.
        code = code.replace("--range-lines 512", "--range-lines 200").replace(" --png", "")
        for name, content in re.findall(r"^cat > (\S+) <<'CSV'\n(.*?)^CSV$", code, re.M | re.S):
            (tmp_path / name).write_text(content)
        for arguments in commands_of(code, tmp_path):
            result = CliRunner().invoke(commands, arguments, catch_exceptions=False)
            assert result.exit_code == 0, result.output
    by_tracker, by_core = (
        pd.read_csv(f"{name}_years.csv").set_index("year")["accumulation_m_we"]
        for name in ("accumulation", "by_core")
    )
    # Twenty years of .3 m w.e. a year in the mean, which vary by a fifth.
    assert len(by_tracker) > 12
    assert by_tracker.mean() == pytest.approx(0.3, rel=0.15)
    # Other densities, the same layers.
    assert 0.001 < abs(by_core / by_tracker - 1).max() < 0.1
    tracked, joined = (
        xr.load_dataset(name) for name in ("layers/20120330_04_layers.nc", "joined_layers.nc")
    )
    either = tracked["twtt"].sel(layer=["snow_12", "snow_13"]).notnull().any("layer")
    assert (joined["twtt"].sel(layer="snow_12").notnull() == either).all()
    assert not {"snow_13", "snow_17"} & set(joined["layer"].values)
    added = snowsim.io.read_layers(tmp_path / "corrected_layers.nc")
    assert added["layer"].values.tolist()[:3] == ["surface", "by_hand", "snow_2"]
    assert added["Latitude"].dims == ("slow_time",)
    below = added["twtt"].notnull()
    assert (added["twtt_low"] <= added["twtt"]).where(below, True).all()


@pytest.mark.slow
@pytest.mark.parametrize("page", ["layers", "trackers"])
def test_a_tutorial_works_word_for_word_in_an_empty_folder(tmp_path, page, monkeypatch):
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    # Of the same kind, with fewer scenes and steps.
    smaller = {"-n 400": "-n 12", "-n 20": "-n 2", "--steps 500": "--steps 20"}
    for language, code in blocks(ROOT / f"docs/start/{page}.md"):
        for word, other in smaller.items():
            code = code.replace(word, other)
        shell = ["bash", "-euo", "pipefail", "-c", f"exec 2>&1\n{code}"]
        run_in(tmp_path, *(shell if language == "bash" else [sys.executable, "-c", code]))
    assert len(list(tmp_path.rglob("*.png"))) > 1
    if page != "layers":
        return
    tracked, corrected = (
        pd.read_csv(tmp_path / f"{name}_years.csv").set_index("year")
        for name in ("accumulation", "corrected")
    )
    said = " ".join((ROOT / "docs/start/layers.md").read_text().split())
    sure = [
        f"{table['year_confidence'][year]:.2f}"[1:]
        for table in (tracked, corrected)
        for year in (2002, 2001)
    ]
    assert "dates are {} sure down to there, and {} or less below".format(*sure) in said
    assert "Now dates are {} sure down to 2002. Below they are {}:".format(*sure[2:]) in said
    thick = [f"{table['accumulation_m_we'][2002]:.2f}"[1:] for table in (corrected, tracked)]
    assert "2002 is thick, {} m, and is counted here as two years of {} m".format(*thick) in said


def test_code_on_the_other_pages_runs(tmp_path):
    pages = [ROOT / f"docs/start/{name}.md" for name in ("add-your-own", "trackers")]
    save_named(pages[0], tmp_path)
    pages += sorted((ROOT / "docs/stages").glob("*.md"))
    # One process for all, in which no block sees what another named.
    program = [
        f"exec(compile({code!r}, {page.name!r}, 'exec'), {{}})"
        for page in pages
        for language, code in blocks(page)
        if language == "python"
    ]
    assert program
    run_in(tmp_path, sys.executable, "-c", "\n".join(program))
