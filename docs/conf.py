"""Sphinx builds the documentation with this: ``make docs``, or ``sphinx-build -n -W docs build/docs``.

Nothing is fetched: equations become MathML, the graph of rules and the configuration reference are made from the
workflow itself while the pages are read.
"""

import sys
from pathlib import Path

from docutils.utils.math.latex2mathml import tex2mathml

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

import configuration  # noqa: E402
import rulegraph  # noqa: E402

import snowsim  # noqa: E402

project = "snowsim"
author = "The snowsim developers"
project_copyright = author
version = release = snowsim.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["amsmath", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]

html_theme = "furo"
html_title = f"snowsim {release}"
html_copy_source = False
html_show_sourcelink = False
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["wide.css"]

default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_param = False
napoleon_use_ivar = True
nitpicky = True
# Docstrings say shapes and quantities between backquotes; only some of them are names that have a page.
nitpick_ignore_regex = [(r"py:(obj|class)", r"(?s).*")]

# What a page asks for with ``<!-- generated: name -->``, made when it is read.
GENERATED = {
    "configuration": lambda: configuration.markdown(configuration.read_settings()),
    "flow": lambda: _raw(rulegraph.svg(rulegraph.FLOW, "What flows between the stages")),
    "rules": lambda: _raw(rulegraph.svg(rulegraph.reduced(rulegraph.read_rules()), "Rules of the default target")),
}


# Pages that hold something generated: read again at every build.
GENERATED_PAGES = {"configuration", "start/concept"}


def _raw(svg):
    return f'```{{raw}} html\n<div class="picture">{svg.strip()}</div>\n```'


def fill_in(app, docname, source):
    """Put what is generated where a page says ``<!-- generated: name -->``."""
    for name, make in GENERATED.items():
        mark = f"<!-- generated: {name} -->"
        if mark in source[0]:
            if docname not in GENERATED_PAGES:
                msg = f"{docname}: a page with {mark} must be in GENERATED_PAGES of conf.py"
                raise ValueError(msg)
            source[0] = source[0].replace(mark, make())


def visit_math(translator, node):
    """An equation within the text as MathML."""
    translator.body.append(str(tex2mathml(node.astext(), as_block=False)))


def visit_displaymath(translator, node):
    """An equation on a line of its own as MathML."""
    translator.body.append(f'<div class="math">{tex2mathml(node.astext(), as_block=True)}</div>')


def _skip(visit):
    from docutils import nodes

    def visit_and_skip(translator, node):
        visit(translator, node)
        raise nodes.SkipNode

    return visit_and_skip


def setup(app):
    """Sphinx calls this."""
    app.add_html_math_renderer("mathml", (_skip(visit_math), None), (_skip(visit_displaymath), None))
    app.connect("source-read", fill_in)
    app.connect("env-get-outdated", lambda app, env, added, changed, removed: GENERATED_PAGES)
