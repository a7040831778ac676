"""What is to be drawn, told apart from who draws it: views, cameras, jobs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sheetmorph.geometry.mesh import Floats, Ints

Image = NDArray[np.uint8]
Colours = NDArray[np.uint8]

EYE_DISTANCE = 3.6
"""Distance of the eye in a perspective view, in radii of what is seen."""

KEY_LIGHT = (-0.45, 0.55, 0.70)
"""Direction to the main light as the eye sees it: from the left, above, behind the eye."""
SHININESS = 24.0


@dataclass(frozen=True)
class Light:
    """Strengths of the light from everywhere, of the main light, of the light at the eye,
    and of the gloss."""

    ambient: float
    key: float
    head: float
    shine: float


SHAPE_LIGHT = Light(0.48, 0.32, 0.25, 0.08)
FIELD_LIGHT = Light(0.68, 0.20, 0.16, 0.0)
"""Flat enough to read colours against a colour bar."""


@dataclass(frozen=True, eq=False)
class Camera:
    """Where the eye is. The three directions are orthonormal, right × up = toward.

    Attributes:
        centre: the point [m] in the middle of the picture, shape (3,).
        right: direction that runs to the right of the picture, shape (3,).
        up: direction that runs upward in the picture, shape (3,).
        toward: direction from the centre to the eye, shape (3,).
        extent: height [m] of the picture in the plane of the centre.
        distance: distance [m] of the eye from the centre; 0 for a parallel projection.
    """

    centre: Floats
    right: Floats
    up: Floats
    toward: Floats
    extent: float
    distance: float

    def project(self, points: ArrayLike, size: tuple[int, int]) -> Floats:
        """Pixel coordinates and nearness of points.

        Args:
            points: positions [m], shape (..., 3).
            size: width and height of the picture [px].

        Returns:
            x to the right [px], y downward [px] and the depth toward the eye [m],
            shape (..., 3).
        """
        x, y, depth = self._flat(np.asarray(points, dtype=np.float64))
        scale = size[1] / self.extent
        return np.stack([size[0] / 2 + scale * x, size[1] / 2 - scale * y, depth], axis=-1)

    def _flat(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        local = points - self.centre
        x, y, depth = local @ self.right, local @ self.up, local @ self.toward
        if self.distance > 0:
            shrink = self.distance / np.maximum(self.distance - depth, 0.05 * self.distance)
            x, y = x * shrink, y * shrink
        return x, y, depth

    def fitted(self, points: Floats, size: tuple[int, int], margin: float) -> Camera:
        """The same direction of view, moved so that the points fill the picture.

        Args:
            points: positions [m], shape (N, 3).
            size: width and height of the picture [px].
            margin: free room around the points, as a fraction of the picture.
        """
        radius = 0.5 * float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
        centre = 0.5 * (points.max(axis=0) + points.min(axis=0))
        camera = Camera(
            centre,
            self.right,
            self.up,
            self.toward,
            2 * radius,
            EYE_DISTANCE * radius if self.distance > 0 else 0.0,
        )
        for _ in range(3):
            x, y, _depth = camera._flat(points)
            shift = 0.5 * (x.max() + x.min()) * camera.right + 0.5 * (y.max() + y.min()) * camera.up
            wanted = max(float(np.ptp(y)), float(np.ptp(x)) * size[1] / size[0], 0.02 * radius)
            camera = Camera(
                camera.centre + shift,
                self.right,
                self.up,
                self.toward,
                wanted / (1.0 - 2.0 * margin),
                camera.distance,
            )
        return camera


def perspective(azimuth: float = -62.0, elevation: float = 36.0) -> Camera:
    """A camera that looks down on the sheet; the angles are in degrees."""
    a, e = np.radians(azimuth), np.radians(elevation)
    toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return Camera(np.zeros(3), right, np.cross(toward, right), toward, 1.0, 1.0)


def from_above() -> Camera:
    """A parallel view along −z: x to the right, y upward."""
    x, y, z = np.eye(3)
    return Camera(np.zeros(3), x, y, z, 1.0, 0.0)


def from_the_side() -> Camera:
    """A parallel view along +y: x to the right, z upward."""
    x, y, z = np.eye(3)
    return Camera(np.zeros(3), x, z, -y, 1.0, 0.0)


@dataclass(frozen=True, eq=False)
class View:
    """One picture of the sheet.

    Attributes:
        points: node positions [m], shape (V, 3).
        colours: colour of every node, multiplied with the texture, shape (V, 3).
        textures: indices into the textures of the job, for the upper side and for the
            underside of the sheet.
        camera: where the eye is.
        size: width and height of the picture [px].
        light: how the sheet is lit.
    """

    points: Floats
    colours: Colours
    textures: tuple[int, int]
    camera: Camera
    size: tuple[int, int]
    light: Light = SHAPE_LIGHT


@dataclass(frozen=True, eq=False)
class Job:
    """Views of one mesh.

    Attributes:
        triangles: node indices, shape (T, 3).
        uv: place of every node in the textures, shape (V, 2); (0, 0) is the lower left.
        textures: pictures laid on the flat sheet, each of shape (h, w, 3), row 0 on top.
        views: what to draw, in this order.
    """

    triangles: Ints
    uv: Floats
    textures: tuple[Image, ...]
    views: tuple[View, ...]


def node_normals(points: Floats, triangles: Ints) -> Floats:
    """Unit normals at the nodes, means of the triangles' around them by area, shape (V, 3)."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    flat = triangles.ravel()
    normals = np.stack(
        [
            np.bincount(flat, weights=np.repeat(areas[:, k], 3), minlength=len(points))
            for k in range(3)
        ],
        axis=1,
    )
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    straight_up = np.array([0.0, 0.0, 1.0])
    return np.where(lengths > 0, normals / np.maximum(lengths, 1e-300), straight_up)
