"""Files around the code say what is true of it."""

import importlib
import re

import pytest
import yaml
from runs import CONFIG

import snowsim
from lib.imports import ROOT


def test_citation_names_this_version_and_licence():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == snowsim.__version__
    zenodo = yaml.safe_load((ROOT / ".zenodo.json").read_text())
    assert zenodo["version"] == citation["version"]
    assert zenodo["license"] == citation["license"] == "BSD-3-Clause"
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert all(
        {"title", "authors", "year"} <= set(reference) for reference in citation["references"]
    )


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
    readme = (ROOT / "README.md").read_text()
    targets = re.findall(r"`(\w+)`", readme.split("| target | makes |")[1].split("\n\n")[0])
    assert targets
    assert set(targets) <= rule_names
    for link in re.findall(r"\]\(((?!http)[^)#]+)\)", readme):
        assert (ROOT / link).exists(), link


def test_the_graph_of_the_readme_is_small_and_shows_targets_and_stages(rule_names):
    graph = (ROOT / "README.md").read_text().split("```mermaid\n")[1].split("```")[0]
    edges = re.findall(
        r"^    (\w+)(?:\[.+?\])? -->\|.+\| (\w+)(?:\[.+?\])?$", graph, flags=re.MULTILINE
    )
    assert (
        len(edges) == len(graph.splitlines()) - 1
    )  # every line after the first is an edge, said what flows
    nodes = {node for edge in edges for node in edge}
    assert 0 < len(nodes) <= 12
    assert len(set(edges)) == len(edges) <= 16
    stages = {path.name for path in (ROOT / "snowsim").rglob("*") if path.is_dir()}
    assert nodes <= rule_names | stages | set(CONFIG)


def test_every_file_that_a_page_names_is_there():
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]
    for page in pages:
        for name in re.findall(
            r"`((?:snowsim|workflow|config|docs|tests|benchmarks)/[\w./]*)`", page.read_text()
        ):
            assert (ROOT / name).exists(), f"{page.name}: {name}"


def test_from_a_setting_to_its_equation_are_two_hops(rule_names):
    table = (
        (ROOT / "docs/start/concept.md")
        .read_text()
        .split("| key | rule | function | equation |")[1]
    )
    rows = re.findall(
        r"^\| `([\w.]+)` \| `(\w+)` \| `([\w.]+)` \| (.+) \|$", table, flags=re.MULTILINE
    )
    assert len(rows) >= 5
    for key, rule, name, equation in rows:
        value = CONFIG
        for part in key.split("."):
            value = value[part]
        assert rule in rule_names
        module, _, function = name.rpartition(".")
        docstring = getattr(importlib.import_module(module), function).__doc__
        author, year = re.search(r"(\w+)(?: & \w+| et al\.)? \((\d{4})\)", equation).groups()
        assert author in docstring, name
        assert year in docstring, name
