"""What a script depends on: the files of this project that it imports, and those that they import.

Snakemake does not follow imports, so rules name these files. That importing a module executes the
``__init__`` of its folder does not count: a script takes nothing from it.
"""

import ast
import functools
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Where the first part of a dotted name lies, and what it may be: scripts import each other by their
# bare names.
PLACES = {"snowsim": ROOT, "lib": ROOT / "workflow", "evaluation": ROOT / "workflow"}
SCRIPTS = ROOT / "workflow/scripts"
# Logs, errors and progress of every script: no result depends on them.
WITHOUT = {SCRIPTS / "job.py", ROOT / "workflow/lib/progress.py"}


def module_file(name):
    """File of a dotted module name of this project, or None where there is no such module."""
    top = name.partition(".")[0]
    path = PLACES.get(top, SCRIPTS).joinpath(*name.split("."))
    for candidate in (path.with_suffix(".py"), path / "__init__.py"):
        if candidate.is_file():
            return candidate
    return None


def _statements(body):
    """Statements and those inside them: expressions, most of a file, import nothing."""
    for node in body:
        yield node
        for part in ("body", "orelse", "handlers", "finalbody", "cases"):
            yield from _statements(getattr(node, part, ()))


@functools.cache
def imported_files(path):
    """Files of this project from which one file imports names, anywhere in it."""
    files = []
    for node in _statements(ast.parse(path.read_text()).body):
        if isinstance(node, ast.Import):
            files += [module_file(alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            # What is imported from a package may be a module of it, or a name in its __init__.
            own = module_file(node.module)
            files += [module_file(f"{node.module}.{alias.name}") or own for alias in node.names]
    return sorted(set(files) - WITHOUT - {None})


@functools.cache
def closure(path):
    """Files of this project on which the result of a file depends, itself left out, sorted."""
    path = Path(path)
    found = set()
    waiting = [path]
    while waiting:
        new = set(imported_files(waiting.pop())) - found
        found |= new
        waiting += new
    return sorted(found - {path})
