"""All figures of one stage: each is drawn by the function of its name, from what that function's arguments name."""

from contextlib import ExitStack
from importlib import import_module
from inspect import signature
from pathlib import Path

from job import run

from lib.figures.style import note_source, write_figure
from snowsim.io.files import read_dataset, read_table, write_table
from snowsim.io.scenes import SceneSet


def read(path):
    return read_dataset(path) if Path(path).suffix == ".nc" else read_table(path)


def plot(figures, tables, stage, source, settings, scenes, studies, **inputs):
    stage = import_module(f"lib.figures.{stage}")
    given = {**settings, "source": source, "studies": [read_table(path) for path in studies]}
    tables = iter(tables)

    def argument(name, opened):
        """What a function calls `name`: a setting, scenes, one file's content, or that of several, one by one."""
        if name in given:
            return given[name]
        if name in scenes:
            return opened.enter_context(SceneSet(inputs[name]))
        return read(inputs[name]) if isinstance(inputs[name], str) else map(read, inputs[name])

    for path in figures:
        draw = getattr(stage, Path(path).stem)
        with ExitStack() as opened:
            drawn = draw(**{name: argument(name, opened) for name in signature(draw).parameters})
        figure, *made = drawn if isinstance(drawn, tuple) else (drawn,)
        for table in made:
            write_table(next(tables), table)
        note_source(figure, source)
        write_figure(path, figure)


run(plot)
