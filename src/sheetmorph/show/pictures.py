"""Writing the pictures of a result into its folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from sheetmorph.show.render import RenderWorker
from sheetmorph.show.scene import Image

if TYPE_CHECKING:
    from sheetmorph.show import stills
    from sheetmorph.study.result import Result

FOLDER = "pictures"
NAMES = (
    "overview.png",
    "design.png",
    "thermal_strain.png",
    "shape.png",
    "top.png",
    "side.png",
    "dihedral.png",
    "strain.png",
    "aspect_ratio.png",
)
"""Files that `write_pictures` writes, in the order of the report."""

MOTION_NAMES = ("energies.png",)
"""What it writes besides of a motion."""


def write_pictures(
    result: Result, folder: str | Path, worker: RenderWorker | None = None
) -> list[Path]:
    """Write all pictures of a result as PNG files into `<folder>/pictures`.

    Args:
        result: what was computed.
        folder: the results folder; made when absent.
        worker: draws the shape; started early it saves a second. One is started and ended
            here when absent. Its `note` says when VTK could not be used.

    Returns:
        The paths of the files, in the order of `NAMES`, then of `MOTION_NAMES`.

    Raises:
        OutputError: a file cannot be written; no half-written file is left.
        ComputationError: SHEETMORPH_RENDERER=vtk, and VTK does not draw.
    """
    from sheetmorph.show import stills

    with borrowed(worker) as painter:
        plan = stills.plan(result)
        return compose(result, Path(folder), plan, painter.draw(plan.job))


def compose(result: Result, folder: Path, plan: stills.Plan, images: Iterator[Image]) -> list[Path]:
    """Write all pictures, given those that the renderer has begun to draw."""
    from sheetmorph.show import flat, motion, stills, style

    target = folder / FOLDER
    with style.style():
        # These need no renderer: they are drawn while it works.
        paths = [
            flat.write_design(result, target / "design.png"),
            flat.write_thermal_strain(result, target / "thermal_strain.png"),
            flat.write_aspect_ratio(result, target / "aspect_ratio.png"),
        ]
        if result.motion is not None:
            paths.append(motion.write_energies(result, target / motion.NAME))
        paths += stills.write(result, plan, images, target)
    order = (*NAMES, *MOTION_NAMES)
    return sorted(paths, key=lambda path: order.index(path.name))


def shape_png(result: Result, size: tuple[int, int] = (900, 620)) -> bytes:
    """The final shape alone, without words, as a PNG file.

    Args:
        result: what was computed.
        size: width and height [px].

    Raises:
        ComputationError: SHEETMORPH_RENDERER=vtk, and VTK does not draw.
    """
    import io

    from PIL import Image as Pillow

    from sheetmorph.show import scene, stills

    final = result.positions[-1]
    camera = scene.perspective().fitted(final, size, 0.05)
    view = scene.View(final, stills.white(len(final)), stills.SHAPE_COLOURS, camera, size)
    with RenderWorker.start() as painter:
        (image,) = painter.draw(stills.base_job(result, (view,)))
    stream = io.BytesIO()
    Pillow.fromarray(image).save(stream, format="PNG", optimize=True)
    return stream.getvalue()


@contextmanager
def borrowed(worker: RenderWorker | None) -> Iterator[RenderWorker]:
    """The worker that was given, or one of our own for as long as it is needed."""
    if worker is not None:
        yield worker
        return
    with RenderWorker.start() as own:
        yield own
