"""What the tutorials tell a reader to do works, word for word, in a fresh copy."""

import os
import shutil
import sys
from pathlib import Path

import pytest
import yaml
from pages import blocks, save_named
from processes import ROOT, run_in
from snakemake.utils import update_config

import snowsim

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
        if code.rstrip().endswith("snakemake -n"):
            assert "Nothing to be done" in printed
    assert all((clone / name).stat().st_size >= least for name, least in made.items())


def test_code_on_the_other_pages_runs(tmp_path):
    # As tracked, for the page that corrects picks.
    climate = snowsim.Climate(accumulation_m=0.3)
    _, layers = snowsim.simulate(climate, "snow-2012", n_range_lines=1000, rng=1)
    layers["layer"] = ["surface", *(f"snow_{n}" for n in range(1, layers.sizes["layer"]))]
    of_tracker = {f"twtt_{end}": layers["twtt"] for end in ("low", "high")}
    tracked = layers[["twtt", "quality", "type", "Latitude", "Longitude", "Elevation"]]
    tracked = tracked.assign(confidence=layers["twtt"], **of_tracker)
    names = [f"Data_20120330_04_00{n}" for n in (1, 2)]
    frames = [
        snowsim.io.layers.with_frame(tracked.isel(slow_time=lines), name)
        for name, lines in zip(names, (slice(0, 500), slice(500, 1000)), strict=True)
    ]
    snowsim.io.write_layers(
        tmp_path / "20120330_04_layers.nc", snowsim.io.layers.join_frames(frames)
    )
    pages = [ROOT / "docs/start/add-your-own.md", *sorted((ROOT / "docs/stages").glob("*.md"))]
    save_named(pages[0], tmp_path)
    # One process for all, in which no block sees what another named.
    program = [
        f"exec(compile({code!r}, {page.name!r}, 'exec'), {{}})"
        for page in pages
        for language, code in blocks(page)
        if language == "python"
    ]
    assert program
    run_in(tmp_path, sys.executable, "-c", "\n".join(program))
    corrected = snowsim.io.open_segment([tmp_path / "corrected_layers.nc"])
    assert "snow_4" not in corrected["layer"].values
    is_picked = corrected["twtt"].sel(layer="snow_7").notnull().groupby("frame").any()
    assert is_picked.values.tolist() == [True, False]
    added = snowsim.io.read_layers(tmp_path / "added_layers.nc")
    assert added["layer"].values.tolist()[5:8] == ["snow_5", "by_hand", "snow_6"]
    assert added["Latitude"].dims == ("slow_time",)
    assert (added["twtt_low"] <= added["twtt"]).all()
    assert snowsim.accumulation(added).sizes["year"] == added.sizes["layer"] - 2
