"""Scans from files: every format, every way of being broken."""

from __future__ import annotations

import builtins
import struct
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from sheetmorph.compare.scan import read_surface, unit_of_scale
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
PLY = (
    "ply\nformat ascii 1.0\nelement vertex {v}\nproperty float x\nproperty float y\n"
    "property float z\nelement face {f}\nproperty list uchar int vertex_indices\nend_header\n"
)
SQUARE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


def written(folder: Path, name: str, surface: Surface, **how: object) -> Path:
    file = folder / name
    trimesh.Trimesh(surface.points, surface.triangles, process=False).export(file, **how)
    return file


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("a.stl", {}),
        ("a.STL", {"file_type": "stl_ascii"}),
        ("a.obj", {}),
        ("a.ply", {}),
        ("a.ply", {"encoding": "ascii"}),
    ],
)
def test_every_format_gives_the_same_surface(
    tmp_path: Path, made: SimpleNamespace, name: str, how: dict[str, str]
) -> None:
    bowl = made.bowl(count=20)
    scan = read_surface(written(tmp_path, name, bowl, **how))
    assert scan.name == name
    assert scan.notes == ()
    assert len(scan.surface.triangles) == len(bowl.triangles)
    assert len(scan.surface.points) == len(bowl.points)  # the corners of an STL are one again
    assert scan.surface.area == pytest.approx(bowl.area, rel=1e-5)
    assert bowl.nearest(scan.surface.points).distance.max() < 1e-6


def test_a_known_unit_gives_metres(tmp_path: Path, made: SimpleNamespace) -> None:
    bowl = made.bowl(count=20)
    file = written(tmp_path, "a.stl", bowl)
    scan = read_surface(file, unit=0.0254)
    assert scan.surface.size == pytest.approx(0.0254 * bowl.size, rel=1e-6)
    assert scan.unit == 0.0254
    assert read_surface(file).unit is None
    for unit in (0.0, -1.0, float("nan")):
        with pytest.raises(InputError, match=r"a\.stl"):
            read_surface(file, unit=unit)


def test_scale_names_its_unit() -> None:
    assert unit_of_scale(0.0254) == "in"
    assert unit_of_scale(0.00102) == "mm"
    assert unit_of_scale(0.19) is None
    assert unit_of_scale(0.0) is None


def test_polygons_and_objects(tmp_path: Path) -> None:
    quad = tmp_path / "quad.ply"
    quad.write_text(PLY.format(v=4, f=1) + SQUARE + "4 0 1 2 3\n")
    assert read_surface(quad).surface.area == pytest.approx(1.0)
    mixed = tmp_path / "mixed.ply"
    mixed.write_text(PLY.format(v=5, f=2) + SQUARE + "2 0.5 0\n" + "4 0 1 2 3\n3 1 4 2\n")
    assert read_surface(mixed).surface.area == pytest.approx(1.5)
    polygon = tmp_path / "polygon.obj"
    polygon.write_text("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\nf 1 2 3\n")
    assert len(read_surface(polygon).surface.triangles) == 4
    two = tmp_path / "two.stl"
    solid = (
        "solid {0}\nfacet normal 0 0 1\nouter loop\nvertex 0 0 {0}\nvertex 1 0 {0}\n"
        "vertex 0 1e+0 {0}\nendloop\nendfacet\nendsolid {0}\n"
    )
    two.write_text(solid.format(0) + solid.format(5).upper())
    scan = read_surface(two)
    assert scan.surface.area == pytest.approx(1.0)
    assert "2 objects" in scan.notes[0]


def test_solid_in_a_binary_header_is_no_text(tmp_path: Path, made: SimpleNamespace) -> None:
    file = written(tmp_path, "a.stl", made.bowl(count=8))
    data = bytearray(file.read_bytes())
    data[:80] = b"solid facet".ljust(80)
    file.write_bytes(data)
    assert read_surface(file).surface.area > 0.0


def test_no_other_file_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "near.mtl").write_text("newmtl a\nmap_Kd near.png\n")
    file = tmp_path / "a.obj"
    file.write_text("mtllib ../../../../etc/passwd\nmtllib near.mtl\nusemtl a\n" + TETRAHEDRON)
    opened = []
    real = builtins.open

    def watched(name: object, *rest: object, **more: object) -> object:
        opened.append(str(name))
        return real(name, *rest, **more)  # type: ignore[call-overload]

    read_surface(file)  # imports are done
    monkeypatch.setattr(builtins, "open", watched)
    assert len(read_surface(file).surface.triangles) == 4
    assert not [name for name in opened if "passwd" in name or "near" in name]


def stl(count: int, triangles: int, value: float = 1.0) -> bytes:
    corner = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, value, 0, 0, 0, value, 0, 0)
    return b"\0" * 80 + struct.pack("<I", count) + corner * triangles


BROKEN = {
    "empty.stl": b"",
    "cut.stl": stl(100, 40),
    "lying.stl": stl(4_000_000_000, 2),
    "more.stl": stl(1, 3),
    "none.stl": stl(0, 0),
    "short.stl": b"abc",
    "zeros.stl": b"\0" * 500,
    "nan.stl": stl(2, 2, float("nan")),
    "infinite.stl": stl(2, 2, float("inf")),
    "huge.stl": stl(2, 2, 3e38),
    "point.stl": stl(2, 2, 0.0),
    "line.obj": b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n",
    "text.stl": b"A letter to the reader.\n" * 20,
    "page.stl": b"<html><body>Please log in</body></html>" * 5,
    "half.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n",
    "words.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex zero 0 0\nvertex 1 0 0\n"
    b"vertex 0 1 0\nendloop\nendfacet\nendsolid a\n",
    "odd.stl": b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
    b"endloop\nendfacet\nendsolid a\n",
    "bare.stl": b"solid a\nendsolid a\n",
    "points.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\n",
    "points.ply": (PLY.format(v=4, f=0) + SQUARE).encode(),
    "text.obj": b"A letter to the reader.\n",
    "beyond.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    "before.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -9\n",
    "nan.obj": b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "words.obj": b"v 0 0 x\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    "letters.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf a b c\n",
    "binary.obj": bytes(range(256)) * 9,
    "header.ply": b"ply\nformat ascii 1.0\nelement vertex 3\n",
    "lying.ply": (PLY.format(v=999_999_999_999, f=1) + SQUARE + "3 0 1 2\n").encode(),
    "many.ply": (PLY.format(v=4, f=900_000) + SQUARE + "3 0 1 2\n").encode(),
    "cut.ply": (PLY.format(v=40, f=1) + SQUARE).encode(),
    "minus.ply": (PLY.format(v=4, f=-1) + SQUARE).encode(),
    "beyond.ply": (PLY.format(v=4, f=1) + SQUARE + "3 0 1 7\n").encode(),
    "binary.ply": PLY.format(v=400, f=10).replace("ascii", "binary_little_endian").encode()
    + b"\1" * 900,
    "text.ply": b"A letter to the reader.\n",
    "kind.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty quux x\nend_header\n0\n",
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_refused_by_name(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_bytes(BROKEN[name])
    with pytest.raises(InputError) as error:
        read_surface(file)
    text = str(error.value)
    assert name in text
    assert "\n" not in text
    assert len(text) < 400


def test_points_alone_are_told_what_to_do(tmp_path: Path) -> None:
    file = tmp_path / "cloud.ply"
    file.write_text(PLY.format(v=4, f=0) + SQUARE)
    with pytest.raises(InputError, match=r"4 points but no triangles.*make a triangle mesh"):
        read_surface(file)


def test_every_cut_of_a_file_is_refused(tmp_path: Path, made: SimpleNamespace) -> None:
    bowl = made.bowl(count=6)
    for name, how in (("a.stl", {}), ("b.stl", {"file_type": "stl_ascii"}), ("a.ply", {})):
        data = written(tmp_path, name, bowl, **how).read_bytes()
        file = tmp_path / f"cut_{name}"
        for share in np.linspace(0.05, 0.97, 12):
            file.write_bytes(data[: int(share * len(data))])
            with pytest.raises(InputError, match="cut_"):
                read_surface(file)


def test_places_that_are_no_scan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "folder.stl"
    folder.mkdir()
    with pytest.raises(InputError, match="is not a file"):
        read_surface(folder)
    with pytest.raises(InputError, match="there is no such file"):
        read_surface(tmp_path / "absent.stl")
    with pytest.raises(InputError, match=r"did you mean \.stl"):
        read_surface(tmp_path / "a.stl1")
    large = tmp_path / "large.stl"
    large.write_bytes(stl(3, 3))
    monkeypatch.setattr("sheetmorph.compare.scan.MAX_BYTES", 100)
    with pytest.raises(InputError, match="too large"):
        read_surface(large)
    monkeypatch.undo()
    monkeypatch.setattr("sheetmorph.compare.scan.MAX_TRIANGLES", 2)
    with pytest.raises(InputError, match="too many triangles"):
        read_surface(large)


def test_far_from_the_origin_is_told(tmp_path: Path, made: SimpleNamespace) -> None:
    bowl = made.bowl(count=8)
    far = Surface(bowl.points + np.array([500_000.0, 4_000_000.0, 0.0]), bowl.triangles)
    scan = read_surface(written(tmp_path, "map.obj", far))
    assert any("away from the origin" in note for note in scan.notes)


def test_the_reference_scan(reference: Path) -> None:
    scan = read_surface(reference / "petals_scan.stl")
    assert len(scan.surface.triangles) == 22_008
    assert len(scan.surface.points) == 11_022
    assert scan.surface.size == pytest.approx(0.63674, rel=1e-4)
