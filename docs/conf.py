"""Sphinx builds the pages with this: ``make docs``, or ``sphinx-build -n -W docs build/docs``.

Nothing is fetched: equations become MathML.
"""

import sys
from pathlib import Path

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import snowsim

project = "snowsim"
author = "The snowsim developers"
project_copyright = author
version = release = snowsim.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["amsmath", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "examples"]
sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",  # written anew by each build
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,  # its page would fetch a script
}

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
# Docstrings say shapes and quantities between backquotes; only some of them are names that have a
# page.
nitpick_ignore_regex = [(r"py:(obj|class)", r"(?s).*")]


def visit_math(translator, node):
    """An equation within the text as MathML."""
    translator.body.append(str(tex2mathml(node.astext(), as_block=False)))
    raise SkipNode


def visit_displaymath(translator, node):
    """An equation on a line of its own as MathML."""
    translator.body.append(f'<div class="math">{tex2mathml(node.astext(), as_block=True)}</div>')
    raise SkipNode


def setup(app):
    """Sphinx calls this."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
