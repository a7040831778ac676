"""What a redone paper consists of: rows with a verdict by a stated rule, figures as data."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from sheetmorph.geometry.mesh import Floats, Ints

if TYPE_CHECKING:
    from sheetmorph.paper.runs import Run

Verdict = Literal["agrees", "agrees in part", "differs", "not comparable", "not redone"]
VERDICTS: tuple[Verdict, ...] = (
    *("agrees", "agrees in part", "differs"),
    *("not comparable", "not redone"),
)
Value = float | str
Rule = Callable[[Value, Value], tuple[Verdict, str]]
"""From the paper's value and ours to the verdict, and the rule with its numbers in words."""


@dataclass(frozen=True)
class Row:
    """One result of the paper beside ours.

    Attributes:
        id: unique, such as "mesh-863-970".
        what: the quantity or the claim.
        where: its place in the paper.
        paper: what the paper states; None where it states nothing.
        ours: what was found here; None where nothing was.
        unit: of both, "" for plain numbers and words.
        verdict: by the rule in `reason`.
        reason: one or two sentences with the numbers that decided.
    """

    id: str
    what: str
    where: str
    paper: Value | None
    ours: Value | None
    unit: str
    verdict: Verdict
    reason: str


def judged(
    key: str,
    what: str,
    where: str,
    paper: Value | None,
    ours: Value | None,
    rule: Rule,
    *,
    unit: str = "",
    differently: str = "",
    lack: str = "",
    note: str = "",
) -> Row:
    """A row whose verdict follows from its numbers.

    Without a value of ours it is "not redone". Without one of the paper, or where the two
    are measured `differently`, it is "not comparable". Otherwise the rule decides.

    Args:
        key: the `id` of the row.
        differently: how the two values differ in kind (seconds here, actuation there);
            empty where they can be compared.
        lack: why there is no value of ours.
        note: a sentence added to the reason.
    """
    verdict: Verdict
    if ours is None or (isinstance(ours, float) and not math.isfinite(ours)):
        ours, verdict, reason = None, "not redone", lack or "There is no value of ours."
    elif paper is None:
        verdict, reason = "not comparable", "The paper states no number here."
    elif differently:
        verdict, reason = "not comparable", differently
    else:
        verdict, reason = rule(paper, ours)
    return Row(key, what, where, paper, ours, unit, verdict, " ".join([reason, note]).strip())


def near(agree: float, part: float, *, relative: bool = False) -> Rule:
    """Agrees where ours lies within `agree` of the paper's number, in part within `part`."""

    def rule(paper: Value, ours: Value) -> tuple[Verdict, str]:
        away = abs(float(ours) - float(paper))
        text = f"Off by {number(away)}"
        limits = f"agrees up to {agree:g}, in part up to {part:g}"
        if relative:
            away /= abs(float(paper))
            text = f"Off by {100 * away:.2g} %"
            limits = f"agrees up to {100 * agree:g} %, in part up to {100 * part:g} %"
        return _graded(away <= agree, away <= part), f"{text} ({limits})."

    return rule


def at_least(slack: float) -> Rule:
    """Agrees where ours reaches the paper's number, in part where it lacks at most `slack`."""

    def rule(paper: Value, ours: Value) -> tuple[Verdict, str]:
        lacking = float(paper) - float(ours)
        text = f"Lacks {number(lacking)}" if lacking > 0 else f"Above by {number(-lacking)}"
        limits = f"agrees from {float(paper):g}, in part from {float(paper) - slack:g}"
        return _graded(lacking <= 0, lacking <= slack), f"{text} ({limits})."

    return rule


def within(agree: float, part: float) -> Rule:
    """Agrees where ours is at most `agree`, in part at most `part`; for claims without number."""

    def rule(paper: Value, ours: Value) -> tuple[Verdict, str]:
        del paper
        text = f"{number(float(ours))} (agrees up to {agree:g}, in part up to {part:g})."
        return _graded(float(ours) <= agree, float(ours) <= part), text

    return rule


def reaching(agree: float, part: float) -> Rule:
    """Agrees where ours is at least `agree`, in part at least `part`; for claims without number."""

    def rule(paper: Value, ours: Value) -> tuple[Verdict, str]:
        del paper
        text = f"{number(float(ours))} (agrees from {agree:g}, in part from {part:g})."
        return _graded(float(ours) >= agree, float(ours) >= part), text

    return rule


def same_order() -> Rule:
    """Agrees up to a factor of √10, in part up to a factor of 10: for numbers told as orders."""

    def rule(paper: Value, ours: Value) -> tuple[Verdict, str]:
        factor = 10 ** abs(math.log10(float(ours) / float(paper)))
        text = f"Apart by a factor of {number(factor)} (agrees up to √10, in part up to 10)."
        return _graded(factor <= math.sqrt(10), factor <= 10), text

    return rule


def claims(*checked: tuple[str, bool]) -> Rule:
    """Agrees where all parts of a claim hold, in part where some do, differs where none."""

    def rule(paper: Value, ours: Value) -> tuple[Verdict, str]:
        del paper, ours
        true = [text for text, holds in checked if holds]
        false = [text for text, holds in checked if not holds]
        parts = ["Holds: " + "; ".join(true) + "."] if true else []
        parts += ["Does not hold: " + "; ".join(false) + "."] if false else []
        return _graded(not false, bool(true)), " ".join(parts)

    return rule


def _graded(agrees: bool, in_part: bool) -> Verdict:
    if agrees:
        return "agrees"
    return "agrees in part" if in_part else "differs"


def number(value: float) -> str:
    """A number with three digits."""
    return f"{value:.3g}".replace("-", "−")


@dataclass(frozen=True, eq=False)
class Bare:
    """A surface without a result, such as a scan.

    Attributes:
        points: [m], shape (V, 3).
        triangles: shape (T, 3).
    """

    points: Floats
    triangles: Ints


@dataclass(frozen=True, eq=False)
class ShapeFigure:
    """Shapes side by side.

    Attributes:
        name: unique.
        caption: one or two sentences.
        columns: a label and a run or a surface each.
        rows: of "shape", "angle", "strain", "top".
        across: columns beside each other; the others follow below.
    """

    name: str
    caption: str
    columns: tuple[tuple[str, Run | Bare], ...]
    rows: tuple[str, ...] = ("shape",)
    across: int = 3


@dataclass(frozen=True, eq=False)
class Curve:
    """A line of a diagram; `dots` draws points without a line, `dashed` a broken line."""

    label: str
    x: Floats
    y: Floats
    look: Literal["line", "dots", "dashed"] = "line"


@dataclass(frozen=True, eq=False)
class CurveFigure:
    """A diagram, with horizontal `marks`: a height and what it means."""

    name: str
    caption: str
    x_label: str
    y_label: str
    curves: tuple[Curve, ...]
    marks: tuple[tuple[float, str], ...] = ()


@dataclass(frozen=True, eq=False)
class MapFigure:
    """Fields seen from above, side by side.

    Attributes:
        maps: a label and values of shape (n, n) each, x along the first axis.
        limits: of the colour bar.
        label: of the colour bar.
    """

    name: str
    caption: str
    maps: tuple[tuple[str, Floats], ...]
    limits: tuple[float, float]
    label: str


Figure = ShapeFigure | CurveFigure | MapFigure


@dataclass(frozen=True)
class Table:
    """Numbers that belong together: head and rows of text."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class Findings:
    """What a section found: rows, figures, tables, and notes in sentences."""

    rows: Sequence[Row] = ()
    figures: Sequence[Figure] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = field(default=())
