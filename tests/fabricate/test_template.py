"""The paper template measured as a maker would: with a ruler, and pasted together."""

from __future__ import annotations

import re

import numpy as np
import pypdfium2
import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.options import PAPERS
from sheetmorph.fabricate.picture import plan_picture
from sheetmorph.fabricate.stack import levels_of
from sheetmorph.fabricate.template import (
    BAR_HEIGHT,
    BARS,
    MARGIN,
    OVERLAP,
    Tiling,
    template_pdf,
    tiling,
)

DPI = 300
BIG = (
    '[[pattern]]\nkind = "star"\narms = 6\narm_length = "180 mm"\nhalf_width = "9 mm"\n'
    '[outline]\nkind = "disc"\nradius = "200 mm"'
)


def pages(data: bytes, dpi: float = DPI) -> list[np.ndarray]:
    """The pages in shades of grey."""
    document = pypdfium2.PdfDocument(data)
    images = [page.render(scale=dpi / 72.0).to_pil().convert("L") for page in document]
    return [np.asarray(image) for image in images]


def mm(pixels: float, dpi: float = DPI) -> float:
    return 25.4 * pixels / dpi


def run_length(row: np.ndarray) -> int:
    """Length of the first dark run."""
    dark = np.flatnonzero(row < 128)
    breaks = np.flatnonzero(np.diff(dark) > 1)
    return int(breaks[0] + 1) if len(breaks) else len(dark)


@pytest.mark.parametrize("paper", PAPERS)
def test_the_scale_bars_are_as_long_as_they_say(bowl, make, paper: str) -> None:
    for design, upright in ((bowl, True), (make(BIG), None)):
        data = template_pdf(design, levels_of(design), paper)
        document = pypdfium2.PdfDocument(data)
        width, height = PAPERS[paper]
        for page in document:
            found = sorted(0.0254 / 72 * side for side in page.get_size())
            assert found == pytest.approx([width, height], abs=1e-5)
            assert upright is None or page.get_size()[0] < page.get_size()[1]
        for image in pages(data):
            for index, (name, length) in enumerate(BARS):
                height_of_bar = MARGIN + 0.0115 - 0.0085 * index + 0.5 * BAR_HEIGHT
                row = image[round(image.shape[0] - height_of_bar / 0.0254 * DPI)]
                assert mm(run_length(row)) == pytest.approx(1e3 * length, abs=0.2), name


def test_one_page_is_enough_for_the_designs_of_the_paper(bowl) -> None:
    for paper in PAPERS:
        assert len(pypdfium2.PdfDocument(template_pdf(bowl, levels_of(bowl), paper))) == 1


def test_tiles_cover_the_drawing_and_overlap() -> None:
    bounds = (-0.21, -0.3, 0.33, 0.1)
    plan = tiling(bounds, "a4")
    assert plan.columns * plan.rows == len(plan.tiles)
    assert plan.tiles[0].label == "A1"
    assert [tile.label for tile in plan.tiles][: plan.columns + 1] == [
        *["A1", "B1", "C1"][: plan.columns],
        "A2",
    ]
    union = shapely.union_all([shapely.box(*tile.window) for tile in plan.tiles])
    assert union.covers(shapely.box(*bounds))
    one, other = plan.tiles[0].window, plan.tiles[1].window
    assert one[2] - other[0] == pytest.approx(OVERLAP)
    assert one[1] == other[1]
    below = plan.tiles[plan.columns].window
    assert below[3] - one[1] == pytest.approx(OVERLAP)


@pytest.mark.parametrize("paper", PAPERS)
def test_pages_pasted_together_show_the_outline(make, paper: str) -> None:
    design = make(BIG)
    levels = levels_of(design)
    plan = tiling(plan_picture(design, levels, pen=3e-4, hatch=2e-3, ticks=True).bounds, paper)
    assert len(plan.tiles) >= 4
    dpi = 100.0
    images = pages(template_pdf(design, levels, paper), dpi)
    assert len(images) == len(plan.tiles)
    pasted = _pasted(plan, images, dpi)
    low = np.min([tile.window[:2] for tile in plan.tiles], axis=0)
    high = np.max([tile.window[2:] for tile in plan.tiles], axis=0)
    scale = dpi / 0.0254
    for shape, step in (
        (design.outline_polygon().exterior, 1e-3),
        (design.inert_parts[0].region.geoms[0].exterior, 1e-3),
    ):
        points = shapely.get_coordinates(
            shapely.line_interpolate_point(shape, np.arange(0.0, shape.length, step))
        )
        column = np.round((points[:, 0] - low[0]) * scale - 0.5).astype(int)
        row = np.round((high[1] - points[:, 1]) * scale - 0.5).astype(int)
        around = [
            pasted[row + j, column + i] for i in (-1, 0, 1) for j in (-1, 0, 1)
        ]  # a pixel is 0.25 mm
        assert (np.min(around, axis=0) < 200).all()
    # And nothing dark lies where the sheet is empty.
    empty = shapely.Point(0.0, 0.0).buffer(0.17) - design.inert_parts[0].region.buffer(4e-3)
    for spot in empty.geoms:
        x, y = spot.representative_point().coords[0]
        assert pasted[int((high[1] - y) * scale), int((x - low[0]) * scale)] > 230


def _pasted(plan: Tiling, images: list[np.ndarray], dpi: float) -> np.ndarray:
    """Pages laid upon each other, darkest on top, as pasted sheets held against a window."""
    scale = dpi / 0.0254
    low = np.min([tile.window[:2] for tile in plan.tiles], axis=0)
    high = np.max([tile.window[2:] for tile in plan.tiles], axis=0)
    wide, tall = np.ceil((high - low) * scale).astype(int) + 2
    canvas = np.full((tall, wide), 255, dtype=np.uint8)
    for tile, image in zip(plan.tiles, images, strict=True):
        x, y = plan.origin
        left, top = round(x * scale), round((plan.paper[1] - y) * scale)
        columns = round((tile.window[2] - tile.window[0]) * scale)
        rows = round((tile.window[3] - tile.window[1]) * scale)
        # Off the trim line, which is drawn on the window's edge.
        part = image[top - rows + 3 : top - 3, left + 3 : left + columns - 3]
        at_x = round((tile.window[0] - low[0]) * scale) + 3
        at_y = round((high[1] - tile.window[3]) * scale) + 3
        place = canvas[at_y : at_y + part.shape[0], at_x : at_x + part.shape[1]]
        np.minimum(place, part[: place.shape[0], : place.shape[1]], out=place)
    return canvas


def test_every_page_says_what_it_is(make, two_faces) -> None:
    def text_of(design) -> list[str]:
        document = pypdfium2.PdfDocument(template_pdf(design, levels_of(design), "a4"))
        return [page.get_textpage().get_text_range() for page in document]

    for number, text in enumerate(text_of(make(BIG)), 1):
        assert "Print at 100 %" in text
        assert "50 mm" in text
        assert "2 in" in text
        assert f"Page {number} of" in text
        assert re.search(r"\b[A-C][1-3]\b", text)
        assert "|" in text  # crosses named after the pages they join
        assert not re.search(r"\b20\d\d\b", text), "no date"
    above, below = text_of(two_faces)
    assert "Seen from above" in above
    assert "Underside" in below
    assert "U-A1" in below


def test_the_underside_is_the_mirror_image(two_faces) -> None:
    """Laid on its page, the sheet turned over must fit the outline; the hole shows the hand."""
    front, back = pages(template_pdf(two_faces, levels_of(two_faces), "a4"), 150.0)
    # The window is as high as the page less margins and footer; both are centred in it.
    strip = slice(0, round(front.shape[0] * 0.85))
    dark = [np.argwhere(image[strip] < 60) for image in (front, back)]
    assert dark[0].min(axis=0) == pytest.approx(dark[1].min(axis=0), abs=2)
    mirrored = back[strip, ::-1] < 60
    outline = front[strip] < 60
    # All the dark of the one is near the dark of the other, mirrored.
    from scipy.ndimage import binary_dilation

    near = binary_dilation(mirrored, iterations=4)
    assert (outline & ~near).sum() < 0.02 * outline.sum()
    assert (outline & ~binary_dilation(back[strip] < 60, iterations=4)).sum() > 100


def test_the_same_design_gives_the_same_bytes(two_faces) -> None:
    one, other = (template_pdf(two_faces, levels_of(two_faces), "letter") for _ in range(2))
    assert one == other


def test_a_wall_of_pages_is_refused() -> None:
    with pytest.raises(InputError, match=r"would take \d+ pages of A4"):
        tiling((0.0, 0.0, 3.0, 3.0), "a4")
