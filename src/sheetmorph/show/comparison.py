"""All that can be seen of a comparison, written into its folder in one go."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sheetmorph.core.files import write_text
from sheetmorph.show import guard
from sheetmorph.show.guard import Written
from sheetmorph.show.pictures import borrowed
from sheetmorph.show.render import RenderWorker

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.show.comparison_views import Names

DATA = "comparison.json"
PAGE = "comparison.html"
ALIGNED = "aligned_scan.stl"
PICTURES = ("overlay.png", "distance.png", "ssim.png", "histogram.png")
OUTPUTS = (DATA, PAGE, ALIGNED, *(f"pictures/{name}" for name in PICTURES))
"""What a comparison writes into its folder, and what the next one there replaces."""


def check_folder(folder: str | Path, force: bool, inputs: Iterable[Path] = ()) -> None:
    """Refuse a folder that holds a comparison, or that cannot be one.

    Raises:
        InputError, OutputError: see `guard.check_folder`.
    """
    marker = Path(folder) / DATA
    guard.check_folder(
        folder,
        OUTPUTS,
        "comparison",
        ours=lambda _file: marker.exists(),
        force=force,
        inputs=inputs,
    )


def write_comparison(
    comparison: Comparison,
    folder: str | Path,
    names: Names,
    worker: RenderWorker | None = None,
    *,
    pictures: bool = True,
    force: bool = False,
    more: Mapping[str, Any] | None = None,
) -> Written:
    """Write a comparison: its numbers, the aligned scan, pictures and the page.

    Args:
        comparison: what was found.
        folder: where to write; made when absent.
        names: what to call shape and scan.
        worker: draws both; started early it saves a second. One is started and ended here
            when absent.
        pictures: draw `pictures/*.png`.
        force: replace the comparison that is in the folder.
        more: further entries of `comparison.json`.

    Raises:
        InputError: the folder holds a comparison and `force` is not set.
        OutputError: a file cannot be written; no half-written file is left.
        ComputationError: SHEETMORPH_RENDERER=vtk, and VTK does not draw.
    """
    from sheetmorph.geometry.writers import write_stl
    from sheetmorph.show.comparison_report import write_page

    place = Path(folder)
    check_folder(place, force)
    notes: Sequence[str] = ()
    drawn: list[Path] = []
    data = comparison.to_json() | dict(more or {})
    # The numbers come first, so that a folder cut off half way is known as a comparison.
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(place / DATA, text + "\n")
    if pictures:
        with borrowed(worker) as painter:
            drawn = _draw(comparison, place / "pictures", names, painter)
            notes = [painter.note] if painter.note else []
    else:
        # Pictures of an earlier comparison would belie the new numbers.
        for name in PICTURES:
            (place / "pictures" / name).unlink(missing_ok=True)
    write_stl(place / ALIGNED, comparison.scan.triangles, comparison.scan.points)
    page = write_page(comparison, data, place / PAGE, names, drawn, notes)
    return Written((place / DATA, page, place / ALIGNED, *drawn), tuple(notes))


def _draw(comparison: Comparison, folder: Path, names: Names, painter: RenderWorker) -> list[Path]:
    from sheetmorph.show.comparison_pictures import Images, write_pictures
    from sheetmorph.show.comparison_views import views_of

    views = views_of(comparison)
    images = Images(
        both=painter.draw(views.both),
        scan=painter.draw(views.scan),
        shape=painter.draw(views.shape),
    )
    return write_pictures(comparison, views, images, names, folder)
