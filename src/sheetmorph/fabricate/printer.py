"""Printers: built-in profiles, and what can be changed of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sheetmorph.core.errors import InputError, nearest


def check_length(key: str, value: float, low: float, high: float) -> None:
    """Refuse a length outside its range.

    Raises:
        InputError: not a number from `low` to `high` [m].
    """
    if not low <= value <= high:
        raise InputError(
            "is out of range",
            key=key,
            value=f"{1e3 * value:g} mm",
            allowed=f"{1e3 * low:g} mm to {1e3 * high:g} mm",
        )


@dataclass(frozen=True)
class PrinterProfile:
    """A printer, as far as flat parts need to know it.

    Attributes:
        name: for people.
        nozzle_width: width of one printed line [m].
        bed_width: along x [m].
        bed_depth: along y [m].
        minimum_feature: below this width, features are a single weak line [m].
        layer_height: [m].
    """

    name: str
    nozzle_width: float
    bed_width: float
    bed_depth: float
    minimum_feature: float
    layer_height: float

    def __post_init__(self) -> None:
        """Refuse what is no printer.

        Raises:
            InputError: a length out of range, or layers thicker than the nozzle is wide.
        """
        check_length("nozzle_width", self.nozzle_width, 0.05e-3, 5e-3)
        check_length("minimum_feature", self.minimum_feature, 0.0, 20e-3)
        check_length("layer_height", self.layer_height, 0.01e-3, 3e-3)
        for key in ("bed_width", "bed_depth"):
            check_length(key, getattr(self, key), 10e-3, 5.0)
        if self.layer_height > self.nozzle_width:
            raise InputError(
                "layers are never higher than the nozzle is wide",
                key="layer_height",
                value=f"{1e3 * self.layer_height:g} mm",
                allowed=f"≤ {1e3 * self.nozzle_width:g} mm",
            )


GENERIC = PrinterProfile("generic-0.4", 0.4e-3, 0.220, 0.220, 0.8e-3, 0.2e-3)
PROFILES = {
    profile.name: profile
    for profile in (
        GENERIC,
        PrinterProfile("bambu-p1s", 0.4e-3, 0.256, 0.256, 0.8e-3, 0.2e-3),
        PrinterProfile("prusa-mk4", 0.4e-3, 0.250, 0.210, 0.8e-3, 0.2e-3),
    )
}


def find_profile(name: str, **overrides: float | None) -> PrinterProfile:
    """A built-in profile, with some of its lengths replaced.

    Args:
        name: one of `PROFILES`.
        overrides: lengths [m] by the name of their field; None leaves one as it is.

    Raises:
        InputError: there is no such profile, or a length is out of range.
    """
    if name not in PROFILES:
        guess = nearest(name, PROFILES)
        hint = f"; did you mean {guess}?" if guess else ""
        raise InputError(
            f"there is no such printer{hint}",
            key="printer",
            value=name,
            allowed=", ".join(PROFILES),
        )
    given = {key: value for key, value in overrides.items() if value is not None}
    return replace(PROFILES[name], **given)  # type: ignore[arg-type]
