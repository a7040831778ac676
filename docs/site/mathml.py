"""Formulas as MathML, made while the site is built: no script and no font is loaded to show them.

Docutils brings the converter. What it does not know is an error of the build.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.util import logging

log = logging.getLogger(__name__)


def setup(app: Any) -> None:
    """Let HTML pages write formulas by this file, under the name `mathml`."""
    app.add_html_math_renderer("mathml", (inline, leave), (block, leave))
    app.config.html_math_renderer = "mathml"


def inline(writer: Any, node: nodes.math) -> None:
    """A formula in a line of text."""
    writer.body.append(f'<span class="math">{convert(node, as_block=False)}</span>')
    raise nodes.SkipNode


def block(writer: Any, node: nodes.math_block) -> None:
    """A formula on lines of its own, with an anchor where it has a label."""
    names = "".join(f' id="{name}"' for name in node.get("ids", ())[:1])
    writer.body.append(f'<div class="math"{names}>{convert(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def leave(writer: Any, node: nodes.Node) -> None:
    """Nothing is left to write."""


def convert(node: nodes.Node, *, as_block: bool) -> str:
    """MathML of a formula; a warning with its place where it cannot be converted."""
    source = node.astext()
    if as_block and "\\\\" in source and "\\begin" not in source:
        source = f"\\begin{{aligned}}{source}\\end{{aligned}}"
    try:
        return latex2mathml.tex2mathml(source, as_block=as_block)
    except Exception as error:  # the converter raises several kinds
        log.warning("formula not understood: %s (%s)", source, error, location=node)
        return ""
