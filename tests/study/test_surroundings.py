"""Sheets with weight, on a table, and in contact with themselves."""

from __future__ import annotations

import numpy as np
import pytest
from anew import Anew
from small import SMALL

from sheetmorph.branches.search import find_branches
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Event, Notice
from sheetmorph.design.spec import Design
from sheetmorph.geometry.crossings import crossing_pairs
from sheetmorph.study.design_keys import number_at
from sheetmorph.study.journal import Journal
from sheetmorph.study.model import build_problem
from sheetmorph.study.result import Result
from sheetmorph.study.sensitivity import Objective, sensitivities
from sheetmorph.study.simulate import simulate
from sheetmorph.study.stability import modes_of

HEAVY = SMALL.replace("young_modulus", 'density = "1100 kg/m^3"\nyoung_modulus')

STRIP = """
name = "strip"
model = "laminate"
[outline]
kind = "rectangle"
width = "30 mm"
height = "4 mm"
[[layers]]
name = "film"
role = "active"
thickness = "0.2 mm"
young_modulus = "0.9 MPa"
[[layers]]
name = "inert"
role = "inert"
thickness = "0.6 mm"
young_modulus = "2.7 MPa"
[actuation]
eps_pre = -0.2
profile = "uniform"
[contact]
self_contact = true
[mesh]
size = "2 mm"
"""

CANTILEVER = """
name = "cantilever"
model = "laminate"
[outline]
kind = "rectangle"
width = "40 mm"
height = "8 mm"
centre = ["20 mm", "0 mm"]
[[layers]]
name = "strip"
role = "inert"
thickness = "0.5 mm"
young_modulus = "400 MPa"
poisson_ratio = 0
density = "1100 kg/m^3"
[gravity]
magnitude = "9.81 m/s^2"
[perturbation]
total_force = "0 N"
[[supports]]
kind = "box"
x = ["0 mm", "0 mm"]
y = ["-4 mm", "4 mm"]
clamp = true
[mesh]
size = "2 mm"
"""


def crossings(result: Result) -> list[int]:
    return [len(crossing_pairs(state, result.mesh.triangles)) for state in result.positions]


@pytest.mark.parametrize(("orientation", "sign"), [("as_drawn", -1.0), ("turned_over", 1.0)])
def test_a_cantilever_sags_by_its_own_weight(orientation: str, sign: float) -> None:
    """w = q L⁴/(8 E I), which is 1 % of the length here."""
    result = simulate(
        Design.from_toml(CANTILEVER).with_values({"gravity.orientation": orientation})
    )
    load, rigidity, length = 1100 * 9.81 * 0.5e-3, 400e6 * 0.5e-3**3 / 12, 0.04
    tip = result.positions[-1][np.isclose(result.mesh.nodes[:, 0], length), 2].mean()
    assert tip == pytest.approx(sign * load * length**4 / (8 * rigidity), rel=2e-3)
    assert result.summary["weight_N"] == pytest.approx(load * length * 0.008, rel=1e-9)


def test_hanging_upright_stretches_by_its_weight() -> None:
    """The free end of a strip that hangs goes down by ρ g L²/(2 E)."""
    hanging = Design.from_toml(CANTILEVER).with_values(
        {"gravity.direction": [1, 0, 0], "layers.0.young_modulus": "0.2 MPa"}
    )
    result = simulate(hanging)
    moved = result.positions[-1] - result.mesh.nodes
    end = np.isclose(result.mesh.nodes[:, 0], 0.04)
    assert moved[end, 0].mean() == pytest.approx(1100 * 9.81 * 0.04**2 / (2 * 0.2e6), rel=0.03)


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_a_heavy_sheet_rests_on_a_table(model: str) -> None:
    design = Design.from_toml(HEAVY).with_values(
        {"model": model, "gravity.orientation": "turned_over", "contact.table": True}
    )
    result = simulate(design)
    told, table = result.summary, result.summary["table"]
    assert result.status == "completed"
    assert told["stable"]
    assert table["reaction_N"] == pytest.approx(told["weight_N"], rel=1e-6)
    assert 0.5 * 0.3e-3 < table["lowest_m"] < 0.5 * 0.3e-3 + table["range_m"]
    # The weight stays the same all the way: so does the reaction, once the sheet is laid down.
    problem = build_problem(design, result.mesh)
    for state, load in zip(result.positions, result.load_fraction, strict=True):
        assert problem.surroundings.table.heights(state).min() > 0.0
        if load == 1.0:
            forces = problem.surroundings.table.forces(state)
            assert forces.sum() == pytest.approx(told["weight_N"], rel=1e-4)  # by the tolerance
    # Nothing is left free but to slide: three rigid motions are none of the modes.
    assert modes_of(result, (-1,), 1)[0].eigenvalues[0] > 0.0


def test_the_sheet_comes_to_the_gap_as_the_range_goes_to_zero() -> None:
    base = Design.from_toml(HEAVY).with_values(
        {"model": "laminate", "gravity.orientation": "as_drawn", "contact.table": True}
    )
    rooms, heights = [], []
    for reach in ("0.1 mm", "0.03 mm", "0.01 mm"):
        result = simulate(base.with_values({"contact.range": reach}))
        rooms.append(result.summary["table"]["lowest_m"] - 0.15e-3)
        heights.append(result.summary["height_m"])
    assert rooms[0] > 2.0 * rooms[1] > 4.0 * rooms[2] > 0.0
    assert abs(heights[2] - heights[1]) < 0.5 * abs(heights[1] - heights[0])
    assert heights[2] == pytest.approx(heights[0], rel=2e-3)


def test_a_roll_converges_as_the_range_goes_to_zero() -> None:
    base, sizes = Design.from_toml(STRIP), []
    for reach in ("0.2 mm", "0.1 mm", "0.05 mm"):
        result = simulate(base.with_values({"contact.range": reach}))
        sizes.append(result.summary["bbox_m"][0])
    # The limit is approached in proportion to the range.
    assert (sizes[0] - sizes[1]) / (sizes[1] - sizes[2]) == pytest.approx(2.0, rel=0.1)


def test_a_held_sheet_drapes_over_a_table_below_it() -> None:
    """A soft strip, clamped 2 mm above a table, sags until its end lies on it."""
    base = Design.from_toml(CANTILEVER).with_values({"layers.0.young_modulus": "2 MPa"})
    hanging = simulate(base)
    assert hanging.positions[-1][:, 2].min() < -10e-3
    draped = simulate(base.with_values({"contact.table": True, "contact.table_distance": "2 mm"}))
    table = draped.summary["table"]
    assert draped.status == "completed"
    assert table["nodes_in_contact"] > 5
    assert 0.25e-3 < table["lowest_m"] < 0.25e-3 + table["range_m"]
    assert 0.0 < table["reaction_N"] < draped.summary["weight_N"]


@pytest.fixture(scope="module")
def rolled() -> Result:
    return simulate(Design.from_toml(STRIP))


@pytest.fixture(scope="module")
def off() -> Result:
    """The same strip without contact; its run tells what it has found."""
    told: list[Event] = []
    result = simulate(
        Design.from_toml(STRIP).with_values({"contact.self_contact": False}), on_event=told.append
    )
    result.summary["told"] = [event.text for event in told if isinstance(event, Notice)]
    return result


def test_a_rolling_strip_never_passes_through_itself(rolled: Result, off: Result) -> None:
    """Without contact the same strip does, from a full turn on; with it no state does."""
    assert off.status == "completed"
    assert crossings(off)[-1] == off.summary["crossing_pairs"] > 10
    assert rolled.status == "completed"
    assert rolled.summary["stable"]
    assert crossings(rolled) == [0] * len(rolled.positions)
    neighbours, far = rolled.summary["self_contact"]
    assert not neighbours["touches"]
    assert far["touches"]
    assert 0.0 < far["room_m"] < far["range_m"]
    assert far["gap_m"] == pytest.approx(0.8e-3)
    assert rolled.summary["energy_J"]["self_contact"] > 0.0


def test_before_anything_touches_contact_changes_nothing(rolled: Result, off: Result) -> None:
    early = (rolled.ramp < 0.6) & (rolled.load_fraction == 1.0)
    assert early.sum() > 5
    count = int(early.sum())
    np.testing.assert_allclose(rolled.positions[:count], off.positions[:count], atol=1e-10)


def test_a_run_in_contact_goes_on_bit_for_bit(rolled: Result, tmp_path) -> None:
    journal = Journal.of_run(tmp_path)
    design = Design.from_toml(STRIP)
    cut = simulate(
        design.with_values({"solver.max_steps": len(rolled.positions) - 3}), journal=journal
    )
    assert cut.status == "too_many_steps"
    assert len(cut.positions) < len(rolled.positions)
    whole = simulate(design, journal=journal, resume=True)
    assert np.array_equal(whole.positions, rolled.positions)


def test_a_search_that_fails_is_a_status_and_keeps_states_that_do_not_cross() -> None:
    result = simulate(
        Design.from_toml(STRIP).with_values(
            {"solver.max_iterations": 2, "solver.min_step": 0.05, "solver.initial_step": 0.05}
        )
    )
    assert result.status == "step_too_small"
    assert result.summary["remedy"]
    assert sum(crossings(result)) == 0


def test_a_sheet_that_crosses_is_told_without_contact(off: Result) -> None:
    (notice,) = off.summary["told"]
    assert f"{off.summary['crossing_pairs']} pairs of triangles" in notice
    assert "contact.self_contact = true" in notice


def test_branches_are_refused_with_weight_and_contact() -> None:
    for text in (STRIP, CANTILEVER):
        with pytest.raises(InputError, match="without weight and contact"):
            find_branches(Design.from_toml(text))


def ends_apart(result: Result) -> Objective:
    """Half the squared distance of the two ends of a strip."""
    along = result.mesh.nodes[:, 0]
    first, last = int(along.argmin()), int(along.argmax())

    def objective(positions: np.ndarray) -> tuple[float, np.ndarray]:
        across = positions[first] - positions[last]
        slope = np.zeros_like(positions)
        slope[first], slope[last] = across, -across
        return 0.5 * float(across @ across), slope

    return objective


def test_sensitivities_of_a_state_in_contact(rolled: Result) -> None:
    """By the adjoint with what has grown, and by running twice."""
    objective = ends_apart(rolled)
    key, step = "layers.0.eigenstrain_factor", 2e-4
    found = sensitivities(rolled, objective, [key]).keys[key]
    values = []
    for sign in (1.0, -1.0):
        moved = simulate(Design.from_toml(STRIP).with_values({key: 1.0 + sign * step}))
        values.append(objective(moved.positions[-1])[0])
    assert found == pytest.approx((values[0] - values[1]) / (2.0 * step), rel=2e-3)


def test_keys_that_move_the_barriers_of_contact(rolled: Result) -> None:
    """The film's thickness is the gap, and its rigidity the measure of the forces."""
    anew = Anew(rolled, objective := ends_apart(rolled))
    keys = ["layers.0.thickness", "layers.1.young_modulus", "actuation.eps_pre"]
    values = {key: number_at(rolled.design, key) for key in keys}
    found = sensitivities(rolled, objective, keys, fields=()).keys
    for key, value in values.items():
        expected = anew.slope({key: value}, {key: value}) / value
        assert found[key] == pytest.approx(expected, rel=1e-4)
