"""The one look of all pictures: colours, fonts, pixel-exact figures, PNG files."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.core.files import replacing
from sheetmorph.geometry.mesh import Floats
from sheetmorph.show.scene import Colours, Image

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK = "#1b2530"
MUTED = "#5c6975"
FAINT = "#c9d1d8"
HELD = "#c8102e"
FILM = (245, 196, 92)
BILAYER = (31, 111, 168)
UNDER_FILM = (226, 215, 190)
BOTTOM = (136, 84, 160)
BALANCED = (38, 140, 118)
"""Colours of the plan: film, pattern above it, below it, and on both faces; paler from below."""
SHAPE = (31, 111, 168)
SCAN = (235, 142, 44)
"""Colours of what was computed and what was measured; told apart by the colour-blind too."""

ANGLE_MAP = "viridis"
STRAIN_MAP = "RdBu_r"

DPI = 100
TEXT, SMALL = 14.0, 12.5
"""Font sizes [pt] that can still be read when a picture is shown at half its size."""
PNG_EFFORT = 4

_RC: Any = {
    "font.family": "DejaVu Sans",
    "font.size": TEXT,
    "text.color": INK,
    "text.parse_math": False,  # a dollar sign in the name of a layer is a dollar sign
    "axes.labelcolor": INK,
    "axes.edgecolor": MUTED,
    "xtick.color": INK,
    "ytick.color": INK,
}


class Sheet:
    """A white figure whose coordinates are pixels, (0, 0) at the lower left.

    Attributes:
        figure: the figure of matplotlib.
        axes: axes over the whole figure, in pixels.
        width, height: size [px].
    """

    def __init__(self, width: int, height: int) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.width, self.height = width, height
        self._images: list[tuple[Image, int, int]] = []
        self.figure: Figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, facecolor="none")
        FigureCanvasAgg(self.figure)
        self.axes: Axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_xlim(0, width)
        self.axes.set_ylim(0, height)
        self.axes.axis("off")

    def text(self, x: float, y: float, text: str, **options: Any) -> None:
        """Write at a place [px]; options are those of `Axes.text`."""
        self.axes.text(x, y, text, **options)

    def title(self, title: str, subtitle: str) -> None:
        """A title with a grey line below it, at the upper left."""
        self.text(24, self.height - 20, title, fontsize=21, fontweight="bold", va="top")
        self.text(24, self.height - 60, subtitle, color=MUTED, va="top")

    def foot(self, text: str) -> None:
        """A grey line at the lower left."""
        self.text(24, 28, text, fontsize=SMALL, color=MUTED, va="center")

    def image(self, image: Image, x: int, y: int) -> None:
        """Put a picture under all else, its lower left corner at a place [px]."""
        self._images.append((image, x, y))

    def inset(self, x: float, y: float, width: float, height: float) -> Axes:
        """Axes in a rectangle [px]."""
        return self.figure.add_axes(
            (x / self.width, y / self.height, width / self.width, height / self.height)
        )

    def colour_bar(
        self,
        box: tuple[float, float, float, float],
        name: str,
        limits: tuple[float, float],
        shown: tuple[float, float],
        label: str,
        fontsize: float = TEXT,
    ) -> None:
        """A standing colour bar.

        Args:
            box: x, y, width, height [px].
            name: the colour map.
            limits: the values at the two ends of the map.
            shown: the part of them that occurs, and that the bar shows.
            label: name and unit.
            fontsize: of the label and the numbers.
        """
        from matplotlib.ticker import MaxNLocator

        low, high = shown
        x, y, width, height = (round(side) for side in box)
        ramp = mapped(np.linspace(high, low, height), name, limits)
        self.image(np.repeat(ramp[:, None], width, axis=1), x, y)
        axes = self.inset(x, y, width, height)
        axes.set_facecolor("none")
        axes.set_ylim(low, high)
        axes.xaxis.set_ticks([])
        axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
        axes.yaxis.tick_right()
        axes.tick_params(labelsize=fontsize, length=3, pad=3)
        axes.set_title(label, fontsize=fontsize, loc="left", pad=10)
        for spine in axes.spines.values():
            spine.set_linewidth(0.6)

    def save(self, path: Path) -> Path:
        """Write a PNG file, whole or not at all.

        Raises:
            OutputError: it cannot be written.
        """
        from PIL import Image as Pillow

        canvas: Any = self.figure.canvas
        canvas.draw()
        drawing = Pillow.fromarray(np.asarray(canvas.buffer_rgba()))
        picture = Pillow.new("RGB", drawing.size, "white")
        for image, x, y in self._images:
            picture.paste(Pillow.fromarray(image), (x, self.height - y - image.shape[0]))
        picture.paste(drawing, (0, 0), drawing)
        with replacing(path) as partial:
            picture.save(partial, format="PNG", compress_level=PNG_EFFORT)
        return path


@contextmanager
def style() -> Iterator[None]:
    """Draw with the fonts and colours of the house, and without warnings on missing glyphs."""
    from matplotlib import rc_context

    with rc_context(_RC), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=r"Glyph .* missing", category=UserWarning)
        yield


def colour(rgb: tuple[int, int, int]) -> str:
    """A colour of three bytes as `#rrggbb`."""
    return "#{:02x}{:02x}{:02x}".format(*rgb)


def mapped(values: Floats, name: str, limits: tuple[float, float]) -> Colours:
    """Colours of numbers by a colour map, shape (..., 3)."""
    from matplotlib import colormaps

    low, high = limits
    share = np.clip((np.asarray(values) - low) / (high - low), 0.0, 1.0)
    return np.asarray(colormaps[name](share, bytes=True)[..., :3], dtype=np.uint8)


def round_length(target: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above the target."""
    power = 10.0 ** math.floor(math.log10(target))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= target * (1 + 1e-9))


def millimetres(length: float) -> str:
    """A length [m] as text in mm with three digits."""
    value = 1e3 * length
    if abs(value) >= 100:
        return f"{value:.0f} mm"
    return f"{value:.1f} mm" if abs(value) >= 1 else f"{value:.2g} mm"


def signed(value: float, digits: int = 2) -> str:
    """A number with a real minus sign, and none before a zero."""
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("-", "−")


def shortened(text: str, limit: int) -> str:
    """Text on one line, cut to a number of characters."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= limit else line[: limit - 1] + "…"
