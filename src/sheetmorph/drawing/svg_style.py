"""How an element of an SVG is painted: attributes, style sheets, inheritance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.colours import colour_hex
from sheetmorph.drawing.markup import local
from sheetmorph.drawing.notes import Notes

MAX_RULES = 2000
MAX_STYLE = 2 * 2**20
MAX_TRIALS = 5_000_000
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
OWN = ("display", "opacity", "vector-effect", "clip-path", "mask")

Declared = tuple[dict[str, str], dict[str, str]]
"""Properties of a block of declarations, and those of them that are !important."""


class StyleSheet:
    """The style sheets and `style` attributes of a drawing, within bounds."""

    def __init__(self, root: Element, notes: Notes) -> None:
        from cssselect2 import ElementWrapper, Matcher

        self._matcher = Matcher()
        self._notes = notes
        self._rules = self._chains = self._trials = self._length = 0
        self._blocks: dict[str, Declared] = {}
        for element in root.iter():
            if local(element) == "style":
                self._read(element.text or "")
        self._wrapped: dict[Element, Any] = {}
        if self._rules:
            tree = ElementWrapper.from_xml_root(root).iter_subtree()
            self._wrapped = {wrapper.etree_element: wrapper for wrapper in tree}

    def declared(self, element: Element) -> dict[str, str]:
        """The properties an element declares itself: attributes, then rules, then `style`.

        Raises:
            InputError: the style sheets are too large, or too much work.
        """
        values = {name: element.attrib[name] for name in (*INITIAL, *OWN) if name in element.attrib}
        important: dict[str, str] = {}
        blocks: list[Declared] = []
        if self._rules:
            wrapper = self._wrapped[element]
            # A selector of three parts tries pairs of the elements around.
            self._trials += self._chains * (1 + len(wrapper.ancestors)) ** 2
            if self._trials > MAX_TRIALS:
                raise InputError("the style selectors are too much work; use plain classes")
            blocks = [payload for *_, payload in self._matcher.match(wrapper)]
        if "style" in element.attrib:
            blocks.append(self._block(element.attrib["style"]))
        for plain, pressing in blocks:
            values |= plain
            important |= pressing
        return values | important

    def _read(self, text: str) -> None:
        import tinycss2

        self._pay(text)
        for rule in tinycss2.parse_stylesheet(text, skip_comments=True, skip_whitespace=True):
            if rule.type != "qualified-rule":
                what = f"@{rule.at_keyword}" if rule.type == "at-rule" else "that is damaged"
                self._notes.add("style", f"the style rule {what[:40]} was ignored")
                continue
            block = _sorted(tinycss2.parse_blocks_contents(rule.content))
            for selector in tinycss2.serialize(rule.prelude).split(","):
                self._add(selector.strip(), block)

    def _add(self, selector: str, block: Declared) -> None:
        """Keep a rule of tags, classes, ids and attributes within up to two others.

        Pseudo-classes and siblings say nothing of a still drawing, and cost a walk each.
        """
        from cssselect2 import SelectorError, compile_selector_list

        self._rules += 1
        if self._rules > MAX_RULES:
            raise InputError("the drawing has too many style rules", allowed=f"≤ {MAX_RULES}")
        words = len(selector.replace(">", " ").split())
        try:
            if words > 3 or any(mark in selector for mark in ":~+"):
                raise SelectorError
            for compiled in compile_selector_list(selector):
                self._matcher.add_selector(compiled, block)
            self._chains += words > 1 or "*" in selector or "[" in selector
        except SelectorError:
            self._notes.add("style", f"the style selector {selector[:40]!r} was ignored")

    def _block(self, text: str) -> Declared:
        """The declarations of a `style` attribute; many elements share one text."""
        import tinycss2

        if text not in self._blocks:
            self._pay(text)
            self._blocks[text] = _sorted(tinycss2.parse_blocks_contents(text))
        return self._blocks[text]

    def _pay(self, text: str) -> None:
        self._length += len(text)
        if self._length > MAX_STYLE:
            raise InputError(
                "the styles of the drawing are too long",
                allowed=f"≤ {MAX_STYLE // 2**20} million characters",
            )


def inherited(parent: Mapping[str, str], declared: Mapping[str, str]) -> dict[str, str]:
    """The inheritable properties of an element."""
    own = {
        name: value for name, value in declared.items() if name in INITIAL and value != "inherit"
    }
    for name, value in own.items():
        if value in ("initial", "unset"):
            own[name] = INITIAL[name]
    return {**parent, **own}


def paint(style: Mapping[str, str], what: str) -> str | None:
    """The colour of a fill or stroke, empty when it is no plain one, None without paint."""
    text = style[what].strip().lower()
    if text == "none" or is_clear(style[f"{what}-opacity"]):
        return None
    colour = colour_hex(style["color"] if text == "currentcolor" else text)
    return "" if colour is None else colour or None


def is_clear(opacity: str) -> bool:
    """Whether an opacity leaves nothing to see."""
    try:
        return float(opacity.rstrip("% ")) <= 0.0
    except ValueError:
        return False


def _sorted(nodes: list[Any]) -> Declared:
    from tinycss2 import serialize

    plain: dict[str, str] = {}
    important: dict[str, str] = {}
    for node in nodes:
        if node.type == "declaration" and (node.lower_name in INITIAL or node.lower_name in OWN):
            chosen = important if node.important else plain
            chosen[node.lower_name] = serialize(node.value).strip()
    return plain, important
