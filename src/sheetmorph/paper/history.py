"""Fig. 8D: height over width of the three designs as they are actuated."""

from __future__ import annotations

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.paper.rows import (
    Curve,
    CurveFigure,
    Findings,
    Row,
    Table,
    at_least,
    claims,
    judged,
    number,
)
from sheetmorph.paper.runs import (
    LETTERS,
    WIDTHS,
    Outcome,
    Outcomes,
    Run,
    Setting,
)
from sheetmorph.paper.sections import WITHOUT_MESHES, Section, failures, listed
from sheetmorph.paper.shapes import final

WHERE = "Fig. 8D, Structural Similarity Index Measure"
COMMON = -0.20
"""An actuation that all three designs pass, at which their h/d are compared."""

_ONSET, _PLATEAU = 0.05, 0.95
_KIND = (
    "The paper gives seconds in an oven, the model knows actuation alone: without the heating "
    "curve of the samples one cannot be turned into the other."
)
_WIDTHS = {
    "feret_max": "largest caliper width",
    "feret_min": "smallest caliper width",
    "x": "extent along x",
}


def _runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    return tuple(final(design) for design in LETTERS)


def reached_at(actuation: Floats, ratio: Floats, share: float) -> float:
    """Actuation at which h/d first reaches a share of its largest value."""
    wanted = share * float(ratio.max())
    k = int(np.argmax(ratio >= wanted))
    if k == 0:
        return float(actuation[0])
    part = (wanted - ratio[k - 1]) / (ratio[k] - ratio[k - 1])
    return float(actuation[k - 1] + part * (actuation[k] - actuation[k - 1]))


def ratio_at(actuation: Floats, ratio: Floats, eps_pre: float) -> float:
    """h/d at an actuation, straight between the states."""
    return float(np.interp(-eps_pre, -actuation, ratio))


def _evaluate(setting: Setting, outcomes: Outcomes) -> Findings:
    found = {design: outcomes[final(design)] for design in LETTERS}
    rows: list[Row] = []
    stated = {"bowl": 5.0, "canoe": 12.0, "petals": 7.0}
    for design, letter in LETTERS.items():
        outcome = found[design]
        rows.append(
            judged(
                f"onset-{design}",
                f"{letter}: onset of morphing",
                WHERE,
                f"{stated[design]:g} s",
                None
                if outcome.failure
                else f"h/d at {100 * _ONSET:.0f} % of its last value at ε_pre = "
                + number(reached_at(*_history(outcome), _ONSET)),
                claims(),
                differently=_KIND,
                lack=outcome.failure,
            )
        )
    bowl = found["bowl"]
    rows.append(
        judged(
            "plateau-bowl",
            "A: h/d levels off",
            WHERE,
            "after 12 s",
            None
            if bowl.failure
            else f"h/d at {100 * _PLATEAU:.0f} % of its last value at ε_pre = "
            + number(reached_at(*_history(bowl), _PLATEAU)),
            claims(),
            differently=_KIND,
            lack=bowl.failure,
        )
    )
    rows += [_petals_row(found["petals"]), _sensitivity_row(found, failures(outcomes, *outcomes))]
    good = {design: outcome for design, outcome in found.items() if not outcome.failure}
    curves = [
        Curve(f"{LETTERS[design]} ({design})", *(_history(outcome)))
        for design, outcome in good.items()
    ]
    figure = CurveFigure(
        "history",
        "Height over width against actuation; d is the largest caliper width of the shape seen "
        "from above. The broken line is the 1.2 that the paper states for C.",
        "εₚᵣₑ  [–]",
        "h/d",
        tuple(curves),
        ((1.2, "stated for C"),),
    )
    head = ("design", "εₚᵣₑ  [–]", *(f"h/d, d = {_WIDTHS[name]}" for name in WIDTHS))
    table = tuple(
        (
            LETTERS[design],
            number(float(outcome.actuation[-1])),
            *(f"{outcome.aspect_ratio[name][-1]:.3f}" for name in WIDTHS),
        )
        for design, outcome in good.items()
    )
    notes = [
        (
            "The paper reads h and d off side views by hand and defines d by a picture. Here h is "
            "the extent along z and d the largest caliper width of the projection on the plane of "
            "the flat sheet; the table gives two other readings of d."
        )
    ]
    if not setting.reference:
        notes.append(WITHOUT_MESHES)
    return Findings(
        rows, [figure] if curves else [], [Table("h/d at full actuation", head, table)], notes
    )


def _history(outcome: Outcome) -> tuple[Floats, Floats]:
    """Actuation and h/d while the load is on: the removal of the load is left out."""
    rising = np.concatenate([[True], np.abs(np.diff(outcome.actuation)) > 1e-12])
    rising[-1] = True
    actuation, ratio = outcome.actuation[rising], outcome.aspect_ratio[WIDTHS[0]][rising]
    last = np.abs(actuation - actuation[-1]) < 1e-12
    keep = ~last
    keep[-1] = True  # at full actuation the state without the load counts
    return actuation[keep], ratio[keep]


def _petals_row(outcome: Outcome) -> Row:
    values = [] if outcome.failure else [float(outcome.aspect_ratio[name].max()) for name in WIDTHS]
    return judged(
        "aspect-petals",
        "C: largest h/d, by the reading of d that gives most",
        WHERE,
        1.2,
        max(values) if values else None,
        at_least(0.1),
        lack=outcome.failure,
        note=f"With d as largest, smallest caliper width and extent along x: {listed(values)}.",
    )


def _sensitivity_row(found: dict[str, Outcome], lack: str) -> Row:
    at = {} if lack else {d: ratio_at(*_history(o), COMMON) for d, o in found.items()}
    return judged(
        "sensitivity",
        "h/d of B and C answers more strongly to actuation than that of A",
        WHERE,
        "B and C more sensitive than A",
        f"at ε_pre = {number(COMMON)}: A, B, C {listed(list(at.values()))}" if at else None,
        claims(
            (
                "h/d of B is above that of A at the same actuation",
                bool(at) and at["canoe"] > at["bowl"],
            ),
            ("h/d of C is above that of A", bool(at) and at["petals"] > at["bowl"]),
        ),
        lack=lack,
    )


HISTORY = Section("history", "Height over width", "Fig. 8A–D", _runs, _evaluate)
