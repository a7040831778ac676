"""The pictures of a result: there, whole, of their size, not blank."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from PIL import Image

from sheetmorph.core.errors import OutputError
from sheetmorph.show import pictures, style
from sheetmorph.show.pictures import NAMES, write_pictures
from sheetmorph.show.render import RenderWorker


@pytest.fixture(autouse=True)
def drawn(monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")


def check(paths):
    for path in paths:
        with Image.open(path) as image:
            image.load()
            assert image.format == "PNG"
            assert image.mode == "RGB"
            assert 740 <= image.width <= 1500
            assert 280 <= image.height <= 1200
            assert np.asarray(image).std() > 15, path
            assert image.getpixel((0, 0)) == (255, 255, 255)


def test_all_pictures(dome_result, tmp_path):
    paths = write_pictures(dome_result, tmp_path)
    assert [path.name for path in paths] == list(NAMES)
    assert sorted(path.name for path in (tmp_path / "pictures").iterdir()) == sorted(NAMES)
    check(paths)


def test_with_the_worker_of_the_run(dome_result, tmp_path, monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "auto")
    with RenderWorker.start() as worker:
        check(write_pictures(dome_result, tmp_path, worker))


def test_one_state_only(small, build, tmp_path):
    mesh, positions, ramp, pattern = small
    result = build(mesh, positions[:1], ramp[:1], np.zeros(1), pattern, status="step_too_small")
    check(write_pictures(result, tmp_path))


def test_bare_sheet_without_pattern_actuation_or_supports(small, build, tmp_path):
    mesh, positions, ramp, _ = small
    result = build(mesh, positions, ramp, np.zeros(6), shapely.Polygon(), eps_pre=0.0)
    bare = replace(
        result,
        held_nodes=np.empty(0, dtype=np.intp),
        thermal_strain_full=np.zeros(len(mesh.edges)),
    )
    check(write_pictures(bare, tmp_path))


@pytest.mark.slow
def test_swelling_sheet(small, build, tmp_path):
    mesh, positions, ramp, pattern = small
    result = build(mesh, positions, ramp, np.zeros(6), pattern, eps_pre=0.2)
    check(write_pictures(result, tmp_path))


def test_names_are_drawn_as_they_are(dome_result, tmp_path, recwarn):
    """Dollar signs are no formulas, and unknown glyphs, line ends and length do no harm."""
    design = replace(dome_result.design, name="$x_{ \\frac & 形 \n" + 200 * "W")
    check(write_pictures(replace(dome_result, design=design), tmp_path))
    assert not recwarn.list


def test_a_failure_leaves_nothing_half_written(dome_result, tmp_path, monkeypatch):
    old = tmp_path / "pictures" / "design.png"
    old.parent.mkdir()
    old.write_bytes(b"old")

    def disk_full(self, stream, **options):
        with open(stream, "wb") as file:  # noqa: PTH123
            file.write(b"half a picture")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Image.Image, "save", disk_full)
    with pytest.raises(OutputError, match=r"design\.png: cannot be written \(No space left"):
        write_pictures(dome_result, tmp_path)
    assert old.read_bytes() == b"old"
    assert list(old.parent.iterdir()) == [old]


@pytest.mark.slow
def test_a_worker_of_our_own_is_ended(dome_result, tmp_path, monkeypatch):
    started = []
    start = RenderWorker.start

    def remember():
        started.append(start())
        return started[0]

    monkeypatch.setenv("SHEETMORPH_RENDERER", "auto")
    monkeypatch.setattr(pictures.RenderWorker, "start", remember)
    write_pictures(dome_result, tmp_path)
    assert started[0]._child is None


@pytest.mark.parametrize(
    ("target", "length"), [(0.031, 0.02), (1.0, 1.0), (7.3, 5.0), (0.0099, 0.005), (150, 100)]
)
def test_scale_bars_have_round_lengths(target, length):
    assert style.round_length(target) == pytest.approx(length)


def test_numbers_have_real_minus_signs_and_no_negative_zero():
    assert style.signed(-0.3) == "−0.30"
    assert style.signed(-0.001) == "0.00"
    assert style.millimetres(3e-4) == "0.3 mm"
    assert style.millimetres(0.1019) == "102 mm"
