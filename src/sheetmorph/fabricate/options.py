"""What the maker has and wants: printer, kerf, stock, paper; and what was predicted."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.printer import GENERIC, PrinterProfile, check_length

PAPERS: dict[str, tuple[float, float]] = {"a4": (0.210, 0.297), "letter": (0.2159, 0.2794)}
"""Width and height of the papers that a template can be made for [m], upright."""

PAPER_NAMES = {"a4": "A4", "letter": "Letter"}
MAX_COPIES = 500
MAX_PICTURE = 20_000_000
_PNG = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True)
class FabricationOptions:
    """How the parts are to be made.

    Attributes:
        printer: the printer for the inert parts.
        kerf: width of what the cutter takes away [m]; cut lines run half of it outside the
            part and inside its holes.
        copies: of the sheet, to be nested on stock.
        stock_width: of a sheet of stock [m]; None for no nesting.
        stock_height: of a sheet of stock [m].
        spacing: least distance between nested copies, and from the edge of the stock [m].
        papers: for which a template is made, of `PAPERS`.
    """

    printer: PrinterProfile = GENERIC
    kerf: float = 0.0
    copies: int = 1
    stock_width: float | None = None
    stock_height: float | None = None
    spacing: float = 2e-3
    papers: tuple[str, ...] = ("a4", "letter")

    def __post_init__(self) -> None:
        """Refuse what no workshop has.

        Raises:
            InputError: a number out of range, or a stock with one side.
        """
        check_length("kerf", self.kerf, 0.0, 5e-3)
        check_length("spacing", self.spacing, 0.0, 0.1)
        if not 1 <= self.copies <= MAX_COPIES:
            raise InputError(
                "this many copies are not made",
                key="copies",
                value=self.copies,
                allowed=f"1 to {MAX_COPIES}",
            )
        sides = (("stock_width", self.stock_width), ("stock_height", self.stock_height))
        given = [side for side in sides if side[1] is not None]
        if len(given) == 1:
            raise InputError(
                "a sheet of stock has two sides, a width and a height", key=given[0][0]
            )
        for key, side in given:
            check_length(key, side or 0.0, 1e-3, 10.0)
        if self.copies > 1 and not given:
            raise InputError(
                "several copies are nested on stock; say how large a sheet of stock is",
                key="stock_width",
                allowed="stock_width and stock_height, such as 300 mm and 200 mm",
            )
        for paper in self.papers:
            if paper not in PAPERS:
                raise InputError(
                    "this paper is not known", key="papers", value=paper, allowed=", ".join(PAPERS)
                )

    @property
    def stock(self) -> tuple[float, float] | None:
        """Width and height of a sheet of stock [m], or None."""
        if self.stock_width is None or self.stock_height is None:
            return None
        return self.stock_width, self.stock_height


@dataclass(frozen=True)
class Prediction:
    """The shape that was computed for the design.

    Attributes:
        width: extent of the final shape along x [m].
        depth: extent along y [m].
        height: extent along z [m].
        aspect_ratio: height over the largest width in any direction, h/d.
        status: how the computation ended; the sizes and the picture are shown only when this
            is "completed".
        stable: True when the shape is a stable equilibrium.
        picture_png: the shape as a PNG file, or None.
        note: a line for the reader; may be empty.
    """

    width: float
    depth: float
    height: float
    aspect_ratio: float
    status: str
    stable: bool
    picture_png: bytes | None = None
    note: str = ""

    def __post_init__(self) -> None:
        """Refuse what is no prediction.

        Raises:
            InputError: a size is negative or not finite, or the picture is no PNG file.
        """
        for key in ("width", "depth", "height"):
            value = getattr(self, key)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError("is not a size", key=f"prediction.{key}", value=value)
        picture = self.picture_png
        if picture is not None and (not picture.startswith(_PNG) or len(picture) > MAX_PICTURE):
            raise InputError(
                "is not a PNG file",
                key="prediction.picture_png",
                allowed=f"PNG of at most {MAX_PICTURE // 1_000_000} MB",
            )
