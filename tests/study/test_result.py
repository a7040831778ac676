"""Results: fields, saving, loading, damage; journals and going on."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.core.events import Event, Progress, StateReached
from sheetmorph.study.journal import Journal
from sheetmorph.study.simulate import explain


def test_fields_have_their_shapes_and_sum_to_the_energies(small_result: sm.Result) -> None:
    r = small_result
    s, v = r.positions.shape[:2]
    e, h = len(r.mesh.edges), len(r.mesh.hinges)
    assert r.strain.shape == r.thermal_strain.shape == r.stretch_energy_density.shape == (s, e)
    assert r.dihedral.shape == r.bend_energy_density.shape == (s, h)
    assert r.height.shape == r.mean_curvature.shape == r.gaussian_curvature.shape == (s, v)
    assert r.aspect_ratio.shape == r.actuation.shape == (s,)
    np.testing.assert_allclose(r.positions[0], r.mesh.nodes, atol=1e-16)
    areas = r.mesh.edge_areas
    assert areas.sum() == pytest.approx(r.mesh.triangle_areas.sum(), rel=1e-12)
    energies = r.summary["energy_J"]
    assert r.stretch_energy_density[-1] @ areas == pytest.approx(energies["stretch"], rel=1e-9)
    assert r.bend_energy_density[-1] @ areas[r.mesh.hinge_edges[:, 0]] == pytest.approx(
        energies["bend"], rel=1e-9
    )
    assert energies["total"] == pytest.approx(
        energies["stretch"] + energies["bend"] + energies["load"]
    )


def test_summary_has_what_it_promises(small_result: sm.Result) -> None:
    summary = small_result.summary
    wanted = {
        *("status", "stable", "negative_pivots", "residual_max_N", "newton_iterations"),
        *("factorisations", "seconds", "solver", "nodes", "edges", "triangles", "height_m"),
        *("bbox_m", "aspect_ratio", "energy_J", "version", "design_hash"),
    }
    assert wanted <= set(summary)
    assert set(summary["seconds"]) >= {"assembly", "factorise", "solve", "total", "wall"}
    assert set(summary["energy_J"]) == {"stretch", "bend", "guard", "fold", "load", "total"}
    assert isinstance(summary["stable"], bool)
    json.dumps(summary, allow_nan=False)


def test_a_free_sheet_lies_level(small_result: sm.Result) -> None:
    """Rigid motions are taken out of every state: middle and mean tilt stay where they were."""
    for state in small_result.positions:
        np.testing.assert_allclose(
            state.mean(axis=0), small_result.mesh.nodes.mean(axis=0), atol=1e-15
        )
    assert len(small_result.held_nodes) == 0
    assert small_result.summary["height_m"] > 1e-3


def test_save_and_load(small_result: sm.Result, tmp_path: Path) -> None:
    small_result.save(tmp_path / "run")
    for place in (tmp_path / "run", tmp_path / "run" / "result.h5"):
        again = sm.Result.load(place)
        for name in ("positions", "ramp", "load_fraction", "thermal_strain_full", "coupling"):
            np.testing.assert_array_equal(getattr(again, name), getattr(small_result, name))
        np.testing.assert_array_equal(again.mesh.hinge_edges, small_result.mesh.hinge_edges)
        np.testing.assert_array_equal(again.strain, small_result.strain)
        assert again.summary == small_result.summary
        assert again.design.hash == small_result.design.hash
    assert (
        json.loads((tmp_path / "run" / "summary.json").read_text("utf-8")) == small_result.summary
    )
    with h5py.File(tmp_path / "run" / "result.h5") as file:
        assert file["fields/dihedral"].attrs["unit"] == "rad"
        assert set(file["fields"]) >= {"dihedral", "strain", "thermal_strain", "height"}


DAMAGE = {
    "empty": lambda data: b"",
    "truncated": lambda data: data[: len(data) // 2],
    "cut at the end": lambda data: data[:-64],
    "text": lambda data: b"this is no HDF5 file",
    "overwritten": lambda data: data[:512] + bytes(512) + data[1024:],
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_files_are_refused(damage: str, small_result: sm.Result, tmp_path: Path) -> None:
    file = small_result.save(tmp_path / "r.h5")
    file.write_bytes(DAMAGE[damage](file.read_bytes()))
    with pytest.raises(sm.InputError) as caught:
        sm.Result.load(file)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def _edited(small_result: sm.Result, path: Path, edit) -> Path:  # type: ignore[no-untyped-def]
    file = small_result.save(path)
    with h5py.File(file, "r+") as h5:
        edit(h5)
    return file


def _announce(h5: h5py.File) -> None:
    del h5["states/ramp"]
    h5.create_dataset("states/ramp", shape=(10**8,), dtype=float, chunks=(10**6,))


def test_a_text_that_announces_gigabytes_is_not_read(
    small_result: sm.Result, tmp_path: Path
) -> None:
    """HDF5 sets aside what the length of a variable text says, before it looks for the text."""
    text = small_result.design.to_toml()
    file = _edited(small_result, tmp_path / "r.h5", _replace("design", text))
    assert sm.Result.load(file).design.to_toml() == text  # as it was written once
    with h5py.File(file) as h5:
        place = h5["design"].id.get_offset()
    data = bytearray(file.read_bytes())
    data[place : place + 4] = (3 * 10**9).to_bytes(4, "little")
    file.write_bytes(data)
    with pytest.raises(sm.InputError, match="announces 3000000000 bytes"):
        sm.Result.load(file)


def _replace(name: str, values: np.ndarray):  # type: ignore[no-untyped-def]
    def edit(h5: h5py.File) -> None:
        del h5[name]
        h5[name] = values

    return edit


def _set(name: str, value: float):  # type: ignore[no-untyped-def]
    def edit(h5: h5py.File) -> None:
        h5[name][..., 0] = value

    return edit


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda h5: h5.attrs.__setitem__("format", "other"), "no result of sheetmorph"),
        (lambda h5: h5.attrs.__setitem__("format_version", 99), "newer sheetmorph"),
        (lambda h5: h5.__delitem__("mesh/edges"), "cannot be read"),
        (_replace("states/ramp", np.zeros(2)), "shape"),
        (_replace("mesh/triangles", np.full((5, 3), 10**6)), "shape|range"),
        (_replace("states/positions", np.array([b"x"])), "numbers"),
        (_replace("design", "name = 3"), "name"),
        (_replace("summary", "{"), "cannot be read"),
        (_replace("summary", "3"), "summary is no table"),
        (_replace("mesh/nodes", 3.0), "mesh/nodes is one number"),
        (_set("mesh/nodes", np.nan), "nodes has a coordinate that is not a finite number"),
        (_set("states/positions", -np.inf), "positions has a coordinate that is not"),
        (_set("states/positions", 1e300), "positions has a coordinate that is not"),
        (_announce, "announces more than the file holds"),
    ],
)
def test_wrong_contents_are_refused(small_result, tmp_path, edit, message) -> None:  # type: ignore[no-untyped-def]
    file = _edited(small_result, tmp_path / "r.h5", edit)
    with pytest.raises(sm.InputError, match=message):
        sm.Result.load(file)


def test_missing_results_say_so(tmp_path: Path) -> None:
    with pytest.raises(sm.InputError, match=r"no result\.h5"):
        sm.Result.load(tmp_path)
    with pytest.raises(sm.InputError, match="no such result"):
        sm.Result.load(tmp_path / "x.h5")
    Journal.of_run(tmp_path).begin("0")
    with pytest.raises(sm.InputError, match="--resume"):
        sm.Result.load(tmp_path)


def test_events_tell_every_state(small_design: sm.Design) -> None:
    events: list[Event] = []
    result = sm.simulate(small_design, on_event=events.append)
    assert sum(isinstance(e, StateReached) for e in events) == len(result.positions) - 1
    fractions = [e.fraction for e in events if isinstance(e, Progress)]
    assert fractions == sorted(fractions)


@pytest.mark.parametrize("states", [2, 5, 9])
def test_a_run_that_dies_goes_on_to_the_same_bits(
    small_design: sm.Design, small_result: sm.Result, tmp_path: Path, states: int
) -> None:
    class Died(Exception):  # noqa: N818
        pass

    def die(event: Event) -> None:
        if isinstance(event, StateReached) and event.index == states:
            raise Died

    journal = Journal.of_run(tmp_path)
    with pytest.raises(Died):
        sm.simulate(small_design, on_event=die, journal=journal)
    assert len(list(journal.folder.glob("state_*.npz"))) == states
    (journal.folder / "state_99999.partial.npz").write_bytes(b"half a state")
    result = sm.simulate(small_design, journal=journal, resume=True)
    np.testing.assert_array_equal(result.positions, small_result.positions)


def test_only_the_same_design_goes_on(small_design: sm.Design, tmp_path: Path) -> None:
    journal = Journal.of_run(tmp_path)
    with pytest.raises(sm.InputError, match="no unfinished run"):
        sm.simulate(small_design, journal=journal, resume=True)
    sm.simulate(small_design, journal=journal)
    other = small_design.with_values({"actuation.eps_pre": -0.2})
    with pytest.raises(sm.InputError, match="another design"):
        sm.simulate(other, journal=journal, resume=True)
    (journal.folder / "state_00002.npz").write_bytes(b"PK damaged")
    with pytest.raises(sm.InputError, match="cannot be read"):
        sm.simulate(small_design, journal=journal, resume=True)


def test_a_full_disk_leaves_nothing_half_written(
    small_result: sm.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_result.save(tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(sm.OutputError, match=r"No space left.*-o"):
        small_result.save(tmp_path)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_failures_are_statuses_with_a_remedy(small_design: sm.Design) -> None:
    result = sm.simulate(small_design.with_values({"solver.max_steps": 3}))
    assert result.status == "too_many_steps"
    assert "solver.max_steps" in result.summary["remedy"]
    assert 0 < result.summary["actuation_reached"] < 1
    assert len(result.positions) == 4
    result = sm.simulate(small_design.with_values({"solver.time_limit": "1e-9 s"}))
    assert result.status == "time_limit"


# A soft rim between stiff arms on a coarse mesh folds.
FOLDS = {
    "outline.radius": "62 mm",
    "pattern.0.arms": 6,
    "pattern.0.arm_length": "42 mm",
    "pattern.0.half_width": "5.3 mm",
    "layers.0.thickness": "0.18 mm",
    "layers.0.young_modulus": "0.6 MPa",
    "layers.1.thickness": "1.2 mm",
    "layers.1.young_modulus": "26 MPa",
    "mesh.size": "7.6 mm",
    "actuation.eps_pre": -0.57,
}
# A jump of the eigenstrain at the rim of the pattern leaves triangles there no shape.
COLLAPSES = {"actuation.profile": "step", "actuation.eps_pre": -0.8}


@pytest.mark.parametrize("values", [FOLDS, COLLAPSES])
def test_triangles_that_would_collapse_are_held_open_and_told_of(
    small_design: sm.Design, values: dict[str, object]
) -> None:
    quick = {"solver.min_step": 2e-3, "solver.max_iterations": 60}
    result = sm.simulate(small_design.with_values({**values, **quick}))
    assert result.status == "completed"
    assert result.summary["stable"]
    assert "guard" in result.summary["detail"]
    assert "mm" in result.summary["detail"]
    assert 0.0 < result.summary["energy_J"]["guard"] < 0.01 * result.summary["energy_J"]["total"]


@pytest.mark.parametrize("wanted", ["folded flat", "collapsed to"])
def test_a_sheet_beyond_the_model_says_where(small_result: sm.Result, wanted: str) -> None:
    positions = small_result.positions.copy()
    _, _, c, d = small_result.mesh.hinges[0]
    if wanted == "folded flat":
        positions[-1, d] = positions[-1, c] + [0.0, 0.0, 1e-5]
    else:
        positions[-1, :, 1] *= 0.02
    result = replace(small_result, positions=positions, summary=dict(small_result.summary))
    explain(result)
    assert wanted in result.summary["detail"]
    assert "mm" in result.summary["detail"]
    assert "mesh.size" in result.summary["remedy"]
