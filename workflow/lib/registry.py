"""The list of figures, workflow/figures.yaml: which job draws which of them, from what files."""

import re

from lib.imports import ROOT, closure


def plots(registry, left_out):
    """Figures by (rule's name, stage) and file.

    What the default run leaves out is asked for by a rule of its own.
    """
    found = {}
    for stage, figures in registry.items():
        for file, figure in figures.items():
            rule = f"plot_{stage}"
            if figure.get("needs") in left_out:
                rule += "_left_out"
            found.setdefault((rule, stage), {})[file] = figure
    return found


def inputs_of(figures, files_of):
    """Inputs of figures, each once, by name.

    An input is one file, or what `files_of` makes of a path by the name in its braces.
    """
    paths = {}
    for figure in figures.values():
        for name, path in paths_of(figure):
            if paths.setdefault(name, path) != path:
                msg = f"figures: {name}: expected one path in a stage, got {paths[name]} and {path}"
                raise ValueError(msg)
    files = {}
    for name, path in paths.items():
        path = f"results/{path}"
        braces = re.search(r"\{(\w+)\}", path)
        files[name] = files_of[braces[1]](path) if braces else path
    return files


def paths_of(figure):
    """Names and paths of what a figure is drawn from, under the folder of results."""
    for name in figure.get("tables", []):
        yield name, f"tables/{name}.csv"
    yield from figure.get("inputs", {}).items()
    yield from figure.get("scenes", {}).items()


def named_by(figures, kind):
    """What figures list under a kind, such as `scenes` or `studies`."""
    return [item for figure in figures.values() for item in figure.get(kind, [])]


def settings_of(figures):
    """Settings of all figures by name."""
    settings = {}
    for figure in figures.values():
        settings |= figure.get("settings", {})
    return settings


def drawn_by(stage):
    """Input function: what draws a stage's figures; other stages' code draws nothing anew."""
    drawing = ROOT / f"workflow/evaluation/lib/figures/{stage}.py"

    def code(wildcards):
        files = {drawing, *closure(drawing), *closure(ROOT / "workflow/evaluation/scripts/plot.py")}
        return sorted(map(str, files))

    return code


def write_captions(registry, folder):
    """Write every caption to a file, by the figure's name.

    Snakemake's own report takes captions from files alone.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for figures in registry.values():
        for file, figure in figures.items():
            path = folder / f"{file}.rst"
            caption = figure["caption"]
            if not path.is_file() or path.read_text() != caption:
                path.write_text(caption)
