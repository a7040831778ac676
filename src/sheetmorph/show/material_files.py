"""The folders that `sheetmorph material` writes: numbers, tables and a picture."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from sheetmorph.core.files import write_text
from sheetmorph.design.shrink_fit import ShrinkFit
from sheetmorph.design.shrinkage import curve_text
from sheetmorph.measure.cantilever import CantileverResult, Summary
from sheetmorph.show import guard
from sheetmorph.show.material import write_cantilever_picture, write_shrink_picture

SHRINK_FILES = ("shrink.json", "curve.csv", "shrink.png")
CANTILEVER_FILES = ("cantilever.json", "cantilever.csv", "cantilever.png")
"""What a command writes; the first names the command, so that a later one knows its own."""

_FORMATS = {
    "shrink.json": "sheetmorph shrink curve",
    "cantilever.json": "sheetmorph cantilever test",
}
_KINDS = {"shrink.json": "shrink curve", "cantilever.json": "cantilever test"}


def shrink_numbers(fit: ShrinkFit) -> dict[str, Any]:
    """The numbers of a fit in SI units, ready for JSON."""
    found = fit.anisotropy
    return {
        "format": _FORMATS["shrink.json"],
        "source": fit.data.name,
        "rows": len(fit.data.temperatures),
        "glass_temperature": fit.data.glass_temperature,
        "trend": fit.trend,
        "onset": fit.onset,
        "plateau": fit.plateau,
        "plateau_eps_pre": float(fit.fitted[-1]) - 1.0,
        "plateau_scatter": None if fit.scatter is None else float(fit.scatter[-1]),
        "residual_rms": fit.residual_rms,
        "pooled_deviation": fit.pooled_deviation,
        "anisotropy": None
        if found is None
        else {
            "difference": found.difference,
            "standard_error": found.standard_error,
            "probability": found.probability,
            "significant": found.significant,
            "temperatures": found.temperatures,
            "largest": found.largest,
            "largest_at": found.largest_at,
        },
        "anisotropy_text": fit.anisotropy_text,
        "temperatures": fit.temperatures.tolist(),
        "fitted": fit.fitted.tolist(),
        "counts": fit.together.counts.astype(int).tolist(),
        "means": fit.together.means.tolist(),
        "deviations": _plain(fit.together.deviations.tolist()),
        "by_direction": {
            way: {
                "counts": group.counts.astype(int).tolist(),
                "means": _plain(group.means.tolist()),
                "deviations": _plain(group.deviations.tolist()),
            }
            for way, group in fit.by_direction.items()
        },
    }


def cantilever_numbers(result: CantileverResult) -> dict[str, Any]:
    """The numbers of a test in SI units, ready for JSON; ± with n − 1 in the denominator."""
    return {
        "format": _FORMATS["cantilever.json"],
        "loading": result.rows.loading,
        "large_deflection": result.large_deflection,
        "young_modulus": _summary(result.modulus),
        "nominal_stiffness": _summary(result.nominal_stiffness),
        "second_moment": _summary(result.second_moment),
        "greatest_deflection_ratio": float(result.rows.deflection_ratio.max()),
        "mean_overestimate": float(result.overestimate.mean()),
        "warnings": list(result.warnings),
    }


def check_place(folder: Path, names: tuple[str, ...], force: bool, source: Path) -> None:
    """Refuse a folder in which these files cannot be written, before anything is computed.

    Args:
        folder: where to write.
        names: of the files; the first tells whose they are.
        force: replace files that the same command wrote.
        source: the file of readings, which must not be written over.

    Raises:
        InputError, OutputError: see `guard.check_folder`.
    """
    guard.check_folder(
        folder,
        names,
        _KINDS[names[0]],
        ours=lambda _file: guard.wrote(folder / names[0], _FORMATS[names[0]]),
        force=force,
        inputs=[source],
    )


def write_shrink_files(fit: ShrinkFit, folder: Path) -> tuple[Path, ...]:
    """Write shrink.json, curve.csv (for `actuation.shrink_curve`) and shrink.png.

    Raises:
        OutputError: something cannot be written; what is there is whole.
    """
    glass = fit.data.glass_temperature
    remarks = (
        f"Monotone fit to {len(fit.data.temperatures)} measurements of {_one_line(fit.data.name)}.",
        "std: standard deviation of single measurements.",
        *(() if glass is None else (f"Tg = {glass!r} K",)),
    )
    text = curve_text(fit.curve, remarks)
    return _write(
        folder,
        SHRINK_FILES,
        shrink_numbers(fit),
        text,
        lambda path: write_shrink_picture(fit, path),
    )


def write_cantilever_files(result: CantileverResult, folder: Path) -> tuple[Path, ...]:
    """Write cantilever.json, cantilever.csv (every sample) and cantilever.png.

    Raises:
        OutputError: something cannot be written; what is there is whole.
    """
    numbers, text = cantilever_numbers(result), cantilever_text(result)
    return _write(
        folder, CANTILEVER_FILES, numbers, text, lambda path: write_cantilever_picture(result, path)
    )


def cantilever_text(result: CantileverResult) -> str:
    """Every sample's numbers as CSV text, in SI units."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    error = result.modulus_uncertainty
    given = ["± E [Pa]"] if error is not None else []
    writer.writerow(
        ["sample", "E [Pa]", *given, "I [m^4]", "K [N/m]", "deflection/length", "E too large by"]
    )
    overestimate = 0.0 * result.overestimate if result.large_deflection else result.overestimate
    for row, sample in enumerate(result.rows.samples):
        numbers = [result.young_modulus[row], *([error[row]] if error is not None else [])]
        numbers += [result.rows.second_moment[row], result.stiffness[row]]
        numbers += [result.rows.deflection_ratio[row], overestimate[row]]
        writer.writerow([_harmless(sample), *(f"{float(number):.9g}" for number in numbers)])
    return stream.getvalue()


def _write(
    folder: Path,
    names: tuple[str, ...],
    numbers: dict[str, Any],
    table: str,
    picture: Callable[[Path], Path],
) -> tuple[Path, ...]:
    # The numbers come first, so that a folder cut off half way is known as ours.
    marker, text, image = (folder / name for name in names)
    write_text(marker, json.dumps(numbers, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    write_text(text, table)
    picture(image)
    return marker, text, image


def _summary(summary: Summary) -> dict[str, float | int]:
    return {"mean": summary.mean, "deviation": summary.deviation, "count": summary.count}


def _plain(numbers: list[float]) -> list[float | None]:
    return [None if math.isnan(number) else number for number in numbers]


def _one_line(text: str) -> str:
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _harmless(text: str) -> str:
    """A name that a spreadsheet does not take for a formula."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text
