"""Files with which fuzzing begins, made here: one or more of each format and dialect."""

from __future__ import annotations

import io
import re
import tempfile
from pathlib import Path

import meshio
import numpy as np
import shapely
import trimesh

import sheetmorph as sm
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.drawing.write import Ink, dxf_bytes, svg_bytes
from sheetmorph.geometry.files import write_mesh

RING = shapely.Point(0.01, 0.02).buffer(0.03, 4).difference(shapely.box(0, 0.01, 0.02, 0.03))
DOCS = Path(__file__).resolve().parents[1] / "docs"

GMSH2 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 10 0 0
3 10 10 0
4 0 10 0
$EndNodes
$Elements
3
1 15 2 0 1 1
2 2 2 0 1 1 2 3
3 2 2 0 1 1 3 4
$EndElements
"""
TABLE = "temperature [degC], L/L0, std\n20, 1.0, 0\n93, 1.0, 0\n120, 0.60, 0.02\n150, 0.41, 0.03\n"
STYLED = b"""<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm" viewBox="0 0 90 90">
<style>.a { fill: red; stroke: blue } g > #b { fill: none }</style><defs><symbol id="s"
viewBox="0 0 9 9"><path d="M0 0h9v9h-9z"/></symbol></defs><g transform="rotate(30 9 9)" class="a">
<use href="#s" width="20" height="20"/><path id="b" d="M30 30A9 9 0 0 1 50 50C1 2 3 4 5 6Q7 8 9 10z"
stroke-width="2"/><polygon points="1,2 3,4 5,1"/><ellipse cx="9" cy="9" rx="3" ry="2"/></g></svg>"""
SWEEP = b"""[family]
kind = "random_kirigami"
sheet_radius = "30 mm"
[list]
family.seed = { from = 0, to = 3, step = 1 }
[samples]
count = 2
[samples.bounds]
actuation.eps_pre = { from = -0.4, to = -0.2 }
"""


def made(reader: str) -> list[tuple[str, bytes]]:
    """Files for a reader, with their endings."""
    return {
        "design": _designs,
        "mesh": _meshes,
        "svg": lambda: [(".svg", svg_bytes([Ink("SHEET", (RING,))])), (".svg", STYLED)],
        "dxf": lambda: [(".dxf", data) for data in _dxfs()],
        "stl": lambda: [(".stl", _solid("stl")), (".stl", _solid("stl_ascii"))],
        "3mf": lambda: [(".3mf", _solid("3mf"))],
        "scan": lambda: [
            (f".{kind.split('_')[0]}", _solid(kind)) for kind in ("stl", "stl_ascii", "obj", "ply")
        ],
        "result": _results,
        "curve": lambda: [(".csv", TABLE.encode())],
        "sweep": lambda: [(".toml", SWEEP)],
    }[reader]()


def _solid(kind: str) -> bytes:
    solid = trimesh.creation.extrude_polygon(shapely.affinity.scale(RING, 1e3, 1e3), 1.0)
    data = solid.export(file_type=kind)
    return data if isinstance(data, bytes) else data.encode()


def _dxfs() -> list[bytes]:
    import ezdxf

    document = ezdxf.new("R2000")
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    block = document.blocks.new("B")
    block.add_circle((1, 1), 2)
    space.add_blockref("B", (20, 3), dxfattribs={"xscale": 2, "rotation": 30})
    space.add_lwpolyline([(0, 0, 0.3), (9, 0, 0), (9, 9, 0)], format="xyb", close=True)
    space.add_spline([(30, 0), (40, 10), (50, 0), (40, -10), (30, 0)])
    space.add_ellipse((60, 0), (5, 0), 0.5)
    fill = space.add_hatch()
    fill.paths.add_edge_path().add_arc((70, 0), 3, 0, 360)
    text, binary = io.StringIO(), io.BytesIO()
    document.write(text, fmt="asc")
    document.write(binary, fmt="bin")
    small = dxf_bytes([Ink("SHEET", (RING,))])
    # The entities alone: what comes before them is boilerplate that hides them.
    entities = re.sub(r"(?s)^.*?(  0\nSECTION\n  2\nENTITIES)", r"\1", text.getvalue())
    return [small, entities.encode(), text.getvalue().encode(), binary.getvalue()]


def _designs() -> list[tuple[str, bytes]]:
    texts = [preset_text(name, name) for name in PRESETS]
    head = preset_text("bowl", "a").split("[[pattern]]", maxsplit=1)[0]
    layers = preset_text("bowl", "a").split("# The layers", maxsplit=1)[1]
    for page in ("patterns.md", "design-file.md"):
        blocks = re.findall(r"(?s)```toml\n(.*?)```", (DOCS / page).read_text("utf-8"))
        texts += blocks
        texts += [
            head + block + "\n#" + layers
            for block in blocks
            if "[[pattern]]" in block and "[outline]" not in block
        ]
    return [(".toml", text.encode()) for text in texts]


def _meshes() -> list[tuple[str, bytes]]:
    points = np.array([[0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0], [5, 5, 0]], dtype=float)
    cells = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    found = [(".msh", GMSH2.encode())]
    mesh = sm.Design.from_toml(preset_text("petals", "a")).with_values(
        {"perturbation.shape": "bowl", "supports": None, "mesh.size": "20 mm"}
    )
    with tempfile.TemporaryDirectory() as folder:
        for ending, options in (
            (".msh", {"file_format": "gmsh22"}),
            (".msh", {"file_format": "gmsh"}),
            (".msh", {"file_format": "gmsh", "binary": False}),
            (".vtu", {}),
            (".vtu", {"binary": False}),
            (".obj", {}),
            (".ply", {"binary": False}),
            (".ply", {}),
            (".stl", {"binary": True}),
            (".stl", {}),
        ):
            file = Path(folder) / f"a{ending}"
            meshio.write(file, meshio.Mesh(points, [("triangle", cells)]), **options)
            found.append((ending, file.read_bytes()))
        text = Path(folder) / "a.txt"
        write_mesh(text, mesh.build_mesh())
        found.append((".txt", text.read_bytes()))
    return found


def _results() -> list[tuple[str, bytes]]:
    found = []
    coarse = {"perturbation.shape": "bowl", "supports": None, "mesh.size": "25 mm"}
    with tempfile.TemporaryDirectory() as folder:
        for model in ("published", "laminate"):
            design = sm.Design.from_toml(preset_text("petals", "a"))
            design = design.with_values({"model": model, **coarse, "actuation.eps_pre": -0.1})
            file = sm.simulate(design).save(Path(folder) / f"{model}.h5")
            found.append((".h5", Path(file).read_bytes()))
    return found
