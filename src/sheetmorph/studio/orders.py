"""What a browser may ask for over its socket: small tables, checked before anything is done."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from sheetmorph.core.errors import InputError, SheetmorphError
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.studio.session import MAX_TEXT, Session

MAX_KEYS = 50
MAX_VALUE = 200_000


def obey(session: Session, text: str) -> None:
    """Do what a message says; what cannot be done is told to the browser."""
    try:
        order = json.loads(text)
        if not isinstance(order, dict) or order.get("do") not in ORDERS:
            raise InputError("this is no order that the studio knows")
        ORDERS[order["do"]](session, order)
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


ORDERS: dict[str, Callable[[Session, dict[str, Any]], None]] = {
    "edit": _edit,
    "open": _open,
    "preset": _preset,
    "undo": lambda session, order: session.step(back=True),
    "redo": lambda session, order: session.step(back=False),
    "stop": lambda session, order: session.stop_help(),
}
"""The orders by their names."""
