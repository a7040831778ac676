"""Writing sheets: STL for making, a ParaView series for looking, text for reading again."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import write_bytes, write_text
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.geometry.surface import triangle_normals

_TYPES = {"f8": "Float64", "i4": "Int32", "u1": "UInt8"}
_TRIANGLE = 5  # VTK's number for the cell type


def write_stl(path: str | Path, triangles: ArrayLike, positions: ArrayLike) -> None:
    """Write one state as binary STL; lengths as given.

    Args:
        triangles: node indices, shape (T, 3).
        positions: node positions, shape (V, 3).

    Raises:
        InputError: a position is not a finite number.
        OutputError: the file cannot be written.
    """
    faces = np.asarray(triangles)
    points = _finite(positions, "positions", path)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    data = np.zeros(len(faces), record)
    data["normal"] = triangle_normals(points, faces)
    data["corners"] = points[faces]
    # A binary file must not begin with "solid", the mark of the text format.
    header = b"sheetmorph".ljust(80, b"\0") + np.uint32(len(faces)).astype("<u4").tobytes()
    write_bytes(path, header + data.tobytes())


def write_mesh(path: str | Path, mesh: SheetMesh, unit: float = 1.0) -> None:
    """Write a mesh in the text format of the published meshes; `read_mesh` reads it again.

    Nodes, triangles and edges keep their order and direction, coordinates all their digits.

    Args:
        path: the file, which should end in `.txt`.
        mesh: flat or curved.
        unit: length of one unit of the file [m].

    Raises:
        OutputError: the file cannot be written.
    """
    lines: list[str] = []
    for title, rows in (
        ("*shellNodes", (mesh.nodes / unit).tolist()),
        ("*FaceNodes", mesh.triangles.tolist()),
        ("*Edges", mesh.edges.tolist()),
    ):
        lines.append(title)
        lines += [f"{k}, {', '.join(map(repr, row))}" for k, row in enumerate(rows)]
    write_text(path, "\n".join([*lines, ""]))


def write_vtu_series(
    folder: str | Path,
    name: str,
    triangles: ArrayLike,
    positions: ArrayLike,
    times: ArrayLike,
    point_fields: Mapping[str, ArrayLike] | None = None,
    cell_fields: Mapping[str, ArrayLike] | None = None,
    clock: ArrayLike | None = None,
) -> Path:
    """Write every state as `name_0000.vtu`, … and an index `name.pvd` for ParaView.

    Args:
        folder: where to write; made when absent.
        name: beginning of the file names.
        triangles: node indices, shape (T, 3).
        positions: node positions [m], shape (S, V, 3).
        times: actuation of each state, shape (S,), kept in every file as the field
            `actuation`. Its magnitude is the time in the index if that increases strictly,
            as ParaView needs; else the number of the state is.
        point_fields: values at the nodes by name, each of shape (S, V) or (S, V, k).
        cell_fields: values on the triangles by name, each of shape (S, T) or (S, T, k).
        clock: times for the index, increasing [s], shape (S,); none by default.

    Returns:
        The path of the index. It is written last: when it is there, all states are.

    Raises:
        InputError: shapes do not fit together, or a position is not a finite number.
        OutputError: a file cannot be written.
    """
    points = _finite(positions, "positions", name)
    faces = np.ascontiguousarray(triangles, dtype="<i4")
    if points.ndim != 3 or points.shape[2] != 3:
        raise InputError("positions must have shape (S, V, 3)", key=name, value=points.shape)
    moments = np.asarray(times, dtype=np.float64)
    if moments.shape != points.shape[:1]:
        raise InputError("one time per state is needed", key=name, value=moments.shape)
    at_points = _fields(point_fields, points.shape[:2])
    at_cells = _fields(cell_fields, (len(points), len(faces)))
    target = Path(folder)
    cells = "".join(
        [
            "<Cells>",
            _array("connectivity", faces.ravel()),
            _array("offsets", np.arange(3, 3 * len(faces) + 1, 3, dtype="<i4")),
            _array("types", np.full(len(faces), _TRIANGLE, dtype="u1")),
            "</Cells>",
        ]
    )
    entries = []
    increasing = bool((np.diff(np.abs(moments)) > 0.0).all())
    for state, moment in enumerate(moments):
        file = f"{name}_{state:04d}.vtu"
        text = "".join(
            [
                (
                    '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" '
                    'byte_order="LittleEndian" header_type="UInt64"><UnstructuredGrid><FieldData>'
                ),
                _array("actuation", moments[state : state + 1], tuples=1),
                (
                    f'</FieldData><Piece NumberOfPoints="{points.shape[1]}" '
                    f'NumberOfCells="{len(faces)}"><Points>'
                ),
                _array("Points", points[state]),
                "</Points>",
                cells,
                "<PointData>",
                *(_array(key, values[state]) for key, values in at_points.items()),
                "</PointData><CellData>",
                *(_array(key, values[state]) for key, values in at_cells.items()),
                "</CellData></Piece></UnstructuredGrid></VTKFile>\n",
            ]
        )
        write_bytes(target / file, text.encode())
        time = abs(float(moment)) if increasing else float(state)
        if clock is not None:
            time = float(np.asarray(clock)[state])
        entries.append(f'<DataSet timestep="{time!r}" part="0" file={quoteattr(file)}/>\n')
    index = target / f"{name}.pvd"
    write_text(
        index,
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="1.0" '
        f'byte_order="LittleEndian"><Collection>\n{"".join(entries)}</Collection></VTKFile>\n',
    )
    return index


def _array(name: str, values: NDArray[np.generic], tuples: int | None = None) -> str:
    """A VTK data array: base64 of its length in bytes and its values."""
    data = np.ascontiguousarray(values).tobytes()
    text = base64.b64encode(np.uint64(len(data)).astype("<u8").tobytes() + data).decode()
    parts = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    count = f' NumberOfTuples="{tuples}"' if tuples is not None else ""
    return (
        f'<DataArray type="{_TYPES[values.dtype.str[1:]]}" Name={quoteattr(name)}'
        f'{parts}{count} format="binary">{text}</DataArray>'
    )


def _fields(fields: Mapping[str, ArrayLike] | None, shape: tuple[int, int]) -> dict[str, Floats]:
    arrays = {}
    for key, values in (fields or {}).items():
        array = np.asarray(values, dtype="<f8")
        if array.shape[:2] != shape or array.ndim > 3:
            raise InputError(
                "the field does not fit the mesh",
                key=key,
                value=array.shape,
                allowed=f"({shape[0]}, {shape[1]}) or ({shape[0]}, {shape[1]}, k)",
            )
        arrays[key] = array
    return arrays


def _finite(values: ArrayLike, what: str, where: str | Path) -> Floats:
    array = np.asarray(values, dtype="<f8")
    if not np.isfinite(array).all():
        raise InputError(f"{what} must be finite numbers", key=str(where))
    return array
