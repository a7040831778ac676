"""The files of a package as bytes: what is written, before anything is written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sheetmorph import __version__
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.fabricate import cut
from sheetmorph.fabricate.assembly import describe
from sheetmorph.fabricate.assembly_pages import assembly_html, assembly_pdf
from sheetmorph.fabricate.names import part_names, plate_names
from sheetmorph.fabricate.nest import nest
from sheetmorph.fabricate.options import PAPER_NAMES
from sheetmorph.fabricate.print3d import PrintedPart, arrange, lay_on_bed
from sheetmorph.fabricate.printability import check_part
from sheetmorph.fabricate.solid_files import bytes_3mf, bytes_stl, writes_3mf
from sheetmorph.fabricate.stack import check_stack, levels_of
from sheetmorph.fabricate.template import template_pdf

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design
    from sheetmorph.drawing.ink import Ink
    from sheetmorph.fabricate.options import FabricationOptions, Prediction
    from sheetmorph.fabricate.printer import PrinterProfile

MARGIN = 2e-3
"""Room about the drawings in SVG [m]."""


@dataclass(frozen=True, eq=False)
class Contents:
    """All files of a package.

    Attributes:
        files: bytes by name within the folder.
        warnings: what to know, in sentences.
    """

    files: dict[str, bytes]
    warnings: tuple[str, ...]


def make_contents(
    design: Design,
    options: FabricationOptions,
    prediction: Prediction | None = None,
    on_event: Listener = silent,
) -> Contents:
    """Make every file of a package in memory.

    Raises:
        InputError: the sheet cannot be cut with this kerf or does not fit the stock, or a part
            cannot be glued on.
    """
    levels = levels_of(design)
    printed = [lay_on_bed(level, options.printer) for level in levels if level.part is not None]
    warnings = check_stack(levels) + _check_slits(design)
    for part in printed:
        warnings += _check_bed(part, options.printer)
        if part.level.part is not None:
            warnings += check_part(part.level.part, options.printer)
    if printed and not writes_3mf():
        warnings.append("3MF files are left out: lib3mf is not installed. Print the STL files.")
    on_event(Progress(0.1, "printed parts"))
    told: dict[str, str] = {}
    files: dict[str, bytes] = {}
    _add_solids(design, printed, options.printer, files, told)
    on_event(Progress(0.3, "lines to cut"))
    warnings += _add_drawings(design, options, files, told)
    on_event(Progress(0.6, "template"))
    for paper in options.papers:
        name = f"template-{paper}.pdf"
        try:
            files[name] = template_pdf(design, levels, paper)
        except InputError as error:
            warnings.append(f"{name} is left out: {error.message}.")
            continue
        told[name] = f"Template in true size on {PAPER_NAMES[paper]}."
    on_event(Progress(0.8, "assembly sheet"))
    told["assembly.html"] = "This sheet, as a page."
    told["assembly.pdf"] = "This sheet, to print."
    sheet = describe(
        design, levels, printed, options, prediction=prediction, warnings=warnings, files=told
    )
    files["assembly.html"] = assembly_html(sheet).encode("utf-8")
    files["assembly.pdf"] = assembly_pdf(sheet, options.papers[0] if options.papers else "a4")
    return Contents(files, sheet.warnings)


def _check_slits(design: Design) -> list[str]:
    """The model cuts all layers along a slit; a printed part is in one piece."""
    warnings = []
    for part in design.inert_parts:
        crossing = design.layout.slits.intersection(part.region)
        if crossing.length > 1e-6:
            at = crossing.representative_point()
            warnings.append(
                f"{part.name}: a slit runs through it near ({1e3 * at.x:.4g}, {1e3 * at.y:.4g}) "
                "mm. The computed shape is cut there through all layers: cut the part too, before "
                "you glue it."
            )
    return warnings


def _check_bed(part: PrintedPart, profile: PrinterProfile) -> list[str]:
    low_x, low_y, high_x, high_y = part.plan.bounds
    size = f"{1e3 * (high_x - low_x):.1f} × {1e3 * (high_y - low_y):.1f} mm"
    bed = f"{1e3 * profile.bed_width:g} × {1e3 * profile.bed_depth:g} mm"
    if not part.fits:
        return [
            (
                f"{part.name}: {size} is larger than the bed of {profile.name} ({bed}), however it "
                "is turned; split the part or choose a larger printer. It is on no plate."
            )
        ]
    if part.angle:
        degrees = round(57.29577951308232 * part.angle)
        return [f"{part.name}: is turned by {degrees}° on the bed of {profile.name}, to fit."]
    return []


def _add_solids(
    design: Design,
    printed: Sequence[PrintedPart],
    profile: PrinterProfile,
    files: dict[str, bytes],
    told: dict[str, str],
) -> None:
    if not printed:
        return
    for name, part in zip(part_names(part.name for part in printed), printed, strict=True):
        what = f"{part.name}, {1e3 * part.thickness:g} mm"
        bodies = part.bodies()
        side = "upper" if part.level.face == "bottom" else "lower"
        note = (
            f"Print the face on the bed as it is: it is the {side} face of the part, to be glued."
        )
        files[f"parts/{name}.stl"] = bytes_stl(bodies)
        if not writes_3mf():
            told[f"parts/{name}.stl"] = f"Printed part: {what}. Its numbers are millimetres."
            continue
        files[f"parts/{name}.3mf"] = bytes_3mf(bodies, _metadata(design, what, note))
        told[f"parts/{name}.3mf"] = f"Printed part: {what}."
        told[f"parts/{name}.stl"] = "The same without unit and name; its numbers are millimetres."
    if not writes_3mf():
        return
    beds = arrange(printed, profile)
    for name, bed in zip(plate_names(len(beds)), beds, strict=True):
        bodies = tuple(body for part in bed for body in part.bodies())
        files[f"parts/{name}.3mf"] = bytes_3mf(
            bodies, _metadata(design, "all parts", f"Arranged on the bed of {profile.name}.")
        )
        told[f"parts/{name}.3mf"] = (
            f"On one bed, for one sheet: {', '.join(part.name for part in bed)}."
        )


def _add_drawings(
    design: Design, options: FabricationOptions, files: dict[str, bytes], told: dict[str, str]
) -> list[str]:
    """Add what is to be cut; what had to be left out comes back in sentences."""
    left_out: list[str] = []
    _add(files, "cut/sheet", cut.sheet_inks(design, options.kerf), f"{design.name}: sheet")
    told["cut/sheet.dxf, .svg"] = "The sheet to cut: outline, holes, slits, each on its layer."
    if design.inert_parts:
        inks, left_out = cut.pattern_inks(design, options.kerf)
        if inks:
            _add(files, "cut/pattern", inks, f"{design.name}: parts")
            told["cut/pattern.dxf, .svg"] = (
                "The parts seen from above, a layer each, to cut instead of print."
            )
    if options.stock is not None:
        drawings = _nested(design, options, options.stock)
        for number, inks in enumerate(drawings, 1):
            name = "nest" if len(drawings) == 1 else f"nest-{number}"
            _add(files, f"cut/{name}", inks, f"{design.name}: stock {number} of {len(drawings)}")
        more = f" on {len(drawings)} sheets of stock" if len(drawings) > 1 else ""
        told["cut/nest*.dxf, .svg"] = f"{options.copies} × the sheet, nested{more}."
    return left_out


def _nested(
    design: Design, options: FabricationOptions, stock: tuple[float, float]
) -> list[list[Ink]]:
    """For each sheet of stock its drawing."""
    import shapely

    from sheetmorph.drawing.ink import Ink

    sheet = cut.cut_region(design.outline_polygon(), options.kerf, "the sheet").geoms[0]
    slits = design.layout.slits
    drawings = []
    for places in nest(sheet, options.copies, stock, options.spacing):
        placed = shapely.MultiPolygon([place.apply(sheet) for place in places])
        inks = cut.contour_inks(placed)
        if not slits.is_empty:
            moved = tuple(place.apply(slits) for place in places)
            inks.insert(0, Ink(cut.SLITS, moved, cut.COLOURS[cut.SLITS]))
        frame = shapely.box(0.0, 0.0, *stock).exterior
        drawings.append([*inks, Ink(cut.STOCK, (frame,), cut.COLOURS[cut.STOCK])])
    return drawings


def _add(files: dict[str, bytes], name: str, inks: Sequence[Ink], title: str) -> None:
    from sheetmorph.drawing.write_dxf import dxf_bytes
    from sheetmorph.drawing.write_svg import svg_bytes

    files[f"{name}.dxf"] = dxf_bytes(inks)
    files[f"{name}.svg"] = svg_bytes(inks, margin=MARGIN, title=title)


def _metadata(design: Design, what: str, note: str) -> dict[str, str]:
    return {
        "Title": f"{design.name}: {what}",
        "Description": note,
        "Application": f"sheetmorph {__version__}",
    }
