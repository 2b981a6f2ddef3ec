"""What Python files import of the package, read from their source."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def module_file(name, root=ROOT):
    """File of a dotted module name of the package, or None where there is no such module."""
    path = root / name.replace(".", "/")
    for candidate in (path / "__init__.py", path.with_suffix(".py")):
        if candidate.is_file():
            return candidate
    return None


def imported_modules(path, root=ROOT):
    """Dotted names of the package's modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(Path(path).read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "snowsim")
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "snowsim":
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                yield name if module_file(name, root) else node.module


def closure(script, root=ROOT):
    """Files of the package from which a script imports names, and from which those import, and so on.

    Importing a module of a folder also executes the folder's ``__init__``; nothing is taken from it, so an edit there
    does not count.
    """
    files = set()
    waiting = list(imported_modules(script, root=root))
    while waiting:
        name = waiting.pop()
        path = module_file(name, root)
        assert path, f"{script}: no module {name}"
        if path not in files:
            files.add(path)
            waiting += imported_modules(path, root=root)
    return files
