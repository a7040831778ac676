"""The report of a result: one HTML page that carries all it needs."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import write_text
from sheetmorph.show import film, pictures
from sheetmorph.show.citations import references
from sheetmorph.show.numbers import banner_of, facts_of, layers_of, lead_of, tables_of
from sheetmorph.show.page import rendered

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

NAME = "report.html"

_CAPTIONS = {
    "overview.png": (
        "The sheet at several actuations: shape, dihedral angle |θ| and axial strain ε.",
        True,
    ),
    "design.png": ("The flat sheet: mesh, regions, outline of the pattern, held nodes.", False),
    "thermal_strain.png": (
        "Free strain of the sheet at full actuation; it is zero in the pattern.",
        False,
    ),
    "shape.png": (
        "The shape in perspective, true to scale. The underside of the sheet is paler.",
        True,
    ),
    "top.png": ("The shape from above (parallel projection).", False),
    "side.png": ("The shape from the side (parallel projection); z is not exaggerated.", False),
    "dihedral.png": ("How far the sheet is folded: dihedral angle between triangles.", False),
    "strain.png": ("How far the sheet is stretched: l/l₀ − 1 of the edges.", False),
    "aspect_ratio.png": ("Height over width of the shape against actuation, or time.", True),
    "energies.png": ("Where the energy of the motion comes from, and where it goes.", True),
}


def write_report(
    result: Result,
    folder: str | Path,
    *,
    notes: Sequence[str] = (),
    renderer: str = "",
) -> Path:
    """Write `<folder>/report.html`, with the pictures and the film that lie in the folder.

    Args:
        result: what was computed.
        folder: the results folder; pictures that are not there are left out.
        notes: lines for the reader, such as that of `RenderWorker.note`.
        renderer: who drew the pictures, "vtk" or "drawn"; decides on a reference.

    Returns:
        The path of the page. It refers to nothing outside itself.

    Raises:
        OutputError: it cannot be written; no half-written file is left.
        InputError: a picture in the folder cannot be read.
    """
    place = Path(folder)
    path = place / NAME
    write_text(path, render(result, place, notes=notes, renderer=renderer))
    return path


def render(result: Result, folder: Path, *, notes: Sequence[str] = (), renderer: str = "") -> str:
    """The page of `write_report` as text."""
    design, summary = result.design, result.summary
    shown = [
        picture_of(folder / pictures.FOLDER / name, caption, wide, design.name)
        for name, (caption, wide) in _CAPTIONS.items()
        if (folder / pictures.FOLDER / name).is_file()
    ]
    used = {"model": design.model, **summary, "renderer": renderer}
    return rendered(
        NAME,
        title=design.name,
        lead=lead_of(result),
        banner=banner_of(result),
        notes=list(notes),
        facts=facts_of(result),
        film=_film(result, folder),
        pictures=shown,
        layers=layers_of(design),
        tables=tables_of(summary),
        source=design.source,
        references=references(used),
        version=summary.get("version", ""),
        design_hash=summary.get("design_hash", ""),
    )


def picture_of(path: Path, caption: str, wide: bool, name: str) -> dict[str, Any]:
    """A picture as a template wants it: data, size, words, whether it takes the whole width.

    Raises:
        InputError: it cannot be read.
    """
    width, height = _size(path)
    return {
        "data": _data_uri(path),
        "width": width,
        "height": height,
        "alt": f"{name}: {caption}",
        "caption": caption,
        "wide": wide,
    }


def _film(result: Result, folder: Path) -> dict[str, Any] | None:
    path = folder / film.NAME
    if not path.is_file():
        return None
    still = folder / pictures.FOLDER / "shape.png"
    caption = (
        f"From flat to the last state; smooth frames between {len(result.positions)} "
        "computed states."
    )
    return picture_of(path, caption, True, result.design.name) | {
        "still": _data_uri(still) if still.is_file() else None
    }


def _size(path: Path) -> tuple[int, int]:
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            return image.size
    except (OSError, UnidentifiedImageError) as error:
        raise InputError("this picture is damaged; remove it and draw again", file=path) from error


def _data_uri(path: Path) -> str:
    kind = path.suffix.lstrip(".")
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
