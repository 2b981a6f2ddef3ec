"""The list of figures says of each what its function takes; colours stand in one place."""

import importlib
import inspect
import re
from pathlib import Path

import pytest
import yaml

from lib.figures.style import COLOURS
from lib.imports import ROOT
from lib.registry import drawn_by, inputs_of, plots, settings_of

FIGURES = yaml.safe_load((ROOT / "workflow/figures.yaml").read_text())
LIB = ROOT / "workflow/lib"


@pytest.mark.parametrize("stage", FIGURES)
def test_every_figure_is_drawn_by_the_function_of_its_name_from_what_the_list_names(stage):
    module = importlib.import_module(f"lib.figures.{stage}")
    for file, figure in FIGURES[stage].items():
        named = {
            *figure.get("tables", []),
            *figure.get("inputs", {}),
            *figure.get("scenes", {}),
            *settings_of({0: figure}),
        }
        taken = set(inspect.signature(getattr(module, Path(file).stem)).parameters)
        assert taken - {"source", "studies"} == named, file
        assert ("studies" in taken) == ("studies" in figure), file
        assert figure["caption"].endswith("."), file


def test_what_a_source_cannot_give_is_left_to_a_rule_of_its_own():
    found = plots({"a": {"x.svg": {}, "y.svg": {"needs": "a map"}}}, {"a map": "images tell no positions"})
    assert {rule: list(figures) for rule, figures in found.items()} == {
        ("plot_a", "a"): ["x.svg"],
        ("plot_a_left_out", "a"): ["y.svg"],
    }


def test_paths_are_expanded_and_a_name_has_one_path_in_a_stage():
    frames = {"frame": lambda path: [path.replace("{frame}", "7")]}
    figures = {"x": {"tables": ["t"]}, "y": {"tables": ["t"], "inputs": {"f": "flight/{frame}.nc"}}}
    assert inputs_of(figures, frames) == {"t": "results/tables/t.csv", "f": ["results/flight/7.nc"]}
    with pytest.raises(ValueError, match=r"t: expected one path in a stage, got tables/t\.csv and t\.nc"):
        inputs_of({**figures, "z": {"inputs": {"t": "t.nc"}}}, frames)


def test_figures_of_another_stage_are_no_code_of_a_stage():
    code = {Path(file).stem for file in drawn_by("tracker")(None)}
    assert {"tracker", "style", "files"} <= code
    assert not code & (set(FIGURES) - {"tracker"})


def test_colours_stand_in_the_style_alone():
    assert all(re.fullmatch("#[0-9A-F]{6}", colour) for colour in COLOURS.values())
    for path in [*LIB.glob("figures/*.py"), *LIB.glob("report/*.py")]:
        if path.stem != "style":
            assert not re.findall(r'"#[0-9A-Fa-f]{6}"|color="(?:black|white)"|RD\+', path.read_text()), path
