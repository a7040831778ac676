"""The process that draws with VTK, started by `sheetmorph.show.render`.

It says `{"ready": true}` once VTK has drawn a first picture. Then it reads one JSON line
per job from standard input: `{"job": n, "file": npz, "views": [...]}`. For every view it
writes `<n>-<k>.npy` beside the job's file and then the line `{"job": n, "view": k}`. It
ends when standard input ends. A crash in here, such as that of a missing graphics driver,
cannot hurt the run.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from sheetmorph.geometry.mesh import Floats, Ints
from sheetmorph.show import scene


class Canvas:
    """A sheet in a window of VTK.

    Args:
        window: off the screen; the sheet takes the place of what was in it.
        triangles: node indices, shape (T, 3).
        uv: place of every node in the textures, shape (V, 2).
        textures: pictures of shape (h, w, 3), row 0 on top.
    """

    def __init__(
        self,
        window: Any,
        triangles: Ints,
        uv: Floats,
        textures: list[scene.Image],
    ) -> None:
        from vtkmodules import vtkRenderingCore
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

        self._numpy_to_vtk = numpy_to_vtk
        self._triangles = triangles
        self._points: Floats | None = None
        self._colours: scene.Colours | None = None
        self._sheet = vtkPolyData()
        cells = vtkCellArray()
        cells.SetData(3, numpy_to_vtkIdTypeArray(triangles.astype(np.int64).ravel(), deep=True))
        self._sheet.SetPolys(cells)
        self._sheet.GetPointData().SetTCoords(numpy_to_vtk(uv.astype(np.float32), deep=True))
        self._textures = [_texture(texture) for texture in textures]

        self._renderer = vtkRenderingCore.vtkRenderer()
        self._renderer.SetBackground(1.0, 1.0, 1.0)
        self._renderer.AutomaticLightCreationOff()
        self._lights = []
        for direction in (scene.KEY_LIGHT, (0.0, 0.0, 1.0)):
            light = vtkRenderingCore.vtkLight()
            light.SetLightTypeToCameraLight()
            light.SetPosition(*direction)
            light.SetFocalPoint(0.0, 0.0, 0.0)
            self._renderer.AddLight(light)
            self._lights.append(light)
        self._sides = []
        for side in range(2):
            mapper = vtkRenderingCore.vtkPolyDataMapper()
            mapper.SetInputData(self._sheet)
            mapper.SetScalarModeToUsePointData()
            actor = vtkRenderingCore.vtkActor()
            actor.SetMapper(mapper)
            surface = actor.GetProperty()
            surface.SetBackfaceCulling(side == 0)
            surface.SetFrontfaceCulling(side == 1)
            surface.SetInterpolationToPhong()
            surface.SetDiffuse(1.0)
            surface.SetSpecularPower(scene.SHININESS / 2)
            self._renderer.AddActor(actor)
            self._sides.append(actor)
        self._window = window
        for old in list(window.GetRenderers()):
            window.RemoveRenderer(old)
        window.AddRenderer(self._renderer)

    def draw(
        self, points: Floats, colours: scene.Colours, parameters: dict[str, Any]
    ) -> scene.Image:
        """Draw one view; `parameters` are those of `view_parameters`."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkPoints, vtkUnsignedCharArray

        # What is the same as in the last view is on the graphics card already.
        data = self._sheet.GetPointData()
        if self._points is None or not np.array_equal(points, self._points):
            places = vtkPoints()
            places.SetData(self._numpy_to_vtk(points.astype(np.float32), deep=True))
            self._sheet.SetPoints(places)
            normals = scene.node_normals(points, self._triangles)
            data.SetNormals(self._numpy_to_vtk(normals.astype(np.float32), deep=True))
            self._points = points
        if self._colours is None or not np.array_equal(colours, self._colours):
            data.SetScalars(self._numpy_to_vtk(np.ascontiguousarray(colours), deep=True))
            self._colours = colours
        strengths = parameters["light"]
        for actor, texture in zip(self._sides, parameters["textures"], strict=True):
            actor.SetTexture(self._textures[texture])
            actor.GetProperty().SetAmbient(strengths["ambient"])
            actor.GetProperty().SetSpecular(strengths["shine"] / strengths["key"])
        for light, name in zip(self._lights, ("key", "head"), strict=True):
            light.SetIntensity(strengths[name])

        view = parameters["camera"]
        centre, toward = np.array(view["centre"]), np.array(view["toward"])
        away = view["distance"] or 4.0 * view["extent"]
        camera = self._renderer.GetActiveCamera()
        camera.SetFocalPoint(*centre)
        camera.SetPosition(*(centre + away * toward))
        camera.SetViewUp(*view["up"])
        camera.SetParallelProjection(view["distance"] == 0)
        camera.SetParallelScale(0.5 * view["extent"])
        camera.SetViewAngle(np.degrees(2 * np.arctan(0.5 * view["extent"] / away)))
        self._renderer.ResetCameraClippingRange()

        width, height = parameters["size"]
        self._window.SetSize(width, height)
        self._window.Render()
        pixels = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 1, pixels, 0)
        image = vtk_to_numpy(pixels).reshape(height, width, 3)[::-1]
        return np.ascontiguousarray(image)


def view_parameters(view: scene.View) -> dict[str, Any]:
    """The parts of a view that are no arrays, as JSON can carry them."""
    camera = view.camera
    return {
        "textures": list(view.textures),
        "light": asdict(view.light),
        "size": [int(side) for side in view.size],
        "camera": {
            "centre": camera.centre.tolist(),
            "up": camera.up.tolist(),
            "toward": camera.toward.tolist(),
            "extent": float(camera.extent),
            "distance": float(camera.distance),
        },
    }


def _texture(image: scene.Image) -> Any:
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkRenderingCore import vtkTexture

    height, width = image.shape[:2]
    picture = vtkImageData()
    picture.SetDimensions(width, height, 1)
    rows = np.ascontiguousarray(image[::-1]).reshape(-1, 3)
    picture.GetPointData().SetScalars(numpy_to_vtk(rows, deep=True))
    texture = vtkTexture()
    texture.SetInputData(picture)
    texture.InterpolateOn()
    texture.MipmapOn()
    texture.SetMaximumAnisotropicFiltering(2)
    texture.EdgeClampOn()
    return texture


def choose_window() -> None:
    """Ask VTK for the window that needs no display, where its library is installed."""
    if not sys.platform.startswith("linux"):
        return
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        print("libEGL.so.1 is missing", file=sys.stderr)  # noqa: T201  for the parent
    else:
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


def serve(jobs: TextIO, answers: TextIO) -> None:
    """Draw every job that comes, until there are no more."""
    choose_window()
    window = _window()
    _warm_up(window)
    _say(answers, {"ready": True})
    for line in jobs:
        job = json.loads(line)
        file = Path(job["file"])
        with np.load(file, allow_pickle=False) as arrays:
            textures = [arrays[f"texture{k}"] for k in range(job["textures"])]
            canvas = Canvas(window, arrays["triangles"], arrays["uv"], textures)
            points, colours = arrays["points"], arrays["colours"]
        for k, parameters in enumerate(job["views"]):
            image = canvas.draw(points[k].astype(np.float64), colours[k], parameters)
            np.save(file.with_name(f"{job['job']}-{k}.npy"), image, allow_pickle=False)
            _say(answers, {"job": job["job"], "view": k})


def _window() -> Any:
    """The window in which all is drawn; a second one would compile the shaders again."""
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  registers the windows
    from vtkmodules.vtkRenderingCore import vtkRenderWindow

    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    return window


def _warm_up(window: Any) -> None:
    """Draw one triangle, so that drivers are loaded and shaders are compiled."""
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    white = np.full((3, 3), 255, dtype=np.uint8)
    texture = np.full((2, 2, 3), 255, np.uint8)
    canvas = Canvas(window, np.array([[0, 1, 2]], dtype=np.int32), corners[:, :2], [texture])
    camera = scene.perspective().fitted(corners, (64, 64), 0.1)
    view = scene.View(corners, white, (0, 0), camera, (64, 64))
    image = canvas.draw(corners, white, view_parameters(view))
    if image.min() == 255:
        raise RuntimeError("the graphics driver draws nothing")


def _say(answers: TextIO, message: dict[str, Any]) -> None:
    answers.write(json.dumps(message) + "\n")
    answers.flush()


def main() -> None:
    """Serve on standard input and output; what libraries print goes to standard error."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    serve(sys.stdin, answers)


if __name__ == "__main__":
    main()
