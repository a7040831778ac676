"""A motion in pictures: times of its states, and where its energy goes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.show import style
from sheetmorph.show.flat import WIDTH, actuation_text, subtitle
from sheetmorph.show.style import Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sheetmorph.study.motion_record import MotionRecord
    from sheetmorph.study.result import Result

NAME = "energies.png"

_STORED = (("kinetic_J", "kinetic", style.SCAN), ("elastic_J", "elastic", style.SHAPE))
_FLOWS = (
    ("actuation_work_J", "by the actuation", style.BALANCED),
    ("load_work_J", "by loads", style.BOTTOM),
    ("damped_J", "damped", (120, 130, 140)),
    ("numerical_J", "lost to the steps in time", (190, 150, 90)),
)


def time_text(seconds: float) -> str:
    """A time for people."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= size or (unit == "s" and seconds == 0.0):
            return f"t = {seconds / size:.3g} {unit}" if seconds else "t = 0"
    return f"t = {seconds:.3g} s"


def state_text(result: Result, state: int) -> str:
    """How far a state has come: its actuation, or its time."""
    if result.motion is None:
        return actuation_text(float(result.actuation[state]))
    return time_text(float(result.motion.time[state]))


def write_energies(result: Result, path: Path) -> Path:
    """Energies of a motion, and the works, against time."""
    motion = result.motion
    assert motion is not None  # noqa: S101  asked for with a motion alone
    rows = 2 if any(np.abs(motion.history[name]).max() > 0.0 for name, _, _ in _FLOWS) else 1
    sheet = Sheet(WIDTH, 216 + 330 * rows)
    sheet.title("Energies of the motion", subtitle(result, str(result.summary["status"])))
    width = WIDTH - 116 - 56
    for row, (columns, label) in enumerate(
        ((_STORED, "energy  [mJ]"), (_FLOWS, "work so far  [mJ]"))[:rows]
    ):
        axes = sheet.inset(116, 110 + 330 * (rows - 1 - row), width, 274)
        _curves(axes, motion, columns, label)
        if row == rows - 1:
            axes.set_xlabel("time  [s]", labelpad=8)
        else:
            axes.tick_params(labelbottom=False)
    told = result.summary["motion"]
    rest = "at rest" if told["at_rest"] else "in motion"
    end = f"{rest} at {told['time_s']:.3g} s"
    sheet.text(WIDTH - 24, sheet.height - 20, end, ha="right", va="top", fontsize=16)
    sheet.foot(
        "kinetic + elastic = work by actuation and loads − damped − lost to the steps in time"
    )
    return sheet.save(path)


def _curves(
    axes: Axes,
    motion: MotionRecord,
    columns: tuple[tuple[str, str, tuple[int, int, int]], ...],
    label: str,
) -> None:
    time = motion.history["time_s"]
    for name, text, rgb in columns:
        values = motion.history[name]
        axes.plot(time, 1e3 * values, "-", color=style.colour(rgb), lw=1.8, label=text)
    axes.set_xlim(0.0, float(time[-1]) or 1.0)
    axes.set_ylabel(label, labelpad=8)
    axes.grid(color=style.FAINT, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(-0.01, 0.99),
        ncol=len(columns),
        frameon=False,
        fontsize=style.SMALL,
        columnspacing=1.4,
    )
