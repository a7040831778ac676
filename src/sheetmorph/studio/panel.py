"""The side panel: the keys of a design with their values, units, ranges and words.

It is read off the schema of the design file, so that a new key is on the panel at once.
"""

from __future__ import annotations

import inspect
import re
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel

from sheetmorph.core.units import Kind, format_si, to_si
from sheetmorph.design.fields import Quantity

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design

UNITS: dict[Kind, str] = {
    "length": "mm",
    "pressure": "MPa",
    "density": "kg/m^3",
    "force": "mN",
    "force per length": "N/m",
    "acceleration": "m/s^2",
    "temperature": "degC",
    "angle": "deg",
    "time": "s",
    "dimensionless": "",
}
"""Units in which the panel shows quantities."""

DIGITS = 6
_HIDDEN = {"kind", "operation", "part", "clip", "mirror", "grid_array", "polar_array"}
_TABLES: tuple[tuple[str, str], ...] = (
    ("actuation", "Actuation"),
    ("perturbation", "Perturbation load"),
    ("mesh", "Mesh"),
    ("published", "Mechanical model"),
    ("laminate", "Mechanical model"),
    ("solver", "Solver"),
)
MODELS = ("published", "laminate")
_FOLDED = {*MODELS, "solver"}
_MODEL = {
    "key": "model",
    "label": "Model",
    "type": "choice",
    "choices": list(MODELS),
    "help": "of the mechanics: the reduced one of the paper, or layered shells",
    "given": True,
}


def panel(design: Design) -> list[dict[str, Any]]:
    """The groups of the panel from top to bottom, each with its entries; ready for JSON."""
    groups = [_group("outline", f"Sheet: {_words(design.outline.kind)}", design.outline)]
    for index, shape in enumerate(design.pattern):
        title = f"Pattern {index + 1}: {_words(shape.kind)}"
        groups.append(_group(f"pattern.{index}", title, shape) | {"shape": index})
    for index, layer in enumerate(design.layers):
        groups.append(_group(f"layers.{index}", f"Layer {index + 1}: {layer.name}", layer))
    for name, title in _TABLES:
        if name in MODELS and name != design.model:
            continue
        group = _group(name, title, getattr(design.spec, name))
        if name in MODELS:
            group["entries"].insert(0, {**_MODEL, "value": design.model})
        groups.append(group | {"folded": name in _FOLDED})
    return [group for group in groups if group["entries"]]


def _group(key: str, title: str, section: BaseModel) -> dict[str, Any]:
    words = _described(type(section))
    entries = []
    for name, field in type(section).model_fields.items():
        if name in _HIDDEN:
            continue
        annotation = field.annotation
        rules = [annotation, *field.metadata]
        entry = _entry(getattr(section, name), rules)
        if entry is not None:
            told = {"key": f"{key}.{name}", "label": _words(name), "help": words.get(name, "")}
            entries.append(told | entry | {"given": name in section.model_fields_set})
    return {"key": key, "title": title, "entries": entries, "folded": False}


def _entry(value: Any, rules: list[Any]) -> dict[str, Any] | None:
    """Type, value and range of one key; None for what has no simple editor."""
    kinds = [_inner(rule) for rule in rules]
    flat = [part for parts in kinds for part in parts]
    quantity = next((part for part in flat if isinstance(part, Quantity)), None)
    choices = next((get_args(part) for part in flat if get_origin(part) is Literal), None)
    if quantity is not None and not any(get_origin(part) is tuple for part in flat):
        return _quantity(value, quantity, choices)
    if get_origin(rules[0]) is tuple and quantity is not None:
        return _pair(value)
    if choices is not None:
        return {"type": "choice", "choices": list(choices), "value": value}
    if isinstance(value, bool):
        return {"type": "flag", "value": value}
    if isinstance(value, int | float) or (value is None and {int, float} & _types(flat)):
        return {"type": "whole" if int in _types(flat) else "number", "value": value} | _range(flat)
    return None


def _inner(annotation: Any) -> list[Any]:
    """An annotation and everything that is wrapped in it."""
    parts = [annotation]
    if get_origin(annotation) is Annotated:
        base, *more = get_args(annotation)
        parts += [*_inner(base), *more]
        parts += [rule for extra in more for rule in getattr(extra, "metadata", ())]
    elif get_origin(annotation) is not Literal:
        for part in get_args(annotation):
            parts += _inner(part)
    return parts


def _types(parts: list[Any]) -> set[type]:
    return {part for part in parts if part in (int, float)}


def _quantity(value: Any, quantity: Quantity, choices: Any) -> dict[str, Any] | None:
    if choices is not None or isinstance(value, str):
        return None  # a direction may be "radial"
    unit = UNITS[quantity.kind]
    entry: dict[str, Any] = {"type": "quantity", "unit": unit, "value": None}
    if value is not None:
        entry["value"] = float(format_si(value, quantity.kind, unit, DIGITS).split()[0])
    for name, bound in (("low", quantity.low), ("high", quantity.high)):
        if bound is not None:
            number = format_si(to_si(bound, quantity.kind), quantity.kind, unit, DIGITS)
            entry[name] = float(number.split()[0])
    return entry


def _pair(value: Any) -> dict[str, Any] | None:
    """A point or an interval: two lengths."""
    if not (isinstance(value, tuple) and len(value) == 2):
        return None
    if not all(isinstance(number, float) for number in value):
        return None
    return {"type": "pair", "unit": "mm", "value": [round(1e3 * number, 6) for number in value]}


def _range(parts: list[Any]) -> dict[str, float]:
    found: dict[str, float] = {}
    for part in parts:
        if isinstance(part, Ge | Gt):
            found["low"] = float(part.ge if isinstance(part, Ge) else part.gt)  # type: ignore[arg-type]
        if isinstance(part, Le | Lt):
            found["high"] = float(part.le if isinstance(part, Le) else part.lt)  # type: ignore[arg-type]
    return found


_LABELS = {"eps_pre": "Free strain ε"}


def _words(name: str) -> str:
    return _LABELS.get(name) or name.replace("_", " ").capitalize()


@lru_cache(maxsize=256)
def _described(section: type) -> dict[str, str]:
    """What the docstrings of a section and of its bases say of its attributes."""
    found: dict[str, str] = {}
    for base in reversed(section.__mro__):
        text = inspect.cleandoc(base.__doc__ or "")
        if "Attributes:" not in text:
            continue
        body = text.split("Attributes:", 1)[1]
        for match in re.finditer(r"^    (\w+): (.*(?:\n {8}.*)*)", body, re.MULTILINE):
            found[match[1]] = " ".join(match[2].split())
    return found
