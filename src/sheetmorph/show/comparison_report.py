"""The page of a comparison: pictures, and every number with a sentence that says what it means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sheetmorph.core.files import write_text
from sheetmorph.show.citations import Citation
from sheetmorph.show.comparison_numbers import banner_of, facts_of, lead_of, told_of
from sheetmorph.show.page import rendered
from sheetmorph.show.report import picture_of

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.show.comparison_views import Names

TEMPLATE = "comparison.html"
_CAPTIONS = {
    "overlay.png": "Both surfaces in the frame of the shape, in parallel projection and at one "
    "scale; front looks along y. Where the shape is in front, the scan shines through it.",
    "distance.png": "How far the two are apart, point by point. Beyond the rim of the other "
    "surface it is the distance to that rim.",
    "ssim.png": "Local structural similarity seen from above: on the left the mean over the "
    "windows that hold a piece of a surface, which is the stricter one; on the right over the "
    "whole height of the box, from which the mean SSIM is made.",
    "histogram.png": "How much of the area is how far from the other surface.",
}

_REFERENCES = (
    Citation(
        "zhang",
        "Y. Zhang, A. Alon, M. K. Jawed",
        "Emergent morphogenesis via planar fabrication enabled by a reduced model of composites",
        "",
        "structural similarity of a scanned and a computed sheet",
    ),
    Citation(
        "wang2004",
        "Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli",
        "Image quality assessment: from error visibility to structural similarity",
        "IEEE Transactions on Image Processing 13, 2004, 600–612",
        "the structural similarity index",
    ),
    Citation(
        "besl1992",
        "P. J. Besl, N. D. McKay",
        "A method for registration of 3-D shapes",
        "IEEE Transactions on Pattern Analysis and Machine Intelligence 14, 1992, 239–256",
        "laying the scan over the shape",
    ),
    Citation(
        "umeyama1991",
        "S. Umeyama",
        "Least-squares estimation of transformation parameters between two point patterns",
        "IEEE Transactions on Pattern Analysis and Machine Intelligence 13, 1991, 376–380",
        "the best scale, rotation and shift",
    ),
)


def write_page(
    comparison: Comparison,
    data: Mapping[str, Any],
    path: Path,
    names: Names,
    pictures: Sequence[Path],
    notes: Sequence[str] = (),
) -> Path:
    """Write the page of a comparison; it refers to nothing outside itself.

    Args:
        comparison: what was found.
        data: the content of `comparison.json`.
        path: of the page.
        names: what shape and scan are called.
        pictures: the files to show, in this order.
        notes: lines for the reader, besides those of the comparison.

    Raises:
        OutputError: it cannot be written.
        InputError: a picture cannot be read.
    """
    title = f"{names.shape} and {names.scan}"
    shown = [picture_of(file, _CAPTIONS[file.name], True, title) for file in pictures]
    page = rendered(
        TEMPLATE,
        title=title,
        lead=lead_of(names, data),
        banner=banner_of(comparison),
        notes=[*comparison.notes, *notes],
        facts=facts_of(comparison, data),
        pictures=shown,
        groups=[{"title": name, "rows": rows} for name, rows in told_of(comparison, data).items()],
        references=_REFERENCES,
    )
    write_text(path, page)
    return path
