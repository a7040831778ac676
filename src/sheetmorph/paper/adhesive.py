"""What the paper says of the adhesive: a third layer, computed."""

from __future__ import annotations

from sheetmorph.paper.rows import (
    Findings,
    Row,
    ShapeFigure,
    Table,
    claims,
    judged,
    reaching,
)
from sheetmorph.paper.runs import LETTERS, Outcome, Outcomes, Run, Setting
from sheetmorph.paper.sections import Section, failures, listed, result_of, similarity
from sheetmorph.paper.shapes import final
from sheetmorph.paper.variants import ALIKE, SAME

ADHESIVES = tuple((1e-3 * mm, 1e6 * mpa) for mm in (0.05, 0.10) for mpa in (1.0, 3.0))
"""Thickness [m] and modulus [Pa] of the glue: up to 0.1 mm, 1.5–4 GPa cut by three orders."""


def _glued(design: str, adhesive: tuple[float, float]) -> Run:
    return Run.of(design, dict(final(design).values), adhesive=adhesive)


def _glue_runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    return tuple(
        run
        for design in LETTERS
        for run in (final(design), *(_glued(design, layer) for layer in ADHESIVES))
    )


def _adhesive(setting: Setting, outcomes: Outcomes) -> Findings:
    rows: list[Row] = []
    table: list[tuple[str, ...]] = []
    where = "Model Assumptions for the Adhesive Layer"
    for design, letter in LETTERS.items():
        bare = final(design)
        glued = [_glued(design, layer) for layer in ADHESIVES]
        lack = failures(outcomes, bare, *glued)
        if lack:
            alike, stiffer = [], []
        else:
            alike = [similarity(outcomes[bare], outcomes[run]) for run in glued]
            stiffer = [_stiffer(outcomes[bare], outcomes[run]) for run in glued]
            before = float(result_of(outcomes[bare]).summary["aspect_ratio"])
            for run, (thickness, modulus), s, k in zip(
                glued, ADHESIVES, alike, stiffer, strict=True
            ):
                ratio = float(result_of(outcomes[run]).summary["aspect_ratio"])
                table.append(
                    (
                        *(letter, f"{1e3 * thickness:.2f}", f"{1e-6 * modulus:g}"),
                        *(f"+{100 * k:.0f} %", f"{100 * (ratio / before - 1):+.1f} %", f"{s:.3f}"),
                    )
                )
        rows.append(
            judged(
                f"adhesive-{design}",
                f"{letter}: a layer of glue does not change the shape (least SSIM)",
                where,
                "the same shape",
                min(alike, default=None),
                reaching(SAME, ALIKE),
                lack=lack,
                note=f"No number in the paper; {SAME} is its measure of equal meshes, "
                f"{ALIKE} of likeness.",
            )
        )
        rows.append(
            judged(
                f"adhesive-stiffness-{design}",
                f"{letter}: glue makes the bilayer slightly stiffer in bending",
                where,
                "a slight increase",
                f"{listed([100 * k for k in stiffer], 0)} %" if stiffer else None,
                claims(
                    ("k_b rises", min(stiffer, default=0) > 0),
                    ("by less than a tenth", bool(stiffer) and max(stiffer) < 0.1),
                ),
                lack=lack,
            )
        )
    head = (
        *("design", "glue [mm]", "modulus [MPa]", "k_b of the bilayer", "h/d"),
        "SSIM to none",
    )
    notes = (
        (
            "Each design at full actuation with an inert layer between film and print, Poisson's "
            "ratio 0.38; it changes the stiffness of the bilayer alone, the eigenstrain stays. "
            "Most of the gain in k_b comes from the print being lifted away from the film."
        ),
    )
    columns = tuple(
        column
        for design, letter in LETTERS.items()
        for column in (
            (f"{letter}, no glue", final(design)),
            (f"{letter}, 0.1 mm, 3 MPa", _glued(design, ADHESIVES[-1])),
        )
        if outcomes[column[1]].result is not None
    )
    figures = [
        ShapeFigure(
            "adhesive", "Without glue, and with the stiffest layer of it.", columns, across=2
        )
    ]
    tables = [Table("With a third layer", head, tuple(table))]
    return Findings(rows, figures if columns else (), tables, notes)


def _stiffer(bare: Outcome, glued: Outcome) -> float:
    """Gain of the bending stiffness of the bilayer, as a fraction."""
    before, after = (float(result_of(one).bending_stiffness.max()) for one in (bare, glued))
    return after / before - 1


ADHESIVE = Section(
    "adhesive",
    "The adhesive as a third layer",
    "Model Assumptions for the Adhesive Layer",
    _glue_runs,
    _adhesive,
)
