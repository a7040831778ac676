"""Reading meshes: from the ending of a file to its loader, and from there to a sheet."""

from __future__ import annotations

import contextlib
import io
import math
import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sheetmorph.core import strangers
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.gmshfile import read_gmsh
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.textmesh import read_text_mesh
from sheetmorph.geometry.topology import MAX_COORDINATE, MAX_NODES, build_mesh
from sheetmorph.geometry.writers import write_mesh, write_stl, write_vtu_series

__all__ = ["LOADERS", "read_mesh", "write_mesh", "write_stl", "write_vtu_series"]

MAX_BYTES = 200_000_000
_END_OF_PLY_HEADER = re.compile(rb"^[ \t]*end_header[ \t\r]*$", re.MULTILINE)
# Numbers that a file declares before its data; a huge one makes readers allocate or loop.
_DECLARED = {
    ".ply": re.compile(rb"^element\s+\w+\s+(\d+)", re.MULTILINE),
    ".vtu": re.compile(rb'NumberOf(?:Points|Cells)\s*=\s*"\s*(\d+)'),
}


def read_mesh(path: str | Path, unit: float = 1.0, *, curved: bool = False) -> SheetMesh:
    """Read a triangle mesh from a file; the ending says which format it has.

    `.txt` is the text format of the published meshes and keeps the order and direction of
    its edges. `.msh` is Gmsh's format (2.2 and 4.1); `.vtu`, `.stl`, `.obj` and `.ply` are
    read through meshio. Cells other than triangles must be points or lines (ignored);
    vertices of an STL file that coincide are merged; nodes of a Gmsh file that no triangle
    uses (centres of arcs) are dropped; a sheet whose triangles all run clockwise is turned
    over.

    Args:
        path: the file, at most 200 MB.
        unit: length of one unit of the file [m], such as 0.001 for millimetres.
        curved: True for a sheet that need not be flat, see `build_mesh`.

    Returns:
        The checked mesh.

    Raises:
        InputError: the file cannot be read or its mesh is no sheet; names the file.
    """
    file = Path(path)
    if not (math.isfinite(unit) and unit > 0.0):
        raise InputError("the length unit must be a positive number", file=file, value=unit)
    ending = strangers.ending_of(file, LOADERS, "mesh format")
    with strangers.reading(file, "the mesh"):
        strangers.check_size(file, MAX_BYTES)
        return LOADERS[ending](file, unit, curved)


def _read_faces(file: Path, unit: float, curved: bool) -> SheetMesh:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        nodes, triangles = READERS[file.suffix.lower()](file)
    if not np.isfinite(nodes).all() or np.abs(nodes).max() > MAX_COORDINATE / unit:
        bad = ~(np.abs(nodes) <= MAX_COORDINATE / unit).all(axis=1)
        raise InputError(
            f"node {int(np.argmax(bad))} has a coordinate that is not a finite number below "
            f"{MAX_COORDINATE:.0e} m"
        )
    if file.suffix.lower() == ".stl":
        nodes, triangles = _merge_coincident(nodes, triangles)
    if file.suffix.lower() == ".msh":
        used, corners = np.unique(triangles, return_inverse=True)
        nodes, triangles = nodes[used], corners.reshape(-1, 3)
    a, b, c = (nodes[triangles[:, k], :2] for k in range(3))
    u, v = b - a, c - a
    doubled = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    if (doubled < 0.0).all() or (curved and doubled.sum() < 0.0):
        triangles = triangles[:, [0, 2, 1]]
    return build_mesh(unit * nodes, triangles, curved=curved)


def _read_with_meshio(file: Path) -> tuple[Floats, NDArray[np.int64]]:
    return _triangles(file, _meshio_read(file))


def _meshio_read(file: Path) -> object:
    """What meshio makes of a file; it prints, exits and raises in many ways when it fails."""
    import meshio

    _check_declared_counts(file)
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            return meshio.read(file)
    except (Exception, SystemExit) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, SystemExit):
            reason = " ".join(printed.getvalue().split()).removeprefix("Error: ") or "damaged"
        kind = file.suffix.lower()
        raise InputError(f"is no readable {kind} file ({reason[:120]})", file=file) from error


def _check_declared_counts(file: Path) -> None:
    ending = file.suffix.lower()
    size = file.stat().st_size
    with file.open("rb") as stream:
        start = stream.read(84)
        if ending == ".stl" and not start.lstrip().startswith(b"solid"):
            count = int.from_bytes(start[80:84], "little")
            if size != 84 + 50 * count:
                raise InputError(
                    f"the file is cut off or damaged: {count} triangles are announced, "
                    f"{max(size - 84, 0) // 50} are there"
                )
        data = start + stream.read()
    if ending == ".stl" and start.lstrip().startswith(b"solid") and b"endsolid" not in data[-200:]:
        raise InputError("the file is cut off or damaged: it does not end with endsolid")
    # Where a header does not end, meshio reads on for ever.
    if ending == ".ply" and not _END_OF_PLY_HEADER.search(data, 0, 2**16):
        raise InputError("is no readable .ply file: its header does not end with end_header")
    if ending not in _DECLARED:
        return
    for match in _DECLARED[ending].finditer(data):
        for number in match.group(1).split():
            if len(number) > 9 or int(number) > 4 * MAX_NODES:
                raise InputError(
                    "the file announces too many nodes or cells",
                    value=int(number[:30]),
                    allowed=f"≤ {4 * MAX_NODES}",
                )


def _triangles(file: Path, mesh: object) -> tuple[Floats, NDArray[np.int64]]:
    """Nodes, shape (V, 2 or 3), and triangles, shape (T, 3), of what meshio read."""
    try:
        nodes = np.asarray(mesh.points, dtype=np.float64)  # type: ignore[attr-defined]
        blocks = [(str(block.type), np.asarray(block.data)) for block in mesh.cells]  # type: ignore[attr-defined]
        other = {kind for kind, _ in blocks} - {"triangle", "line", "vertex"}
        found = [data.reshape(-1, 3) for kind, data in blocks if kind == "triangle"]
        triangles = np.concatenate(found).astype(np.int64) if found else np.empty((0, 3), np.int64)
    except (AttributeError, TypeError, ValueError, OverflowError) as error:
        raise InputError("the mesh in the file is damaged", file=file) from error
    if other:
        raise InputError(
            "the mesh must have triangles only", value=", ".join(sorted(other)), allowed="triangle"
        )
    if not len(triangles):
        raise InputError("the file has no triangles")
    if nodes.ndim != 2 or nodes.shape[1] not in (2, 3):
        raise InputError("the nodes need 2 or 3 coordinates", value=nodes.shape)
    if triangles.min() < 0 or triangles.max() >= len(nodes):
        bad = int(np.argmax(((triangles < 0) | (triangles >= len(nodes))).any(axis=1)))
        raise InputError(
            f"triangle {bad} refers to a node that does not exist",
            value=triangles[bad].tolist(),
            allowed=f"0 to {len(nodes) - 1}",
        )
    return nodes, triangles


def _merge_coincident(
    nodes: Floats, triangles: NDArray[np.int64]
) -> tuple[Floats, NDArray[np.int64]]:
    """Make nodes one that differ by no more than the rounding of single precision."""
    pairs = cKDTree(nodes).query_pairs(
        1e-6 * float(np.ptp(nodes, axis=0).max()), output_type="ndarray"
    )
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(nodes),) * 2)
    label = connected_components(graph, directed=False)[1]
    first = np.unique(label, return_index=True)[1]
    return nodes[first], label[triangles].astype(np.int64)


READERS: dict[str, Callable[[Path], tuple[Floats, NDArray[np.int64]]]] = {
    ".msh": read_gmsh,
    ".vtu": _read_with_meshio,
    ".stl": _read_with_meshio,
    ".obj": _read_with_meshio,
    ".ply": _read_with_meshio,
}
LOADERS: dict[str, Callable[[Path, float, bool], SheetMesh]] = {
    ".txt": read_text_mesh,
    **dict.fromkeys(READERS, _read_faces),
}
