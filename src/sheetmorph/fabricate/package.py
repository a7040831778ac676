"""From a design to a folder of files for the bench, without touching what others put there."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.core.events import Listener, Notice, Progress, Started, silent
from sheetmorph.core.files import write_bytes, write_text
from sheetmorph.core.locks import FILE as LOCK
from sheetmorph.fabricate.contents import make_contents
from sheetmorph.fabricate.options import FabricationOptions, Prediction

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

MANIFEST = "package-files.json"
"""Lists what was written; a folder without it is not ours."""

_MAX_MANIFEST = 1_000_000
_OURS = re.compile(
    r"parts/[A-Za-z0-9_-]{1,80}\.(3mf|stl)"
    r"|cut/(sheet|pattern|nest(-\d{1,4})?)\.(dxf|svg)"
    r"|template-(a4|letter)\.pdf"
    r"|assembly\.(html|pdf)"
)


@dataclass(frozen=True)
class Package:
    """What was written.

    Attributes:
        folder: where.
        files: the files.
        warnings: what to know before making the parts, in sentences.
    """

    folder: Path
    files: tuple[Path, ...]
    warnings: tuple[str, ...]


def fabricate_design(
    design: Design,
    folder: str | Path,
    *,
    options: FabricationOptions | None = None,
    prediction: Prediction | None = None,
    force: bool = False,
    on_event: Listener = silent,
) -> Package:
    """Write what is needed to make a design on a bench.

    The folder receives parts/ (3MF and STL of each printed part, and of all on the bed),
    cut/ (DXF and SVG of the sheet, of the parts, and of nested copies), templates in true
    size, and the assembly sheet as HTML and PDF. All is made before anything is written.

    Args:
        design: what to make.
        folder: where to write; absent, empty, or with `force` one that was written here.
        options: how it is made; by default without kerf, one copy, a 0.4 mm printer.
        prediction: the shape to expect.
        force: replace the files of an earlier package; others are left as they are.
        on_event: told of the progress, and of every warning.

    Raises:
        InputError: the folder holds other things, or the design cannot be made this way.
        OutputError: something could not be written; what is there is whole.
    """
    place = Path(folder)
    before = _written_before(place, force)
    on_event(Started(f"{design.name}: fabrication"))
    contents = make_contents(design, options or FabricationOptions(), prediction, on_event)
    _refuse_others(place, contents.files, before)
    on_event(Progress(0.9, "writing"))
    # The list comes first, so that a package cut off half way is known as ours.
    _write_manifest(place, design.name, {*before, *contents.files})
    for name, data in contents.files.items():
        write_bytes(place / name, data)
    for name in before:
        if name not in contents.files:
            _remove(place / name)
    _write_manifest(place, design.name, contents.files)
    for warning in contents.warnings:
        on_event(Notice(warning))
    on_event(Progress(1.0, "done"))
    written = tuple(place / name for name in (*contents.files, MANIFEST))
    return Package(place, written, contents.warnings)


def check_folder(folder: str | Path, force: bool = False) -> None:
    """Refuse a folder in which a package cannot be written, before anything is computed.

    Raises:
        InputError: as for `fabricate_design`.
    """
    _written_before(Path(folder), force)


def _written_before(place: Path, force: bool) -> tuple[str, ...]:
    """Names of the files of an earlier package in a folder.

    Raises:
        InputError: the folder is not free.
    """
    if not place.exists():
        return ()
    if not place.is_dir():
        raise InputError("this is a file; choose another folder with -o", file=place)
    manifest = place / MANIFEST
    if not manifest.is_file():
        if any(file.name != LOCK for file in place.iterdir()):
            raise InputError(
                "this folder holds files that were not written by this command; choose another "
                "with -o",
                file=place,
            )
        return ()
    names = _read_manifest(manifest)
    if not force:
        raise InputError(
            "this folder holds parts; add --force to replace them, or choose another with -o",
            file=place,
        )
    return tuple(name for name in names if (place / name).is_file())


def _read_manifest(path: Path) -> list[str]:
    """The names that a list holds, if all of them can be ours."""
    error = InputError(
        "is not the list of a package that this command wrote; choose another folder with -o",
        file=path,
    )
    try:
        if path.stat().st_size > _MAX_MANIFEST:
            raise error
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        raise error from None
    names = content.get("files") if isinstance(content, dict) else None
    ours = isinstance(content, dict) and content.get("format") == "sheetmorph package"
    if not ours or not isinstance(names, list):
        raise error
    if not all(isinstance(name, str) and _OURS.fullmatch(name) for name in names):
        raise error
    return names


def _refuse_others(place: Path, wanted: Iterable[str], before: Iterable[str]) -> None:
    """Refuse to write over files that no earlier package lists, or through links."""
    for name in {"parts/x", "cut/x"}:
        within = place / name
        if within.parent.is_symlink() or (within.parent.exists() and not within.parent.is_dir()):
            raise InputError("is no folder of ours; move it away", file=within.parent)
    for name in sorted(set(wanted) - set(before)):
        if (place / name).exists() or (place / name).is_symlink():
            raise InputError(
                "this file was not written by this command; move it away, or choose another "
                "folder with -o",
                file=place / name,
            )


def _write_manifest(place: Path, name: str, files: Iterable[str]) -> None:
    content = {"format": "sheetmorph package", "design": name, "files": sorted(files)}
    write_text(place / MANIFEST, json.dumps(content, indent=2, ensure_ascii=False) + "\n")


def _remove(path: Path) -> None:
    try:
        path.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{path}: cannot be removed ({error.strerror})") from error
