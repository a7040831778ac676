"""Reading STL and 3MF: the plan of a flat surface or a plate, as seen from above."""

from __future__ import annotations

import io
import re
import zipfile
import zlib
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.model import Curve, DrawnItem, Floats
from sheetmorph.drawing.notes import at, mm
from sheetmorph.drawing.request import MAX_COORDINATE, Contents, Request
from sheetmorph.drawing.svg_numbers import numbers

MAX_TRIANGLES = 200_000
MAX_INFLATED = 100 * 2**20
MAX_DEPTH = 8
MAX_PARTS = 2000
UNITS_3MF: dict[str, float] = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}

_FLOAT = rb"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_VERTEX = re.compile(rb"vertex\s+(" + rb"\s+".join([_FLOAT] * 3) + rb")")
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("mark", "<u2")])
# Faces steeper than this stand upright (cosine of the angle to the plane's normal).
_UPRIGHT = 1e-4
_TILTED = 1e-6


def read_stl(data: bytes, request: Request) -> tuple[Contents, float]:
    """Read the plan of an STL file, binary or text; a unit is a millimetre unless asked for.

    Raises:
        InputError: damaged, cut off, or without flat faces.
    """
    unit = request.scale or 1e-3
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + 50 * count:
        _check_count(count)
        corners = np.frombuffer(data, _RECORD, offset=84)["corners"].astype(np.float64)
    elif data.lstrip().startswith(b"solid"):
        if b"endsolid" not in data[-300:]:
            raise InputError("the file is cut off or damaged: it does not end with endsolid")
        _check_count(data.count(b"facet normal"))
        found = _VERTEX.findall(data)
        if len(found) != 3 * data.count(b"facet normal") or data.count(b"vertex") != len(found):
            raise InputError("the file is damaged: a facet has not three corners")
        corners = np.array(b" ".join(found).split(), dtype=np.float64).reshape(-1, 3, 3)
    else:
        raise InputError(
            f"is no readable STL file, or it is cut off: {count} triangles are announced, "
            f"{max(len(data) - 84, 0) // 50} are there"
        )
    contents = Contents()
    # Single precision moves a corner by 1e-7 of its distance: corners are one within that.
    contents.add(_plan(_welded(corners) * unit, "the solid", request), [])
    return contents, unit


def read_3mf(data: bytes, request: Request) -> tuple[Contents, float]:
    """Read the plans of the objects that a 3MF file builds, each by its name.

    Raises:
        InputError: damaged, beyond the bounds, or without flat faces.
    """
    root = _model(data)
    unit_word = root.get("unit", "millimeter")
    own = UNITS_3MF.get(unit_word)
    if own is None:
        raise InputError(
            "no such unit in 3MF", key="unit", value=unit_word, allowed=", ".join(UNITS_3MF)
        )
    unit = request.scale or own
    if unit != own:
        request.notes.add("unit", f"the file is in {unit_word}s; read as {request.unit}")
    objects = {
        element.get("id", ""): element for element in root.iter() if _tag(element) == "object"
    }
    items = [element for element in root.iter() if _tag(element) == "item"]
    contents = Contents()
    spent = [0, 0]
    for item in items[:MAX_PARTS]:
        target = objects.get(item.get("objectid", ""))
        if target is None:
            raise InputError("the file builds an object that it does not hold")
        parts = _triangles(target, objects, _matrix(item), spent, 0)
        name = target.get("name") or f"object {target.get('id', '')}"
        if len(parts):
            contents.add(_plan(parts * unit, repr(name[:60]), request), [("object", name)])
    if not contents.items:
        raise InputError("the file builds no object with triangles")
    return contents, unit


def _plan(corners: Floats, name: str, request: Request) -> DrawnItem:
    """The shadow of triangles, shape (T, 3, 3) [m], that lie flat or stand upright."""
    import shapely

    from sheetmorph.drawing.areas import as_multipolygon

    if not (np.abs(corners) <= MAX_COORDINATE).all():
        raise InputError(f"{name} has a corner out of bounds", allowed="within 10 km")
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1)
    slope = np.abs(normal[:, 2]) / np.where(size > 0.0, size, 1.0)
    lying = slope > _UPRIGHT
    level = slope > 1.0 - _TILTED
    if not level.any():
        raise InputError(
            f"{name} has no face that lies in a plane of constant z: the plan of a plate is wanted"
        )
    tilted = np.flatnonzero(lying & ~level)
    if len(tilted):
        place = at(corners[tilted[0]].mean(axis=0))
        request.notes.add(
            "tilted",
            f"{name}: {len(tilted)} faces are tilted, one at {place}; the plan is the shadow of "
            "all faces seen from above",
        )
    heights = np.unique(np.round(corners[level][:, 0, 2] / request.flatness))
    if len(heights) > 2:
        request.notes.add(
            "steps",
            f"{name} has flat faces at {len(heights)} heights over "
            f"{mm(float(np.ptp(heights)) * request.flatness)}; the plan is their shadow",
        )
    # The covers of a plate cast the same triangles; each is needed once.
    flat = np.unique(np.sort(corners[lying][:, :, :2].copy().view("f8,f8")[..., 0], axis=1), axis=0)
    triangles = shapely.polygons(flat.view("f8").reshape(-1, 3, 2))
    request.budget.vertices(3 * len(triangles))
    shape = as_multipolygon(shapely.union_all(triangles[shapely.area(triangles) > 0.0]))
    rings = [
        np.asarray(shapely.get_coordinates(ring)[:-1], dtype=np.float64)
        for part in shape.geoms
        for ring in (part.exterior, *part.interiors)
    ]
    curves = [request.curve(ring, True) for ring in rings]
    return DrawnItem(tuple(Curve(c.points, True) for c in curves if c is not None), "evenodd")


def _welded(corners: Floats) -> Floats:
    """Corners rounded to a grid of a millionth of the size, shape kept."""
    if not np.isfinite(corners).all():
        raise InputError("the file has a coordinate that is not finite")
    largest = float(np.abs(corners).max(initial=0.0))
    if largest == 0.0:
        return corners
    grid = 10.0 ** np.floor(np.log10(largest) - 7.0)
    return np.asarray(np.round(corners / grid) * grid, dtype=np.float64)


def _check_count(count: int) -> None:
    if not 0 < count <= MAX_TRIANGLES:
        raise InputError(
            "the number of triangles is out of bounds", value=count, allowed=f"1 to {MAX_TRIANGLES}"
        )


def _model(data: bytes) -> Element:
    """The root of the model in the archive, inflated within bounds."""
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped]

    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [name for name in archive.namelist() if name.lower().endswith(".model")]
            # Some programs keep the meshes in models of their own; the one above names them.
            names.sort(key=lambda name: (name.count("/"), name))
            if not names:
                raise InputError("is no 3MF file: the archive holds no model")
            with archive.open(names[0]) as stream:
                text = stream.read(MAX_INFLATED + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError) as error:
        raise InputError(
            f"is no readable 3MF file, or it is cut off ({str(error)[:80]})"
        ) from error
    except (RuntimeError, OSError, IndexError) as error:
        raise InputError(f"is no readable 3MF file ({str(error)[:80]})") from error
    if len(text) > MAX_INFLATED:
        raise InputError(
            "the model in the archive is too large", allowed=f"≤ {MAX_INFLATED // 2**20} MB"
        )
    try:
        return fromstring(text, forbid_dtd=True)  # type: ignore[no-any-return]
    except (DefusedXmlException, ValueError, SyntaxError, LookupError) as error:
        raise InputError(f"the model in the archive is damaged ({str(error)[:80]})") from error


def _triangles(
    element: Element, objects: dict[str, Element], matrix: Floats, spent: list[int], depth: int
) -> Floats:
    """The triangles of an object and its components, shape (T, 3, 3), in units of the file."""
    spent[0] += 1
    if depth > MAX_DEPTH or spent[0] > MAX_PARTS:
        raise InputError("the objects of the file are too many or nested too deeply")
    found: list[Floats] = []
    for node in element:
        if _tag(node) == "mesh":
            vertices, triangles = _mesh(node)
            spent[1] += len(triangles)
            _check_count(max(spent[1], 1))
            found.append((vertices @ matrix[:3] + matrix[3])[triangles])
        for part in node if _tag(node) == "components" else ():
            target = objects.get(part.get("objectid", ""))
            if target is None or any(name.endswith("}path") for name in part.attrib):
                raise InputError(
                    "an object is kept in another part of the archive, which is not read; "
                    "export one plain 3MF model"
                )
            placed = _matrix(part)
            both = np.vstack([placed[:3] @ matrix[:3], placed[3] @ matrix[:3] + matrix[3]])
            found.append(_triangles(target, objects, both, spent, depth + 1))
    return np.concatenate(found) if found else np.empty((0, 3, 3))


def _mesh(node: Element) -> tuple[Floats, NDArray[np.int64]]:
    try:
        vertices = [[float(v.attrib[k]) for k in "xyz"] for v in node.iter() if _tag(v) == "vertex"]
        corners = [
            [int(t.attrib[k]) for k in ("v1", "v2", "v3")]
            for t in node.iter()
            if _tag(t) == "triangle"
        ]
        points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
        triangles = np.array(corners, dtype=np.int64).reshape(-1, 3)
    except (KeyError, ValueError, OverflowError) as error:
        raise InputError("a mesh in the file is damaged") from error
    if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(points)):
        raise InputError("a triangle in the file refers to a vertex that does not exist")
    return points, triangles


def _matrix(element: Element) -> Floats:
    """The `transform` of an element for row vectors, shape (4, 3)."""
    values = numbers(element.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0"))
    if len(values) != 12:
        raise InputError("a transform in the file has not twelve numbers")
    return np.array(values).reshape(4, 3)


def _tag(element: Element) -> str:
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""
