"""Reading STL and 3MF: the plan of a flat surface or a plate, as seen from above."""

from __future__ import annotations

import io
import logging
import tempfile
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from sheetmorph.core.errors import InputError, shorten
from sheetmorph.drawing.markup import parsed
from sheetmorph.drawing.model import Curve, DrawnItem, Floats
from sheetmorph.drawing.notes import at, mm
from sheetmorph.drawing.request import MAX_COORDINATE, Contents, Request

MAX_TRIANGLES = 200_000
MAX_INFLATED = 50 * 2**20
MAX_ELEMENTS = 1_000_000
MAX_DEPTH = 8
MAX_PARTS = 2000
UNITS_3MF = (
    ("micron", 1e-6),
    ("millimeter", 1e-3),
    ("centimeter", 1e-2),
    ("inch", 0.0254),
    ("foot", 0.3048),
    ("meter", 1.0),
)
"""The units of 3MF and their lengths [m], in the order of lib3mf's enumeration."""

# Faces steeper than this stand upright (cosine of the angle to the plane's normal).
_UPRIGHT = 1e-4
_TILTED = 1e-6


def read_stl(data: bytes, request: Request) -> tuple[Contents, float]:
    """Read the plan of an STL file, binary or text; a unit is a millimetre unless asked for.

    Raises:
        InputError: damaged, cut off, or without flat faces.
    """
    import trimesh

    unit = request.scale or 1e-3
    count = _announced(data)
    try:
        with _quiet():
            mesh = trimesh.load_mesh(io.BytesIO(data), file_type="stl", process=False)
        corners = np.asarray(mesh.triangles, dtype=np.float64)
    except Exception as error:
        raise InputError(f"is no readable STL file ({shorten(str(error), 80)})") from error
    if len(corners) != count:
        raise InputError("the file is damaged: a facet has not three corners")
    contents = Contents()
    # Single precision moves a corner by 1e-7 of its distance: corners are one within that.
    contents.add(_plan(_welded(corners) * unit, "the solid", request), [])
    return contents, unit


def read_3mf(data: bytes, request: Request) -> tuple[Contents, float]:
    """Read the plans of the objects that a 3MF file builds, each by its name.

    Raises:
        InputError: damaged, beyond the bounds, or without flat faces.
    """
    _check_archive(data)
    model = _model(data, request)
    word, own = UNITS_3MF[int(model.GetUnit())]
    unit = request.scale or own
    if unit != own:
        request.notes.add("unit", f"the file is in {word}s; read as {request.unit}")
    contents = Contents()
    spent = [0, 0]
    items = model.GetBuildItems()
    while items.MoveNext():
        item = items.GetCurrent()
        target = item.GetObjectResource()
        placed = _matrix(item.GetObjectTransform())
        corners = _triangles(target, placed, spent, 0)
        name = target.GetName() or f"object {target.GetModelResourceID()}"
        if len(corners):
            plan = _plan(_welded(corners) * unit, repr(name[:60]), request)
            contents.add(plan, [("object", name)])
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


@contextmanager
def _quiet() -> Iterator[None]:
    """Without the log of trimesh; older numpy warns of a text that is no number and reads on."""
    log = logging.getLogger("trimesh")
    before = log.level
    log.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("error", "string or file could not be read")
            yield
    finally:
        log.setLevel(before)


def _announced(data: bytes) -> int:
    """How many triangles an STL file says it has, after a check that it is whole."""
    count = int.from_bytes(data[80:84], "little")
    if len(data) < 84 or len(data) != 84 + 50 * count:
        if not data.lstrip().startswith(b"solid"):
            raise InputError(
                f"is no readable STL file, or it is cut off: {count} triangles are announced, "
                f"{max(len(data) - 84, 0) // 50} are there"
            )
        if b"endsolid" not in data[-300:]:
            raise InputError("the file is cut off or damaged: it does not end with endsolid")
        count = data.count(b"facet normal")
        if data.count(b"vertex") != 3 * count:
            raise InputError("the file is damaged: a facet has not three corners")
    _check_count(count)
    return count


def _check_archive(data: bytes) -> None:
    """Refuse an archive that inflates too far, or whose XML has entities."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if sum(member.file_size for member in members) > MAX_INFLATED:
                raise InputError(
                    "what the archive holds is too large", allowed=f"≤ {MAX_INFLATED // 2**20} MB"
                )
            models = 0
            for member in members:
                if member.filename.lower().endswith((".model", ".rels")):
                    what = f"{member.filename[-60:]!r} in the archive"
                    parsed(archive.read(member), what, MAX_ELEMENTS, forbid_dtd=True)
                    models += member.filename.lower().endswith(".model")
    except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, RuntimeError, OSError) as error:
        raise InputError(
            f"is no readable 3MF file, or it is cut off ({shorten(str(error), 80)})"
        ) from error
    if not models:
        raise InputError("is no 3MF file: the archive holds no model")


def _model(data: bytes, request: Request) -> Any:
    """The model as lib3mf reads it; what it found odd is noted."""
    try:
        import lib3mf
    except (ImportError, OSError) as error:
        raise InputError("3MF cannot be read here: lib3mf is missing; save it as STL") from error
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    try:
        # From a buffer lib3mf would make a Python number of every byte.
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "a.3mf"
            file.write_bytes(data)
            reader.ReadFromFile(str(file))
    except lib3mf.ELib3MFException as error:
        text = str(error).partition(": ")[2] or "damaged"
        raise InputError(f"is no readable 3MF file ({shorten(text, 100)})") from error
    for k in range(reader.GetWarningCount()):
        _code, text = reader.GetWarning(k)
        if "unit" in text.lower():
            words = ", ".join(word for word, _ in UNITS_3MF)
            raise InputError("no such unit in 3MF", key="unit", allowed=words)
        request.notes.add("3MF", f"the file is not quite 3MF: {shorten(text, 100)}")
    return model


def _triangles(target: Any, matrix: Floats, spent: list[int], depth: int) -> Floats:
    """The triangles of an object and its components, shape (T, 3, 3), in units of the file."""
    import lib3mf

    spent[0] += 1
    if depth > MAX_DEPTH or spent[0] > MAX_PARTS:
        raise InputError("the objects of the file are too many or nested too deeply")
    if target.IsMeshObject():
        spent[1] += target.GetTriangleCount()
        _check_count(max(spent[1], 1))
        points, corners = target.GetVertices(), target.GetTriangleIndices()
        if not corners:
            return np.empty((0, 3, 3))
        vertices = np.frombuffer((lib3mf.Position * len(points))(*points), np.float32)
        indices = np.frombuffer((lib3mf.Triangle * len(corners))(*corners), np.uint32)
        placed = vertices.reshape(-1, 3).astype(np.float64) @ matrix[:3] + matrix[3]
        return np.asarray(placed[indices.reshape(-1, 3)], dtype=np.float64)
    found = [np.empty((0, 3, 3))]
    for k in range(target.GetComponentCount() if target.IsComponentsObject() else 0):
        part = target.GetComponent(k)
        placed = _matrix(part.GetTransform())
        both = np.vstack([placed[:3] @ matrix[:3], placed[3] @ matrix[:3] + matrix[3]])
        found.append(_triangles(part.GetObjectResource(), both, spent, depth + 1))
    return np.concatenate(found)


def _matrix(transform: Any) -> Floats:
    """A transform of lib3mf for row vectors, shape (4, 3)."""
    matrix = np.array([list(row) for row in transform.Fields], dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise InputError("a transform in the file is not finite, or too large")
    return matrix
