from __future__ import annotations

import time
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.geometry.writers import write_stl, write_vtu_series


@pytest.fixture
def states(meshes):
    mesh = meshes["bowl"]
    rng = np.random.default_rng(0)
    return mesh, mesh.nodes + 1e-3 * rng.normal(size=(20, *mesh.nodes.shape))


def test_stl(tmp_path, states):
    mesh, x = states
    write_stl(tmp_path / "a.stl", mesh.triangles, x[0])
    assert (tmp_path / "a.stl").stat().st_size == 84 + 50 * len(mesh.triangles)
    read = meshio.read(tmp_path / "a.stl")
    corners = read.points[read.cells_dict["triangle"]]
    np.testing.assert_allclose(corners, x[0][mesh.triangles], atol=1e-7)
    assert [path.name for path in tmp_path.iterdir()] == ["a.stl"]


def test_series(tmp_path, states):
    mesh, x = states
    actuation = -0.3 * np.linspace(0, 1, 20)
    height, area = x[:, :, 2], np.tile(mesh.triangle_areas, (20, 1))
    index = write_vtu_series(
        tmp_path / "new", "a & b", mesh.triangles, x, actuation,
        {"height <m>": height, "shift": x - mesh.nodes}, {"area": area},
    )  # fmt: skip
    assert index == tmp_path / "new" / "a & b.pvd"
    entries = ElementTree.parse(index).getroot().findall("Collection/DataSet")  # noqa: S314
    assert [float(entry.get("timestep")) for entry in entries] == (-actuation).tolist()
    for state in (0, 7, 19):
        read = meshio.read(index.parent / entries[state].get("file"))
        np.testing.assert_array_equal(read.points, x[state])
        np.testing.assert_array_equal(read.cells_dict["triangle"], mesh.triangles)
        np.testing.assert_array_equal(read.point_data["height <m>"], height[state])
        np.testing.assert_array_equal(read.point_data["shift"], x[state] - mesh.nodes)
        np.testing.assert_array_equal(read.cell_data["area"][0], area[state])
        assert read.field_data["actuation"] == actuation[state]
    assert len(list(index.parent.iterdir())) == 21


def test_vtk_reads_the_series(tmp_path, states):
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    mesh, x = states
    write_vtu_series(tmp_path, "a", mesh.triangles, x[:1], [0.5], {"z": x[:1, :, 2]})
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(tmp_path / "a_0000.vtu"))
    reader.Update()
    grid = reader.GetOutput()
    assert grid.GetNumberOfPoints() == len(mesh.nodes)
    assert grid.GetNumberOfCells() == len(mesh.triangles)
    assert grid.GetCellType(0) == 5
    assert grid.GetPointData().GetArray("z").GetValue(3) == x[0, 3, 2]


def test_states_of_equal_actuation_are_counted(tmp_path, states):
    mesh, x = states
    index = write_vtu_series(tmp_path, "a", mesh.triangles, x[:3], [0.0, 0.3, 0.3])
    assert [line.split('"')[1] for line in index.read_text("utf-8").splitlines()[2:5]] == [
        "0.0", "1.0", "2.0",
    ]  # fmt: skip


def test_twenty_states_are_written_quickly(tmp_path, states):
    mesh, x = states
    fields = {"H": x[:, :, 2], "K": x[:, :, 1]}
    best = np.inf
    for trial in range(3):
        start = time.perf_counter()
        write_vtu_series(tmp_path / str(trial), "a", mesh.triangles, x, np.arange(20.0), fields)
        best = min(best, time.perf_counter() - start)
    assert best < 0.3


def test_bad_arrays_are_refused(tmp_path, states):
    mesh, x = states
    bad = x.copy()
    bad[3, 2, 1] = np.nan
    faces, times = mesh.triangles, np.arange(20.0)
    with pytest.raises(InputError, match="finite"):
        write_vtu_series(tmp_path, "a", faces, bad, times)
    with pytest.raises(InputError, match="finite"):
        write_stl(tmp_path / "a.stl", faces, bad[3])
    with pytest.raises(InputError, match="one time per state"):
        write_vtu_series(tmp_path, "a", faces, x, times[:3])
    with pytest.raises(InputError, match="shape"):
        write_vtu_series(tmp_path, "a", faces, x[0], times)
    with pytest.raises(InputError, match="H: the field does not fit"):
        write_vtu_series(tmp_path, "a", faces, x, times, {"H": x[:, :5, 0]})
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_a_file(tmp_path, states):
    mesh, x = states
    (tmp_path / "a").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        write_stl(tmp_path / "a" / "b.stl", mesh.triangles, x[0])
