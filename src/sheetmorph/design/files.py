"""Design files: TOML text to plain data, edits that keep comments, safe paths beside it."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

import numpy as np

from sheetmorph.core import strangers
from sheetmorph.core.errors import InputError, nearest, shorten

MAX_BYTES = 5_000_000
REFERENCE_VARIABLE = "SHEETMORPH_REFERENCE_DATA"

_MAX_DEPTH = 12
_EXCLUSIVE: tuple[tuple[str, ...], ...] = (
    ("actuation.eps_pre", "actuation.temperature"),
    ("mesh.size", "mesh.file", "mesh.reference_file"),
    ("perturbation.force_per_node", "perturbation.total_force"),
    ("gravity.orientation", "gravity.direction"),
)
_TABLES = {"published": "laminate", "laminate": "published"}
_DEEP_KEY = re.compile(rf"(?<![\w\"'-])(?:[\w\"'-]++[ \t]*+\.[ \t]*+){{{_MAX_DEPTH}}}")
_KEY = re.compile(r"[A-Za-z0-9_-]{1,60}(?:(?:\.[A-Za-z0-9_-]{1,60})|(?:\[\d{1,6}\])){0,8}")


def read_design_text(path: Path) -> str:
    """Text of a design file.

    Raises:
        InputError: no such file, not a file, larger than `MAX_BYTES`, or not UTF-8.
    """
    return strangers.read_text(path, MAX_BYTES, "a design file")


def parse_design_text(text: str) -> dict[str, Any]:
    """Plain data of TOML text.

    Raises:
        InputError: too long, nested too deeply, or not TOML (with line and column).
    """
    if len(text) > MAX_BYTES:
        raise InputError("the design is too large", allowed=f"≤ {MAX_BYTES / 1e6:g} MB")
    _check_depth(text)
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason = " ".join(str(error).split())
        raise InputError(f"is not valid TOML: {reason}") from None
    except RecursionError:
        raise InputError("is nested too deeply", allowed=f"≤ {_MAX_DEPTH} levels") from None
    except ValueError as error:
        raise InputError(f"has a number that cannot be read ({shorten(str(error))})") from None


def edit_design_text(text: str, values: Mapping[str, object]) -> str:
    """The text with some keys set, comments and order kept.

    Setting one of several keys that exclude each other removes the others; setting the model
    removes the table of options of the other one.

    Args:
        text: TOML text.
        values: from dotted key to value. An entry of a list goes by its index or its
            name: `layers.1.thickness`, `layers[1].thickness`, `layers.PLA.thickness`.
            Text is read as TOML (`-0.3`, `true`, `[1, 2]`), or else kept as text; None
            removes the key.

    Raises:
        InputError: a key that leads nowhere, or text that is not TOML.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    document = tomlkit.parse(text)
    for model, other in _TABLES.items():
        asked = any(key.split(".")[0] == other for key in values)
        if _parsed(values.get("model")) == model and not asked:
            document.pop(other, None)
    for key, value in values.items():
        for group in _EXCLUSIVE:
            for other in group if key in group and value is not None else ():
                if other != key and values.get(other) is None:
                    _set(document, _split(other), None, other)
        try:
            _set(document, _split(key), _parsed(value), key)
        except (AttributeError, TypeError, ValueError, TOMLKitError):
            raise InputError("is not a value for a design file", key=key, value=value) from None
    return tomlkit.dumps(document)


def path_inside(folder: Path, name: str, key: str) -> Path:
    """Path of a file that must lie in `folder`.

    Raises:
        InputError: the name is absolute, leads out of the folder, or is no existing file.
    """
    allowed = f"a name such as sheet.msh or meshes/sheet.msh, inside {folder.resolve()}"
    parts = (*PurePosixPath(name).parts, *PureWindowsPath(name).parts)
    outside = (
        PurePosixPath(name).is_absolute()
        or bool(PureWindowsPath(name).anchor)
        or ".." in parts
        or "\\" in name
        or any(ord(character) < 32 for character in name)
    )
    if outside:
        raise InputError("leads out of its folder", key=key, value=name, allowed=allowed)
    root = folder.resolve()
    path = (root / name).resolve()
    if not path.is_relative_to(root):
        raise InputError("leads out of its folder by a link", key=key, value=name, allowed=allowed)
    if not path.is_file():
        raise InputError(f"there is no such file in {root}", key=key, value=name)
    return path


def reference_folder(start: Path | None) -> Path:
    """The folder of reference data.

    The environment variable `SHEETMORPH_REFERENCE_DATA` names it; otherwise it is
    `shared/reference` beside the current folder, or beside a folder above `start`.

    Raises:
        InputError: there is none.
    """
    named = os.environ.get(REFERENCE_VARIABLE)
    if named:
        folder = Path(named)
        if not folder.is_dir():
            raise InputError("is not a folder", key=REFERENCE_VARIABLE, value=named)
        return folder
    above = [] if start is None else [*start.resolve().parents]
    for parent in [Path.cwd().parent, *above]:
        folder = parent / "shared" / "reference"
        if folder.is_dir():
            return folder
    raise InputError(
        f"the reference data is not here; set {REFERENCE_VARIABLE} to its folder",
        key="mesh.reference_file",
    )


def _check_depth(text: str) -> None:
    """Refuse keys and brackets nested so deeply that parsing would be slow."""
    if _DEEP_KEY.search(text):
        raise InputError("has a key of too many parts", allowed=f"≤ {_MAX_DEPTH} levels")


def _split(key: str) -> list[str | int]:
    if not _KEY.fullmatch(key):
        raise InputError("is not a key, such as actuation.eps_pre or layers.1.thickness", key=key)
    parts = key.replace("[", ".").replace("]", "").split(".")
    return [int(part) if part.isdigit() else part for part in parts]


def _parsed(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if not isinstance(value, str):
        return value
    try:
        return parse_design_text(f"value = {value}")["value"] if "\n" not in value else value
    except InputError:
        return value


def _set(document: Any, parts: list[str | int], value: object, key: str) -> None:
    table = document
    for depth, part in enumerate(parts[:-1]):
        if isinstance(table, list):
            table = table[_index(table, part, parts[:depth], key)]
        elif isinstance(table, Mapping):
            if part not in table:
                if value is None:
                    return
                if isinstance(parts[depth + 1], int):
                    guess = nearest(str(part), [str(name) for name in table])
                    hint = f"; did you mean {guess}?" if guess else ""
                    raise InputError(f"the design has no {part}{hint}", key=key)
                _add_table(table, part)
            table = table[part]
        else:
            raise InputError(f"leads nowhere: {parts[depth - 1]} is not a table", key=key)
    last = parts[-1]
    if isinstance(table, list):
        index = _index(table, last, parts[:-1], key)
        if isinstance(table[index], Mapping) and not isinstance(value, Mapping | None):
            raise InputError("must be a table", key=key, value=value)
        if value is None:
            del table[index]
        else:
            table[index] = value
    elif not isinstance(table, Mapping):
        raise InputError(f"leads nowhere: {parts[-2]} is not a table", key=key)
    elif value is None:
        table.pop(last, None)  # type: ignore[attr-defined]
    else:
        table[last] = value  # type: ignore[index]


def _add_table(table: Any, name: str | int) -> None:
    import tomlkit

    table[name] = tomlkit.table()


def _index(items: list[Any], part: str | int, path: list[str | int], key: str) -> int:
    if not isinstance(part, int):
        names = [str(item.get("name", "")) for item in items if isinstance(item, Mapping)]
        if part in names:
            return names.index(part)
        guess = nearest(part, names)
        hint = f"; did you mean {guess}?" if guess else ""
        raise InputError(
            f"{path[-1]} is a list: write an index or a name{hint}",
            key=key,
            allowed=f"0 to {len(items) - 1}",
        )
    if part >= len(items):
        raise InputError(
            f"{path[-1]} has no entry {part}", key=key, allowed=f"0 to {len(items) - 1}"
        )
    return part
