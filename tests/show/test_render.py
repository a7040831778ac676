"""Who draws, what happens when VTK crashes or hangs, and that both draw the same."""

import sys

import numpy as np
import pytest

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.show import scene
from sheetmorph.show.child import EGL_MISSING, remedy
from sheetmorph.show.drawn import draw
from sheetmorph.show.render import RenderWorker
from sheetmorph.show.stills import base_job, white

CRASH = (sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
EXIT_139 = (sys.executable, "-c", "raise SystemExit(139)")
HANG = (sys.executable, "-c", "import time; time.sleep(600)")
LIAR = (sys.executable, "-c", 'print(\'{"job": 0, "view": 0}\', flush=True); input(); input()')
ERROR = (sys.executable, "-c", "raise RuntimeError('no driver')")


@pytest.fixture
def job(dome_result):
    points = dome_result.positions[-1]
    size = (120, 90)
    views = [
        scene.View(points, white(len(points)), textures, camera.fitted(points, size, 0.05), size)
        for camera, textures in (
            (scene.perspective(), (0, 1)),
            (scene.from_above(), (0, 1)),
            (scene.from_the_side(), (2, 2)),
        )
    ]
    return base_job(dome_result, tuple(views))


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (CRASH, "it crashed with SIGSEGV"),
        (EXIT_139, "it crashed with SIGSEGV"),
        (HANG, "it was silent for 0.5 s"),
        (LIAR, "its picture cannot be read"),
        (ERROR, "RuntimeError: no driver"),
        (("/nowhere/at/all",), "it cannot be started"),
    ],
)
def test_a_broken_child_costs_no_picture(job, command, said):
    with RenderWorker.start(command, patience=0.5) as worker:
        images = list(worker.draw(job))
        assert worker.renderer == "drawn"
        assert worker.note.startswith("pictures drawn without VTK: ")
        assert said in worker.note
        assert "\n" not in worker.note
    assert [image.shape for image in images] == [(90, 120, 3)] * 3
    assert all(image.std() > 10 for image in images)


def test_a_broken_child_is_not_asked_again(job):
    with RenderWorker.start(HANG, patience=0.2) as worker:
        next(worker.draw(job))
        worker._patience = None
        assert len(list(worker.draw(job))) == 3


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="names Debian packages")
def test_the_note_says_what_to_install():
    assert remedy(f"x\n{EGL_MISSING}\n") == (
        "libEGL.so.1 is missing; on Debian or Ubuntu: apt-get install libegl1 libgl1-mesa-dri"
    )
    assert "apt-get install libegl1" in remedy("")
    assert remedy("No module named 'vtkmodules'") == "install it with: pip install vtk"


def test_drawn_needs_no_child(job, monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")
    with RenderWorker.start(("/nowhere/at/all",)) as worker:
        assert len(list(worker.draw(job))) == 3
        assert worker.note is None
        assert worker.renderer == "drawn"


def test_vtk_or_nobody(job, monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "vtk")
    with (
        RenderWorker.start(CRASH) as worker,
        pytest.raises(ComputationError, match="SHEETMORPH_RENDERER=auto"),
    ):
        list(worker.draw(job))


def test_unknown_renderer(monkeypatch):
    monkeypatch.setenv("SHEETMORPH_RENDERER", "crayon")
    with pytest.raises(InputError, match=r"crayon.*auto, vtk, drawn"):
        RenderWorker.start()


def test_vtk_draws_what_the_rasteriser_draws(job):
    with RenderWorker.start() as worker:
        images = list(worker.draw(job))
        if worker.note:
            pytest.skip(worker.note)
    for image, view in zip(images, job.views, strict=True):
        ours = draw(job, view).astype(float)
        theirs = image.astype(float)
        ink = (ours.min(axis=2) < 250) | (theirs.min(axis=2) < 250)
        both = (ours.min(axis=2) < 250) & (theirs.min(axis=2) < 250)
        assert both.sum() > 0.9 * ink.sum()
        assert np.abs(ours - theirs)[both].mean() < 12


def test_jobs_may_be_collected_in_any_order(job):
    with RenderWorker.start() as worker:
        first, second = worker.draw(job), worker.draw(job)
        late = list(second)
        assert np.array_equal(list(first), late)


def test_the_nearer_surface_hides_the_farther(dome_result):
    """Two triangles, one above the other: seen from above only the upper one shows."""
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5]], dtype=float
    )
    red, blue = (255, 0, 0), (0, 0, 255)
    colours = np.array([red] * 3 + [blue] * 3, dtype=np.uint8)
    size = (40, 40)
    plain = np.full((2, 2, 3), 255, dtype=np.uint8)
    camera = scene.from_above().fitted(points, size, 0.1)
    for order in ([0, 1], [1, 0]):
        triangles = np.array([[0, 1, 2], [3, 4, 5]], dtype=np.int32)[order]
        view = scene.View(points, colours, (0, 0), camera, size)
        image = draw(scene.Job(triangles, points[:, :2], (plain,), (view,)), view)
        assert image[28, 12, 2] > 150
        assert image[28, 12, 0] < 60


def test_the_underside_has_its_own_texture():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    green = np.zeros((2, 2, 3), np.uint8)
    green[..., 1] = 255
    plain = np.full((2, 2, 3), 255, dtype=np.uint8)
    size = (40, 40)
    for triangle, upper in (([0, 1, 2], True), ([0, 2, 1], False)):
        camera = scene.from_above().fitted(points, size, 0.1)
        view = scene.View(points, white(3), (0, 1), camera, size)
        job = scene.Job(np.array([triangle], np.int32), points[:, :2], (plain, green), (view,))
        assert (draw(job, view)[28, 12, 0] > 100) == upper


@pytest.mark.parametrize("camera", [scene.perspective(), scene.from_above()])
def test_fitted_cameras_fill_the_picture(camera, dome_result):
    points, size = dome_result.positions[-1], (300, 200)
    places = camera.fitted(points, size, 0.1).project(points, size)
    assert places[:, 0].min() > 29
    assert places[:, 0].max() < 271
    assert places[:, 1].min() > 19
    assert places[:, 1].max() < 181
    span = np.ptp(places[:, :2], axis=0)
    assert span[0] > 235 or span[1] > 155


def test_cameras_are_right_handed():
    for camera in (scene.perspective(), scene.from_above(), scene.from_the_side()):
        assert np.allclose(np.cross(camera.right, camera.up), camera.toward)
