"""The studio's viewer in a notebook: one result in space, with a slider, in a page by itself.

The page holds the scripts and the result, so that it needs neither a server nor a network, stays in
the notebook when that is saved, and can be written to a file and sent to somebody.
"""

from __future__ import annotations

import base64
import gzip
import html
import json
from dataclasses import dataclass
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Literal

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.core.files import write_bytes
from sheetmorph.studio.bundle import three_js
from sheetmorph.studio.frames import pack
from sheetmorph.studio.scene import FIELDS, scene

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

Theme = Literal["light", "dark"]

PAGE = Path(__file__).resolve().parent / "page"
STYLES = ("style.css", "parts.css", "notebook.css")
SCRIPTS = ("dom.js", "wire.js", "colours.js", "view.js", "notebook.js")
"""Each imports only those before it, and three.js."""
HEIGHTS = (200, 2000)
"""Least and largest height of a view [px]."""


@dataclass(frozen=True)
class View:
    """A result to be looked at. Jupyter shows it where it is the last thing in a cell.

    Attributes:
        page: the whole page, HTML.
        height: of the frame in the notebook [px].
    """

    page: str
    height: int

    def _repr_html_(self) -> str:
        """What Jupyter shows: the page in a frame of its own."""
        return (
            f'<iframe title="The sheet in space" srcdoc="{html.escape(self.page)}" '
            f'style="box-sizing: border-box; width: 100%; height: {self.height}px; '
            f'border: 1px solid #ddd8cc"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<View of {len(self.page) / 1e6:.1f} MB; .save(FILE) writes the page>"

    def save(self, path: str | Path) -> Path:
        """Write the page to a file that any browser opens.

        Raises:
            OutputError: the file cannot be written.
        """
        file = Path(path)
        write_bytes(file, self.page.encode())
        return file


def view(result: Result, *, field: str = "", height: int = 480, theme: Theme = "light") -> View:
    """The interactive view of a result: turn it, scrub the actuation, colour it by a field.

    Args:
        result: what was computed.
        field: what the colours show at first: a name in `sheetmorph.studio.scene.FIELDS`, such as
            "height", "angle" or "mean"; the material by default.
        height: of the view [px], 200 to 2000.
        theme: "light" or "dark".

    Raises:
        InputError: an argument is not one of those; the packages of the studio are not installed.
    """
    if field and field not in FIELDS:
        guess = nearest(field, FIELDS)
        hint = f"; did you mean {guess}?" if guess else ""
        raise InputError(f"is no field of the view{hint}", value=field, allowed=", ".join(FIELDS))
    if not HEIGHTS[0] <= height <= HEIGHTS[1]:
        raise InputError("is no height of a view", value=height, allowed="200 to 2000 pixels")
    if theme not in ("light", "dark"):
        raise InputError("is no theme", value=theme, allowed="light, dark")
    scripts = [("three.js", three_js().read_text("utf-8"))]
    scripts += [(name, (PAGE / name).read_text("utf-8")) for name in SCRIPTS]
    head, arrays = scene(result, preview=False)
    page = Template((PAGE / "notebook.html").read_text("utf-8")).substitute(
        theme=theme,
        title=html.escape(result.design.name),
        style="\n".join((PAGE / name).read_text("utf-8") for name in STYLES),
        modules=_packed(json.dumps(scripts).encode()),
        packet=_packed(pack(head, arrays)),
        field=json.dumps(field),
    )
    return View(page, height)


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, mtime=0)).decode()
