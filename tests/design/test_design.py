"""Load, change, save, hash, and the files that a design names."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from pydantic import ValidationError
from sheets import SHEET

from sheetmorph.core.errors import InputError
from sheetmorph.design.spec import Design


def test_everything_is_in_si(design):
    assert design.layers[0].thickness == 3e-4
    assert design.layers[1].young_modulus == 2.6733e6
    assert design.outline_polygon().bounds == (-0.02, -0.01, 0.02, 0.01)
    assert design.pattern_polygon().bounds == (-0.01, -0.003, 0.01, 0.003)
    assert design.eps_pre == -0.3
    assert design.perturbation.force_per_node == 1e-6
    assert not design.is_free


def test_a_design_cannot_be_changed(design):
    with pytest.raises(FrozenInstanceError):
        design.source = ""
    with pytest.raises(ValidationError):
        design.layers[0].thickness = 1.0


def test_round_trip_keeps_comments_and_content(design, tmp_path):
    design.save(tmp_path / "again.toml")
    again = Design.load(tmp_path / "again.toml")
    assert again.to_toml() == design.source
    assert "# free shrinkage" in again.source
    assert again.spec == design.spec
    assert again.hash == design.hash


def test_a_byte_order_mark_and_windows_line_ends_are_fine(base, design, tmp_path):
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + base.replace("\n", "\r\n").encode())
    assert Design.load(file).hash == design.hash


# with_values


def test_with_values_leaves_the_first_alone(design):
    other = design.with_values({"actuation.eps_pre": -0.2, "layers.1.thickness": "0.8 mm"})
    assert (design.eps_pre, other.eps_pre) == (-0.3, -0.2)
    assert (design.layers[1].thickness, other.layers[1].thickness) == (1e-3, 8e-4)
    assert "# free shrinkage" in other.source
    assert Design.from_toml(other.to_toml()).hash == other.hash


@pytest.mark.parametrize(
    ("key", "value", "read"),
    [
        ("actuation.eps_pre", "-0.25", lambda d: d.eps_pre == -0.25),
        ("actuation.eps_pre", "-25 %", lambda d: d.eps_pre == -0.25),
        ("actuation.eps_pre", np.float64(-0.25), lambda d: d.eps_pre == -0.25),
        ("layers[1].thickness", "0.5 mm", lambda d: d.layers[1].thickness == 5e-4),
        ("layers.PLA.thickness", '"0.5 mm"', lambda d: d.layers[1].thickness == 5e-4),
        ("solver.max_steps", np.int64(7), lambda d: d.solver.max_steps == 7),
        ("outputs.animation", "true", lambda d: d.outputs.animation),
        ("pattern.0.start", '["-8 mm", "0 mm"]', lambda d: d.pattern[0].start == (-8e-3, 0.0)),
        ("supports.0.x.1", "7 mm", lambda d: d.supports[0].x == (-5e-3, 7e-3)),
        ("name", "other name", lambda d: d.name == "other name"),
        ("published.coupling", 0, lambda d: d.published.coupling == 0),
        ("perturbation.ramp_down_steps", "3", lambda d: d.perturbation.ramp_down_steps == 3),
        ("model", "published", lambda d: d.model == "published"),
        ("layers.0.density", None, lambda d: d.layers[0].density == 1000.0),
    ],
)
def test_values_by_dotted_key(design, key, value, read):
    assert read(design.with_values({key: value}))


def test_new_tables_and_lists(design):
    other = design.with_values(
        {
            "supports": [{"kind": "free"}],
            "perturbation.shape": "bowl",
            "outputs.report": False,
            "published.mean_edge_length": "2 mm",
        }
    )
    assert other.is_free
    assert not other.outputs.report
    assert other.published.mean_edge_length == 2e-3
    bare = design.with_values({"pattern": [], "layers.1": None})
    assert bare.pattern_polygon().is_empty
    assert len(bare.layers) == 1
    again = bare.with_values(
        {
            "pattern": [{"kind": "disc", "radius": "3 mm"}],
            "layers.0.name": "a",
            "layers": [*_layers()],
        }
    )
    assert again.pattern[0].radius == 3e-3


def _layers() -> list[dict[str, object]]:
    film = {"name": "a", "role": "active", "thickness": "1 mm", "young_modulus": "1 MPa"}
    return [film, {**film, "name": "b", "role": "inert", "where": "pattern"}]


def test_keys_that_exclude_each_other_replace_each_other(design):
    hot = design.with_values({"actuation.temperature": "130 degC"})
    assert hot.actuation.eps_pre is None
    assert hot.with_values({"actuation.eps_pre": -0.1}).actuation.temperature is None
    assert design.with_values({"mesh.file": "a.msh"}).spec.mesh.size is None
    total = design.with_values({"perturbation.total_force": "1 mN"})
    assert total.perturbation.force_per_node is None
    with pytest.raises(InputError, match="exclude each other"):
        design.with_values({"actuation.temperature": "130 degC", "actuation.eps_pre": -0.1})


@pytest.mark.parametrize(
    ("key", "value", "fragment"),
    [
        ("actuation.eps_per", 1, "actuation.eps_per: unknown key; did you mean eps_pre?"),
        ("actuaton.eps_pre", 1, "actuaton: unknown key; did you mean actuation?"),
        ("layer.1.thickness", "1 mm", "did you mean layers?"),
        ("layers.1.thicknes", "1 mm", "layers[1].thicknes: unknown key; did you mean thickness?"),
        ("layers.2.thickness", "1 mm", "layers has no entry 2; allowed: 0 to 1"),
        ("layers.PLO.thickness", "1 mm", "write an index or a name; did you mean PLA?"),
        ("layers.thickness", "1 mm", "layers is a list"),
        ("name.first", 1, "leads nowhere: name is not a table"),
        ("name.first.second", 1, "leads nowhere: name is not a table"),
        ("a..b", 1, "is not a key"),
        ("", 1, "is not a key"),
        ("x" * 1000, 1, "is not a key"),
        ("actuation.eps_pre", "[1", "actuation.eps_pre: write a number without unit"),
        ("actuation.eps_pre", "1\nname = 2", "actuation.eps_pre: write a number without unit"),
        ("actuation.eps_pre", object(), "is not a value for a design file"),
        ("actuation.eps_pre", float("nan"), "finite number"),
        ("actuation", 3, "actuation: must be a table"),
        ("pattern.0", 3, "pattern.0: must be a table"),
        ("layers.0", "x", "layers.0: must be a table"),
    ],
)
def test_values_that_are_refused(design, key, value, fragment):
    with pytest.raises(InputError) as caught:
        design.with_values({key: value})
    assert fragment in str(caught.value)
    assert "\n" not in str(caught.value)


def test_refused_values_name_the_file(base, tmp_path):
    file = tmp_path / "strip.toml"
    file.write_text(base)
    with pytest.raises(InputError, match=r"strip\.toml: actuation\.eps_pre"):
        Design.load(file).with_values({"actuation.eps_pre": 7})


# hash


def test_hash_is_of_the_content_in_si(base, design):
    same = [
        base.replace('"0.3 mm"', '"300 um"'),
        base.replace('"strip"', '"other"'),
        base.replace("# free shrinkage", "# something else"),
        base + "[outputs]\nreport = false\n",
        base.replace("[solver]", "[solver]\ninitial_step = 0.1"),
        base.replace('"0.8911 MPa"', '"891.1 kPa"'),
    ]
    assert {Design.from_toml(text).hash for text in same} == {design.hash}
    different = [
        base.replace('"0.3 mm"', '"301 um"'),
        base.replace("-0.3", "-0.31"),
        base.replace("coupling = 1.0", "coupling = 0.0"),
        base.replace("max_step = 0.2", "max_step = 0.1"),
        base.replace('size = "2 mm"', 'size = "3 mm"'),
    ]
    hashes = {Design.from_toml(text).hash for text in different}
    assert len(hashes) == len(different)
    assert design.hash not in hashes


def test_hash_is_the_same_in_another_process(design):
    code = "import sys; from sheetmorph.design.spec import Design; "
    code += "print(Design.from_toml(sys.stdin.read()).hash)"
    run = subprocess.run(
        [sys.executable, "-c", code],
        input=design.source,
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.strip() == design.hash


# mesh files


@pytest.fixture
def filed(base, tmp_path):
    (tmp_path / "two.txt").write_text(SHEET)
    text = base.replace('size = "2 mm"', 'file = "two.txt"')
    (tmp_path / "strip.toml").write_text(text)
    return tmp_path / "strip.toml"


def test_mesh_file_beside_the_design(filed):
    design = Design.load(filed)
    assert design.resolve_mesh_path() == (filed.parent / "two.txt").resolve()
    before = design.hash
    (filed.parent / "two.txt").write_text(SHEET.replace("4, 2, 0", "4, 0, 2"))
    assert Design.load(filed).hash != before


def test_mesh_made_from_its_size_has_no_path(design):
    assert design.resolve_mesh_path() is None


@pytest.mark.parametrize(
    "name",
    [
        "../two.txt",
        "/etc/passwd",
        "sub/../../two.txt",
        "C:\\two.txt",
        "..\\two.txt",
        "C:two.txt",
        ".",
    ],
)
@pytest.mark.parametrize("key", ["file", "reference_file"])
def test_paths_that_lead_out_are_refused(filed, monkeypatch, key, name):
    monkeypatch.setenv("SHEETMORPH_REFERENCE_DATA", str(filed.parent))
    filed.write_text(filed.read_text("utf-8").replace('file = "two.txt"', f"{key} = '{name}'"))
    with pytest.raises(
        InputError, match=rf"strip\.toml: mesh\.{key}: (leads out|there is no such)"
    ):
        Design.load(filed).resolve_mesh_path()


def test_links_that_lead_out_are_refused(filed, tmp_path_factory):
    outside = tmp_path_factory.mktemp("outside") / "mesh.txt"
    outside.write_text(SHEET)
    (filed.parent / "two.txt").unlink()
    try:
        (filed.parent / "two.txt").symlink_to(outside)
    except OSError:
        pytest.skip("this system makes no links")
    with pytest.raises(InputError, match="by a link"):
        Design.load(filed).resolve_mesh_path()


def test_a_mesh_file_that_is_not_there(filed):
    (filed.parent / "two.txt").unlink()
    with pytest.raises(InputError, match=r"mesh\.file: there is no such file in"):
        Design.load(filed).build_mesh()


def test_text_has_no_folder(base):
    design = Design.from_toml(base.replace('size = "2 mm"', 'file = "two.txt"'))
    with pytest.raises(InputError, match="no folder"):
        design.resolve_mesh_path()


def test_reference_folder_by_variable_then_by_place(filed, tmp_path, monkeypatch):
    text = filed.read_text("utf-8").replace('file = "two.txt"', 'reference_file = "two.txt"')
    project = tmp_path / "project"
    (project / "examples").mkdir(parents=True)
    (project / "examples" / "a.toml").write_text(text)
    design = Design.load(project / "examples" / "a.toml")
    monkeypatch.setenv("SHEETMORPH_REFERENCE_DATA", str(filed.parent))
    assert design.resolve_mesh_path() == (filed.parent / "two.txt").resolve()
    monkeypatch.setenv("SHEETMORPH_REFERENCE_DATA", str(tmp_path / "absent"))
    with pytest.raises(InputError, match="SHEETMORPH_REFERENCE_DATA: is not a folder"):
        design.resolve_mesh_path()
    monkeypatch.delenv("SHEETMORPH_REFERENCE_DATA")
    (project / "run").mkdir()
    monkeypatch.chdir(project / "run")
    folder = tmp_path / "shared" / "reference"
    folder.mkdir(parents=True)
    (folder / "two.txt").write_text(SHEET)
    assert design.resolve_mesh_path() == (folder / "two.txt").resolve()
    beside = project / "shared" / "reference"
    beside.mkdir(parents=True)
    (beside / "two.txt").write_text(SHEET)
    assert design.resolve_mesh_path() == (beside / "two.txt").resolve()


# start-up


def test_importing_the_schema_is_light():
    code = (
        "import sys, sheetmorph.design.spec; "
        "heavy = {'pint', 'shapely', 'scipy', 'tomlkit', 'matplotlib', 'jax', 'vtk', 'trimesh', "
        "'igl', 'cv2', 'h5py', 'PIL', 'jinja2', 'rich', 'click'} & set(sys.modules); "
        "assert not heavy, heavy"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_first_step_is_the_models_unless_given(base: str) -> None:
    design = Design.from_toml(base)
    assert design.initial_step == 0.1
    assert design.with_values({"solver.max_step": 0.05}).initial_step == 0.05
    layered = design.with_values({"model": "laminate"})
    assert layered.initial_step == 0.01
    assert layered.with_values({"solver.initial_step": 0.07}).initial_step == 0.07
