from __future__ import annotations

import contextlib
import io
import itertools

import meshio
import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.files import LOADERS, read_mesh, write_stl

GOOD = """*shellNodes
10,  0.0,  0.0,  0.0
20,  1.0,  0.0,  0.0
 5,  1.0,  1.0,  0.0
-3,  0.0,  1.0,  0.0
*FaceNodes
0, 10, 20, 5
1, 10, 5, -3
*Edges
0, 10, 20
1, 5, 10
2, -3, 10
3, 20, 5
4, 5, -3
"""

# name → (file ending, arguments of meshio's writer)
FORMATS = {
    "vtu": (".vtu", {}),
    "stl binary": (".stl", {"binary": True}),
    "stl text": (".stl", {"binary": False}),
    "obj": (".obj", {}),
    "ply binary": (".ply", {}),
    "ply text": (".ply", {"binary": False}),
    "gmsh 2.2 text": (".msh", {"file_format": "gmsh22", "binary": False}),
    "gmsh 2.2 binary": (".msh", {"file_format": "gmsh22", "binary": True}),
    "gmsh 4.1 text": (".msh", {"file_format": "gmsh", "binary": False}),
    "gmsh 4.1 binary": (".msh", {"file_format": "gmsh", "binary": True}),
}


def write(path, mesh, arguments):
    with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
        meshio.write(path, mesh, **arguments)


@pytest.fixture(scope="module")
def petals(meshes):
    mesh = meshes["petals"]
    return meshio.Mesh(mesh.nodes, [("triangle", mesh.triangles)])


@pytest.mark.parametrize(
    ("name", "counts"),
    [("bowl", (970, 2800, 1831)), ("canoe", (1215, 3505, 2291)), ("petals", (388, 1087, 700))],
)
def test_released_meshes(reference, name, counts):
    path = reference / f"{name}_mesh.txt"
    mesh = read_mesh(path)
    assert mesh.counts == counts
    lines = path.read_text("utf-8").splitlines()
    first = lines.index("*Edges") + 1
    listed = [[int(word) for word in line.split(",")[1:]] for line in lines[first : first + 50]]
    assert mesh.edges[:50].tolist() == listed


def test_text_keeps_order_and_direction(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("\ufeff** a comment\n\n" + GOOD.replace("\n", "\r\n"), encoding="utf-8")
    mesh = read_mesh(path, 1e-3)
    assert mesh.nodes[2].tolist() == [1e-3, 1e-3, 0.0]
    assert mesh.edges.tolist() == [[0, 1], [2, 0], [3, 0], [1, 2], [2, 3]]


# what to replace, by what, what the message says
BROKEN = {
    "empty": (GOOD, "", "the file is empty"),
    "only spaces": (GOOD, " \n", "section \\*shellNodes is missing"),
    "wrong header": ("*shellNodes", "*Nodes", "line 1: unknown section .*allowed: \\*shellNodes"),
    "no header": ("*shellNodes\n", "", "line 1: the file must begin"),
    "section twice": ("*Edges", "*FaceNodes", "line 9: second section"),
    "no edges": (GOOD[GOOD.index("*Edges") :], "", "section \\*Edges is missing"),
    "edges empty": (GOOD[GOOD.index("0, 10, 20\n1, 5, 10") :], "", "line 9: .*\\*Edges is empty"),
    "cut off in a line": ("3, 20, 5\n4, 5, -3\n", "3, 20", "line 13: a line of \\*Edges needs 3"),
    "cut off between lines": ("4, 5, -3\n", "", "is missing from the list of edges"),
    "not a number": ("20,  1.0", "20,  one", "line 3: 'one' is not a finite number"),
    "NaN": ("20,  1.0", "20,  nan", "line 3: 'nan' is not a finite number"),
    "infinite": ("20,  1.0", "20,  1e999", "line 3: '1e999' is not a finite"),
    "too far": ("20,  1.0", "20,  1e99", "node 1 .*far too large"),
    "too many columns": ("0, 10, 20, 5", "0, 10, 20, 5, 7", "line 7: .*needs 4 numbers"),
    "semicolons": ("10,  0.0,  0.0,  0.0", "10; 0; 0; 0", "line 2: .*needs 4 numbers"),
    "node id twice": ("20,  1.0", "10,  1.0", "line 3: id 10 is used twice"),
    "face id twice": ("1, 10, 5, -3", "0, 10, 5, -3", "line 8: id 0 is used twice"),
    "edge id twice": ("1, 5, 10", "0, 5, 10", "line 11: id 0 is used twice"),
    "id not whole": ("20,  1.0", "20.5,  1.0", "line 3: an id must be a whole number"),
    "id too large": ("20,  1.0", "1e20,  1.0", "line 3: an id must be a whole number"),
    "corner not whole": ("0, 10, 20, 5", "0, 10, 20, 5.5", "line 7: .*does not exist"),
    "unknown node": ("0, 10, 20, 5", "0, 10, 20, 6", "line 7: .*does not exist"),
    "unknown end": ("0, 10, 20\n", "0, 10, 21\n", "line 10: .*does not exist"),
    "flipped": ("0, 10, 20, 5", "0, 10, 5, 20", "triangle 0 is flipped"),
    "not flat": ("1.0,  1.0,  0.0", "1.0,  1.0,  0.3", "not flat: node 2"),
    "extra edge": ("4, 5, -3\n", "4, 5, -3\n5, 20, -3\n", "no side of a triangle"),
    "edge twice": ("4, 5, -3\n", "4, 5, -3\n5, -3, 5\n", "more than once"),
    "unused node": ("-3,  0.0", "7, 5, 5, 0\n-3,  0.0", "node 3 belongs to no triangle"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_text_files(tmp_path, name):
    old, new, text = BROKEN[name]
    assert old in GOOD
    path = tmp_path / "broken.txt"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(InputError, match=text) as caught:
        read_mesh(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", FORMATS)
def test_formats(tmp_path, meshes, petals, name):
    ending, arguments = FORMATS[name]
    path = tmp_path / f"sheet{ending.upper()}"
    write(tmp_path / f"sheet{ending}", petals, arguments)
    (tmp_path / f"sheet{ending}").rename(path)
    mesh = read_mesh(path, 10.0)
    made = meshes["petals"]
    assert mesh.counts == made.counts
    assert mesh.triangle_areas.sum() == pytest.approx(100 * made.triangle_areas.sum(), rel=1e-5)
    np.testing.assert_allclose(np.sort(mesh.nodes[:, 0]), np.sort(10 * made.nodes[:, 0]), atol=1e-7)


def test_our_own_stl_comes_back(tmp_path, meshes):
    made = meshes["bowl"]
    write_stl(tmp_path / "a.stl", made.triangles, made.nodes)
    mesh = read_mesh(tmp_path / "a.stl")
    assert mesh.counts == made.counts


def test_gmsh_points_and_lines_are_skipped_and_a_sheet_face_down_is_turned(tmp_path):
    nodes = np.array([[9, 9, 0], [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    cells = [
        ("vertex", np.array([[0]])),
        ("line", np.array([[1, 2], [2, 3]])),
        ("triangle", np.array([[1, 3, 2], [1, 4, 3]])),
    ]
    path = tmp_path / "a.msh"
    write(path, meshio.Mesh(nodes, cells), {"file_format": "gmsh22", "binary": False})
    mesh = read_mesh(path)
    assert mesh.counts == (4, 5, 2)
    assert mesh.triangle_areas.min() == 0.5


@pytest.mark.parametrize("ending", [e for e in LOADERS if e not in (".txt", ".stl")])
def test_quads_are_refused(tmp_path, ending):
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    path = tmp_path / f"a{ending}"
    arguments = {"file_format": "gmsh22"} if ending == ".msh" else {}
    write(path, meshio.Mesh(nodes, [("quad", np.array([[0, 1, 2, 3]]))]), arguments)
    with pytest.raises(InputError, match="must have triangles only"):
        read_mesh(path)


JUNK = {
    "zeros": bytes(500),
    "noise": np.random.default_rng(0).integers(0, 256, 5000, dtype=np.uint8).tobytes(),
    "words": b"this is no mesh\n" * 20,
    "nothing": b"",
}


@pytest.mark.parametrize(("ending", "junk"), list(itertools.product(LOADERS, JUNK)))
def test_junk(tmp_path, ending, junk, capfd):
    path = tmp_path / f"junk{ending}"
    path.write_bytes(JUNK[junk])
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", FORMATS)
def test_files_cut_off_anywhere(tmp_path, petals, name):
    ending, arguments = FORMATS[name]
    path = tmp_path / f"a{ending}"
    write(path, petals, arguments)
    data = path.read_bytes()
    for part in (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97):
        path.write_bytes(data[: int(part * len(data))])
        with pytest.raises(InputError) as caught:
            read_mesh(path)
        assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", FORMATS)
def test_damaged_files_give_a_sheet_or_an_error(tmp_path, petals, name):
    ending, arguments = FORMATS[name]
    path = tmp_path / f"a{ending}"
    write(path, petals, arguments)
    data = path.read_bytes()
    rng = np.random.default_rng(5)
    for _ in range(25):
        damaged = bytearray(data)
        for place in rng.integers(0, len(data), 4):
            damaged[place] = rng.integers(0, 256)
        start = int(rng.integers(0, min(len(data), 3000)))
        damaged[start : start + 5] = b"99999"
        path.write_bytes(damaged)
        with contextlib.suppress(InputError):
            read_mesh(path)


HUGE = {
    "ply": ("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n"),
    "vtu": ("a.vtu", '<VTKFile><Piece NumberOfPoints="99999999999" NumberOfCells="1"/></VTKFile>'),
    "gmsh 2.2": (
        "a.msh",
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n99999999999\n1 0 0 0\n$EndNodes\n"
            "$Elements\n1\n1 2 0 1 1 1\n$EndElements\n"
        ),
    ),
    "gmsh 4.1": (
        "a.msh",
        (
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n99999999999 1 1 1\n2 1 0 9999999\n"
            "$EndNodes\n$Elements\n1 1 1 1\n2 1 2 1\n1 1 1 1\n$EndElements\n"
        ),
    ),
    "gmsh tag": (
        "a.msh",
        (
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n99999999999999 0 0 0\n$EndNodes\n"
            "$Elements\n1\n1 2 0 1 2 3\n$EndElements\n"
        ),
    ),
}


@pytest.mark.parametrize("name", HUGE)
def test_huge_numbers_are_not_trusted(tmp_path, name):
    file, text = HUGE[name]
    path = tmp_path / file
    path.write_text(text)
    with pytest.raises(InputError):
        read_mesh(path)


@pytest.mark.parametrize("end", ["", "comment end_header\n"])
def test_a_ply_header_without_an_end_is_refused_at_once(tmp_path, end):
    path = tmp_path / "a.ply"
    path.write_text(f"ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\n{end}")
    with pytest.raises(InputError, match="its header does not end with end_header"):
        read_mesh(path)


def test_binary_stl_with_a_huge_count(tmp_path):
    path = tmp_path / "a.stl"
    path.write_bytes(bytes(80) + b"\xff\xff\xff\xff" + bytes(50))
    with pytest.raises(InputError, match="4294967295 triangles are announced, 1 are there"):
        read_mesh(path)


@pytest.mark.parametrize("version", ["4.0", "1", "x"])
def test_other_versions_of_gmsh(tmp_path, version):
    path = tmp_path / "a.msh"
    path.write_text(f"$MeshFormat\n{version} 0 8\n$EndMeshFormat\n")
    with pytest.raises(InputError, match=r"no such version.*2\.2, 4\.1"):
        read_mesh(path)


def test_files_that_cannot_be_read(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"none\.txt: there is no such file"):
        read_mesh(tmp_path / "none.txt")
    (tmp_path / "folder.txt").mkdir()
    with pytest.raises(InputError, match="is not a file"):
        read_mesh(tmp_path / "folder.txt")
    with pytest.raises(InputError, match=r"no such mesh format; did you mean \.stl\?"):
        read_mesh(tmp_path / "a.stll")
    with pytest.raises(InputError, match=r"allowed: \.txt, \.msh"):
        read_mesh(tmp_path / "a")
    monkeypatch.setattr("sheetmorph.geometry.files.MAX_BYTES", 10)
    (tmp_path / "big.txt").write_text(GOOD)
    with pytest.raises(InputError, match="too large"):
        read_mesh(tmp_path / "big.txt")


@pytest.mark.parametrize("unit", [0.0, -1.0, float("nan"), float("inf")])
def test_bad_units(tmp_path, unit):
    with pytest.raises(InputError, match="length unit"):
        read_mesh(tmp_path / "a.txt", unit)
