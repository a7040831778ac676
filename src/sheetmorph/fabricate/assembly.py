"""What the assembly sheet says: layers, parts, masses, steps, oven, safety; as plain data."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sheetmorph.fabricate import steps
from sheetmorph.fabricate.oven import oven_setting, sentences_of
from sheetmorph.fabricate.picture import Picture, exploded_picture, plan_picture
from sheetmorph.fabricate.stack import Level

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design
    from sheetmorph.fabricate.options import FabricationOptions, Prediction
    from sheetmorph.fabricate.print3d import PrintedPart
    from sheetmorph.fabricate.steps import Step

PAPER = (
    "Zhang, Alon, Jawed: Emergent morphogenesis via planar fabrication enabled by a reduced "
    "model of composites. Experimental section, “Manufacturing Protocol” (bonding, curing, "
    "oven), “Pattern Design and Results” (thick and wide parts), and the assumptions on the "
    "adhesive layer."
)


@dataclass(frozen=True)
class Table:
    """Rows of text below titles; the columns in `numbers` are aligned as numbers."""

    titles: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Assembly:
    """The content of the assembly sheet.

    Attributes:
        title: name of the design.
        lead: one sentence on what is made.
        warnings: what to know before starting.
        plan: the flat sheet.
        exploded: its layers pulled apart.
        layers: from the bottom up.
        parts: what to cut and to print, with masses.
        files: what is in the folder.
        steps: what to do.
        expected: label and value of the predicted shape; that it is unknown when the
            computation did not reach it; empty without a prediction.
        expected_note: a line below them.
        picture_png: of the predicted shape.
        safety: what to beware of.
        sources: where the numbers come from.
    """

    title: str
    lead: str
    warnings: tuple[str, ...]
    plan: Picture
    exploded: Picture
    layers: Table
    parts: Table
    files: Table
    steps: tuple[Step, ...]
    expected: tuple[tuple[str, str], ...]
    expected_note: str
    picture_png: bytes | None
    safety: tuple[str, ...]
    sources: tuple[str, ...]


def describe(
    design: Design,
    levels: Sequence[Level],
    printed: Sequence[PrintedPart],
    options: FabricationOptions,
    *,
    prediction: Prediction | None = None,
    warnings: Sequence[str] = (),
    files: Mapping[str, str] | None = None,
) -> Assembly:
    """Put the assembly sheet together.

    Args:
        design: what is made.
        levels: its layers, from `stack.levels_of`.
        printed: its parts on the bed.
        options: how they are made.
        prediction: what shape to expect.
        warnings: of the printer and the template.
        files: names of the files in the folder, and what each is.

    Raises:
        InputError: the design's shrink curve is not usable.
    """
    setting = oven_setting(design)
    low_x, low_y, high_x, high_y = design.outline_polygon().bounds
    size = max(high_x - low_x, high_y - low_y)
    return Assembly(
        title=design.name,
        lead=_lead(design, levels),
        warnings=(
            *warnings,
            *_film_warning(design),
            *(sentences_of(setting) if setting.reach in ("beyond", "swells") else ()),
        ),
        plan=plan_picture(design, levels, pen=size / 320, hatch=size / 45),
        exploded=exploded_picture(levels, design.layout.slits),
        layers=_layer_table(levels),
        parts=_part_table(levels, options.copies),
        files=Table(("File", "What it is"), tuple((files or {}).items())),
        steps=steps.all_steps(design, tuple(levels), printed, options, setting, tuple(files or ())),
        expected=_expected(prediction),
        expected_note=_expected_note(prediction),
        picture_png=prediction.picture_png if prediction and _reached(prediction) else None,
        safety=steps.SAFETY,
        sources=(PAPER, f"Shrink curve: “{setting.curve}”. Sizes, areas and masses: the design."),
    )


def _lead(design: Design, levels: Sequence[Level]) -> str:
    low_x, low_y, high_x, high_y = design.outline_polygon().bounds
    count = sum(level.part is not None for level in levels)
    parts = "without printed parts" if not count else f"with {count} printed part{'s'[: count > 1]}"
    return (
        f"A flat sheet of {1e3 * (high_x - low_x):.1f} × {1e3 * (high_y - low_y):.1f} mm, {parts}, "
        f"that {'swells' if design.eps_pre > 0 else 'shrinks'} by up to "
        f"{100 * abs(design.eps_pre):.3g} % in length where it is free (eps_pre = "
        f"{_signed(design.eps_pre)})."
    )


def _film_warning(design: Design) -> list[str]:
    if design.pattern:
        return []
    return ["The design has no pattern: there is nothing to print or to glue, only the sheet."]


def _layer_table(levels: Sequence[Level]) -> Table:
    rows = []
    for number, level in enumerate(levels, 1):
        if level.part is None:
            how = (
                f"{level.layer.role} film, whole sheet"
                if level.face == "film"
                else f"inert sheet, whole outline, glued to {steps.joined(level.on)}"
            )
            rows.append((str(number), level.layer.name, _mm(level.layer.thickness), how))
            continue
        side = "lower" if level.face == "top" else "upper"
        on = steps.joined(level.on)
        rows.append(
            (
                str(number),
                level.layer.name,
                _mm(level.layer.thickness),
                f"printed; its {side} face is glued to {on} and lies on the printer's bed",
            )
        )
    return Table(("From below", "Layer", "Thickness", "How it lies"), tuple(rows), (2,))


def _part_table(levels: Sequence[Level], copies: int) -> Table:
    rows = []
    total = 0.0
    for level in levels:
        area, layer = float(level.region.area), level.layer
        mass = area * layer.thickness * layer.density
        total += mass
        pieces = 1 if level.part is None else len(level.part.region.geoms)
        count = str(copies) if pieces == 1 else f"{copies} × {pieces} pieces"
        rows.append(
            (
                layer.name,
                "cut" if level.part is None else f"printed, {level.face} face",
                count,
                _mm(layer.thickness),
                f"{1e4 * area:.2f} cm²",
                f"{layer.density:g} kg/m³",
                _gram(mass),
            )
        )
    rows.append(("One assembled sheet", "", "", "", "", "without glue", _gram(total)))
    titles = ("Part", "Made", "Count", "Thickness", "Plan area", "Density", "Mass of one")
    return Table(titles, tuple(rows), (2, 3, 4, 5, 6))


def _expected(prediction: Prediction | None) -> tuple[tuple[str, str], ...]:
    if prediction is None:
        return ()
    status = prediction.status.replace("_", " ")
    if not _reached(prediction):
        return (("Shape", "unknown"), ("Computation", status))
    ratio = f"{prediction.aspect_ratio:.3f}" if math.isfinite(prediction.aspect_ratio) else "–"
    width, depth, height = (
        f"{1e3 * side:.1f} mm" for side in (prediction.width, prediction.depth, prediction.height)
    )
    return (
        ("Width (along x)", width),
        ("Depth (along y)", depth),
        ("Height", height),
        ("Height over the largest width in any direction, h/d", ratio),
        ("Computation", status),
        ("Shape", "stable" if prediction.stable else "not stable: it may flip or bend otherwise"),
    )


def _expected_note(prediction: Prediction | None) -> str:
    if prediction is None:
        return "No shape was computed for this sheet."
    told = [prediction.note.strip()] if prediction.note.strip() else []
    if not _reached(prediction):
        return " ".join(
            [
                "The shape is unknown: the computation did not reach the full actuation.",
                *told,
            ]
        )
    told.append(
        "Real sheets sometimes bend the other way: in the paper, up or down was decided by small "
        "imperfections, with very similar shapes."
    )
    return " ".join(told)


def _reached(prediction: Prediction) -> bool:
    return prediction.status == "completed"


def _signed(value: float) -> str:
    return f"{value:+.3g}".replace("-", "−")


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


def _gram(mass: float) -> str:
    return f"{1e3 * mass:.3g} g" if mass < 1.0 else f"{mass:.3g} kg"
