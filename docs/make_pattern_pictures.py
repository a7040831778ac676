"""Draw the pictures of docs/patterns.md from the examples that stand in it.

Run it in the project's environment: .venv/bin/python docs/make_pattern_pictures.py
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import sheetmorph as sm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DOCS = Path(__file__).resolve().parent
CELL, GAP, LABEL, MARGIN = 220, 26, 34, 20
"""Side of a plan, space between two, height of a name, space around all [px]."""
COLOURS = 32
SECOND_PART = (142, 84, 150)

OUTLINE = """
[outline]
kind = "disc"
radius = "50 mm"
"""
"""The sheet of the examples that name none."""

LAYERS = """
[[layers]]
name = "polystyrene"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.8911 MPa"
"""

INERT = """
[[layers]]
name = "inert {part}"
role = "inert"
thickness = "0.7 mm"
young_modulus = "2.6733 MPa"
where = "{part}"
"""

REST = """
[actuation]
eps_pre = -0.3

[mesh]
size = "2.5 mm"
"""


@dataclass(frozen=True)
class Example:
    """An example of the page.

    Attributes:
        picture: name of the picture in which it is drawn.
        caption: what its first line says.
        text: its TOML.
    """

    picture: str
    caption: str
    text: str

    def design(self) -> sm.Design:
        """The example as a complete design: with a sheet, layers, actuation and mesh."""
        outline = "" if "[outline]" in self.text else OUTLINE
        parts = dict.fromkeys(re.findall(r'^part = "([^"]+)"$', self.text, re.MULTILINE))
        tables = self.text.split("[[pattern]]")[1:]
        if any("\npart = " not in table for table in tables):
            parts = {"pattern": None, **parts}
        layers = LAYERS + "".join(INERT.format(part=part) for part in parts)
        return sm.Design.from_toml(
            f'name = "example"\n{self.text}\n{outline}\n{layers}\n{REST}', DOCS
        )


def read_examples(page: Path) -> list[Example]:
    """The TOML blocks of the page that begin with a comment, and the picture above each."""
    found = []
    picture = ""
    pattern = r"!\[[^\]]*\]\(pictures/([\w.-]+)\)|^```toml\n# ([^\n]+)\n(.*?)^```"
    for match in re.finditer(pattern, page.read_text("utf-8"), re.MULTILINE | re.DOTALL):
        if match[1]:
            picture = match[1]
        else:
            found.append(Example(picture, match[2], match[3]))
    return found


def main() -> None:
    """Draw all pictures of the page."""
    from make_pictures import shrink

    from sheetmorph.show import style

    examples = read_examples(DOCS / "patterns.md")
    for name in dict.fromkeys(example.picture for example in examples):
        chosen = [example for example in examples if example.picture == name]
        with style.style():
            draw(chosen, DOCS / "pictures" / name)
        shrink(DOCS / "pictures" / name, COLOURS)


def draw(examples: list[Example], path: Path) -> None:
    """One picture: each example with its caption below."""
    from sheetmorph.show import style

    columns = max((5, 4, 3), key=lambda number: -(-len(examples) % number))
    rows = -(-len(examples) // columns)
    width = 2 * MARGIN + columns * (CELL + GAP) - GAP
    height = 2 * MARGIN + rows * (CELL + LABEL + GAP) - GAP
    sheet = style.Sheet(width, height)
    for index, example in enumerate(examples):
        x = MARGIN + index % columns * (CELL + GAP)
        y = height - MARGIN - CELL - index // columns * (CELL + LABEL + GAP)
        draw_plan(sheet.inset(x, y, CELL, CELL), example.design())
        sheet.text(x + CELL / 2, y - 8, example.caption, ha="center", va="top")
    sheet.save(path)


def draw_plan(axes: Axes, design: sm.Design) -> None:
    """The flat sheet of a design with the parts of its pattern and its slits."""
    from sheetmorph.show import style

    layout = design.layout
    fill(axes, layout.sheet, style.FILM)
    for colour, part in zip((style.BILAYER, SECOND_PART), layout.parts.values(), strict=False):
        fill(axes, part, colour)
    for slit in layout.slits.geoms:
        axes.plot(*slit.xy, color=style.INK, lw=2.5, solid_capstyle="butt")
    low_x, low_y, high_x, high_y = layout.sheet.bounds
    half = 0.51 * max(high_x - low_x, high_y - low_y)
    x, y = (low_x + high_x) / 2, (low_y + high_y) / 2
    axes.set_xlim(x - half, x + half)
    axes.set_ylim(y - half, y + half)
    axes.axis("off")


def fill(axes: Axes, shape: Any, rgb: tuple[int, int, int]) -> None:
    """Fill polygons, their holes left open."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    from sheetmorph.show import style

    for polygon in getattr(shape, "geoms", [shape]):
        rings = [
            Outline(ring.coords, closed=True) for ring in (polygon.exterior, *polygon.interiors)
        ]
        axes.add_patch(
            PathPatch(
                Outline.make_compound_path(*rings),
                facecolor=style.colour(rgb),
                edgecolor=style.INK,
                lw=0.9,
            )
        )


if __name__ == "__main__":
    main()
