"""Modes and bifurcations of sheets, against plates whose modes are known."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.cli import main
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.structured import disc
from sheetmorph.proofs.bilayer_disc import DiscSheet
from sheetmorph.proofs.buckling import DISC, POISSON, THICKNESS
from sheetmorph.study.model import build_problem
from sheetmorph.study.stability import first_bifurcation, modes_at, modes_of, system_of

RIGIDITY = 1e6 * THICKNESS**3 / (12 * (1 - POISSON**2))


def frequencies(text: str, rings: int, count: int) -> np.ndarray:
    """√(λ R⁴/D) of a flat disc with the radius 1 m."""
    problem = build_problem(sm.Design.from_toml(text), disc(1.0, rings))
    system = system_of(problem).at(0.0, 0.0)
    return np.sqrt(modes_at(problem, system, problem.start, count).eigenvalues / RIGIDITY)


def test_a_free_disc_vibrates_as_plate_theory_says() -> None:
    """Zeros of the frequency equation of a free disc in Bessel functions J and I at ν = 0.3
    (Leissa, Vibration of Plates, NASA SP-160, 1969), with 2, 0, 3 and 1 nodal diameters."""
    text = DISC[: DISC.index("[[supports]]")]
    known = np.array([5.35833, 5.35833, 9.00314, 12.43899, 12.43899, 20.47455])
    coarse, fine = (np.abs(frequencies(text, rings, 6) / known - 1.0) for rings in (8, 16))
    assert fine.max() < 0.02
    assert np.log2(coarse / fine).min() > 1.8


def test_the_clamped_disc() -> None:
    """10.2158 and, twice, 21.260 (Leissa), the zeros of J0 I1 + I0 J1 and of J1 I2 + I1 J2."""
    mesh = disc(1.0, 16)
    rim = np.flatnonzero(np.linalg.norm(mesh.nodes, axis=1) > 1.0 - 1e-9).tolist()
    text = DISC.replace("nodes = [0]", f"nodes = {rim}")
    np.testing.assert_allclose(frequencies(text, 16, 3), [10.2158, 21.260, 21.260], rtol=0.02)


def test_the_double_bifurcation_of_a_disc_and_the_turning_of_its_pipe() -> None:
    """The rolled disc may turn about its axis at no cost: a mode next to zero, by the mesh."""
    sheet = DiscSheet.of(6, 2.5, lens=False, quarter=False)
    found = first_bifurcation(sheet.problem, system=sheet.system)
    assert found is not None and found.negative_pivots == 2
    here = sheet.system.at(found.ramp, 0.0)
    at = modes_at(sheet.problem, here, found.x, 3).eigenvalues
    assert np.abs(at[:2]).max() < 1e-6 * at[2]
    rolled = sheet.settled(2.5, sheet.saddled(found.x))
    modes = modes_at(sheet.problem, sheet.system.at(1.0, 0.0), rolled, 2).eigenvalues
    assert 0.0 < modes[0] < 0.01 * modes[1]


def test_modes_of_a_result(small_result: sm.Result) -> None:
    found = modes_of(small_result, [0, -1], 3)
    assert [one.state for one in found] == [0, len(small_result.positions) - 1]
    for one in found:
        assert one.checked and one.eigenvalues[0] > 0.0
        assert one.modes.shape == (3, len(small_result.mesh.nodes), 3)
        np.testing.assert_allclose(np.linalg.norm(one.modes, axis=2).max(axis=1), 1.0, rtol=1e-12)
    # Of the flat sheet they are all but out of the plane; its hinges feel strains a little.
    assert np.abs(found[0].modes[:, :, :2]).max() < 0.03


def test_modes_that_cannot_be(small_result: sm.Result) -> None:
    with pytest.raises(InputError, match="no such state"):
        modes_of(small_result, [99])
    with pytest.raises(InputError, match="so many modes"):
        modes_of(small_result, count=0)


def test_modes_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "small.toml"
    quiet = "[outputs]\npictures = false\nanimation = false\nreport = false\nseries = false\n"
    file.write_text(SMALL + quiet)
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--modes", "2"]) == 0
    assert "first bifurcation without load: none found" in capsys.readouterr().out
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))
    values = summary["stability"]["eigenvalues_N_per_m3"]
    result = sm.Result.load(tmp_path / "out")
    assert values == pytest.approx(modes_of(result, count=2)[0].eigenvalues, rel=1e-9)
    with h5py.File(tmp_path / "out" / "modes.h5") as stored:
        assert stored["modes"].shape == (len(result.positions), 2, len(result.mesh.nodes), 3)
        assert stored["eigenvalues"][-1] == pytest.approx(values)
