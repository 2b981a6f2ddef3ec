"""Functions of someone's own, which the configuration names: renderers and trackers."""

import importlib.util
from pathlib import Path


def own_function(path, name):
    """The function `name` of a Python file; ValueError if it defines none."""
    path = Path(path).resolve()
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    function = getattr(module, name, None)
    if not callable(function):
        msg = f"{path}: expected a function {name}, as config: own names it, found none"
        raise ValueError(msg)
    return function
