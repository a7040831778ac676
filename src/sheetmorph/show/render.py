"""Drawing the sheet in space: by VTK in a process of its own, else by the rasteriser here.

VTK ends the whole process where the graphics libraries it needs are missing. So it never
enters this process: `RenderWorker` starts a child early, while the solver runs, sends it
jobs, and draws what the child could not.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Literal, Self, cast

from sheetmorph.core.errors import ComputationError, InputError
from sheetmorph.show.child import Child, RenderError
from sheetmorph.show.scene import Image, Job

Mode = Literal["auto", "vtk", "drawn"]
MODES = ("auto", "vtk", "drawn")
VARIABLE = "SHEETMORPH_RENDERER"
PATIENCE = 20.0
"""Seconds without a picture after which the child is given up."""

COMMAND = (sys.executable, "-P", "-m", "sheetmorph.show.render_worker")


def chosen_mode() -> Mode:
    """The renderer that the environment variable SHEETMORPH_RENDERER asks for.

    Raises:
        InputError: the variable has another value than auto, vtk or drawn.
    """
    mode = os.environ.get(VARIABLE, "").strip().lower() or "auto"
    if mode not in MODES:
        raise InputError("no such renderer", key=VARIABLE, value=mode, allowed=", ".join(MODES))
    return cast(Mode, mode)


class RenderWorker:
    """Draws jobs; a context manager, or call `close`.

    Attributes:
        note: one line for the user when the pictures had to be drawn without VTK, which
            says why and what to install; None as long as all is well.
    """

    def __init__(self, mode: Mode, command: Sequence[str], patience: float) -> None:
        self.note: str | None = None
        self._mode = mode
        self._child: Child | None = None
        if mode != "drawn":
            try:
                self._child = Child(command, patience)
            except RenderError as failure:
                self._give_up(failure)

    @classmethod
    def start(cls, command: Sequence[str] = COMMAND, patience: float = PATIENCE) -> RenderWorker:
        """Start the child in the background, so that VTK loads while the solver runs.

        The environment variable SHEETMORPH_RENDERER chooses who draws: `vtk` or nobody,
        `drawn` without VTK and without a child, `auto` (the default) VTK where it works.

        Args:
            command: the program that draws.
            patience: seconds without a picture after which the child is given up.

        Raises:
            InputError: SHEETMORPH_RENDERER names no renderer.
        """
        return cls(chosen_mode(), command, patience)

    @property
    def renderer(self) -> str:
        """Who draws: "vtk" or "drawn"."""
        return "drawn" if self._child is None else "vtk"

    def draw(self, job: Job) -> Iterator[Image]:
        """Send a job to the child at once; iterate over the pictures when they are needed.

        Returns:
            The pictures in the order of the views, each of shape (height, width, 3).

        Raises:
            ComputationError: (while iterating) VTK was demanded and does not draw.
        """
        number = 0
        if self._child is not None:
            try:
                number = self._child.send(job)
            except RenderError as failure:
                self._give_up(failure)
        return self._pictures(number, job)

    def _pictures(self, number: int, job: Job) -> Iterator[Image]:
        for index, view in enumerate(job.views):
            if self._child is not None:
                try:
                    image = self._child.receive(number, index)
                except RenderError as failure:
                    self._give_up(failure)
                else:
                    yield image
                    continue
            if self._mode == "vtk":
                raise ComputationError(f"{self.note}; or set {VARIABLE}=auto")
            from sheetmorph.show.drawn import draw

            yield draw(job, view)

    def close(self) -> None:
        """End the child and remove its files."""
        child, self._child = self._child, None
        if child is not None:
            child.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _give_up(self, failure: RenderError) -> None:
        self.note = f"pictures drawn without VTK: {failure}"
        self.close()
