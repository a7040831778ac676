"""The sweep file: which designs it asks for, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest
from many import STARS, written
from scipy.stats import qmc
from small import SMALL

import sheetmorph as sm
from sheetmorph.design.families import random_kirigami
from sheetmorph.sweep.plan import Plan


def test_a_grid_combines_all_with_all(tmp_path: Path) -> None:
    plan = Plan.load(written(tmp_path))
    assert len(plan) == 4
    inputs = [tuple(plan.task(k).inputs.values()) for k in range(4)]
    assert inputs == [
        (-0.1, 0.0005, 0.005),
        (-0.1, 0.0009, 0.005),
        (-0.2, 0.0005, 0.005),
        (-0.2, 0.0009, 0.005),
    ]
    design = plan.task(3).make()
    assert design.eps_pre == -0.2
    assert design.layers[1].thickness == 0.9e-3
    ids = [plan.task(k).id for k in range(4)]
    assert len(set(ids)) == 4
    assert [Plan.load(written(tmp_path)).task(k).id for k in range(4)] == ids


def test_lists_go_side_by_side_and_samples_vary_fastest(tmp_path: Path) -> None:
    text = """
design = "small.toml"
[list]
actuation.eps_pre = [-0.1, -0.3]
mesh.size = ["4 mm", "5 mm"]
[samples]
count = 3
seed = 5
[samples.bounds]
layers.print.thickness = { from = "0.5 mm", to = "1 mm" }
"""
    plan = Plan.load(written(tmp_path, text))
    assert len(plan) == 6
    assert [plan.task(k).inputs["actuation.eps_pre"] for k in range(6)] == 3 * [-0.1] + 3 * [-0.3]
    assert [plan.task(k).inputs["mesh.size"] for k in range(6)] == 3 * [0.004] + 3 * [0.005]
    shares = qmc.Sobol(1, rng=5).random_base2(2)[:3, 0]
    found = [plan.task(k).inputs["layers.print.thickness"] for k in range(3)]
    assert found == pytest.approx(0.0005 + 0.0005 * shares, rel=1e-11)
    assert found == [plan.task(k).inputs["layers.print.thickness"] for k in range(3, 6)]


def test_a_latin_hypercube_has_one_design_in_every_stripe(tmp_path: Path) -> None:
    text = STARS.replace('["0.5 mm", "0.9 mm"]', '["0.5 mm"]') + (
        '[samples]\nmethod = "latin_hypercube"\ncount = 10\nseed = {seed}\n'
        "[samples.bounds]\n"
        'layers.film.thickness = {{ from = "0.2 mm", to = "0.3 mm" }}\n'
        "pattern.0.arms = {{ from = 3, to = 12, whole = true }}\n"
    )
    first, again, other = (
        Plan.load(written(tmp_path, text.format(seed=seed))) for seed in (1, 1, 2)
    )
    for plan in (first, other):
        rows = [plan.task(k).inputs for k in range(10)]
        assert sorted(int((row["layers.film.thickness"] - 2e-4) / 1e-5) for row in rows) == list(
            range(10)
        )
        assert sorted(row["pattern.0.arms"] for row in rows) == list(range(3, 13))
    assert first.fingerprint == again.fingerprint != other.fingerprint


def test_families_take_seeds_and_arguments(tmp_path: Path) -> None:
    text = """
[family]
kind = "random_kirigami"
sheet_radius = "25 mm"
polygons = 1
[list]
family.seed = { from = 3, to = 5, step = 1 }
[grid]
family.line_width = ["3 mm", "4 mm"]
actuation.eps_pre = [-0.25]
"""
    plan = Plan.load(written(tmp_path, text))
    assert len(plan) == 6
    task = plan.task(5)
    assert task.inputs == {"family.seed": 5, "family.line_width": 0.004, "actuation.eps_pre": -0.25}
    expected = random_kirigami(5, sheet_radius=0.025, polygons=1, line_width=0.004)
    assert task.make().hash == expected.with_values({"actuation.eps_pre": -0.25}).hash


def test_quoted_keys_and_set_values(tmp_path: Path) -> None:
    file = written(tmp_path, 'design = "small.toml"\n[grid]\n"actuation.eps_pre" = [-0.1]\n')
    plan = Plan.load(file, {"mesh.size": "4 mm"})
    assert plan.task(0).make().spec.mesh.size == 0.004
    assert plan.fingerprint != Plan.load(file).fingerprint


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["nothing varies"]),
        (SMALL, ["this is a design", 'design = "stars.toml"']),
        ("[grid]\na.b = [1]", ["design", "family"]),
        ('design = "small.toml"', ["nothing varies"]),
        ('design = "../small.toml"\n[grid]\na.b = [1]', ["leads out"]),
        ('design = "/etc/passwd"\n[grid]\na.b = [1]', ["leads out"]),
        ('design = "none.toml"\n[grid]\na.b = [1]', ["no such file"]),
        ("design = 3\n[grid]\na.b = [1]", ["name of a design file"]),
        (STARS + "[grids]", ["grids", "did you mean grid"]),
        (STARS + "[list]\nactuation.eps_pre = [1]", ["actuation.eps_pre", "twice"]),
        (STARS + '[list]\n"layers[1].x" = [1]\n"layers.1.x" = [1]', ["layers.1.x", "twice"]),
        (STARS.replace("eps_pre", "eps_pro"), ["none of 4", "eps_pro"]),
        (STARS + "[list]\nmesh.a = [1]\nmesh.b = [1, 2]", ["side by side"]),
        (STARS + "[family]", ["either"]),
        (STARS + "[list]\nfamily.seed = [1]", ["family.seed", "no family"]),
        (STARS + "[samples]\ncount = 4", ["samples.bounds"]),
        (STARS + "[samples]\ncount = 0\n[samples.bounds]\na = {from=0,to=1}", ["samples.count"]),
        (
            STARS + "[samples]\ncount = 4\nmethod='x'\n[samples.bounds]\na = {from=0,to=1}",
            ["sobol"],
        ),
        (STARS + "[samples]\ncount = 9\nseed = -1\n[samples.bounds]\na = {from=0,to=1}", ["seed"]),
        (STARS + "a = {from=0,to=1000,step=1}\nb = {from=0,to=1000,step=1}", ["too many"]),
        ('states = "some"\n' + STARS, ["states", "final, all, none"]),
        ("[family]\nkind = 'x'\n[list]\nfamily.seed = [1]", ["random_kirigami"]),
        ("[family]\nkind = 'random_kirigami'\n[grid]\na.b = [1]", ["seed"]),
        (
            "[family]\nkind = 'random_kirigami'\n[list]\nfamily.seed = [1]\nfamily.line = [1]",
            ["did you mean lines"],
        ),
        ("[family]\nkind = 'random_kirigami'\nseed=1\n[list]\nfamily.seed = [1]", ["twice"]),
        ("x = ", ["TOML"]),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, words: list[str]) -> None:
    file = written(tmp_path, text)
    with pytest.raises(sm.InputError) as caught:
        Plan.load(file)
    message = str(caught.value)
    assert "\n" not in message
    assert str(file) in message
    for word in words:
        assert word in message


def test_a_family_argument_that_is_no_number_is_refused(tmp_path: Path) -> None:
    text = "[family]\nkind = 'random_kirigami'\nlines = 'six'\n[list]\nfamily.seed = [1]"
    with pytest.raises(sm.InputError, match="none of 1 designs"):
        Plan.load(written(tmp_path, text))
    text = "[family]\nkind = 'random_kirigami'\nline_width = 'six'\n[list]\nfamily.seed = [1]"
    with pytest.raises(sm.InputError, match="argument of the family"):
        Plan.load(written(tmp_path, text))
