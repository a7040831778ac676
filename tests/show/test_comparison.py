"""Pictures and page of a comparison: there, whole, and true to what was found."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from sheetmorph.compare.comparison import CompareOptions, compare_surfaces
from sheetmorph.compare.distances import distances
from sheetmorph.compare.similarity import ssim
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.show import comparison as show
from sheetmorph.show import scene
from sheetmorph.show.comparison_numbers import banner_of, baselines_of, millimetres, told_of
from sheetmorph.show.comparison_ssim import column_means, near_surfaces
from sheetmorph.show.comparison_views import (
    Names,
    distance_from_shape,
    distance_to_scan,
    round_limit,
    see_through,
    silhouette,
    views_of,
)
from sheetmorph.show.drawn import draw

EVIL = "<script>alert('x')</script> & $x_{"


@pytest.fixture(autouse=True)
def drawn(monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")


@pytest.fixture(scope="module")
def comparison(dome_result):
    """The dome against a copy that is bent a little, half as large, turned and moved."""
    points = dome_result.positions[-1]
    triangles = dome_result.mesh.triangles.astype(np.int64)
    bent = points + np.outer(2e-3 * np.sin(60 * points[:, 0]), [0.0, 0.0, 1.0])
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    return compare_surfaces(
        Surface(points, triangles),
        Surface(0.5 * bent @ turn.T + 0.2, triangles),
        flat=Surface(dome_result.mesh.nodes, triangles),
        options=CompareOptions(grid=20, window=4),
    )


def square(height, side=1.0):
    corners = np.array([[0.0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]])
    return Surface(corners + np.array([0, 0, height]), np.array([[0, 1, 2], [0, 2, 3]]))


def test_signs_are_those_of_the_upper_side_of_the_shape():
    shape = square(0.0)
    for height in (0.2, -0.3):
        scan = square(height)
        over = Surface(scan.points, scan.triangles[:, ::-1])
        for other in (scan, over):  # whichever way the scan is oriented
            assert np.allclose(distance_from_shape(shape, other.points), height)
            assert np.allclose(distance_to_scan(shape, other), height)


@pytest.mark.parametrize(
    ("distance", "limit"), [(0.00235, 0.003), (0.0012, 0.0015), (0.01, 0.01), (0.9, 1.0), (0, 1e-6)]
)
def test_colours_end_at_round_distances(distance, limit):
    assert round_limit(distance) == pytest.approx(limit)


def test_glass_shows_what_lies_behind_it():
    """Scan below, shape above it on the right half: seen from above and from below."""
    scan, half = square(0.0), square(0.5)
    half = Surface(half.points * [0.5, 1, 1] + [0.5, 0, 0], half.triangles)
    size, white = (60, 60), np.full((2, 2, 3), 255, np.uint8)
    points = np.concatenate([scan.points, half.points])
    red, blue = np.array([255, 0, 0]), np.array([0, 0, 255])
    light = scene.Light(1.0, 0.0, 0.0, 0.0)

    def seen(surfaces, colours, camera):
        nodes = np.concatenate([surface.points for surface in surfaces])
        faces = np.concatenate(
            [surface.triangles + 4 * k for k, surface in enumerate(surfaces)]
        ).astype(np.int32)
        painted = np.repeat(np.array(colours, np.uint8), 4, axis=0)
        view = scene.View(nodes, painted, (0, 0), camera, size, light)
        return draw(scene.Job(faces, nodes[:, :2], (white,), (view,)), view)

    x, y, z = np.eye(3)
    below = scene.Camera(np.zeros(3), x, -y, -z, 1.0, 0.0)
    for camera, expected in ((scene.from_above(), 0.7 * blue + 0.3 * red), (below, red)):
        fitted = camera.fitted(points, size, 0.1)
        alone = seen([scan], [red], fitted)
        image = see_through(seen([scan, half], [red, blue], fitted), alone, 0.7)
        assert np.abs(image[30, 45] - expected).max() <= 2
        assert np.abs(image[30, 15].astype(int) - red).max() <= 2
        assert tuple(image[2, 2]) == (255, 255, 255)
        cover = silhouette(alone)
        assert cover[30, 30] == 1.0
        assert cover[2, 2] == 0.0


def test_means_along_z_are_those_of_the_windows_on_a_surface():
    class Found:
        window, origin, spacing = 3, np.zeros(3), np.full(3, 0.1)
        field = np.zeros((11, 11, 11))

    found = Found()
    found.field[:] = np.linspace(0.0, 1.0, 11)  # grows with z
    points = np.array([[0.5, 0.5, 0.2], [0.5, 0.5, 0.8]])
    mask = near_surfaces(found, points)
    assert mask.sum() == 2 * 27
    means = column_means(found.field, mask)
    assert means[5, 5] == pytest.approx(0.5)
    assert means[4, 6] == pytest.approx(0.5)
    assert means[0, 0] == pytest.approx(0.5)  # nothing there: the whole column
    assert column_means(found.field, near_surfaces(found, points[:1]))[5, 5] == pytest.approx(0.2)


def test_views_show_both_from_all_sides_at_one_scale(comparison):
    views = views_of(comparison)
    assert len(views.both.views) == 6
    assert len({view.camera.extent for view in views.both.views}) == 1
    towards = np.array([view.camera.toward for view in views.both.views])
    assert len(np.unique(towards, axis=0)) == 6
    for job, surface in ((views.scan, comparison.scan), (views.shape, comparison.shape)):
        assert len(job.views) == 9
        assert len(job.triangles) == len(surface.triangles)
    for view in views.both.views:
        right, up, toward = view.camera.right, view.camera.up, view.camera.toward
        assert np.allclose(np.cross(right, up), toward)
        places = view.camera.project(view.points, view.size)
        assert places[:, :2].min() > 0
        assert places[:, 0].max() < view.size[0]
        assert places[:, 1].max() < view.size[1]


@pytest.fixture(scope="module")
def folder(comparison, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SHEETMORPH_RENDERER", "drawn")
        place = tmp_path_factory.mktemp("comparison")
        written = show.write_comparison(comparison, place, Names("dome", EVIL))
    assert written.notes == ()
    assert {str(path.relative_to(place)) for path in written.files} == set(show.OUTPUTS)
    return place


def test_all_pictures_are_whole(folder):
    for name in show.PICTURES:
        with Image.open(folder / "pictures" / name) as image:
            image.load()
            pixels = np.asarray(image)
        assert image.size[0] == 1000
        assert pixels.std() > 15, name
        # Nothing runs over the rim of the picture.
        for edge in (pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]):
            assert edge.min() > 240, name


def test_the_page_carries_everything_and_escapes_names(folder, comparison):
    text = (folder / show.PAGE).read_text("utf-8")
    assert "<script" not in text
    assert "default-src 'none'" in text
    assert text.count("data:image/png;base64,") == len(show.PICTURES)

    class Page(HTMLParser):
        words = ""
        open: list[str] = []  # noqa: RUF012  one page only

        def handle_starttag(self, tag, attrs):
            if tag not in ("meta", "img", "br"):
                self.open.append(tag)

        def handle_endtag(self, tag):
            assert self.open.pop() == tag

        def handle_data(self, data):
            self.words += f"{data} "

    page = Page()
    page.feed(text)
    assert not page.open
    words = " ".join(page.words.split())
    assert EVIL in words
    assert f"{comparison.similarity.value:.3f}" in words
    assert millimetres(comparison.scan_to_shape.rms) in words
    assert millimetres(comparison.shape_to_scan.maximum) in words
    for name, value in baselines_of(comparison.to_json()).items():
        assert f"SSIM of a {name.replace('_', ' ')} {value:.3f}" in words
    assert not re.search(r"https?:|url\(|@import", re.sub(r"data:[^\"]+", "", text))


def test_every_number_has_its_sentence(comparison):
    for group, rows in told_of(comparison, comparison.to_json()).items():
        for row in rows:
            assert row.meaning.endswith((".", "below:", ".)")), (group, row.label)


def test_an_uncertain_pose_is_told(comparison, tmp_path):
    alignment = replace(comparison.alignment, next_rms=1.05 * comparison.alignment.rms)
    doubtful = replace(comparison, alignment=replace(alignment, confidence=0.04))
    show.write_comparison(doubtful, tmp_path, Names("dome", "scan"), pictures=False)
    text = (tmp_path / show.PAGE).read_text("utf-8")
    assert "Another pose fits nearly as well" in text
    assert "--known-length" in text
    assert "data:image" not in text
    assert not (tmp_path / "pictures").exists()


def test_unlike_surfaces_are_told(comparison):
    far = replace(comparison.alignment, rms=0.1 * comparison.shape.size)
    banner = banner_of(replace(comparison, alignment=far))
    assert not banner.good
    assert "10 % of the size" in banner.lines[0]
    assert banner_of(comparison).good


def test_flat_and_equal_surfaces_are_no_trouble(comparison, dome_result, tmp_path):
    flat = Surface(dome_result.mesh.nodes, dome_result.mesh.triangles.astype(np.int64))
    there, back = distances(flat, flat)
    same = replace(
        comparison,
        shape=flat,
        scan=flat,
        scan_to_shape=there,
        shape_to_scan=back,
        similarity=ssim(flat, flat, 12, 3),
    )
    written = show.write_comparison(same, tmp_path, Names("flat", "flat"))
    assert len(written.files) == len(show.OUTPUTS)


def test_a_folder_is_not_overwritten_unasked(folder):
    with pytest.raises(InputError, match="--force"):
        show.check_folder(folder, force=False)
    show.check_folder(folder, force=True)
    with pytest.raises(InputError, match="this is a file"):
        show.check_folder(folder / show.DATA, force=True)
