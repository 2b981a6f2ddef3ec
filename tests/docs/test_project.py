"""Files around the code say what is true of it."""

import re
from pathlib import Path

import pytest
import yaml

import snowsim

ROOT = Path(__file__).resolve().parents[2]


def test_citation_names_this_version_and_licence():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == snowsim.__version__
    assert citation["license"] == "BSD-3-Clause"
    assert {"cff-version", "message", "title", "authors"} <= set(citation)
    assert all({"title", "authors", "year"} <= set(reference) for reference in citation["references"])


def make_targets():
    text = (ROOT / "Makefile").read_text()
    return set(re.search(r"^\.PHONY: (.*)$", text, flags=re.MULTILINE)[1].split())


@pytest.mark.parametrize("path", ["README.md", "CONTRIBUTING.md", ".github/workflows/ci.yml", "docs/start/tutorial.md"])
def test_make_is_asked_for_targets_that_it_has(path):
    asked = re.findall(r"(?:`|run: |^)make ([\w-]+)", (ROOT / path).read_text(), flags=re.MULTILINE)
    assert asked
    assert set(asked) <= make_targets()


def test_readme_names_targets_and_files_that_are_there():
    readme = (ROOT / "README.md").read_text()
    rules = "\n".join(path.read_text() for path in (ROOT / "Snakefile", *(ROOT / "workflow/rules").glob("*.smk")))
    table = readme.split("| target | makes |")[1].split("\n\n")[0]
    targets = re.findall(r"`(\w+)`", table)
    assert targets
    for target in targets:
        assert re.search(rf"^rule {target}:", rules, flags=re.MULTILINE), target
    for link in re.findall(r"\]\(((?!http)[^)#]+)\)", readme):
        assert (ROOT / link).exists(), link


def test_hooks_are_local_and_of_the_projects_own_environment():
    hooks = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text())
    assert [repo["repo"] for repo in hooks["repos"]] == ["local"]
    entries = [hook["entry"].split()[0] for repo in hooks["repos"] for hook in repo["hooks"]]
    assert set(entries) <= {".venv/bin/ruff", ".venv/bin/snakefmt", "bash"}
    assert all(hook["language"] == "system" for repo in hooks["repos"] for hook in repo["hooks"])


def test_issue_templates_have_a_name_and_what_they_are_about():
    templates = sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.md"))
    assert templates
    for path in templates:
        head = yaml.safe_load(path.read_text().split("---")[1])
        assert head["name"], path
        assert head["about"], path
