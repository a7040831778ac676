"""The assembly sheet: right numbers, the paper's protocol, nothing from outside, no injection."""

from __future__ import annotations

import io
import re

import pypdfium2
import pytest
from PIL import Image

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.assembly import Assembly, describe
from sheetmorph.fabricate.assembly_pages import assembly_html, assembly_pdf
from sheetmorph.fabricate.options import FabricationOptions, Prediction
from sheetmorph.fabricate.print3d import lay_on_bed
from sheetmorph.fabricate.printer import GENERIC
from sheetmorph.fabricate.stack import levels_of


def sheet_of(design, prediction=None, **more) -> Assembly:
    levels = levels_of(design)
    printed = [lay_on_bed(level, GENERIC) for level in levels if level.part]
    return describe(design, levels, printed, FabricationOptions(**more), prediction=prediction)


def text_of(sheet: Assembly) -> str:
    return " ".join(line for step in sheet.steps for line in step.lines)


def png(width: int = 8, height: int = 6) -> bytes:
    buffer = io.BytesIO()
    Image.new("RGB", (width, height), "#336699").save(buffer, "png")
    return buffer.getvalue()


@pytest.fixture
def predicted() -> Prediction:
    return Prediction(0.0681, 0.0692, 0.0312, 0.4551, "completed", True, png(), "A note.")


def test_masses_and_areas(bowl) -> None:
    sheet = sheet_of(bowl)
    film, part, total = sheet.parts.rows
    area = bowl.outline_polygon().area
    assert film[0] == "polystyrene"
    assert film[4] == f"{1e4 * area:.2f} cm²"
    assert film[6] == f"{1e3 * area * 0.3e-3 * 1050:.3g} g"
    pattern = bowl.pattern_polygon().area
    assert part[6] == f"{1e3 * pattern * 0.7e-3 * 1250:.3g} g"
    assert total[6] == f"{1e3 * (area * 0.3e-3 * 1050 + pattern * 0.7e-3 * 1250):.3g} g"


def test_the_protocol_of_the_paper_is_followed(bowl) -> None:
    text = text_of(sheet_of(bowl))
    for words in (
        "two-part epoxy",
        "0.1 mm once cured",
        "680 N/m²",
        "10 hours",
        "preheat the oven to 149 °C (300 °F)",
        "about 15 s",
        "film side down on non-stick foil",
        "thicker and wider parts need longer",
        "by hand, with heat-proof gloves",
    ):
        assert words in text, words
    # 680 N/m² on 27.6 cm².
    assert "0.19 kg on the glued area of this sheet, 27.6 cm²" in text
    safety = " ".join(sheet_of(bowl).safety)
    for words in ("ventilated", "styrene", "skin", "Never leave the oven alone", "food"):
        assert words in safety


def test_both_faces_are_explained(two_faces) -> None:
    sheet = sheet_of(two_faces)
    text = text_of(sheet)
    assert "turn the sheet over like a page, left to right" in text
    assert "inert rail goes on the underside and lies on the bed mirrored" in text
    assert "both faces carry parts" in text
    assert "SLITS, HOLES, then SHEET" in text
    assert [row[1] for row in sheet.layers.rows] == ["inert rail", "polystyrene", "inert arms"]


def test_parts_on_a_whole_inert_sheet(skinned) -> None:
    sheet = sheet_of(skinned)
    assert [row[3] for row in sheet.layers.rows] == [
        "printed; its upper face is glued to inner and lies on the printer's bed",
        "printed; its upper face is glued to polystyrene and lies on the printer's bed",
        "active film, whole sheet",
        "inert sheet, whole outline, glued to polystyrene",
        "printed; its lower face is glued to skin and lies on the printer's bed",
    ]
    (glue,) = [step.lines for step in sheet.steps if step.title == "Glue"]
    _, whole, top, below = glue
    assert "from below, with glue all over: polystyrene, then skin." in whole
    assert "set rib on its shaded places, on skin, the face from the bed downward." in top
    assert "skin" not in top.partition("set rib")[0]
    assert below.index("set inner on its shaded places, on polystyrene") < below.index("set outer")
    # 600 mm² of each part; the disc is a polygon of 240 sides.
    film = skinned.outline_polygon().area
    masses = [600e-6 * 0.2e-3 * 2000, 600e-6 * 0.4e-3 * 1250, film * 0.3e-3 * 1050]
    masses += [film * 0.1e-3 * 1000, 600e-6 * 0.8e-3 * 1250]
    wanted = [f"{1e3 * mass:.3g} g" for mass in (*masses, sum(masses))]
    assert [row[6] for row in sheet.parts.rows] == wanted
    # 680 N/m² over the whole sheet, which is glued to the skin.
    assert "is 0.54 kg on the glued area of this sheet, 78.5 cm², which is all" in text_of(sheet)


def test_other_kinds_of_design(make, bare) -> None:
    sheet = sheet_of(bare)
    assert [step.title for step in sheet.steps] == ["Cut the sheet", "Heat", "Take it out"]
    assert "no pattern" in sheet.warnings[0]
    swelling = sheet_of(make("", actuation="eps_pre = 0.2"))
    assert "swells by up to 20 %" in swelling.lead
    assert "15 s" not in text_of(swelling)
    hot = sheet_of(make("", actuation='temperature = "200 degC"'))
    assert "names 200 °C (392 °F)" in text_of(hot)
    assert "needs longer; the paper" not in text_of(hot)
    below = make('[[pattern]]\nkind = "disc"\nradius = "9 mm"', below=("pattern",))
    assert "Turn it over and lay it film side down" in text_of(sheet_of(below))
    assert "cut/nest holds 3 copies" in text_of(
        sheet_of(bare, copies=3, stock_width=0.3, stock_height=0.2)
    )


def test_the_page_stands_alone(two_faces, predicted) -> None:
    page = assembly_html(sheet_of(two_faces, predicted))
    assert "default-src 'none'" in page
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert "url(" not in page
    assert page.count("<svg ") == 2
    assert "data:image/png;base64," in page
    label = "Height over the largest width in any direction, h/d"
    for words in ("68.1 mm", label, "0.455", "completed", "A note."):
        assert words in page
    assert "No shape was computed" in assembly_html(sheet_of(two_faces))


def test_names_cannot_become_markup(make) -> None:
    text = '[[pattern]]\npart = "arms"\nkind = "disc"\nradius = "9 mm"'
    design = make(text).with_values({"layers.1.name": '<script>alert(1)</script> & "x" é 中'})
    nasty = Prediction(0.1, 0.1, 0.1, 1.0, "<b>", False, None, "<img src=x onerror=y>")
    sheet = sheet_of(design, nasty)
    page = assembly_html(sheet)
    assert "<script" not in page
    assert "<img" not in page
    assert "&lt;script&gt;" in page
    words = "".join(
        part.get_textpage().get_text_range() for part in pypdfium2.PdfDocument(assembly_pdf(sheet))
    )
    assert "<script>" in words.replace("\r\n", "").replace("\n", "")
    assert "中" not in words


def test_the_pdf_says_the_same(two_faces, predicted) -> None:
    sheet = sheet_of(two_faces, predicted)
    data = assembly_pdf(sheet)
    assert data == assembly_pdf(sheet)
    document = pypdfium2.PdfDocument(data)
    assert 2 <= len(document) <= 4
    assert document[0].get_size() == pytest.approx((595.28, 841.89), abs=0.01)
    words = "".join(page.get_textpage().get_text_range() for page in document)
    words = re.sub(r"\s+", " ", words)
    for step in sheet.steps:
        assert step.title in words
        for line in step.lines:
            assert line in words
    for _, value in sheet.expected:
        assert value in words
    letter = pypdfium2.PdfDocument(assembly_pdf(sheet, "letter"))
    assert letter[0].get_size() == pytest.approx((612, 792), abs=0.01)


def test_failed_and_broken_predictions(two_faces) -> None:
    for size, picture in ((0.0, None), (0.0537, png())):
        failed = Prediction(
            size, size, size, 0.7531, "not_converged", True, picture, "Ended at 4 %."
        )
        sheet = sheet_of(two_faces, failed)
        assert sheet.expected == (("Shape", "unknown"), ("Computation", "not converged"))
        assert sheet.picture_png is None
        assert sheet.expected_note.startswith("The shape is unknown: the computation did not reach")
        assert sheet.expected_note.endswith("full actuation. Ended at 4 %.")
        page = assembly_html(sheet)
        for words in ("53.7 mm", "0.753", "stable", "data:image/png", "<img", "bend the other way"):
            assert words not in page, words
        assert "Ended at 4 %." in page
    with pytest.raises(InputError, match="picture_png"):
        Prediction(0.1, 0.1, 0.1, 1.0, "completed", True, b"GIF89a")
    with pytest.raises(InputError, match="height"):
        Prediction(0.1, 0.1, float("nan"), 1.0, "completed", True)
    cut_off = Prediction(0.1, 0.1, 0.1, 1.0, "completed", True, png()[:40])
    with pytest.raises(InputError, match="cannot be read as a picture"):
        assembly_pdf(sheet_of(two_faces, cut_off))
    tall = Prediction(0.1, 0.1, 0.1, 1.0, "completed", True, png(3, 900))
    assert len(pypdfium2.PdfDocument(assembly_pdf(sheet_of(two_faces, tall)))) <= 5
