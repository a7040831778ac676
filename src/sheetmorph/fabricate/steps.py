"""The steps from files to a morphed sheet, by the protocol of the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sheetmorph.fabricate import oven
from sheetmorph.fabricate.cut import HOLES, SHEET, SLITS, describe_kerf
from sheetmorph.fabricate.names import PLATE
from sheetmorph.fabricate.stack import Level, bonded_first, glued_area

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


_NAMED = 3
"""So many files of parts are named; more are "the parts"."""


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
    files: Sequence[str] = (),
) -> tuple[Step, ...]:
    """The steps in order, with the names of the files; those with nothing to do are left out."""
    found = [_cut(design, levels, options, files)]
    if printed:
        found.append(_print(printed, options, files))
    if len(levels) > 1:
        found += [_glue(levels), _cure(design, levels)]
    found += [_heat(levels, setting), _take_out()]
    return tuple(found)


def _cut(
    design: Design, levels: tuple[Level, ...], options: FabricationOptions, files: Sequence[str]
) -> Step:
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
            if any(name.startswith("cut/pattern") for name in files)
            else "The crosses on the layer MARKS stand in the waste beside the sheet: do not cut "
            "them."
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
    return f"Cut its layers in this order: {joined([*slits, *holes, SHEET], ', then ')}."


def _print(
    printed: Sequence[PrintedPart], options: FabricationOptions, files: Sequence[str]
) -> Step:
    lines = [
        (
            f"Print {_what_to_print(files)}, in the orientation of the files: the face on the bed "
            f"is the one to be glued. Checked against {options.printer.name}, "
            f"{1e3 * options.printer.bed_width:g} × {1e3 * options.printer.bed_depth:g} mm."
        ),
        "Do not mirror anything in the slicer. The paper used PLA on a fused deposition printer.",
    ]
    large = [part.name for part in printed if not part.fits]
    if large:
        lines.append(
            f"{joined(large)} {'is' if len(large) == 1 else 'are'} larger than that bed, however "
            "turned: split them in the design, or choose a larger printer."
        )
    if options.copies > 1:
        lines.append(f"The files hold the parts of one sheet: print them {options.copies} times.")
    below = [part.name for part in printed if part.level.face == "bottom"]
    if below:
        lines.append(
            f"{joined(below)} {'goes' if len(below) == 1 else 'go'} on the underside and "
            f"{'lies' if len(below) == 1 else 'lie'} on the bed mirrored, as seen on the pages of "
            "the template that begin with U."
        )
    return Step("Print the parts", tuple(lines))


def _what_to_print(files: Sequence[str]) -> str:
    """The files that were written, by name."""
    solid = [name for name in files if name.startswith("parts/")]
    found = [name for name in solid if name.endswith(".3mf")] or solid
    plates = [name for name in found if PLATE.fullmatch(name.split("/")[1].rpartition(".")[0])]
    single = [name for name in found if name not in plates]
    alone = joined(single) if 0 < len(single) <= _NAMED else "the parts one by one"
    if plates:
        return f"{joined(plates)} (parts arranged on the bed), or {alone}"
    return f"{alone} (in millimetres)" if found and found[0].endswith(".stl") else alone


def _glue(levels: tuple[Level, ...]) -> Step:
    first = bonded_first(levels)
    where = " on the parts alone" if len(first) < len(levels) else ""
    lines = [
        (
            "Roughen lightly and degrease both faces. Mix two-part epoxy (the paper: Gorilla) and "
            f"spread a thin, uniform layer{where}, no thicker than "
            f"{1e3 * oven.ADHESIVE_THICKNESS:g} mm once cured; wipe off what squeezes out, for "
            "glue on the free film holds it back."
        ),
    ]
    if len(first) > 1:
        lines.append(
            "First bond the whole sheets upon each other, from below, with glue all over: "
            f"{joined([level.layer.name for level in first], ', then ')}."
        )
    for face in ("top", "bottom"):
        outer = [level for level in levels if level.face == face and level not in first]
        if not outer:
            continue
        outward = outer if face == "top" else outer[::-1]
        place = (
            "Top face: lay the sheet on the template, the outlines matched, and "
            if face == "top"
            else "Underside: turn the sheet over like a page, left to right, lay it on the pages "
            "of the template that begin with U, and "
        )
        lines.append(f"{place}{joined([_set(level) for level in outward], ', then ')}.")
    return Step("Glue", tuple(lines))


def _set(level: Level) -> str:
    """What to do with one layer on a face of the sheet."""
    on = joined(level.on)
    if level.part is None:
        return f"lay {level.layer.name}, a whole sheet, over all of it, glued to {on} alone"
    return f"set {level.layer.name} on its shaded places, on {on}, the face from the bed downward"


def _cure(design: Design, levels: tuple[Level, ...]) -> Step:
    sheet = float(design.outline_polygon().area)
    glued = glued_area(levels)
    weight = (
        f"The paper's {oven.CURE_PRESSURE:g} N/m² is {oven.cure_mass(glued):.2g} kg on the glued "
        f"area of this sheet, {1e4 * glued:.1f} cm²"
    )
    if glued < 0.999 * sheet:
        weight += (
            f". (Taken over the whole sheet, {1e4 * sheet:.1f} cm², it would be "
            f"{oven.cure_mass(sheet):.2g} kg; the paper does not say which.)"
        )
    else:
        weight += ", which is all of it."
    return Step(
        "Cure",
        (
            (
                f"Leave it under a flat, evenly distributed weight for {oven.CURE_HOURS:g} hours "
                "or more at room temperature, between non-stick foil."
            ),
            weight,
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


def joined(names: Sequence[str], word: str = " and ") -> str:
    """Names in a sentence, the last after `word`."""
    return names[0] if len(names) == 1 else ", ".join(names[:-1]) + word + names[-1]


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
