"""Which commit a table of the pages is of, and whether the code that it depends on has changed."""

import ast
import subprocess
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Small tables that are kept in the repository; the others are of a run of the workflow.
KEPT = {
    "budgets": "workflow/evaluation/measured_budgets.csv",
    "choices": "workflow/evaluation/measured_choices.csv",
    "headline": "workflow/evaluation/measured_flights.csv",
    "flights": "workflow/evaluation/measured_flights.csv",
    "deep_layers": "workflow/evaluation/measured_flights_depths.csv",
    "annotation": "workflow/evaluation/measured_annotation.csv",
    "joining": "benchmarks/joining_by_flight.csv",
    "confidence": "benchmarks/confidence_by_case.csv",
    "dates": "benchmarks/years_by_class.csv",
    "dated_cases": "benchmarks/years_by_case.csv",
    "agreement": "benchmarks/agreement_by_flight.csv",
}
FLOWN = (
    *(f"snowsim/{name}" for name in ("labels", "phy", "cgan", "statistics", "metrics")),
    *(f"snowsim/tracker/{name}.py" for name in ("network", "train", "sampling", "calibration")),
    *("workflow/reference", "workflow/lib/tracker_training.py", "workflow/lib/cgan_training.py"),
    *("workflow/evaluation/lib/flights.py", "workflow/evaluation/lib/studied.py"),
)
TRACKED = ("snowsim/tracker", "snowsim/metrics", "workflow/reference", "workflow/pretrained")
# Studies whose scenes are scored once, and the code that their scores depend on: they are not
# repeated at every change, so that their pages have to say what has changed.
SCORED_ONCE = {
    "headline": FLOWN,
    "flights": FLOWN,
    "deep_layers": FLOWN,
    "transfer": TRACKED,
    "accumulation": (*TRACKED, "snowsim/snowpack"),
}
# What has changed in that code since, if anything, by table.
CHECKS = "limits of settings, checks of input and warnings are new since, and change no number"
SINCE = {
    "headline": CHECKS,
    "flights": CHECKS,
    "deep_layers": CHECKS,
    "accumulation": "warnings and checks of input are new since, and the flag of a year whose "
    "lower end is unsure, which change no number of it",
    "transfer": "memory of the network is reserved in another way since, and settings and input "
    "are checked more, which changes no pick",
}


def git(*arguments):
    """Output of a git command in the checkout; CalledProcessError where there is none."""
    command = ["git", "-C", ROOT, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def commit_line(name):
    """The line under a table that is filled now.

    A kept table is of the commit that put it there, any other of the checkout's.
    """
    of_file = ["--", KEPT[name]] if name in KEPT else []
    commit = git("log", "-1", "--format=%H", *of_file)
    line = f"Commit {commit[:8]}" + (f"; {SINCE[name]}" if name in SINCE else "") + "."
    return textwrap.fill(line, 120) + "\n"


def changed_since(commit, paths):
    """Files at `paths` whose code is not that of a commit; words of docstrings do not count."""
    names = git("diff", "--name-only", commit, "--", *paths).splitlines()
    return [name for name in names if code_of(name, commit) != code_of(name)]


def code_of(name, commit=None):
    """Code of a file of a commit, or of the checkout, without comments and docstrings.

    None if the file is not there.
    """
    try:
        text = git("show", f"{commit}:{name}") if commit else (ROOT / name).read_text()
    except (subprocess.CalledProcessError, FileNotFoundError):
        return None
    if not name.endswith(".py"):
        return text
    tree = ast.parse(text)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and is_text(body[0]):
            del body[0]
    return ast.dump(tree)


def is_text(statement):
    """Whether a statement is a string alone, as a docstring is."""
    value = getattr(statement, "value", None)
    return isinstance(statement, ast.Expr) and isinstance(getattr(value, "value", None), str)
