"""How an element of an SVG is painted: attributes, style sheets, inheritance."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.notes import Notes

MAX_RULES = 2000
INITIAL: dict[str, str] = {
    "fill": "black",
    "fill-rule": "nonzero",
    "fill-opacity": "1",
    "stroke": "none",
    "stroke-width": "1",
    "stroke-linecap": "butt",
    "stroke-linejoin": "miter",
    "stroke-miterlimit": "4",
    "stroke-opacity": "1",
    "stroke-dasharray": "none",
    "color": "black",
    "visibility": "visible",
}
"""Properties that children inherit, with their values at the root."""
OWN = ("display", "opacity", "vector-effect", "clip-path", "mask", "transform")

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_SIMPLE = re.compile(r"(?P<type>[\w-]+|\*)?(?P<marks>(?:[.#][\w-]+)*)")
_MARK = re.compile(r"[.#][\w-]+")


@dataclass(frozen=True)
class _Simple:
    """What one element must have: a tag, an id, classes; `child` ties it to its parent alone."""

    tag: str
    identity: str
    classes: frozenset[str]
    child: bool

    def fits(self, element: Element) -> bool:
        """Whether the element has the tag, the id and all classes."""
        return (
            self.tag in ("", "*", local(element))
            and self.identity in ("", element.get("id", ""))
            and self.classes <= set(element.get("class", "").split())
        )


@dataclass(frozen=True)
class _Rule:
    parts: tuple[_Simple, ...]
    rank: tuple[int, int, int, int]
    values: Mapping[str, tuple[str, bool]]


class StyleSheet:
    """The rules of the <style> elements of a drawing."""

    def __init__(self, root: Element, notes: Notes) -> None:
        self._by_mark: dict[str, list[_Rule]] = defaultdict(list)
        self._count = 0
        for element in root.iter():
            if local(element) == "style":
                self._read(element.text or "", notes)

    def declared(self, element: Element, ancestors: tuple[Element, ...]) -> dict[str, str]:
        """The properties an element declares itself: attributes, then rules, then `style`."""
        values = {name: element.attrib[name] for name in (*INITIAL, *OWN) if name in element.attrib}
        values.pop("transform", None)
        important: dict[str, str] = {}
        for rule in sorted(self._matching(element, ancestors), key=lambda rule: rule.rank):
            for name, (value, presses) in rule.values.items():
                (important if presses else values)[name] = value
        for name, (value, _) in _declarations(element.get("style", "")).items():
            values[name] = value
        return values | important

    def _matching(self, element: Element, ancestors: tuple[Element, ...]) -> Iterator[_Rule]:
        if not self._count:
            return
        marks = ["*", local(element), "#" + element.get("id", "")]
        marks += ["." + name for name in set(element.get("class", "").split())]
        for mark in marks:
            for rule in self._by_mark.get(mark, ()):
                if _fits(rule.parts, element, ancestors):
                    yield rule

    def _read(self, text: str, notes: Notes) -> None:
        text = _COMMENT.sub(" ", text).replace("<!--", " ").replace("-->", " ")
        position = 0
        while (opening := text.find("{", position)) >= 0:
            selectors = text[position:opening].strip()
            closing = _closing(text, opening)
            body, position = text[opening + 1 : closing], closing + 1
            if selectors.startswith("@"):
                notes.add("style", f"the style rule {selectors[:40]!r} was ignored")
                continue
            values = _declarations(body)
            for selector in selectors.split(","):
                self._add(selector.strip(), values, notes)

    def _add(self, selector: str, values: Mapping[str, tuple[str, bool]], notes: Notes) -> None:
        parts: list[_Simple] = []
        child = False
        for word in selector.replace(">", " > ").split():
            if word == ">":
                child = True
                continue
            match = _SIMPLE.fullmatch(word)
            if match is None or len(parts) > 8:
                notes.add("style", f"the style selector {selector[:40]!r} was ignored")
                return
            marks = _MARK.findall(match["marks"])
            identity = next((mark[1:] for mark in marks if mark[0] == "#"), "")
            classes = frozenset(mark[1:] for mark in marks if mark[0] == ".")
            parts.append(_Simple(match["type"] or "", identity, classes, child))
            child = False
        if not parts:
            return
        self._count += 1
        if self._count > MAX_RULES:
            raise InputError("the drawing has too many style rules", allowed=f"≤ {MAX_RULES}")
        rank = (
            sum(bool(part.identity) for part in parts),
            sum(len(part.classes) for part in parts),
            sum(part.tag not in ("", "*") for part in parts),
            self._count,
        )
        last = parts[-1]
        marks = ["#" + last.identity] if last.identity else ["." + c for c in sorted(last.classes)]
        self._by_mark[marks[0] if marks else (last.tag or "*")].append(
            _Rule(tuple(parts), rank, values)
        )


def local(element: Element) -> str:
    """The tag of an element without its namespace."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def inherited(parent: Mapping[str, str], declared: Mapping[str, str]) -> dict[str, str]:
    """The inheritable properties of an element."""
    own = {
        name: value for name, value in declared.items() if name in INITIAL and value != "inherit"
    }
    for name, value in own.items():
        if value in ("initial", "unset"):
            own[name] = INITIAL[name]
    return {**parent, **own}


def _fits(parts: tuple[_Simple, ...], element: Element, ancestors: tuple[Element, ...]) -> bool:
    if not parts[-1].fits(element):
        return False
    if len(parts) == 1:
        return True
    if parts[-1].child:
        return bool(ancestors) and _fits(parts[:-1], ancestors[-1], ancestors[:-1])
    # The nearest fitting ancestor serves unless a '>' stands further left, which is rare.
    return any(
        _fits(parts[:-1], ancestors[k], ancestors[:k]) for k in range(len(ancestors) - 1, -1, -1)
    )


def _declarations(text: str) -> dict[str, tuple[str, bool]]:
    values: dict[str, tuple[str, bool]] = {}
    for part in text.split(";"):
        name, colon, value = part.partition(":")
        word, mark, _ = value.partition("!important")
        if colon:
            values[name.strip().lower()] = (word.strip(), bool(mark))
    return values


def _closing(text: str, opening: int) -> int:
    depth = 0
    for match in re.compile(r"[{}]").finditer(text, opening):
        depth += 1 if match[0] == "{" else -1
        if depth == 0:
            return match.start()
    return len(text)
