"""Examples in docstrings show what they claim."""

import doctest
import importlib

import pytest

PUBLIC = (
    "snowsim.phy.mean_power",
    "snowsim.phy.render",
    "snowsim.phy.draw_speckle",
    "snowsim.statistics.fit",
    "snowsim.labels.draw",
    "snowsim.metrics.image.similarity",
    "snowsim.metrics.edges.match_counts",
    "snowsim.metrics.edges.score",
    "snowsim.metrics.edges.suppress",
    "snowsim.io.read_echogram",
    "snowsim.io.read_layers",
)


@pytest.mark.parametrize("name", PUBLIC)
def test_the_example_of_a_public_function_runs(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # examples may write files
    module, _, function = name.rpartition(".")
    public = getattr(importlib.import_module(module), function)
    home = importlib.import_module(public.__module__)
    (example,) = doctest.DocTestFinder(recurse=False).find(public, name, module=home)
    assert example.examples, f"{name} has no example"
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    shown = []
    runner.run(example, out=shown.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(shown)
