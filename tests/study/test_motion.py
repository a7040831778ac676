"""Motion of sheets: where it ends, how it vibrates, what becomes of its energy."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from moving import CANTILEVER, DENSITY, FORCE, HEIGHT, LENGTH, POKED, WIDTH, YOUNG, moving
from small import SMALL

import sheetmorph as sm
from sheetmorph.branches.search import find_branches
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import MomentReached, Progress
from sheetmorph.design.masses import node_masses
from sheetmorph.geometry.structured import disc
from sheetmorph.proofs.bilayer_disc import RADIUS, THICKNESS
from sheetmorph.proofs.sheets import nearest_node
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.solve.dynamic import move, start_of_motion
from sheetmorph.solve.eigen import Modes, smallest_modes
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.study.journal import Journal
from sheetmorph.study.ledger import Ledger
from sheetmorph.study.model import build_problem
from sheetmorph.study.motion import MovingSheet
from sheetmorph.study.stability import system_of

KNOWN = 1.8751040687**2 / (2 * np.pi) * np.sqrt(YOUNG * HEIGHT**2 / (12 * DENSITY * LENGTH**4))
"""Lowest frequency of the cantilever by Euler and Bernoulli [Hz]; its Poisson's ratio is 0."""


def balance(result: sm.Result) -> np.ndarray:
    """What the account of energy leaves unexplained in every row [J], the start left aside."""
    assert result.motion is not None
    h = result.motion.history
    stored = h["kinetic_J"] + h["elastic_J"]
    works = h["actuation_work_J"] + h["load_work_J"]
    return np.asarray(stored - stored[0] - works + h["damped_J"] + h["numerical_J"])


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_it_rests_in_the_quasi_static_shape(model: str) -> None:
    result = sm.simulate(moving(model))
    still = sm.simulate(moving(model).with_values({"solver.kind": "quasi_static"}))
    told = result.summary["motion"]
    assert result.status == "completed" and told["at_rest"] and result.summary["stable"]
    assert told["settled_by_m"] < 1e-4 * 0.04  # it was there but for a trace before it settled
    (turned,) = align_to_reference(result.positions[-1:], still.positions[-1])
    np.testing.assert_allclose(turned, still.positions[-1], atol=1e-10)
    for name, value in still.summary["energy_J"].items():
        assert result.summary["energy_J"][name] == pytest.approx(value, rel=1e-7, abs=1e-15)
    # The mass is that of both layers.
    areas = still.mesh.triangle_areas
    grams = 1050 * 0.3e-3 * areas.sum()
    grams += 1250 * 0.7e-3 * areas[result.triangle_in_pattern].sum()
    assert told["mass_kg"] == pytest.approx(grams)
    assert np.abs(balance(result)).max() < 1e-12 * result.motion.history["elastic_J"].max()


def swing(step: float, integrator: str = "trapezoidal", **more: object) -> sm.Result:
    values = {"time_step": f"{step} s", "integrator": integrator, **more}
    design = sm.Design.from_toml(CANTILEVER)
    return sm.simulate(design.with_values({f"solver.dynamic.{k}": v for k, v in values.items()}))


def tip(result: sm.Result) -> np.ndarray:
    node = nearest_node(result.mesh, (LENGTH, WIDTH / 2, 0.0))
    return np.asarray(result.positions[:, node, 2])


@pytest.fixture(scope="module")
def swung() -> sm.Result:
    """Eight half periods."""
    return swing(0.5e-3, end_time="250 ms")


def test_the_cantilever_has_its_frequency(swung: sm.Result) -> None:
    inertia = WIDTH * HEIGHT**3 / 12
    assert tip(swung)[0] == pytest.approx(FORCE * LENGTH**3 / (3 * YOUNG * inertia), rel=0.01)
    z, time = tip(swung), swung.motion.time
    crossings = np.flatnonzero(z[:-1] * z[1:] < 0)
    roots = time[crossings] - z[crossings] * np.diff(time)[crossings] / np.diff(z)[crossings]
    found = 0.5 / np.diff(roots).mean()
    assert found == pytest.approx(KNOWN, rel=0.01)


def test_the_trapezoidal_rule_keeps_the_energy_of_the_cantilever(swung: sm.Result) -> None:
    h = swung.motion.history
    energy = (h["kinetic_J"] + h["elastic_J"])[1:]  # the force is gone after the first step
    np.testing.assert_allclose(energy, energy[0], rtol=1e-4)
    assert h["kinetic_J"].max() > 0.9 * energy[0]
    assert np.abs(balance(swung)).max() < 1e-12 * energy[0]


@pytest.fixture(scope="module")
def mode() -> Modes:
    """The first mode of the cantilever, with its masses."""
    sheet = plucked(1e-3, "trapezoidal")
    return smallest_modes(sheet.static(0.0), sheet.problem.start, 1, weights=sheet.inertia.mass)


def plucked(step: float, integrator: str) -> MovingSheet:
    design = sm.Design.from_toml(CANTILEVER).with_values(
        {
            "solver.dynamic.time_step": f"{step} s",
            "solver.dynamic.integrator": integrator,
            "solver.dynamic.course.loads": [0, 0],
            "solver.dynamic.end_time": "20 ms",
        }
    )
    assert design.solver.dynamic is not None
    return MovingSheet.of(build_problem(design), design.solver.dynamic)


def test_the_first_mode_is_that_of_euler_and_bernoulli(mode: Modes) -> None:
    assert np.sqrt(mode.eigenvalues[0]) / (2 * np.pi) == pytest.approx(KNOWN, rel=0.01)


@pytest.mark.parametrize(
    ("integrator", "order", "longest"), [("implicit_euler", 1, 1e-3), ("trapezoidal", 2, 2e-3)]
)
def test_order_of_accuracy_on_the_cantilever(
    mode: Modes, integrator: str, order: int, longest: float
) -> None:
    # Pushed in its first mode, it is an oscillator: q = v0 sin(ωt)/ω.
    omega, push = float(np.sqrt(mode.eigenvalues[0])), 1e-3
    errors = []
    for step in (longest, longest / 2, longest / 4):
        sheet = plucked(step, integrator)
        rest, weighted = sheet.problem.start, sheet.inertia.mass * mode.vectors[0]
        start = start_of_motion(sheet.at, sheet.inertia, rest, sheet.options)
        start = replace(start, velocity=push * mode.vectors[0])
        ledger = Ledger(sheet.acting, sheet.inertia, sheet.problem.mesh.nodes.size)
        ledger.begin(start)
        end = move(sheet.at, sheet.static, sheet.inertia, start, sheet.options, account=ledger).last
        assert end.time == 0.02
        found = weighted @ (end.x - rest) / (weighted @ mode.vectors[0])
        errors.append(abs(found * omega / push - np.sin(omega * end.time)))
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    np.testing.assert_allclose(slopes, order, atol=0.1)


@pytest.mark.parametrize("damping", ["0 1/s", "30 1/s"])
def test_without_load_energy_only_falls(damping: str) -> None:
    result = swing(1e-3, "implicit_euler", damping=damping)
    h = result.motion.history
    energy = (h["kinetic_J"] + h["elastic_J"])[1:]
    assert (np.diff(energy) <= 1e-12 * energy[0]).all()
    # One mode alone: a step takes the share that it takes of an oscillator.
    omega = 2 * np.pi * 16.1
    slowest = 2 * np.log1p(omega**2 * 1e-6) / 2 * len(energy)
    assert energy[-1] < np.exp(-0.9 * slowest) * energy[0]
    assert (h["damped_J"][-1] > 0) == (damping != "0 1/s")


@pytest.fixture(scope="module")
def poked() -> sm.Result:
    mesh = disc(RADIUS, 6, quarter=True)
    strain = 4.0 * (THICKNESS / RADIUS) ** 2 * 2.0 / 3.0
    design = sm.Design.from_toml(POKED).with_values({"actuation.eps_pre": strain})
    return sm.simulate(design, mesh=mesh)


def test_a_snap_in_time(poked: sm.Result) -> None:
    h, time = poked.motion.history, poked.motion.history["time_s"]
    told = poked.summary["motion"]
    assert told["at_rest"] and poked.summary["stable"]
    along, across = (nearest_node(poked.mesh, place) for place in ((RADIUS, 0, 0), (0, RADIUS, 0)))
    before = int(np.searchsorted(poked.motion.time, 0.69))
    high, low = poked.positions[before, along, 2], poked.positions[before, across, 2]
    assert high > 3 * low > 0
    # It stays over when the force is gone: the mirror image, in the same energy.
    np.testing.assert_allclose(poked.positions[-1, [along, across], 2], [low, high], rtol=0.02)
    elastic = h["elastic_J"]
    assert elastic[-1] == pytest.approx(elastic[np.searchsorted(time, 0.69)], rel=1e-3)
    # The kinetic energy is that of the snap, and dies away.
    peak = time[h["kinetic_J"].argmax()]
    assert 0.7 < peak < 1.0
    assert h["kinetic_J"][-1] < 1e-6 * elastic.max()  # what counts as rest
    assert h["kinetic_J"][-1] < 1e-4 * told["kinetic_peak_J"]
    assert h["load_work_J"][-1] > 0
    assert np.abs(balance(poked)).max() < 1e-12 * elastic.max()


def test_the_other_shape_is_an_equilibrium_of_the_quasi_static_solver(poked: sm.Result) -> None:
    # The shape before the poke, mirrored at the diagonal, followed down by Newton alone.
    problem = build_problem(poked.design.with_values({"loads": None}), poked.mesh)
    before = int(np.searchsorted(poked.motion.time, 0.69))
    order = nearest_nodes(poked.mesh.nodes[:, [1, 0, 2]], poked.mesh.nodes)
    mirrored = poked.positions[before][order][:, [1, 0, 2]]
    start = np.concatenate([mirrored.ravel(), poked.scalars[-1]])
    system = system_of(problem).at(1.0, 0.0)
    found = minimise(system, start, NewtonOptions(problem.residual_tolerance, max_iterations=300))
    assert found.outcome is Outcome.CONVERGED and found.stable
    np.testing.assert_allclose(problem.positions(found.x), poked.positions[-1], atol=1e-8)


def nearest_nodes(places: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Index of the node nearest to each place."""
    return np.asarray(((nodes[:, None] - places[None]) ** 2).sum(axis=2).argmin(axis=1))


def test_a_motion_that_was_cut_off_goes_on_as_it_would_have(tmp_path: Path) -> None:
    design = moving(output_interval="50 ms")
    whole = sm.simulate(design)
    cut = design.with_values({"solver.max_steps": 41})
    part = sm.simulate(cut, journal=Journal.of_run(tmp_path))
    assert part.status == "too_many_steps" and part.summary["motion"]["steps"] == 41
    assert "max_steps" in part.summary["remedy"]
    again = sm.simulate(design, journal=Journal.of_run(tmp_path), resume=True)
    assert again.motion is not None and whole.motion is not None
    np.testing.assert_array_equal(again.positions, whole.positions)
    np.testing.assert_array_equal(again.motion.time, whole.motion.time)
    for name, column in whole.motion.history.items():
        np.testing.assert_array_equal(again.motion.history[name], column)
    with pytest.raises(InputError, match="another design"):
        sm.simulate(moving(), journal=Journal.of_run(tmp_path), resume=True)


def test_a_motion_is_kept_in_the_file(tmp_path: Path, poked: sm.Result) -> None:
    poked.save(tmp_path)
    again = sm.Result.load(tmp_path)
    assert again.motion is not None and poked.motion is not None
    np.testing.assert_array_equal(again.motion.time, poked.motion.time)
    np.testing.assert_array_equal(again.motion.velocity, poked.motion.velocity)
    assert again.motion.to_csv() == poked.motion.to_csv()
    assert (np.diff(again.motion.time) > 0).all()
    assert json.loads((tmp_path / "summary.json").read_text("utf-8"))["motion"]["at_rest"]


def test_it_tells_how_far_it_is() -> None:
    events: list[object] = []
    sm.simulate(moving(end_time="0.2 s"), on_event=events.append)
    times = [event.time for event in events if isinstance(event, MomentReached)]
    shares = [event.fraction for event in events if isinstance(event, Progress)]
    assert times[-1] == 0.2 and shares == sorted(shares) and 0.9 < shares[-1] <= 1.0


def test_at_the_end_time_it_may_still_move() -> None:
    result = sm.simulate(moving(end_time="0.5 s"))
    told = result.summary["motion"]
    assert result.status == "completed" and not told["at_rest"] and told["time_s"] == 0.5
    assert not result.summary["stable"] and result.ramp[-1] == 0.5


def test_a_free_sheet_keeps_its_centre_of_mass() -> None:
    result = sm.simulate(moving("laminate", end_time="0.4 s", damping="0 1/s"))
    weights = node_masses(result.mesh, result.regions)
    centres = np.einsum("v,svk->sk", weights, result.positions) / weights.sum()
    np.testing.assert_allclose(centres - centres[0], 0.0, atol=1e-8 * 0.04)


def test_what_cannot_move_is_refused() -> None:
    design = moving()
    for values, words in (
        ({"layers.0.density": None}, "density"),
        ({"solver.dynamic": None}, "time step"),
        ({"solver.dynamic.integrator": "trapezoidal", "solver.dynamic.damping": None}, "end_time"),
        ({"solver.dynamic.course.times": ["0 s", "2 s", "1 s"]}, "increase"),
        ({"solver.dynamic.course.times": ["1 s", "2 s", "3 s"]}, "increase"),
        ({"solver.dynamic.course.loads": [0, 1]}, "3 times"),
        ({"solver.dynamic.course.actuation": [0, 1, 1.5]}, "actuation"),
        ({"solver.dynamic.damping": "1 s"}, "rate"),
        ({"solver.dynamic.time_step": "0 s"}, "time_step"),
    ):
        with pytest.raises(InputError, match=words):
            design.with_values(values)
    with pytest.raises(InputError, match="follows equilibria"):
        sm.simulate(design, stops=[0.5])
    with pytest.raises(InputError, match="follows equilibria"):
        find_branches(design)


def test_hashes_of_designs_without_motion_are_what_they_were() -> None:
    plain = sm.Design.from_toml(SMALL)
    written = plain.with_values({"solver.kind": "quasi_static"})
    assert written.hash == plain.hash
    assert moving().hash != moving().with_values({"solver.kind": "quasi_static"}).hash
    assert moving().hash != moving(damping="3 1/s").hash
