"""Validation errors of a design, told to people: one line, the dotted key, what is allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.fields import NAME_ALLOWED, PROBLEM

_TAGGED = ("outline", "pattern", "supports", "loads")

_SIMPLE: dict[str, str] = {
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": 'must be text in quotes, "like this"',
    "finite_number": "must be a finite number",
    "string_too_short": "must not be empty",
}


def to_input_error(error: ValidationError) -> InputError:
    """The first problem that pydantic found, with the number of others."""
    details = _without_echoes(error.errors(include_url=False))
    first = _translate(details[0])
    if len(details) == 1:
        return first
    more = f" (and {len(details) - 1} more)"
    if first.allowed is not None:
        return InputError(
            first.message, key=first.key, value=first.value, allowed=first.allowed + more
        )
    return InputError(first.message + more, key=first.key, value=first.value)


def _without_echoes(details: Sequence[Any]) -> list[Any]:
    """Leave out lists that are "too short" only because their entries are wrong."""
    places = [tuple(detail["loc"]) for detail in details]
    return [
        detail
        for detail, place in zip(details, places, strict=True)
        if detail["type"] != "too_short"
        or not any(len(other) > len(place) and other[: len(place)] == place for other in places)
    ]


def dotted(path: Sequence[str | int]) -> str:
    """`("layers", 1, "thickness")` as `layers[1].thickness`."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            text += f".{part}" if text else part
    return text


def _translate(detail: Mapping[str, Any]) -> InputError:
    kind, context = str(detail["type"]), detail.get("ctx", {})
    path, given = _without_tags(detail["loc"]), detail.get("input")
    key = dotted(path)
    if kind == PROBLEM:
        inner = context["key"]
        full = f"{key}.{inner}" if key and inner else key or inner
        return InputError(
            context["text"], key=full, value=context["value"], allowed=context["allowed"]
        )
    if kind in _SIMPLE:
        return InputError(_SIMPLE[kind], key=key, value=given)
    if kind == "missing":
        if path and isinstance(path[-1], int):
            return InputError("needs two values", key=dotted(path[:-1]), allowed="[x, y]")
        return InputError("is required", key=key)
    if kind == "literal_error":
        return _choice(key, given, str(context["expected"]).replace("'", ""))
    if kind == "union_tag_invalid":
        expected = str(context["expected_tags"]).replace("'", "")
        return _choice(f"{key}.kind", given.get("kind") if given else None, expected)
    if kind == "union_tag_not_found":
        return _untagged(key, path, given)
    return _structural(kind, key, path, given, context)


def _structural(
    kind: str, key: str, path: Sequence[str | int], given: Any, context: Mapping[str, Any]
) -> InputError:
    """Problems of size, range and nesting."""
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return InputError("must be a table", key=key, value=given, allowed=f"[{key}]")
    if kind in ("tuple_type", "list_type"):
        return InputError("must be a list", key=key, value=given)
    if kind in ("too_short", "too_long"):
        least, most = context.get("min_length"), context.get("max_length")
        bound = f"≥ {least}" if kind == "too_short" else f"≤ {most}"
        return InputError(
            f"has {context['actual_length']} entries", key=key, allowed=f"{bound} entries"
        )
    if kind == "string_too_long":
        return InputError(
            "is too long", key=key, value=given, allowed=f"≤ {context['max_length']} characters"
        )
    if kind == "string_pattern_mismatch":
        allowed = NAME_ALLOWED if key == "name" else "printable characters"
        return InputError(
            "has a character that is not allowed", key=key, value=given, allowed=allowed
        )
    for sign, name in (("≥", "ge"), (">", "gt"), ("≤", "le"), ("<", "lt")):
        if name in context:
            return InputError(
                "is out of range", key=key, value=given, allowed=f"{sign} {context[name]:g}"
            )
    return InputError(f"cannot be used ({kind.replace('_', ' ')})", key=key, value=given)


def _choice(key: str, given: object, expected: str) -> InputError:
    names = [name.strip() for name in expected.replace(" or ", ", ").split(",")]
    guess = nearest(given, names) if isinstance(given, str) else None
    hint = (
        f"is not one of the choices; did you mean {guess}?"
        if guess
        else ("is not one of the choices")
    )
    return InputError(hint, key=key, value=given, allowed=", ".join(names))


def _untagged(key: str, path: Sequence[str | int], given: Any) -> InputError:
    if not isinstance(given, Mapping):
        brackets = f"[[{path[0]}]]" if len(path) > 1 else f"[{key}]"
        return InputError("must be a table", key=key, value=given, allowed=brackets)
    return InputError("is required: it says what this is", key=f"{key}.kind")


def _without_tags(path: Sequence[str | int]) -> list[str | int]:
    """The path in the file: pydantic adds the kind of a shape after its place."""
    if not path or path[0] not in _TAGGED:
        return list(path)
    place = 1 if path[0] == "outline" else 2
    return [*path[:place], *path[place + 1 :]]
