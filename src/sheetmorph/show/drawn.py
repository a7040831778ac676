"""The renderer that needs no graphics library: a small rasteriser with a depth buffer.

Every pixel is lit on its own, so that the pictures look like those of VTK: the colour of
the texture times the colour of the nodes times the light that falls on either side.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.compiled import kernel
from sheetmorph.geometry.mesh import Floats
from sheetmorph.show.scene import KEY_LIGHT, SHININESS, Image, Job, View, node_normals

SUPERSAMPLING = 2


def draw(job: Job, view: View, supersampling: int = SUPERSAMPLING) -> Image:
    """Draw one view of a job.

    Returns:
        The picture on white, shape (height, width, 3), row 0 on top.
    """
    width, height = view.size
    camera = view.camera
    points = np.asarray(view.points, dtype=np.float64)
    pixels = camera.project(points, (width * supersampling, height * supersampling))
    # Attributes interpolate linearly on the screen once divided by the distance to the eye.
    if camera.distance > 0:
        away = np.maximum(camera.distance - pixels[:, 2], 0.05 * camera.distance)
        weights = camera.distance / away
    else:
        weights = np.ones(len(points))
    basis = np.stack([camera.right, camera.up, camera.toward], axis=1)
    normals = node_normals(points, job.triangles) @ basis
    image = np.full((height * supersampling, width * supersampling, 3), 255.0, dtype=np.float32)
    depth = np.full(image.shape[:2], -np.inf, dtype=np.float32)
    _rasterise(
        image,
        depth,
        np.ascontiguousarray(job.triangles),
        np.ascontiguousarray(pixels),
        weights,
        np.ascontiguousarray(normals),
        np.ascontiguousarray(job.uv, dtype=np.float64),
        view.colours.astype(np.float64),
        job.textures[view.textures[0]],
        job.textures[view.textures[1]],
        _unit(KEY_LIGHT),
        np.array([view.light.ambient, view.light.key, view.light.head, view.light.shine]),
    )
    picture = np.empty((height, width, 3), dtype=np.uint8)
    _shrink(image, picture, supersampling)
    return picture


def _unit(vector: tuple[float, float, float]) -> Floats:
    array = np.array(vector)
    return np.asarray(array / np.linalg.norm(array))


def _rasterise_python(
    image: NDArray[np.float32],
    depth: NDArray[np.float32],
    triangles: NDArray[np.int32],
    pixels: Floats,
    weights: Floats,
    normals: Floats,
    uv: Floats,
    colours: Floats,
    upper: Image,
    lower: Image,
    light: Floats,
    strengths: Floats,
) -> None:
    rows, columns = depth.shape
    ambient, key, head, shine = strengths
    half = np.empty(3)
    half[0], half[1], half[2] = light[0], light[1], light[2] + 1.0
    half /= math.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
    normal = np.empty(3)
    for t in range(len(triangles)):
        a, b, c = triangles[t]
        ax, ay = pixels[a, 0], pixels[a, 1]
        bx, by = pixels[b, 0] - ax, pixels[b, 1] - ay
        cx, cy = pixels[c, 0] - ax, pixels[c, 1] - ay
        doubled = bx * cy - by * cx
        if abs(doubled) < 1e-12:
            continue
        # Rows run downward, so the upper side turns the other way round on the screen.
        side = 1.0 if doubled < 0 else -1.0
        texture = upper if doubled < 0 else lower
        tall, wide = texture.shape[:2]
        left = max(0, math.floor(ax + min(0.0, bx, cx)))
        right = min(columns - 1, math.ceil(ax + max(0.0, bx, cx)))
        top = max(0, math.floor(ay + min(0.0, by, cy)))
        bottom = min(rows - 1, math.ceil(ay + max(0.0, by, cy)))
        for row in range(top, bottom + 1):
            py = row + 0.5 - ay
            for column in range(left, right + 1):
                px = column + 0.5 - ax
                v = (px * cy - py * cx) / doubled
                w = (bx * py - by * px) / doubled
                u = 1.0 - v - w
                if u < -1e-9 or v < -1e-9 or w < -1e-9:
                    continue
                u, v, w = u * weights[a], v * weights[b], w * weights[c]
                total = u + v + w
                u, v, w = u / total, v / total, w / total
                near = u * pixels[a, 2] + v * pixels[b, 2] + w * pixels[c, 2]
                if near <= depth[row, column]:
                    continue
                depth[row, column] = near
                for k in range(3):
                    normal[k] = u * normals[a, k] + v * normals[b, k] + w * normals[c, k]
                length = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2) + 1e-300
                length *= side
                facing = max(normal[2] / length, 0.0)
                lit = (normal[0] * light[0] + normal[1] * light[1] + normal[2] * light[2]) / length
                gloss = (normal[0] * half[0] + normal[1] * half[1] + normal[2] * half[2]) / length
                brightness = ambient + key * max(lit, 0.0) + head * facing
                gleam = 255.0 * shine * max(gloss, 0.0) ** SHININESS
                # The texture between its four nearest pixels.
                x = (u * uv[a, 0] + v * uv[b, 0] + w * uv[c, 0]) * wide - 0.5
                y = (1.0 - (u * uv[a, 1] + v * uv[b, 1] + w * uv[c, 1])) * tall - 0.5
                x, y = min(max(x, 0.0), wide - 1.001), min(max(y, 0.0), tall - 1.001)
                i, j = int(y), int(x)
                fy, fx = y - i, x - j
                for k in range(3):
                    texel = (texture[i, j, k] * (1 - fx) + texture[i, j + 1, k] * fx) * (1 - fy) + (
                        texture[i + 1, j, k] * (1 - fx) + texture[i + 1, j + 1, k] * fx
                    ) * fy
                    colour = u * colours[a, k] + v * colours[b, k] + w * colours[c, k]
                    image[row, column, k] = min(texel * colour / 255.0 * brightness + gleam, 255.0)


def _shrink_python(image: NDArray[np.float32], picture: Image, factor: int) -> None:
    for row in range(picture.shape[0]):
        for column in range(picture.shape[1]):
            for k in range(3):
                total = 0.5 * factor * factor
                for i in range(factor):
                    for j in range(factor):
                        total += image[row * factor + i, column * factor + j, k]
                picture[row, column, k] = int(total / (factor * factor))


_shrink: Any = kernel(_shrink_python)
_rasterise: Any = kernel(_rasterise_python)
