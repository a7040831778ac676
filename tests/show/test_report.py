"""The report: one page that carries all it needs and escapes what users write."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.show import citations
from sheetmorph.show.folder import write_folder
from sheetmorph.show.pictures import NAMES
from sheetmorph.show.report import write_report

EVIL = "<script>alert('x')</script> & \"quotes\""


class Page(HTMLParser):
    """The tags and the text of a page; complains about tags that do not match."""

    VOID = frozenset({"meta", "img", "br", "source", "link"})

    def __init__(self, text):
        super().__init__()
        self.tags, self.open, self.text = [], [], ""
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += f"{data} "

    def all(self, tag):
        return [attrs for name, attrs in self.tags if name == tag]


@pytest.fixture(scope="module")
def folder(dome_result, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SHEETMORPH_RENDERER", "drawn")
        place = tmp_path_factory.mktemp("results")
        shown = write_folder(dome_result, place)
    names = [path.name for path in shown.files]
    assert names == [*NAMES, "animation.gif", "report.html"]
    assert shown.notes == []
    return place


def page_of(result, folder, **options):
    return Page(write_report(result, folder, **options).read_text(encoding="utf-8"))


def test_it_carries_everything(folder):
    text = (folder / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    images = page.all("img")
    assert len(images) == len(NAMES) + 1
    for image in images:
        assert re.match(r"data:image/(png|gif);base64,[A-Za-z0-9+/]+=*$", image["src"])
        assert len(image["alt"]) > 20
        assert int(image["width"]) > 0
        assert int(image["height"]) > 0
    assert not re.search(r"https?:|//[a-z]+\.|url\(|@import", re.sub(r"data:[^\"]+", "", text))
    assert not page.all("script")
    assert not page.all("link")
    assert "default-src 'none'" in text
    assert len(text) < 8_000_000


def test_it_tells_the_numbers_with_units(folder, dome_result):
    text = Page((folder / "report.html").read_text(encoding="utf-8")).text
    words = " ".join(text.split())
    for expected in (
        "Completed, and the last state is stable",
        "polystyrene active everywhere 0.3 mm 1 MPa 0.33",
        "PLA inert in the pattern 0.7 mm 3 MPa 0.33",
        "Linear solver mkl",
        "Factorisations 70",
        "Wall time 1.34 s",
        "Stretching 0.12 mJ",
        "Largest residual force 3.2e−12 N",
        "Discrete shells",
        "PARDISO",
        "eps_pre = -0.3",
    ):
        assert expected in words, expected
    assert f"{dome_result.mesh.counts[0]} nodes" in words


def test_what_users_write_is_escaped(folder, dome_result):
    layer = replace(dome_result.design).layers[0]
    layer = type(layer)(**{**vars(layer), "name": EVIL})
    design = replace(dome_result.design, name=EVIL, source=EVIL, layers=(layer,))
    result = replace(dome_result, design=design, summary=dome_result.summary | {"detail": EVIL})
    path = write_report(result, folder, notes=[EVIL])
    text = path.read_text(encoding="utf-8")
    assert "<script" not in text
    page = Page(text)
    assert page.text.count(EVIL) >= 5  # title, heading, layer, design file, detail, note
    assert all("onerror" not in image for image in page.all("img"))


@pytest.mark.parametrize(
    ("changes", "title", "remedy"),
    [
        (
            {"status": "step_too_small", "remedy": "try a finer mesh.size"},
            "Not completed: step too small",
            "Remedy: try a finer mesh.size",
        ),
        ({"stable": False, "negative_pivots": 2}, "not stable", "Remedy: try another perturbation"),
    ],
)
def test_trouble_is_told_with_its_remedy(dome_result, tmp_path, changes, title, remedy):
    summary = dome_result.summary | changes
    page = page_of(replace(dome_result, summary=summary), tmp_path, notes=["install libegl1"])
    words = " ".join(page.text.split())
    assert title in words
    assert remedy in words
    assert "install libegl1" in words
    assert page.all("section")[0]["class"] == "banner bad"


def test_it_works_without_pictures_and_with_a_short_summary(dome_result, tmp_path):
    short = {"status": "completed", "eps_pre": -0.3}
    page = page_of(replace(dome_result, summary=short), tmp_path)
    assert page.all("img") == []
    assert "Design file" in page.text


def test_a_damaged_picture_is_named(dome_result, tmp_path):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "shape.png").write_bytes(b"no picture")
    with pytest.raises(InputError, match=r"shape\.png: this picture is damaged"):
        write_report(dome_result, tmp_path)
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    ("summary", "inside", "outside"),
    [
        ({"model": "published", "solver": "mkl-pardiso 0.0.6"}, "schenk2004", "timoshenko1925"),
        ({"model": "laminate", "solver": "rslab"}, "timoshenko1925", "seung1988"),
        ({"model": "laminate", "solver": "scipy", "renderer": "vtk"}, "li2005", "schenk2004"),
        ({}, "nocedal2006", "schroeder2006"),
    ],
)
def test_references_follow_what_was_used(summary, inside, outside):
    keys = [citation.key for citation in citations.references(summary)]
    assert inside in keys
    assert outside not in keys
    assert len(keys) == len(set(keys))
