"""XML from strangers: no entities, and a bounded number of elements, counted while it is read."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder

from sheetmorph.core.errors import InputError

MAX_NESTING = 256


def parsed(data: bytes, what: str, most: int, *, forbid_dtd: bool) -> Element:
    """The root element of an XML text.

    Args:
        data: the text in any encoding that it declares.
        what: the thing in words, such as "the file", for messages.
        most: how many elements it may have.
        forbid_dtd: refuse even a document type without entities.

    Raises:
        InputError: damaged, with entities, or beyond the bounds.
    """
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]
    from defusedxml.ElementTree import XMLParser  # type: ignore[import-untyped]

    parser = XMLParser(target=_Counted(what, most), forbid_dtd=forbid_dtd)
    try:
        parser.feed(data)
        root: Element = parser.close()
    except DefusedXmlException as error:
        raise InputError(
            f"{what} defines XML entities, which are not read; save it plainly"
        ) from error
    except (ValueError, SyntaxError, LookupError, AssertionError) as error:
        raise InputError(f"{what} is damaged XML ({str(error)[:100]})") from error
    return root


def local(element: Element) -> str:
    """The tag of an element without its namespace."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


class _Counted(TreeBuilder):
    """Builds the tree and refuses to build too large a one."""

    def __init__(self, what: str, most: int) -> None:
        super().__init__()
        self._what = what
        self._most = self._left = most
        self._depth = 0

    def start(self, tag: Any, attributes: Any, /) -> Element:
        """Begin an element."""
        self._left -= 1
        self._depth += 1
        if self._left < 0:
            raise InputError(f"{self._what} has too many elements", allowed=f"≤ {self._most}")
        if self._depth > MAX_NESTING:
            raise InputError(
                f"the elements of {self._what} are nested too deeply",
                allowed=f"≤ {MAX_NESTING} levels",
            )
        return super().start(tag, attributes)

    def end(self, tag: Any, /) -> Element:
        """End an element."""
        self._depth -= 1
        return super().end(tag)
