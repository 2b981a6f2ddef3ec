"""All figures of one stage: each is drawn by the function of its name.

What that function's arguments name is read, or set.
"""

from contextlib import ExitStack
from importlib import import_module
from inspect import signature
from pathlib import Path

from main_path import run

from evaluation.lib.figures.style import note_source, write_figure
from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.io.scenes import SceneSet


def read(path):
    return read_dataset(path) if Path(path).suffix == ".nc" else read_table(path)


def plot(figures, tables, stage, source, settings, scenes, studies, **inputs):
    stage = import_module(f"evaluation.lib.figures.{stage}")
    studies = [read_table(path) for path in studies]
    given = {**settings, "source": source, "studies": studies}
    tables = iter(tables)

    def argument(name, opened):
        """What a function calls `name`: a setting, scenes, or content of one file or of several."""
        if name in given:
            return given[name]
        files = inputs[name]
        if name in scenes:
            return opened.enter_context(SceneSet(files))
        return read(files) if isinstance(files, str) else map(read, files)

    for path in figures:
        draw = getattr(stage, Path(path).stem)
        with ExitStack() as opened:
            arguments = {name: argument(name, opened) for name in signature(draw).parameters}
            figure = draw(**arguments)
        if isinstance(figure, tuple):
            figure, table = figure
            write_table(next(tables), table)
        note_source(figure, source)
        write_figure(path, figure)


run(plot)
