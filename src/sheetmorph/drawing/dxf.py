"""Reading DXF: layers, units and nested blocks."""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.contours import joined
from sheetmorph.drawing.dxf_curves import FILLED, SHAPES, curves_of, is_mesh
from sheetmorph.drawing.model import Curve, DrawnItem, Floats
from sheetmorph.drawing.notes import at
from sheetmorph.drawing.request import UNITS, Contents, Request

if TYPE_CHECKING:
    from ezdxf.document import Drawing as Document
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.entities.insert import Insert

MAX_DEPTH = 16
MAX_COPIES = 5_000
INSUNITS: dict[int, float] = {
    1: 0.0254,
    2: 0.3048,
    4: 1e-3,
    5: 1e-2,
    6: 1.0,
    8: 2.54e-8,
    9: 2.54e-5,
    10: 0.9144,
    12: 1e-9,
    13: 1e-6,
    14: 1e-1,
}
"""Lengths [m] of the units that $INSUNITS numbers."""


def read_dxf(data: bytes, request: Request) -> tuple[Contents, float]:
    """Read the model space of a DXF file, of any release, as text or binary.

    Layers that are off or frozen are left out; entities on layer 0 of a block belong to
    the layer where the block is placed. Loose pieces of a layer are joined where their
    ends meet.

    Returns:
        The items by layer, and the length of a unit of the file [m].

    Raises:
        InputError: no DXF, damaged, cut off, without a unit, or beyond the bounds.
    """
    document = _document(data)
    unit = _unit(document, request)
    walk = _Walk(document, unit, request)
    try:
        walk.visit(document.modelspace(), np.eye(4), "0", 0)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"an entity of the file is damaged ({_reason(error)})") from error
    contents = Contents()
    for name, item in walk.filled:
        contents.add(item, [("layer", name)])
    for name, curves in walk.curves.items():
        for curve in joined(curves, request.gap, request.notes):
            contents.add(DrawnItem((curve,)), [("layer", name)])
    return contents, unit


class _Walk:
    """Goes through the entities and unfolds blocks."""

    def __init__(self, document: Document, unit: float, request: Request) -> None:
        self.curves: dict[str, list[Curve]] = {}
        self.filled: list[tuple[str, DrawnItem]] = []
        self._document = document
        self._unit = unit
        self._request = request
        self._copies = 0
        # Layers differ by more than their letters' case; the first spelling stands for all.
        self._spelling: dict[str, str] = {}
        self._hidden = {
            layer.dxf.name.casefold()
            for layer in document.layers
            if layer.is_off() or layer.is_frozen()
        }

    def visit(
        self, entities: Iterable[DXFGraphic], matrix: Floats, around: str, depth: int
    ) -> None:
        """Read entities that a matrix, shape (4, 4) for row vectors, takes to the drawing."""
        for entity in entities:
            self._request.budget.entity()
            layer = str(entity.dxf.get("layer", "0"))
            layer = around if layer == "0" and depth else layer
            layer = self._spelling.setdefault(layer.casefold(), layer)
            kind = entity.dxftype()
            if entity.dxf.get("invisible", 0) or layer.casefold() in self._hidden:
                self._request.notes.add("hidden", f"a hidden {kind} on layer {layer!r} was ignored")
            elif kind == "INSERT":
                self._insert(entity, matrix, layer, depth)  # type: ignore[arg-type]
            elif kind in SHAPES and not is_mesh(entity):
                self._shape(entity, matrix, layer)
            else:
                place = self._place(entity, matrix)
                self._request.notes.add(
                    "ignored", f"{kind} on layer {layer!r}{place} is no flat curve and was ignored"
                )

    def _shape(self, entity: DXFGraphic, matrix: Floats, layer: str) -> None:
        scale = self._unit * max(float(np.linalg.norm(matrix[:3, :3], ord=2)), 1e-12)
        pieces = curves_of(entity, self._request.flatness / scale, self._request.budget)
        made: list[Curve] = []
        for points, closed in pieces:
            spatial = self._unit * (points @ matrix[:3, :3] + matrix[3, :3])
            heights = spatial[:, 2]
            # Not finite: the check of the curve below says so.
            if np.isfinite(heights).all() and np.ptp(heights) > self._request.flatness:
                self._request.notes.add(
                    "3D",
                    f"{entity.dxftype()} on layer {layer!r} at {at(spatial[0])} leaves the plane "
                    "and was ignored",
                )
                return
            curve = self._request.curve(spatial[:, :2], closed)
            made += [] if curve is None else [curve]
        if entity.dxftype() not in FILLED:
            self.curves.setdefault(layer, []).extend(made)
            return
        closed_ones = [c for c in joined(made, self._request.gap, self._request.notes) if c.closed]
        if closed_ones:
            self.filled.append((layer, DrawnItem(tuple(closed_ones), "evenodd")))

    def _insert(self, entity: Insert, matrix: Floats, layer: str, depth: int) -> None:
        name = str(entity.dxf.get("name", ""))
        block = self._document.blocks.get(name)
        place = self._place(entity, matrix)
        if block is None or block.block is None or block.block.is_xref:
            why = "is kept in another file" if block is not None else "is missing"
            self._request.notes.add("block", f"block {name[:60]!r}{place} {why} and was ignored")
            return
        if depth >= MAX_DEPTH:
            raise InputError(
                f"blocks are nested too deeply at {name[:60]!r}, or one contains itself",
                allowed=f"≤ {MAX_DEPTH} levels",
            )
        count = max(int(entity.mcount), 1)
        self._copies += count
        if self._copies > MAX_COPIES:
            raise InputError("the drawing unfolds too many blocks", allowed=f"≤ {MAX_COPIES}")
        for copy in entity.multi_insert() if count > 1 else (entity,):
            own = np.array(list(copy.matrix44()), dtype=np.float64).reshape(4, 4)
            self.visit(block, own @ matrix, layer, depth + 1)

    def _place(self, entity: DXFGraphic, matrix: Floats) -> str:
        for name in ("insert", "start", "center", "location"):
            if entity.dxf.hasattr(name):
                point = np.array(list(entity.dxf.get(name))[:3], dtype=np.float64)
                if point.shape == (3,):
                    return f" at {at(self._unit * (point @ matrix[:3, :3] + matrix[3, :3]))}"
        return ""


def _document(data: bytes) -> Document:
    from ezdxf.filemanagement import readfile

    binary = data.startswith(b"AutoCAD Binary DXF")
    if not binary and b"SECTION" not in data[:4096]:
        raise InputError("is no DXF file: it does not start with a section")
    if not data.rstrip(b"\r\n \t\x00\x1a").endswith(b"EOF"):
        raise InputError("the file is cut off: it does not end with EOF")
    # The library takes names of files alone when it has to find out the encoding.
    logging.getLogger("ezdxf").setLevel(logging.CRITICAL)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "drawing.dxf"
        copy.write_bytes(data)
        try:
            return readfile(copy)
        except Exception as error:
            raise InputError(f"is no readable DXF file ({_reason(error)})") from error


def _unit(document: Document, request: Request) -> float:
    try:
        code = int(document.header.get("$INSUNITS", 0))
    except (TypeError, ValueError) as error:
        raise InputError("$INSUNITS is no number", key="$INSUNITS") from error
    own = INSUNITS.get(code)
    if request.scale is not None:
        if own is not None and own != request.scale:
            request.notes.add(
                "unit",
                f"the file says that a unit is {1e3 * own:g} mm; read as {request.unit} because "
                "that was asked for",
            )
        return request.scale
    if own is None:
        raise InputError(
            "the drawing does not say its unit; set unit"
            if code == 0
            else f"the drawing has a unit that is not read ($INSUNITS = {code}); set unit",
            key="unit",
            allowed=", ".join(UNITS),
        )
    return own


def _reason(error: Exception) -> str:
    return (" ".join(str(error).split()) or type(error).__name__)[:100]
