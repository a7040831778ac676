"""The search for shapes, on sheets whose shapes are known."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image
from small import SMALL

import sheetmorph as sm
from sheetmorph.branches.barriers import with_barriers
from sheetmorph.branches.result import Branches
from sheetmorph.branches.sameness import MIRROR, Sameness, may_turn_over, turned_over
from sheetmorph.branches.search import SearchOptions, find_branches
from sheetmorph.branches.seeds import (
    inverted_sectors,
    random_loads,
    sector_shares,
    sets_of_sectors,
)
from sheetmorph.branches.walk import bifurcations, unperturbed_path
from sheetmorph.cli import main
from sheetmorph.core.errors import InputError
from sheetmorph.design.presets import preset_text
from sheetmorph.geometry.surface import dihedral_angles
from sheetmorph.geometry.symmetry import node_images
from sheetmorph.proofs.bilayer_disc import DiscSheet
from sheetmorph.solve.critical import stationary
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.stability import negative_eigenvalues
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.stability import first_bifurcation, system_of

NATURAL = 2.0
FEW = SearchOptions(modes=1, sectors=False, random=2)


@pytest.fixture(scope="module")
def sheet() -> DiscSheet:
    """A quarter of a bilayer disc."""
    return DiscSheet.of(6, NATURAL, lens=False, quarter=True)


@pytest.fixture(scope="module")
def of_the_disc(sheet: DiscSheet) -> Branches:
    return find_branches(sheet.problem.design, FEW, mesh=sheet.problem.mesh)


def test_the_two_states_of_the_bistable_disc(sheet: DiscSheet, of_the_disc: Branches) -> None:
    """Rolled about x or about y, mirror images of each other; the dish between is a saddle."""
    rolled, dish = of_the_disc.branches
    assert rolled.stable and not dish.stable and dish.negative == 1
    assert dish.eigenvalue < 0.0 < rolled.eigenvalue
    images = {one.image for one in of_the_disc.seeds_of(rolled.number)}
    assert images == {"", "mirrored at the line at 45°"}
    kicks = [one for one in of_the_disc.attempts if one.kind == "bifurcation"]
    assert len(kicks) == 2 and kicks[0].image != kicks[1].image
    settled = sheet.settled(NATURAL, sheet.saddled(sheet.problem.start))
    known = sheet.system.at(1.0, 0.0).value(settled)
    assert rolled.energy == pytest.approx(known, rel=1e-9)
    curvatures = sheet.curvatures(dish.x)
    assert curvatures[0] == pytest.approx(curvatures[1], rel=1e-6)
    assert all(one.branch is not None for one in of_the_disc.attempts)


def test_the_bifurcation_of_the_disc(sheet: DiscSheet, of_the_disc: Branches) -> None:
    known = first_bifurcation(sheet.problem, system=sheet.system)
    assert known is not None
    ((ramp, before, beyond),) = of_the_disc.bifurcations
    assert ramp == pytest.approx(known.ramp, rel=2e-4)
    assert (before, beyond) == (0, 1) and of_the_disc.followed == 1.0


def test_up_and_down_bowls_are_mirror_images() -> None:
    """Without coupling the published model cannot tell up from down."""
    design = sm.Design.from_toml(SMALL).with_values({"published.coupling": 0.0})
    found = find_branches(design, SearchOptions(modes=1, sectors=False, random=0))
    bowl = found.branches[0]
    images = {one.image for one in found.seeds_of(1)}
    assert bowl.stable and "" in images and MIRROR in images
    runs = {one.kind: one for one in found.attempts}
    assert runs["perturbation"].image == "" and runs["opposite perturbation"].image == MIRROR
    problem = build_problem(design, found.result.mesh)
    energy = problem.total.at(1.0, 0.0)
    up, down = (energy.evaluate(x, 1) for x in (bowl.x, turned_over(problem, bowl.x)))
    assert up[0] == pytest.approx(down[0], rel=1e-12)
    # At both ends it is an equilibrium.
    assert np.abs(system_of(problem).at(1.0, 0.0).gradient(bowl.x)[1]).max() < 1e-12
    held = problem.held_dofs
    assert np.abs(down[1][~held]).max() < 1e-12


def test_with_coupling_up_and_down_are_two_shapes() -> None:
    found = find_branches(sm.Design.from_toml(SMALL), SearchOptions(modes=0, random=2, seed=0))
    assert len(found.branches) >= 2 and all(one.stable for one in found.branches[:2])
    low, high = found.branches[:2]
    assert low.energy < high.energy
    radii = np.linalg.norm(found.result.mesh.nodes, axis=1)
    rim, middle = radii > 0.95 * radii.max(), radii < 0.2 * radii.max()
    rises = [one.positions[rim, 2].mean() - one.positions[middle, 2].mean() for one in (low, high)]
    assert rises[0] * rises[1] < 0.0
    assert not any(MIRROR in name for name in found.images)


@pytest.mark.parametrize(
    ("values", "allowed"),
    [
        ({"published.coupling": 0.0}, True),
        ({}, False),
    ],
)
def test_whether_a_sheet_may_be_turned_over(values: dict[str, object], allowed: bool) -> None:
    problem = build_problem(sm.Design.from_toml(SMALL).with_values(values))
    assert may_turn_over(problem, system_of(problem)) is allowed


def test_layers_tell_up_from_down() -> None:
    problem = DiscSheet.of(4, 1.0, lens=False, quarter=True).problem
    assert not may_turn_over(problem, system_of(problem))


def test_images_of_a_shape_are_the_same_shape() -> None:
    """On a mesh of the symmetry, a state that is moved by a map lies at no distance."""
    design = sm.Design.from_toml(SMALL).with_values({"mesh.symmetry": "auto"})
    problem = build_problem(design)
    same = Sameness.of(problem, system_of(problem))
    nodes, group = problem.mesh.nodes, design.symmetry
    assert len(same.images) == group.elements == 6
    state = nodes + 1e-3 * np.random.default_rng(0).standard_normal(nodes.shape)
    images = node_images(nodes, group, 1e-9)
    for k, image in enumerate(same.images):
        moved = np.empty_like(state)
        moved[images[k]] = same.centre + (state - same.centre) @ image.matrix.T
        apart, name = same.distance(state, moved)
        assert apart < 1e-9 and name == image.name
    other = state + 1e-3 * np.random.default_rng(1).standard_normal(nodes.shape)
    assert same.distance(state, other)[0] > 0.01


@pytest.mark.parametrize(("order", "kinds"), [(2, 1), (3, 2), (4, 4), (6, 11)])
def test_sets_of_sectors_are_the_bracelets(order: int, kinds: int) -> None:
    """Bracelets of two colours, without the two of one colour: 3, 4, 6 and 13 less 2."""
    found = sets_of_sectors(order)
    assert len(found) == len(set(found)) == kinds
    assert all(0 < len(chosen) < order for chosen in found)


def test_an_inverted_sector(small_result: sm.Result) -> None:
    problem = build_problem(small_result.design, small_result.mesh)
    nodes, x = problem.mesh.nodes, small_result.positions[-1].ravel()
    share = sector_shares(problem)
    assert share.shape == (3, len(nodes))
    assert (share.sum(axis=0) <= 1.0 + 1e-12).all() and (share.max(axis=1) == 1.0).all()
    moved = problem.positions(inverted_sectors(problem, x, (1,)))
    before = problem.positions(x)
    level = before[np.linalg.norm(nodes, axis=1).argmin(), 2]
    inside, outside = share[1] == 1.0, share[1] == 0.0
    np.testing.assert_allclose(moved[inside, 2], 2 * level - before[inside, 2], atol=1e-15)
    np.testing.assert_allclose(moved[outside], before[outside], atol=1e-15)
    np.testing.assert_array_equal(moved[:, :2], before[:, :2])


@pytest.mark.slow
def test_each_lobe_of_the_stiff_bowl_can_be_inverted() -> None:
    """With the printed form of the stretching stiffness the outer half of one arm of six stays
    bent to the other side; with that of the published code it turns back."""
    for form, stays in (("printed", True), ("scaled_by_edge_length", False)):
        values = {
            "mesh.size": "4 mm",
            "mesh.symmetry": "auto",
            "published.stretch_stiffness": form,
        }
        design = sm.Design.from_toml(preset_text("bowl")).with_values(values)
        result = sm.simulate(design)
        problem = build_problem(design, result.mesh)
        here = system_of(problem).at(1.0, 0.0)
        options = NewtonOptions(problem.residual_tolerance, max_iterations=1000)
        start = result.positions[-1].ravel()
        before = turns_of_arms(result, start)
        assert (before > 0.0).all()
        found = minimise(here, inverted_sectors(problem, start, (2,)), options)
        assert found.outcome is Outcome.CONVERGED
        assert negative_eigenvalues(here, found.x) == 0
        after = turns_of_arms(result, found.x)
        assert (after[2] < 0.0) == stays
        assert (np.delete(after, 2) > 0.0).all()


def turns_of_arms(result, x: np.ndarray) -> np.ndarray:
    """How far the outer half of each arm of the bowl turns up [rad], shape (6,)."""
    mesh = result.mesh
    inside = np.zeros(len(mesh.nodes), dtype=bool)
    inside[mesh.triangles[result.triangle_in_pattern]] = True
    positions = x[: mesh.nodes.size].reshape(-1, 3)
    turns = []
    for angle in np.arange(6) * np.pi / 3.0:
        outward = np.array([np.cos(angle), np.sin(angle), 0.0])
        across = mesh.nodes @ np.array([-outward[1], outward[0], 0.0])
        along = mesh.nodes @ outward / np.linalg.norm(mesh.nodes, axis=1).max()
        arm = inside & (np.abs(across) < 6e-3)
        places = [
            positions[arm & (along > r) & (along < r + 0.15)].mean(axis=0)
            for r in (0.4, 0.57, 0.74)
        ]
        steps = np.diff(places, axis=0)
        slopes = np.arctan2(steps[:, 2], steps @ outward)
        turns.append((slopes[1] - slopes[0] + np.pi) % (2.0 * np.pi) - np.pi)
    return np.array(turns)


def test_random_loads_are_those_of_their_seeds(sheet: DiscSheet) -> None:
    a, b = (random_loads(sheet.problem, sheet.system, 2, seed) for seed in (3, 4))
    forces = [one.system.energy.force for one in (*a, *b)]
    np.testing.assert_array_equal(forces[1], forces[2])
    assert not np.array_equal(forces[0], forces[1])
    assert not forces[0][sheet.problem.held_dofs].any()
    # The flat sheet would rise by 2 % of its size.
    flat = sheet.system.at(0.0, 0.0)
    assert flat.factorise(flat.hessian(sheet.problem.start)[2])
    rise = np.abs(flat.solve(forces[0])[: sheet.problem.mesh.nodes.size]).max()
    assert rise == pytest.approx(0.02 * sheet.problem.mesh.size, rel=1e-9)


def test_every_bifurcation_of_a_flat_sheet() -> None:
    """Without coupling the sheet may stay flat; eigenvalues pass zero one after another."""
    values = {"published.coupling": 0.0, "actuation.eps_pre": -0.7}
    problem = build_problem(sm.Design.from_toml(SMALL).with_values(values))
    system = system_of(problem)
    path = unperturbed_path(problem, system)
    places = bifurcations(problem, system, path, most=2)
    assert len(places) == 2
    assert places[0].before == 0 and places[1].before >= len(places[0].modes)
    for place in places:
        flat = problem.positions(place.beyond.x)[:, 2]
        assert np.abs(flat).max() < 1e-9
        # On either side of the place the count is another.
        counts = []
        for ramp in (0.999 * place.ramp, 1.001 * place.ramp):
            near = min(path, key=lambda s: abs(s.ramp - place.ramp))
            here = system.at(ramp, 0.0)
            x = stationary(here, near.x, problem.residual_tolerance)
            assert x is not None
            counts.append(here.factorise_indefinite(here.hessian(x)[2]))
        assert counts[1] > counts[0]


@pytest.mark.parametrize("values", [{"modes": -1}, {"random": 10_000}, {"tolerance": 0.0}])
def test_options_that_cannot_be(values: dict[str, float]) -> None:
    with pytest.raises(InputError, match="out of range"):
        SearchOptions(**values)  # type: ignore[arg-type]


def test_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")
    file, out = tmp_path / "small.toml", tmp_path / "out"
    file.write_text(SMALL)
    arguments = [
        "branches",
        str(file),
        "-o",
        str(out),
        "--modes",
        "0",
        "--random",
        "0",
        "--no-sectors",
    ]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    assert "stable" in text and "above the lowest" in text
    data = json.loads((out / "branches.json").read_text("utf-8"))
    with h5py.File(out / "branches.h5") as states:
        count = len(data["branches"])
        assert states["positions"].shape[0] == count >= 2
        assert list(states["energy"]) == [one["energy_J"] for one in data["branches"]]
    with Image.open(out / "branches.png") as picture:
        assert picture.size[0] >= 600
    assert main(arguments) == 2
    assert "--force" in capsys.readouterr().err
    assert main([*arguments, "--force", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["branches"] == data["branches"]


def test_the_barrier_of_the_disc_is_its_dish(of_the_disc: Branches) -> None:
    """Between the two rolls of a quarter the lowest way leads over the dish."""
    rolled, dish = of_the_disc.branches
    (barrier,) = with_barriers(of_the_disc, 3).barriers
    assert (barrier.first, barrier.second) == (1, 1)
    assert barrier.image == "mirrored at the line at 45°"
    assert barrier.converged and barrier.connects and barrier.negative == 1
    assert barrier.height == pytest.approx(dish.energy - rolled.energy, rel=1e-6)
    assert barrier.back == pytest.approx(barrier.height, rel=1e-6)


@pytest.mark.slow
def test_the_barrier_between_two_bowls() -> None:
    """The saddle lies above both."""
    found = find_branches(
        sm.Design.from_toml(SMALL), SearchOptions(modes=0, sectors=False, random=0)
    )
    low, high = (one for one in found.branches if one.stable)
    (barrier,) = with_barriers(found, 1).barriers
    assert (barrier.first, barrier.second, barrier.image) == (low.number, high.number, "")
    assert barrier.converged and barrier.negative == 1
    assert barrier.height > high.energy - low.energy > 0.0
    assert barrier.height - barrier.back == pytest.approx(high.energy - low.energy, rel=1e-6)


def test_shapes_that_lean_on_a_guard_are_none_of_the_sheet() -> None:
    """Kicks fold the coarse petals along a few edges, where only the guard holds them."""
    design = sm.Design.from_toml(preset_text("petals", "petals"))
    found = find_branches(design, SearchOptions(modes=2, random=0))
    assert [one.stable for one in found.branches] == [True, True]
    ended = {one.status for one in found.attempts if one.branch is None}
    assert "leans on a guard" in ended
    for one in found.branches:
        angles = dihedral_angles(one.positions, found.result.mesh.hinges)
        assert np.abs(angles).max() < np.radians(60.0)


def test_where_the_run_itself_leans_on_a_guard_others_are_kept_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")
    monkeypatch.setattr(Problem, "held_open", lambda _problem, _positions: {"folds": 1})
    file, out = tmp_path / "small.toml", tmp_path / "out"
    file.write_text(SMALL)
    options = ("--modes", "0", "--random", "0", "--no-sectors")
    assert main(["branches", str(file), "-o", str(out), *options]) == 0
    text = capsys.readouterr().out
    shapes = json.loads((out / "branches.json").read_text("utf-8"))["branches"]
    assert [one["places_held_by_guards"] for one in shapes] == [1] * len(shapes)
    assert len(shapes) >= 2
    assert text.count("leans on a guard in a place") == len(shapes)
    with h5py.File(out / "branches.h5") as states:
        assert list(states["guarded"]) == [1] * len(shapes)
