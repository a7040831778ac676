"""What a browser may ask for over its socket: small tables, checked before anything is done."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sheetmorph.core.errors import InputError, SheetmorphError
from sheetmorph.core.files import write_text, writing
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.studio.session import MAX_TEXT, Session
from sheetmorph.studio.tasks import APPENDED
from sheetmorph.studio.uploads import ROOM

MAX_KEYS = 50
MAX_VALUE = 200_000


def obey(session: Session, text: str) -> None:
    """Do what a message says; what cannot be done is told to the browser."""
    try:
        order = json.loads(text)
        what = order.get("do") if isinstance(order, dict) else None
        if not isinstance(what, str) or what not in ORDERS:
            raise InputError("this is no order that the studio knows")
        ORDERS[what](session, order)
    except (ValueError, RecursionError):
        session.tell("problem", text="this message is no JSON", about="order")
    except SheetmorphError as error:
        session.tell("problem", text=str(error), about="order")


def _edit(session: Session, order: dict[str, Any]) -> None:
    values = order.get("values")
    if not isinstance(values, dict) or not 0 < len(values) <= MAX_KEYS:
        raise InputError("an edit is a table of keys and values")
    for key, value in values.items():
        if len(key) > 200 or len(json.dumps(value)) > MAX_VALUE:
            raise InputError("an edit has a value that is too long", key=key[:60])
    session.edit(values, order.get("drag") is True)


def _open(session: Session, order: dict[str, Any]) -> None:
    text = order.get("text")
    if not isinstance(text, str) or len(text) > MAX_TEXT:
        raise InputError("a design is a text", allowed=f"≤ {MAX_TEXT / 1e6:g} MB")
    session.open(text)


def _preset(session: Session, order: dict[str, Any]) -> None:
    name = order.get("name")
    if name not in PRESETS:
        raise InputError("there is no such preset", value=name, allowed=", ".join(PRESETS))
    session.open(preset_text(str(name)))


def _add(session: Session, order: dict[str, Any]) -> None:
    """Add a shape to the pattern."""
    shape = order.get("shape")
    if not isinstance(shape, dict) or len(json.dumps(shape)) > MAX_VALUE:
        raise InputError("a shape is a table with its kind and sizes")
    session.edit({APPENDED: shape}, drag=False)


def _use(session: Session, order: dict[str, Any]) -> None:
    given = order.get("roles")
    file = _uploaded(session, "drawing")
    if not isinstance(given, dict):
        raise InputError("say what the drawing is to be")
    roles = {key: _text(given.get(key)) for key in ("sheet", "pattern", "slits", "unit")}
    session.help("use", {"path": str(file), "roles": roles}, "reading the drawing")


def _look(session: Session, order: dict[str, Any]) -> None:
    file = _uploaded(session, "drawing")
    content = {"path": str(file), "unit": _text(order.get("unit"))}
    session.help("look", content, "reading the drawing")


def _compare(session: Session, order: dict[str, Any]) -> None:
    content = {
        "path": str(_uploaded(session, "scan")),
        "unit": _text(order.get("unit")),
        "mirror": order.get("mirror") is True,
    }
    session.help("compare", content, "comparing with the scan")


def _export(session: Session, order: dict[str, Any]) -> None:
    what = order.get("what")
    kerf = order.get("kerf_mm", 0.0)
    if not isinstance(what, list) or not isinstance(kerf, int | float) or not 0 <= kerf <= 5:
        raise InputError("say what to export, and a kerf from 0 to 5 mm")
    with writing("a folder for the files", ROOM):
        into = Path(tempfile.mkdtemp(prefix="export-", dir=session.scratch))
    content = {"what": what, "printer": _text(order.get("printer")), "kerf": 1e-3 * kerf}
    session.help("export", {**content, "into": str(into)}, "writing files")


def _save(session: Session, order: dict[str, Any]) -> None:
    """Write the design file that the studio was started with, or hand over the text."""
    text = session.history.text
    if session.file is None:
        session.tell("text", text=text)
        return
    try:
        there = session.file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        there = None
    if there not in (None, session.saved, text) and order.get("force") is not True:
        session.tell("conflict", file=session.file.name)
        return
    write_text(session.file, text)
    session.saved = text
    session.tell("saved", file=session.file.name)


def _uploaded(session: Session, what: str) -> Path:
    file = session.uploads.get(what)
    if file is None:
        raise InputError(f"there is no {what} yet; drop one on the page")
    return file


def _text(value: object) -> str | None:
    if value is None:
        return None
    if not isinstance(value, str) or len(value) > 200:
        raise InputError("a name is a short text")
    return value


ORDERS: dict[str, Callable[[Session, dict[str, Any]], None]] = {
    "edit": _edit,
    "open": _open,
    "preset": _preset,
    "undo": lambda session, order: session.step(back=True),
    "redo": lambda session, order: session.step(back=False),
    "add": _add,
    "use": _use,
    "look": _look,
    "compare": _compare,
    "export": _export,
    "save": _save,
    "shapes": lambda session, order: session.help("shapes", {}, "looking for other shapes"),
    "forget scan": lambda session, order: session.forget_scan(),
    "stop": lambda session, order: session.stop_help(),
}
"""The orders by their names."""
