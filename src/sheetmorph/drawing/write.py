"""Writing drawings: inks, and the formats they can be written in."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from sheetmorph.drawing.ink import Ink
from sheetmorph.drawing.write_dxf import dxf_bytes
from sheetmorph.drawing.write_svg import svg_bytes

__all__ = ["WRITERS", "Ink", "dxf_bytes", "svg_bytes"]

WRITERS: dict[str, Callable[[Sequence[Ink]], bytes]] = {".dxf": dxf_bytes, ".svg": svg_bytes}
