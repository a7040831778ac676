"""Films of an oven that never was: results drawn from the side, with what spoils real pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from sheetmorph.geometry.surface import side_view
from sheetmorph.show import drawn, fields
from sheetmorph.show.scene import Camera, Job, Light, View
from sheetmorph.show.stills import SHAPE_COLOURS, base_job

SIZE = (640, 480)


@dataclass(frozen=True)
class Oven:
    """How the sheet is filmed.

    roll, elevation, azimuth in degrees; noise and backdrop in grey levels; blur in pixels;
    distance of the camera in widths of the sheet, 0 for a parallel view; thickness in metres;
    ink: the sheet with its two tones and a thin line along its rim, "dark" or "light"; without
    it a pale or a black sheet whose lines are faint.
    """

    roll: float = 0.0
    elevation: float = 0.0
    azimuth: float = 0.0
    noise: float = 0.0
    blur: float = 0.0
    backdrop: tuple[int, int, int] = (70, 60, 55)
    uneven: float = 0.0
    distance: float = 0.0
    thickness: float = 0.4e-3
    seed: int = 1
    ink: str = ""


@dataclass(frozen=True, eq=False)
class Filmed:
    """Pictures (blue, green, red) and what is true about them."""

    images: list[np.ndarray]
    height: np.ndarray  # [m]
    width: np.ndarray  # [m]
    metre_per_pixel: float

    @property
    def ratio(self) -> np.ndarray:
        return self.height / self.width


def film_of(result, oven: Oven = Oven(), frames: int = 8, size=SIZE) -> Filmed:
    """Draw a result from flat to its end as the oven's camera sees it."""
    points, _ = fields.motion(
        result.positions, result.ramp, result.load_fraction, result.actuation, frames
    )
    points = _thick(points, oven.thickness)
    camera, extent = _camera(points, oven, size)
    light = Light(1.0, 0.0, 0.0, 0.0)
    rng = np.random.default_rng(oven.seed)
    job = _thick_job(base_job(result))
    if oven.ink == "light":
        job = replace(job, textures=tuple(_light_lines(t) for t in job.textures))
    elif not oven.ink:
        job = replace(job, textures=tuple(_plain(t, sum(oven.backdrop)) for t in job.textures))
    images = []
    for x in points:
        white = np.full((len(x), 3), 255, dtype=np.uint8)
        view = View(x, white, SHAPE_COLOURS, camera, size)
        lit = drawn.draw(job, view).astype(float)[..., ::-1]
        dark = drawn.draw(_black(job), replace(view, colours=0 * white, light=light))
        cover = 1.0 - dark.astype(float) / 255.0
        picture = _backdrop(oven, size) * (1.0 - cover) + lit - 255.0 * (1.0 - cover)
        if oven.blur:
            picture = cv2.GaussianBlur(picture, (0, 0), oven.blur)
        picture += oven.noise * rng.standard_normal(picture.shape)
        images.append(np.clip(np.round(picture), 0, 255).astype(np.uint8))
    true = side_view(points, np.radians(oven.azimuth))
    return Filmed(images, true[:, 1], true[:, 0], extent / size[1])


def _plain(texture: np.ndarray, backdrop: int) -> np.ndarray:
    """A white sheet in a dark oven, a black one before a light backdrop; hardly any lines."""
    white = backdrop < 380
    return ((120 if white else 0) + (0.53 if white else 0.25) * texture).astype(np.uint8)


def _light_lines(texture: np.ndarray) -> np.ndarray:
    lines = texture.max(axis=2, keepdims=True) < 100
    return np.where(lines, 255, texture).astype(np.uint8)


def write_video(path: Path, images: list[np.ndarray], rate: float = 1.0) -> Path:
    """MP4 by mp4v, AVI by motion JPEG."""
    code = cv2.VideoWriter_fourcc(*("MJPG" if path.suffix == ".avi" else "mp4v"))
    writer = cv2.VideoWriter(str(path), code, rate, images[0].shape[1::-1])
    assert writer.isOpened()
    for image in images:
        writer.write(image)
    writer.release()
    return path


def write_series(folder: Path, images: list[np.ndarray], ending: str = ".png") -> Path:
    """A folder of pictures, numbered without leading zeros."""
    folder.mkdir()
    for k, image in enumerate(images):
        assert cv2.imwrite(str(folder / f"oven {k}{ending}"), image)
    return folder


def _thick(points: np.ndarray, thickness: float) -> np.ndarray:
    """Upper and lower faces, shape (S, 2V, 3)."""
    half = np.array([0.0, 0.0, 0.5 * thickness])
    return np.concatenate([points + half, points - half], axis=1)


def _thick_job(job: Job) -> Job:
    """Both faces, and a wall along the rim: a flat sheet seen from its edge is not nothing."""
    faces = np.asarray(job.triangles, dtype=np.int64)
    count = len(job.uv)
    halves = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    keys = np.sort(halves, axis=1) @ [count, 1]
    _, first, uses = np.unique(keys, return_index=True, return_counts=True)
    a, b = halves[first[uses == 1]].T
    walls = np.concatenate(
        [np.stack([a, a + count, b], axis=1), np.stack([b, a + count, b + count], axis=1)]
    )
    triangles = np.concatenate([faces, faces + count, walls]).astype(job.triangles.dtype)
    return replace(job, triangles=triangles, uv=np.concatenate([job.uv, job.uv]))


def _black(job: Job) -> Job:
    return replace(job, textures=tuple(np.zeros_like(t) for t in job.textures))


def _camera(points, oven: Oven, size) -> tuple[Camera, float]:
    a, e, r = np.radians([oven.azimuth, oven.elevation, oven.roll])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    away = np.array([-np.sin(a), np.cos(a), 0.0])
    up = np.array([0.0, 0.0, np.cos(e)]) + np.sin(e) * away
    toward = np.cross(right, up)
    # A camera turned by the roll: what is level falls to the right in the picture.
    turned, risen = np.cos(r) * right + np.sin(r) * up, np.cos(r) * up - np.sin(r) * right
    flat = points.reshape(-1, 3)
    centre = 0.5 * (flat.max(axis=0) + flat.min(axis=0))
    width = float(np.ptp(flat @ right))
    extent = 1.45 * width * size[1] / size[0]
    return Camera(centre, turned, risen, toward, extent, oven.distance * width), extent


def _backdrop(oven: Oven, size) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-1, 1, size[0]), np.linspace(-1, 1, size[1]))
    shade = oven.uneven * (0.6 * x - 0.5 * y + 0.5 * np.exp(-2 * (x**2 + y**2)))
    return np.array(oven.backdrop, dtype=float) + shade[..., None]
