"""Check a built site: links, anchors and pictures are there; nothing is loaded from elsewhere.

.venv/bin/python docs/site/check.py build/site
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {"src", "srcset", "data", "poster"}
"""Attributes whose address a browser loads by itself; so is `href` of a <link>."""

FOLLOWED = {"http", "https", "mailto"}
"""Kinds of addresses that people may follow to elsewhere."""


@dataclass
class Page(HTMLParser):
    """Anchors and addresses of a page."""

    anchors: set[str] = field(default_factory=set)
    loaded: list[str] = field(default_factory=list)
    linked: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the addresses in a tag."""
        for name, value in attrs:
            if not value:
                continue
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif name in LOADED or (tag == "link" and name == "href"):
                self.loaded.append(value)
            elif name == "href":
                self.linked.append(value)


def read(path: Path) -> Page:
    """Parse a page."""
    page = Page()
    page.feed(path.read_text("utf-8"))
    return page


def problems(site: Path) -> list[str]:
    """What is wrong with the site in the folder; empty when all is well."""
    pages = {path: read(path) for path in sorted(site.rglob("*.html"))}
    if not pages:
        return [f"{site}: no pages"]
    found = []
    for path, page in pages.items():
        name = path.relative_to(site)
        for address in page.loaded:
            if urlsplit(address).scheme not in {"", "data"} or address.startswith("//"):
                found.append(f"{name}: loads {address} from elsewhere")
            elif not address.startswith("data:"):
                found += missing(site, pages, path, address)
        for address in page.linked:
            if urlsplit(address).scheme not in FOLLOWED:
                found += missing(site, pages, path, address)
    return found


def missing(site: Path, pages: dict[Path, Page], page: Path, address: str) -> list[str]:
    """A line for an address that leads nowhere."""
    parts = urlsplit(address)
    name = page.relative_to(site)
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    if parts.scheme or not target.exists() or not target.is_relative_to(site):
        return [f"{name}: {address} leads nowhere"]
    anchor = unquote(parts.fragment)
    if anchor and target in pages and anchor not in pages[target].anchors:
        return [f"{name}: there is no place {anchor} in {target.relative_to(site)}"]
    return []


def main(arguments: list[str]) -> int:
    """Print the problems; returns the exit code."""
    (folder,) = arguments
    found = problems(Path(folder).resolve())
    print(
        "\n".join(found) if found else "all links lead somewhere; nothing is loaded from elsewhere"
    )
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
