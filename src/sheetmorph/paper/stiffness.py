"""What the paper says of the stretching stiffness: its factor and its form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from sheetmorph.energy.hinge import CoupledHinge
from sheetmorph.energy.total import Total
from sheetmorph.paper.rows import (
    Findings,
    Row,
    ShapeFigure,
    Table,
    claims,
    judged,
    within,
)
from sheetmorph.paper.runs import LETTERS, Outcome, Outcomes, Run, Setting
from sheetmorph.paper.sections import (
    WITHOUT_MESHES,
    Section,
    failures,
    listed,
    result_of,
    similarity,
)
from sheetmorph.paper.shapes import final
from sheetmorph.paper.variants import SAME
from sheetmorph.study.model import build_problem

FACTORS = (2.0, 5.0, 10.0)
FORMS = {"scaled_by_edge_length": "released", "printed": "printed"}


def _factor_run(design: str, form: str, factor: float) -> Run:
    values = {
        **dict(final(design).values),
        "published.stretch_stiffness": form,
        "published.stretch_factor": factor,
    }
    return Run.of(design, values)


def _factor_runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    # The slowest first: the pool then ends evenly.
    return tuple(
        _factor_run(design, form, factor)
        for form in reversed(FORMS)
        for factor in reversed(FACTORS)
        for design in ("canoe", "bowl", "petals")
    )


def _factors(setting: Setting, outcomes: Outcomes) -> Findings:
    rows: list[Row] = []
    table: list[tuple[str, ...]] = []
    figures = []
    where = "Model Parameters (scaling of k_s)"

    @cache
    def known(a: Run, b: Run) -> float:
        return similarity(outcomes[a], outcomes[b])

    for design, letter in LETTERS.items():
        for form, name in FORMS.items():
            runs = [_factor_run(design, form, factor) for factor in FACTORS]
            lack = failures(outcomes, *runs)
            alike: list[float] = []
            if not lack:
                alike = [known(run, runs[-1]) for run in runs[:-1]]
            rows.append(
                judged(
                    f"factor-{design}-{name}",
                    f"{letter}, {name} form: ×2 and ×5 give other shapes than ×10",
                    where,
                    "different equilibrium configurations",
                    f"SSIM to ×10: {listed(alike, 3)}" if alike else None,
                    claims(
                        *(
                            (
                                f"the shape at ×{factor:g} is another one (SSIM below {SAME})",
                                s < SAME,
                            )
                            for factor, s in zip(FACTORS, alike, strict=False)
                        )
                    ),
                    lack=lack,
                )
            )
            for factor, run in zip(FACTORS, runs, strict=True):
                table.append(_factor_row(letter, name, factor, run, outcomes, known))
        tenfold = [_factor_run(design, form, FACTORS[-1]) for form in FORMS]
        rows.append(_stable_row(design, outcomes, tenfold, where))
        columns = tuple(
            (f"{name} form, ×{factor:g}", run)
            for form, name in FORMS.items()
            for factor in FACTORS
            if outcomes[run := _factor_run(design, form, factor)].result is not None
        )
        caption = (
            f"Design {letter} at full actuation by the form of K and the factor on k_s; the "
            "released numbers are the released form with ×10."
        )
        if columns:
            figures.append(ShapeFigure(f"factors-{design}", caption, columns))
    rows.append(_exchange_row(outcomes[_factor_run("bowl", "scaled_by_edge_length", FACTORS[-1])]))
    head = (
        *("design", "form of K", "factor", "height [mm]", "h/d", "largest |θ| [rad]"),
        *("stable", "factorisations", "SSIM to ×10 of the released form"),
    )
    notes = (
        (
            "The printed energy has K = 10 k_s, the released numbers come from K = 10 k_s l₀ with "
            "each edge's own length in metres, which is about 300 times softer. The printed form "
            "folds into higher modes: these shapes belong to other branches."
        ),
        (
            f"An SSIM below {SAME} says that a shape is another one, not that it lies on another "
            "branch: in the released form height and h/d move steadily with the factor."
        ),
    )
    tables = [Table("Factor and form of the stretching stiffness", head, tuple(table))]
    return Findings(rows, figures, tables, notes if setting.reference else (*notes, WITHOUT_MESHES))


def _stable_row(design: str, outcomes: Outcomes, runs: list[Run], where: str) -> Row:
    lack = failures(outcomes, *runs)
    stable = [not lack and bool(result_of(outcomes[run]).summary["stable"]) for run in runs]
    return judged(
        f"factor-{design}-stable",
        f"{LETTERS[design]}: ×10 gives a stable shape, in either form",
        where,
        "consistently stable",
        None if lack else ", ".join("stable" if one else "not stable" for one in stable),
        claims(
            *(
                (f"the last state of the {name} form is stable", one)
                for name, one in zip(FORMS.values(), stable, strict=True)
            )
        ),
        lack=lack,
    )


def _factor_row(
    letter: str,
    name: str,
    factor: float,
    run: Run,
    outcomes: Outcomes,
    known: Callable[[Run, Run], float],
) -> tuple[str, ...]:
    outcome = outcomes[run]
    label = (letter, name, f"×{factor:g}")
    if outcome.failure:
        return (*label, *["–"] * 5, outcome.failure)
    result = result_of(outcome)
    usual = _factor_run(run.design, "scaled_by_edge_length", FACTORS[-1])
    return (
        *label,
        f"{1e3 * result.summary['height_m']:.1f}",
        f"{result.summary['aspect_ratio']:.3f}",
        f"{np.abs(result.dihedral[-1]).max():.2f}",
        "yes" if result.summary["stable"] else "no",
        str(result.summary["factorisations"]),
        "–" if outcomes[usual].failure else f"{known(run, usual):.3f}",
    )


def _exchange_row(outcome: Outcome) -> Row:
    """k_s ten times up, or k_b ten times down: the same equilibria."""
    ours = None
    if not outcome.failure:
        result = result_of(outcome)
        single = build_problem(result.design.with_values({"published.stretch_factor": 1.0}))
        stretch, bend, load = (term.at(1.0, 0.0) for term in single.total.terms)
        assert isinstance(bend, CoupledHinge)  # noqa: S101  the order of build_problem
        softer = Total.of(
            [stretch, replace(bend, stiffness=bend.stiffness / 10), load], len(result.mesh.nodes)
        )
        x = np.ascontiguousarray(outcome.shape).ravel()
        free = np.setdiff1d(np.arange(len(result.mesh.nodes)), result.held_nodes)
        gradient = softer.evaluate(x, 1)[1]
        assert gradient is not None  # noqa: S101  order 1 gives it
        force = float(np.abs(gradient.reshape(-1, 3)[free]).max())
        ours = force / (0.1 * single.model.force_scale)
    return judged(
        "factor-exchange",
        "A: k_s × 10 or k_b ÷ 10 give the same equilibrium",
        "Model Parameters (scaling of k_s)",
        "identical solutions",
        ours,
        within(1e-8, 1e-6),
        lack=outcome.failure,
        note="Residual force of the state of k_s × 10 in the energy of k_b ÷ 10, over the moment "
        "of a hinge bent by 1 rad over an edge; the two energies differ by the factor 10 alone.",
    )


FACTOR = Section("factor", "Factor on k_s", "Model Parameters", _factor_runs, _factors)
