"""The steps from files to a morphed sheet, by the protocol of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sheetmorph.fabricate import oven
from sheetmorph.fabricate.cut import HOLES, SHEET, SLITS, describe_kerf
from sheetmorph.fabricate.solid_files import writes_3mf
from sheetmorph.fabricate.stack import Level, glued_area

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design
    from sheetmorph.fabricate.options import FabricationOptions
    from sheetmorph.fabricate.oven import OvenSetting
    from sheetmorph.fabricate.print3d import PrintedPart

SAFETY = (
    "Oven, tray, foil and sheet are hot: wear heat-proof gloves, and use tongs for what is small.",
    (
        "Hot polystyrene gives off styrene fumes: use an oven in a fume hood or a well ventilated "
        "room, and do not breathe what rises when the door opens."
    ),
    "Never use an oven in which food is made, before or after.",
    (
        "Never leave the oven alone while something is in it. If it smokes, switch it off and keep "
        "the door shut."
    ),
    (
        "Uncured epoxy irritates and sensitises the skin: wear nitrile gloves, keep it off the "
        "eyes, air the room, follow its data sheet."
    ),
    (
        "A laser cuts polystyrene with flames and fumes: only with extraction and under watch. "
        "Never cut a plastic that you cannot name."
    ),
)


@dataclass(frozen=True)
class Step:
    """One step: a title, and sentences in order."""

    title: str
    lines: tuple[str, ...]


def all_steps(
    design: Design,
    levels: tuple[Level, ...],
    printed: Sequence[PrintedPart],
    options: FabricationOptions,
    setting: OvenSetting,
) -> tuple[Step, ...]:
    """The steps in order; those without anything to do are left out."""
    found = [_cut(design, levels, options)]
    if printed:
        found.append(_print(printed, options))
    if len(levels) > 1:
        found += [_glue(levels), _cure(design, levels)]
    found += [_heat(levels, setting), _take_out()]
    return tuple(found)


def _cut(design: Design, levels: tuple[Level, ...], options: FabricationOptions) -> Step:
    films = [level for level in levels if level.part is None]
    names = ", ".join(f"{level.layer.name} ({_mm(level.layer.thickness)})" for level in films)
    lines = [
        (
            f"Cut cut/sheet.dxf or cut/sheet.svg (unit: millimetre) from: {names}. "
            f"{_cut_order(design)}"
        ),
        describe_kerf(options.kerf),
        (
            "The crosses on the layer MARKS stand in the waste beside the sheet and coincide with "
            "those of cut/pattern: use them to lay drawings upon each other; do not cut them."
        ),
        "By hand: print a template in true size, lay the film over it, cut along the dark line.",
    ]
    if not design.layout.slits.is_empty:
        lines.insert(1, "Cut the slits right through, to their very ends and not beyond.")
    if options.stock is not None:
        wide, high = (f"{1e3 * side:g}" for side in options.stock)
        lines.append(
            f"cut/nest holds {options.copies} "
            f"{'copies' if options.copies > 1 else 'copy'} on stock of {wide} × {high} mm."
        )
    return Step("Cut the sheet", tuple(lines))


def _cut_order(design: Design) -> str:
    slits = [] if design.layout.slits.is_empty else [SLITS]
    holes = [HOLES] if design.outline_polygon().interiors else []
    if not slits and not holes:
        return f"Cut its layer {SHEET}."
    return f"Cut its layers in this order: {_join([*slits, *holes, SHEET], ', then ')}."


def _print(printed: Sequence[PrintedPart], options: FabricationOptions) -> Step:
    what = (
        "parts/plate.3mf (all parts arranged; more plates where one is not enough) or the parts"
        if writes_3mf()
        else "the parts (STL files, in millimetres)"
    )
    lines = [
        (
            f"Print {what} one by one, in the orientation of the files: the face on the bed is the "
            f"one to be glued. Checked against {options.printer.name}, "
            f"{1e3 * options.printer.bed_width:g} × {1e3 * options.printer.bed_depth:g} mm."
        ),
        "Do not mirror anything in the slicer. The paper used PLA on a fused deposition printer.",
    ]
    if options.copies > 1:
        lines.append(f"The files hold the parts of one sheet: print them {options.copies} times.")
    below = [part.name for part in printed if part.level.face == "bottom"]
    if below:
        lines.append(
            f"{_join(below)} {'goes' if len(below) == 1 else 'go'} on the underside and "
            f"{'lies' if len(below) == 1 else 'lie'} on the bed mirrored, as seen on the pages of "
            "the template that begin with U."
        )
    return Step("Print the parts", tuple(lines))


def _glue(levels: tuple[Level, ...]) -> Step:
    lines = [
        (
            "Roughen lightly and degrease both faces. Mix two-part epoxy (the paper: Gorilla) and "
            "spread a thin, uniform layer on the parts alone, no thicker than "
            f"{1e3 * oven.ADHESIVE_THICKNESS:g} mm once cured; wipe off what squeezes out, for "
            "glue on the free film holds it back."
        ),
    ]
    films = [level.layer.name for level in levels if level.face == "film"]
    if len(films) > 1:
        lines.append(f"First bond the films upon each other, from below: {_join(films, ', ')}.")
    for face in ("top", "bottom"):
        names = [level.layer.name for level in levels if level.face == face]
        if not names:
            continue
        ordered = names if face == "top" else names[::-1]
        if face == "top":
            lines.append(
                f"Top face: lay the film on the template, the outlines matched, and set "
                f"{_join(ordered, ' then ')} on the shaded places, the face from the bed downward."
            )
        else:
            lines.append(
                "Underside: turn the sheet over like a page, left to right, lay it on the pages "
                f"of the template that begin with U, and set {_join(ordered, ' then ')} on the "
                "shaded places, the face from the bed downward."
            )
    return Step("Glue", tuple(lines))


def _cure(design: Design, levels: tuple[Level, ...]) -> Step:
    sheet = float(design.outline_polygon().area)
    glued = max(glued_area(levels, "top"), glued_area(levels, "bottom"))
    return Step(
        "Cure",
        (
            (
                f"Leave it under a flat, evenly distributed weight for {oven.CURE_HOURS:g} hours "
                "or more at room temperature, between non-stick foil."
            ),
            (
                f"The paper's {oven.CURE_PRESSURE:g} N/m² is {oven.cure_mass(glued):.2g} kg on the "
                f"glued area of this sheet, {1e4 * glued:.1f} cm². (Taken over the whole sheet, "
                f"{1e4 * sheet:.1f} cm², it would be {oven.cure_mass(sheet):.2g} kg; the paper "
                "does not say which.)"
            ),
        ),
    )


def _heat(levels: tuple[Level, ...], setting: OvenSetting) -> Step:
    told = list(oven.sentences_of(setting))
    if setting.reach in ("none", "swells"):
        return Step("Actuate", tuple(told))
    paper = (
        f"preheat the oven to {oven.degrees(oven.PAPER_TEMPERATURE)}, leave the sheet in for "
        f"about {oven.PAPER_SECONDS:g} s, and take it out by eye"
    )
    differs = (
        setting.temperature is not None and abs(setting.temperature - oven.PAPER_TEMPERATURE) > 3.0
    )
    if differs:
        told.append(
            f"The paper did it otherwise: {paper}, whatever the design; time, not temperature, "
            "then decides how far it shrinks. At the lower temperature of the curve the sheet "
            "needs longer; the paper gives no time for it."
            if (setting.temperature or 0.0) < oven.PAPER_TEMPERATURE
            else f"The paper did it otherwise: {paper}, whatever the design."
        )
    else:
        told.append(f"As in the paper: {paper}.")
    told += [
        _side_down(levels),
        (
            "Preheat fully before the sheet goes in. Watch it all the time; thicker and wider "
            "parts need longer (paper). Too long in the heat, everything softens, folds inward or "
            "collapses."
        ),
    ]
    return Step("Heat", tuple(told))


def _side_down(levels: tuple[Level, ...]) -> str:
    faces = {level.face for level in levels if level.part is not None}
    if faces == {"top", "bottom"}:
        return (
            "Lay it on non-stick foil. The paper lays the film side down; here both faces carry "
            "parts, so lay the face with fewer and flatter parts down."
        )
    if faces == {"bottom"}:
        return (
            "Turn it over and lay it film side down on non-stick foil, the parts upward, as in "
            "the paper; the shape comes out upside down."
        )
    return "Lay it film side down on non-stick foil" + (
        ", the parts upward (paper)." if faces else " (paper)."
    )


def _take_out() -> Step:
    return Step(
        "Take it out",
        (
            (
                "Take it out by hand, with heat-proof gloves, as soon as the shape is there "
                "(paper); it stops moving as it cools."
            ),
            "Let it cool on a flat, heat-proof place without touching it.",
        ),
    )


def _join(names: Sequence[str], word: str = " and ") -> str:
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + word + names[-1]


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
