"""The whole search on small meshes: hidden designs found again, cut off and gone on with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sheetmorph.compare.pose import Similarity
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Event, Progress
from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import FAMILIES, Space, space_of
from sheetmorph.inverse.find import SearchOptions, find_design
from sheetmorph.inverse.journal import Journal
from sheetmorph.inverse.limits import Limits
from sheetmorph.inverse.misfit import Evaluation, Job, Measure, lay, shape_of
from sheetmorph.inverse.result import Found
from sheetmorph.inverse.search_global import siblings
from sheetmorph.inverse.search_gradient import slide
from sheetmorph.inverse.targets import Target
from sheetmorph.study.simulate import simulate

MESH = {"mesh.size": "11 mm"}
FIXED = {"radius": 0.9, "size": 0.1}
HIDDEN = (0.3, -0.35)
"""Width of the ring and eps_pre."""


def ring() -> Space:
    return space_of(FAMILIES["ring"], 0.08, Limits(), fixed=FIXED, overrides=MESH)


@pytest.fixture(scope="module")
def target() -> Target:
    """The shape of the hidden design, turned over and moved away."""
    shape = shape_of(simulate(ring().design(HIDDEN, "hidden")))
    turn = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
    surface = shape.moved(Similarity(1.0, turn, np.array([0.1, -0.2, 0.3])))
    return Target("hidden", surface, "hidden")


def options(**values: object) -> SearchOptions:
    usual = SearchOptions(
        families=("ring",), budget=12, descents=1, accuracy=4.5e-3, fixed=FIXED, overrides=MESH
    )
    return replace(usual, **values)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def found(target: Target, tmp_path_factory: pytest.TempPathFactory) -> tuple[Found, Path]:
    journal = tmp_path_factory.mktemp("whole") / "evaluations.jsonl"
    return find_design(target, options(), journal=journal), journal


def test_a_hidden_design_is_found_again(found: tuple[Found, Path]) -> None:
    best = found[0]
    assert best.distance < 5e-3  # width and eps_pre do alike, so that neither is known as well
    assert best.made is not None
    assert best.made.broken == ()
    data = best.to_json()
    assert data["status"] == "completed"
    assert data["found"]["aspect_ratio"] == pytest.approx(data["wanted"]["aspect_ratio"], rel=0.02)
    assert data["evaluations"] == best.fresh
    steps = [one.misfit for one in best.steps if one.family == "ring, fine"]
    assert steps == sorted(steps, reverse=True)


@pytest.mark.slow
def test_a_search_that_was_cut_off_ends_as_the_whole_one(
    target: Target, found: tuple[Found, Path], tmp_path: Path
) -> None:
    whole, journal = found
    cut = tmp_path / "evaluations.jsonl"
    seen = []

    def stop(event: Event) -> None:
        if isinstance(event, Progress):
            seen.append(event)
            if len(seen) == 9:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        find_design(target, options(), journal=cut, on_event=stop)
    before = len(cut.read_text("utf-8").splitlines()) - 1
    with cut.open("a", encoding="utf-8") as stream:
        stream.write('{"job": {"family": "ri')  # killed while it wrote
    again = find_design(target, options(), journal=cut, resume=True)
    assert 9 <= before < whole.evaluations
    assert again.fresh == whole.evaluations - before
    assert again.values == whole.values
    assert again.distance == whole.distance
    assert [one.misfit for one in again.steps] == [one.misfit for one in whole.steps]
    once = len(journal.read_text("utf-8").splitlines())
    assert len(cut.read_text("utf-8").splitlines()) == once  # nothing was measured twice


def test_a_journal_of_another_search_is_refused(
    target: Target, found: tuple[Found, Path], tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="another target or other options"):
        find_design(target, options(seed=1), journal=found[1], resume=True)
    with pytest.raises(InputError, match="no unfinished search"):
        find_design(target, options(), journal=tmp_path / "none.jsonl", resume=True)
    damaged = tmp_path / "damaged.jsonl"
    lines = found[1].read_text("utf-8").splitlines()
    damaged.write_text("\n".join([lines[0], lines[1].replace("0.", "x.")]) + "\n", "utf-8")
    with pytest.raises(InputError, match="line 2"):
        find_design(target, options(), journal=damaged, resume=True)


def test_exact_derivatives_lead_downhill(target: Target) -> None:
    space = ring()
    measure = Measure(target.surface, {"ring": space})
    told: list[tuple[Job, Evaluation]] = []
    evaluations = Evaluations(
        measure, Journal(None, ""), on_new=lambda job, one: told.append((job, one))
    )
    start = evaluations(Job("ring", (0.2, -0.25)))
    end = slide(evaluations, space, start)
    squares = [one.misfit for job, one in told if job.slopes]
    assert min(squares) < 0.3 * squares[0]
    assert abs(end.point[1] - HIDDEN[1]) < abs(start.point[1] - HIDDEN[1])


def test_slopes_are_those_of_differences(target: Target) -> None:
    measure = Measure(target.surface, {"ring": ring()})
    here = measure.evaluate(Job("ring", (0.25, -0.3), slopes=True))
    for k, h in ((0, 2e-3), (1, 2e-3)):
        moved = [np.array(here.point) + s * h * np.eye(2)[k] for s in (1, -1)]
        ahead, behind = (
            measure.evaluate(Job("ring", tuple(one.tolist()), near=here.pose, slopes=True)).misfit
            for one in moved
        )
        assert (ahead - behind) / (2 * h) == pytest.approx(here.residuals[k], rel=0.05)


def test_every_choice_of_whole_numbers_is_tried() -> None:
    space = space_of(FAMILIES["star"], 0.08, Limits())
    asked: list[Job] = []

    class Nothing:
        def evaluate(self, job: Job) -> Evaluation:
            asked.append(job)
            return Evaluation(job.family, job.point, 0.5)

    best = Evaluation("star", (0.1, 5.0, 0.7, 0.1, 0.1, -0.4), 0.1)
    siblings(Evaluations(Nothing(), Journal(None, "")), space, best)
    assert [job.point[1] for job in asked] == [3.0, 4.0, 6.0, 7.0, 8.0]
    assert {job.point[2:] for job in asked} == {best.point[2:]}


def test_limits_make_a_misfit_worse(target: Target) -> None:
    limits = Limits(most_inert=0.2)
    space = space_of(FAMILIES["ring"], 0.08, limits, fixed=FIXED, overrides=MESH)
    strict = Measure(target.surface, {"ring": space}).evaluate(Job("ring", HIDDEN))
    loose = Measure(target.surface, {"ring": ring()}).evaluate(Job("ring", HIDDEN))
    assert strict.distance == loose.distance
    assert strict.misfit > loose.misfit + 0.05


def test_a_target_lies_on_itself_in_any_pose_but_not_mirrored(target: Target) -> None:
    shape = shape_of(simulate(ring().design(HIDDEN, "hidden")))
    assert lay(target.surface, shape, 1.0).distance < 2e-4
    larger = shape.moved(Similarity(1.5, np.eye(3), np.zeros(3)))
    free = lay(target.surface, larger, None)
    assert free.pose.scale == pytest.approx(1.5, rel=1e-3)
    assert not free.pose.mirrors


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"families": ("stars",)}, ["--family", "star", "lotus"]),
        ({"fixed": {"radius": 2.0}}, ["--fix radius", "0.6 to 1"]),
        ({"fixed": {"arms": 6.0}}, ["--fix", "radius"]),
    ],
)
def test_bad_options_are_told(target: Target, values: dict[str, object], words: list[str]) -> None:
    with pytest.raises(InputError) as error:
        find_design(target, options(**values))
    assert all(word in str(error.value) for word in words)
