"""Through the command line: every bad input is one line, exit code 2, and nothing is written."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest
from small import SMALL

from sheetmorph.cli import main
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.geometry.topology import build_mesh

FILM = 'thickness = "0.3 mm"'
SIZE = 'size = "3 mm"'
DISC = 'kind = "disc"\nradius = "20 mm"'
ARMS = 'kind = "star"\narms = 3\narm_length = "16 mm"\nhalf_width = "3 mm"'
BOW = 'kind = "polygon"\nunit = "mm"\npoints = [[-9, -9], [9, 9], [9, -9], [-9, 9]]'

# name: (what to replace in the small design, by what, what the message must say)
DESIGNS = {
    "not TOML": ("[outline]", "[outline", "line"),
    "empty": (SMALL, "", "required"),
    "unknown table": ("[mesh]", "[mash]", "did you mean mesh?"),
    "unknown key": ("eps_pre", "eps_prae", "did you mean eps_pre?"),
    "missing name": ('name = "small"', "", "name"),
    "missing layers": ("[[layers]]", "[[layer]]", "did you mean layers?"),
    "bare number": (FILM, "thickness = 0.3", "layers[0].thickness"),
    "wrong unit": (FILM, 'thickness = "0.3 MPa"', "layers[0].thickness"),
    "unknown unit": (FILM, 'thickness = "0.3 mn"', "layers[0].thickness"),
    "zero thickness": (FILM, 'thickness = "0 mm"', "layers[0].thickness"),
    "negative thickness": (FILM, 'thickness = "-0.3 mm"', "layers[0].thickness"),
    "NaN": ("eps_pre = -0.4", "eps_pre = nan", "actuation.eps_pre"),
    "infinite": ("eps_pre = -0.4", "eps_pre = -inf", "actuation.eps_pre"),
    "shrinks to nothing": ("eps_pre = -0.4", "eps_pre = -1.0", "actuation.eps_pre"),
    "no actuation": ("eps_pre = -0.4", "", "actuation"),
    "two actuations": ("eps_pre = -0.4", 'eps_pre = -0.4\ntemperature = "150 degC"', "actuation"),
    "unknown role": ('role = "active"', 'role = "lively"', "layers[0].role"),
    "nothing active": ('role = "active"', 'role = "inert"', "active"),
    "Poisson's ratio": (FILM, f"{FILM}\npoisson_ratio = 0.5", "poisson_ratio"),
    "modulus": ('"1 MPa"', '"0 MPa"', "young_modulus"),
    "self-crossing outline": (DISC, BOW, "outline"),
    "outline without area": ('radius = "20 mm"', 'radius = "0 mm"', "outline.radius"),
    "pattern outside": ("half_width", 'centre = ["90 mm", "0 mm"]\nhalf_width', "pattern[0]"),
    "pattern too long": ('"16 mm"', '"26 mm"', "pattern[0]"),
    "unknown shape": ('kind = "star"', 'kind = "stair"', "star"),
    "no arms": ("arms = 3", "arms = 0", "pattern[0].arms"),
    "half an arm": ("arms = 3", "arms = 2.5", "pattern[0].arms"),
    "mesh too fine": (SIZE, 'size = "0.001 mm"', "mesh.size"),
    "mesh too coarse": (SIZE, 'size = "30 mm"', "mesh.size"),
    "no mesh": (SIZE, "", "mesh"),
    "size and file": (SIZE, f'{SIZE}\nfile = "a.stl"', "mesh.file"),
    "no such mesh file": (SIZE, 'file = "nowhere.stl"', "mesh.file"),
    "mesh file above": (SIZE, 'file = "../a.stl"', "mesh.file"),
    "absolute mesh file": (SIZE, 'file = "/etc/passwd"', "mesh.file"),
    "uniform load on a free sheet": ('shape = "bowl"', 'shape = "uniform"', "perturbation.shape"),
    "support holds nothing": (
        "[mesh]",
        '[[supports]]\nkind = "box"\nx = ["70 mm", "80 mm"]\ny = ["0 mm", "1 mm"]\n[mesh]',
        "supports[0]",
    ),
    "node that is not there": (
        "[mesh]",
        '[[supports]]\nkind = "nodes"\nnodes = [0, 1, 999999]\n[mesh]',
        "supports[0].nodes",
    ),
    "steps": ("[mesh]", "[solver]\nmax_step = 0\n[mesh]", "solver.max_step"),
    "solver": ("[mesh]", '[solver]\nlinear_solver = "umfpack"\n[mesh]', "solver.linear_solver"),
    "curve above": (
        "eps_pre = -0.4",
        'temperature = "400 K"\nshrink_curve = "../c.csv"',
        "actuation.shrink_curve",
    ),
}


def refused(arguments: list[str], capsys: pytest.CaptureFixture[str], *wanted: str) -> str:
    """The one line with which the command line refuses."""
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1 and err.startswith("sheetmorph: "), err
    assert "Traceback" not in err
    for text in wanted:
        assert text in err
    return err


@pytest.mark.parametrize("case", DESIGNS)
@pytest.mark.parametrize("command", ["run", "check"])
def test_broken_designs(
    case: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new, wanted = DESIGNS[case]
    assert old in SMALL
    file = tmp_path / "design.toml"
    file.write_text(SMALL.replace(old, new, 1))
    out = tmp_path / "out"
    refused(
        [command, str(file), *(["-o", str(out)] if command == "run" else [])],
        capsys,
        wanted,
        "design.toml",
    )
    assert not out.exists()
    assert [p.name for p in tmp_path.iterdir()] == ["design.toml"]


def disc_mesh() -> SheetMesh:
    """A disc of 20 mm for the small design, in rings."""
    import sheetmorph as sm

    return sm.Design.from_toml(SMALL).build_mesh()


def listing(mesh: SheetMesh) -> dict[str, list[list[float]]]:
    """The three sections of the text format, in mm."""
    nodes = [[i, *(1e3 * x)] for i, x in enumerate(mesh.nodes)]
    faces = [[i, *t] for i, t in enumerate(mesh.triangles.tolist())]
    edges = [[i, *e] for i, e in enumerate(mesh.edges.tolist())]
    return {"*shellNodes": nodes, "*FaceNodes": faces, "*Edges": edges}


def text_of(sections: dict[str, list[list[float]]]) -> str:
    return "".join(
        name + "\n" + "".join(", ".join(map(str, row)) + "\n" for row in rows)
        for name, rows in sections.items()
    )


def _set(section: str, row: int, column: int, value: object):  # type: ignore[no-untyped-def]
    def edit(sections: dict[str, list[list[object]]]) -> None:
        sections[section][row][column] = value

    return edit


def _swap(sections: dict[str, list[list[float]]]) -> None:
    row = sections["*FaceNodes"][5]
    row[1], row[2] = row[2], row[1]


def _degenerate(sections: dict[str, list[list[float]]]) -> None:
    row = sections["*FaceNodes"][7]
    row[2] = row[1]


def _repeat(sections: dict[str, list[list[float]]]) -> None:
    a, b = sections["*FaceNodes"][0][1:3]
    sections["*shellNodes"].append([9999, 0.0, 0.0, 0.0])
    sections["*FaceNodes"].append([9999, a, b, 9999])


def _apart(sections: dict[str, list[list[float]]]) -> None:
    for k, (x, y) in enumerate(((0, 0), (1, 0), (0, 1))):
        sections["*shellNodes"].append([9000 + k, 100.0 + x, y, 0.0])
    sections["*FaceNodes"].append([9000, 9000, 9001, 9002])
    del sections["*Edges"]


MESHES = {
    "NaN node": (_set("*shellNodes", 3, 1, "nan"), "finite"),
    "word for a number": (_set("*shellNodes", 3, 2, "left"), "line"),
    "flipped triangle": (_swap, "flipped"),
    "degenerate triangle": (_degenerate, "triangle 7"),
    "corner that is not there": (_set("*FaceNodes", 7, 2, 123456), "123456"),
    "out of the plane": (_set("*shellNodes", 4, 3, 5.0), "flat"),
    "edge listed twice": (lambda s: s["*Edges"].append([9999, *s["*Edges"][0][1:]]), "edge"),
    "edge missing": (lambda s: s["*Edges"].pop(), "missing"),
    "edge that is no side": (
        lambda s: s["*Edges"].append([9999, 0, len(s["*shellNodes"]) - 1]),
        "edge",
    ),
    "node id twice": (_set("*shellNodes", 3, 0, 2), "2"),
    "node without triangle": (lambda s: s["*shellNodes"].append([9999, 1.0, 1.0, 0.0]), "node"),
    "non-manifold": (_repeat, ""),
    "two pieces": (_apart, "pieces"),
    "no triangles": (lambda s: s["*FaceNodes"].clear(), ""),
    "metres for millimetres": (
        lambda s: [r.__setitem__(slice(1, 3), [r[1] / 1e3, r[2] / 1e3]) for r in s["*shellNodes"]],
        "mesh.unit",
    ),
}


@pytest.mark.parametrize("case", MESHES)
def test_broken_meshes(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit, wanted = MESHES[case]
    sections = listing(disc_mesh())
    edit(sections)
    (tmp_path / "sheet.txt").write_text(text_of(sections))
    file = tmp_path / "design.toml"
    file.write_text(SMALL.replace(SIZE, 'file = "sheet.txt"'))
    refused(["run", str(file), "-o", str(tmp_path / "out")], capsys, wanted)
    assert not (tmp_path / "out").exists()


def test_the_mesh_that_is_not_broken_runs(tmp_path: Path) -> None:
    """Else the table above could pass for the wrong reason."""
    (tmp_path / "sheet.txt").write_text(text_of(listing(disc_mesh())))
    file = tmp_path / "design.toml"
    file.write_text(
        SMALL.replace(SIZE, 'file = "sheet.txt"')
        + "[outputs]\npictures = false\nanimation = false\nreport = false\n"
    )
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "-q"]) == 0


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", b""),
        ("a.stl", b"solid nothing\nendsolid\n"),
        ("a.stl", bytes(80) + (10**9).to_bytes(4, "little")),
        ("a.msh", b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"),
        ("a.vtu", b"<VTKFile><!DOCTYPE a [<!ENTITY b 'c'>]></VTKFile>"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1000000000\nend_header\n"),
        ("a.obj", b"v 0 0 0\nf 1 2 3\n"),
        ("a.txt", b"\x00\xff\xfe binary"),
        ("a.docx", b"PK"),
    ],
)
def test_unreadable_mesh_files(
    name: str, content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(content)
    file = tmp_path / "design.toml"
    file.write_text(SMALL.replace(SIZE, f'file = "{name}"'))
    refused(["run", str(file), "-o", str(tmp_path / "out")], capsys, name)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "wanted"),
    [
        (["run", "nowhere.toml"], "nowhere.toml"),
        (["run", "."], "."),
        (["run"], "FILE"),
        (["fly"], "fly"),
        (["run", "small.toml", "--set", "actuation.eps_pre"], "KEY=VALUE"),
        (["run", "small.toml", "--set", "actuation.eps=1"], "did you mean"),
        (["run", "small.toml", "--set", "actuation.eps_pre=much"], "actuation.eps_pre"),
        (["run", "small.toml", "-o", "small.toml"], "small.toml"),
        (["run", "small.toml", "--resume", "-o", "none"], "no unfinished run"),
        (["new", "small"], "exists"),
        (["new", "x", "--preset", "boat"], "boat"),
        (["new", "a/../../*"], "name"),
        (["new", ""], "my_bowl"),
        (["new", "../"], "my_bowl"),
        (["run", "small.toml", "-o", ""], "folder"),
    ],
)
def test_bad_arguments(
    arguments: list[str],
    wanted: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(SMALL, encoding="utf-8")
    refused(arguments, capsys, wanted)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["small.toml"]


def test_results_are_not_overwritten_unasked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, out = tmp_path / "small.toml", tmp_path / "out"
    file.write_text(SMALL)
    out.mkdir()
    (out / "result.h5").write_bytes(b"precious")
    refused(["run", str(file), "-o", str(out)], capsys, "--force")
    assert (out / "result.h5").read_bytes() == b"precious"


def test_a_full_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The disk fills up while the second state is written: one line, no half-written file."""
    file, out = tmp_path / "small.toml", tmp_path / "out"
    file.write_text(SMALL)
    real, calls = os.fsync, []

    def filling(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) > 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(descriptor)

    monkeypatch.setattr(os, "fsync", filling)
    refused(["run", str(file), "-o", str(out), "-q"], capsys, "No space left", "-o")
    assert [p for p in out.rglob("*") if "partial" in p.name] == []
    with np.load(out / "states" / "state_00000.npz") as state:
        assert np.isfinite(state["x"]).all()
    assert not (out / "result.h5").exists()


def test_a_folder_that_cannot_be_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    (tmp_path / "taken").write_text("a file where a folder is needed")
    refused(["run", str(file), "-o", str(tmp_path / "taken" / "out"), "-q"], capsys, "taken")


def test_build_mesh_is_what_the_tables_above_rely_on() -> None:
    mesh = disc_mesh()
    again = build_mesh(mesh.nodes, mesh.triangles, mesh.edges)
    np.testing.assert_array_equal(again.hinges, mesh.hinges)
