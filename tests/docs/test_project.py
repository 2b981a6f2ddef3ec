"""Files around the code say what is true of it."""

import importlib
import re
import shlex

import click
import pytest
import yaml
from processes import ROOT

import snowsim
from snowsim.cli import commands

README = (ROOT / "README.md").read_text()


def test_citation_names_this_version_and_licence():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == snowsim.__version__
    zenodo = yaml.safe_load((ROOT / ".zenodo.json").read_text())
    assert zenodo["version"] == citation["version"]
    assert zenodo["license"] == citation["license"] == "BSD-3-Clause"


@pytest.mark.parametrize(
    "path", ["README.md", "CONTRIBUTING.md", ".github/workflows/ci.yml", "docs/start/tutorial.md"]
)
def test_make_is_asked_for_targets_that_it_has(path):
    asked = re.findall(r"(?:`|run: |^)make ([\w-]+)", (ROOT / path).read_text(), flags=re.MULTILINE)
    targets = re.search(r"^\.PHONY: (.*)$", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)[
        1
    ].split()
    assert asked
    assert set(asked) <= set(targets)


@pytest.fixture(scope="module")
def rule_names():
    """Names of all rules in the files of rules."""
    files = (ROOT / "workflow/Snakefile", *(ROOT / "workflow").rglob("*.smk"))
    text = "\n".join(path.read_text() for path in files)
    return set(
        re.findall(r"^ *(?:rule|checkpoint|use rule \w+ as) (\w+)", text, flags=re.MULTILINE)
    )


def test_readme_names_targets_and_files_that_are_there(rule_names):
    targets = re.findall(r"`(\w+)`", README.split("| target | makes |")[1].split("\n\n")[0])
    assert targets
    assert set(targets) <= rule_names
    for link in re.findall(r"\]\(((?!http)[^)#]+)\)", README):
        assert (ROOT / link).exists(), link


def test_lines_of_readme_fit_a_terminal():
    assert max(map(len, README.splitlines())) <= 120


def test_commands_in_readme_are_commands_with_their_options():
    lines = re.findall(r"(?:^|`)snowsim (\w+) ([^`\n]*)", README, flags=re.MULTILINE)
    assert len(lines) > 9
    for name, words in lines:
        command = commands.commands[name]
        parser = command.make_parser(click.Context(command))
        parser.parse_args(shlex.split(words, comments=True))


def test_every_file_that_a_page_names_is_there():
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    for page in pages:
        for name in re.findall(
            r"`((?:snowsim|workflow|config|docs|tests|benchmarks)/[\w./]*)`", page.read_text()
        ):
            assert (ROOT / name).exists(), f"{page.name}: {name}"


def test_the_first_page_names_rules_and_functions_that_are_there(rule_names):
    page = (ROOT / "docs/index.md").read_text()
    rows = re.findall(r"^\| `[\w.]+` \| `(\w+)` \| `([\w.]+)` \|", page, flags=re.MULTILINE)
    assert rows
    for rule, name in rows:
        assert rule in rule_names
        module, _, function = name.rpartition(".")
        assert hasattr(importlib.import_module(module), function), name
