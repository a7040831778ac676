"""The page of a search for a design."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sheetmorph.core.files import write_text
from sheetmorph.show.citations import Citation
from sheetmorph.show.numbers import Banner, Row
from sheetmorph.show.page import rendered
from sheetmorph.show.report import picture_of

if TYPE_CHECKING:
    from sheetmorph.inverse.result import Found

CLOSE, NEAR = 0.02, 0.05
"""Distances, as shares of the size, up to which a shape is told as met, and as alike."""
_CAPTIONS = {
    "found.png": "Above: the target, and the shape of the design that was found, in one view and "
    "at one scale. Below: the flat sheet of that design, and how far the target lies from the "
    "shape.",
    "search.png": "Misfit of the best design against the number of designs that were measured. "
    "Coarse meshes first, then the designs' own.",
}
_REFERENCES = (
    Citation(
        "zhang",
        "Y. Zhang, A. Alon, M. K. Jawed",
        "Emergent morphogenesis via planar fabrication enabled by a reduced model of composites",
        "",
        "the model",
    ),
    Citation(
        "hansen2001",
        "N. Hansen, A. Ostermeier",
        "Completely derandomized self-adaptation in evolution strategies",
        "Evolutionary Computation 9, 2001, 159–195",
        "the search over a family",
    ),
    Citation(
        "branch1999",
        "M. A. Branch, T. F. Coleman, Y. Li",
        "A subspace, interior, and conjugate gradient method for large-scale bound-constrained "
        "minimization problems",
        "SIAM Journal on Scientific Computing 21, 1999, 1–23",
        "the least squares at the end",
    ),
)


def write_page(
    found: Found, path: Path, pictures: Sequence[Path], notes: Sequence[str] = ()
) -> Path:
    """Write the page; it refers to nothing outside itself.

    Raises:
        OutputError: it cannot be written.
        InputError: a picture cannot be read.
    """
    title = f"{found.target.text}: {found.family}"
    page = rendered(
        "inverse.html",
        title=title,
        lead=f"A design of the family {found.family} for the target {found.target.text}.",
        banner=_banner(found),
        facts=_facts(found),
        pictures=[picture_of(file, _CAPTIONS[file.name], True, title) for file in pictures],
        groups=_groups(found),
        notes=[*found.notes, *notes],
        references=_REFERENCES,
    )
    write_text(path, page)
    return path


def _banner(found: Found) -> Banner:
    data = found.to_json()
    share = f"{100 * found.distance:.2f} % of its size"
    broken = [] if found.made is None else [f"Limit missed: {one}." for one in found.made.broken]
    if found.result.status != "completed":
        return Banner(False, "The run of the design did not reach its end", broken)
    if not data["stable"]:
        broken.append("The shape is not stable: another one is near.")
    if found.distance <= CLOSE and not broken:
        return Banner(True, "The shape meets the target", [f"It is {share} away from it."])
    if found.distance <= NEAR:
        lines = [f"It is {share} away.", *broken]
        return Banner(not broken, "The shape resembles the target", lines)
    advice = "Another family, free bounds or another size may come closer."
    lines = [f"The best is {share} away. {advice}", *broken]
    return Banner(False, "No design of the family comes close", lines)


def _facts(found: Found) -> list[Row]:
    data = found.to_json()
    wanted, got = data["wanted"], data["found"]
    return [
        Row("distance", f"{100 * found.distance:.2f} % of the size"),
        Row("distance", f"{1e3 * found.distance_m:.2f} mm"),
        Row("h/d wanted", f"{found.target.aspect_ratio:.3f}"),
        Row("h/d found", f"{got['aspect_ratio']:.3f}"),
        Row("largest width wanted", _mm(wanted["length_m"])),
        Row("largest width found", _mm(got["length_m"])),
        Row("designs measured", f"{found.evaluations}"),
        Row("time", f"{found.seconds:.0f} s"),
    ]


def _groups(found: Found) -> list[dict[str, object]]:
    data = found.to_json()
    wanted, got = data["wanted"], data["found"]
    sizes = [("", "wanted", "found")]
    for key, label in (("length_m", "largest width"), ("width_m", "smallest width")):
        sizes.append((label, _mm(wanted[key]), _mm(got[key])))
    sizes.append(("height", _mm(wanted["height_m"]), _mm(got["height_m"])))
    areas = [f"{1e4 * one['area_m2']:.2f} cm²" for one in (wanted, got)]
    sizes.append(("area", areas[0], areas[1]))
    groups: list[dict[str, object]] = [
        {"title": "Parameters", "rows": [(k, f"{v:.5g}") for k, v in found.values.items()]},
        {"title": "Sizes, both in the pose of the comparison", "rows": sizes},
    ]
    if found.made is not None:
        rows = [
            ("pieces of the pattern", f"{found.made.pieces}"),
            ("inert share of the sheet", f"{100 * found.made.inert:.1f} %"),
            ("narrower than allowed", f"{100 * found.made.narrow:.2f} %"),
        ]
        groups.append({"title": "Pattern and limits", "rows": rows})
    for name, other in found.others.items():
        rows = [
            ("distance", f"{100 * other.distance:.2f} % of the size"),
            ("h/d", f"{other.to_json()['found']['aspect_ratio']:.3f}"),
            *((key, f"{value:.4g}") for key, value in other.values.items()),
        ]
        groups.append({"title": f"On the way: {name}, in the folder {name}/", "rows": rows})
    return groups


def _mm(length: float) -> str:
    return f"{1e3 * length:.2f} mm"
