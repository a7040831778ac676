"""Sphinx configuration of the documentation site: `python make.py docs` builds it.

The source folder is the root of the repository, so that links between pages, README and
examples are the same on the site as on a code host. Pages are Markdown (MyST).
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import mathml  # noqa: E402
import pages  # noqa: E402
from sheetmorph import __version__  # noqa: E402

project = "sheetmorph"
author = "The sheetmorph developers"
copyright = author  # noqa: A001 - the name that Sphinx reads
release = version = __version__

root_doc = "docs/index"
include_patterns = [
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "docs/**.md",
    "examples/**.md",
]
exclude_patterns = [".*", "build", "src", "tests", "benchmarks", "results", "docs/site"]
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]

# Markdown: anchors of headings as on code hosts, formulas, definition lists.
myst_heading_anchors = 5
myst_enable_extensions = ["deflist", "dollarmath", "fieldlist"]
myst_dmath_double_inline = True

# Notebooks are run at every build; an error in a cell is an error of the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

# Docstrings: `name` in backticks is code; signatures stay short.
default_role = "literal"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "fully-qualified"
python_use_unqualified_type_names = True
autodoc_preserve_defaults = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
python_maximum_signature_line_length = 88

html_theme = "furo"
html_title = f"sheetmorph {__version__}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["root"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"sidebar_hide_name": False}
pygments_dark_style = "monokai"


def setup(app: Any) -> None:
    """Connect our own parts: pages made while reading, formulas as MathML, tables as text."""
    pages.setup(app)
    mathml.setup(app)
    app.add_lexer("csv", TextLexer)
