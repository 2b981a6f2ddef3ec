"""The list of figures, workflow/figures.yaml: which job draws which of them, and from what files."""

import re

from lib.imports import ROOT, SCRIPTS, closure


def plots(registry, left_out):
    """Figures by (rule's name, stage) and file; what the default run leaves out is asked for by a rule of its own."""
    found = {}
    for stage, figures in registry.items():
        for file, figure in figures.items():
            rule = f"plot_{stage}_left_out" if figure.get("needs") in left_out else f"plot_{stage}"
            found.setdefault((rule, stage), {})[file] = figure
    return found


def inputs_of(figures, files_of):
    """Inputs of figures, each once, by name: one file, or what `files_of` makes of a path by the name in its braces."""
    paths = {}
    for figure in figures.values():
        named = {name: f"tables/{name}.csv" for name in figure.get("tables", [])}
        for name, path in {**named, **figure.get("inputs", {}), **figure.get("scenes", {})}.items():
            if paths.setdefault(name, path) != path:
                msg = f"figures: {name}: expected one path in a stage, got {paths[name]} and {path}"
                raise ValueError(msg)
    files = {name: f"results/{path}" for name, path in paths.items()}
    for name, path in files.items():
        if braces := re.search(r"\{(\w+)\}", path):
            files[name] = files_of[braces[1]](path)
    return files


def named_by(figures, kind):
    """What figures list under a kind, such as `scenes` or `studies`."""
    return [item for figure in figures.values() for item in figure.get(kind, [])]


def settings_of(figures):
    """Settings of all figures by name."""
    return {
        name: value
        for figure in figures.values()
        for name, value in figure.get("settings", {}).items()
    }


def drawn_by(stage):
    """Input function: what draws a stage's figures; an edit to those of another stage draws nothing anew."""
    drawing = ROOT / f"workflow/lib/figures/{stage}.py"
    return lambda wildcards: sorted(
        {str(f) for f in (drawing, *closure(drawing), *closure(SCRIPTS / "plot.py"))}
    )


def write_captions(registry, folder):
    """Write every caption to a file, by the figure's name: Snakemake's own report takes captions from files alone."""
    folder.mkdir(parents=True, exist_ok=True)
    for figures in registry.values():
        for file, figure in figures.items():
            path = folder / f"{file}.rst"
            if not path.is_file() or path.read_text() != figure["caption"]:
                path.write_text(figure["caption"])
