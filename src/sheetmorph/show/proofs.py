"""The proofs as a page of Markdown with plots, and their numbers beside it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from sheetmorph import __version__
from sheetmorph.core.files import write_text
from sheetmorph.proofs.proof import Check, Curve, Plot, Proof
from sheetmorph.proofs.prove import Outcome
from sheetmorph.show import guard
from sheetmorph.show.style import style

PAGE, NUMBERS = "proofs.md", "proofs.json"
FORMAT = "sheetmorph proofs"
LONG = 12
"""Checks of one proof beyond which the page shows the worst of them alone."""


def check_proofs_folder(folder: str | Path, force: bool = False) -> None:
    """Refuse a folder into which the page cannot be written, before anything is computed.

    Raises:
        InputError, OutputError: see `guard.check_folder`.
    """
    place = Path(folder)
    guard.check_folder(
        place,
        (PAGE, NUMBERS),
        "page of proofs",
        ours=lambda _file: _pictures_of(place) is not None,
        force=force,
    )


def _pictures_of(place: Path) -> set[str] | None:
    """Names of the pictures that an earlier page in a folder has; None if there is none."""
    numbers = guard.numbers_of(place / NUMBERS, FORMAT)
    pictures = None if numbers is None else numbers.get("pictures")
    return {str(name) for name in pictures} if isinstance(pictures, list) else None


def write_proofs(outcomes: Sequence[Outcome], folder: str | Path) -> Path:
    """Write `proofs.md`, `proofs.json` and a picture for each plot.

    Returns:
        The path of the page.

    Raises:
        InputError: a picture would replace one that this command did not draw.
        OutputError: a file cannot be written.
    """
    place = Path(folder)
    plots = [plot for outcome in outcomes if outcome.proof for plot in outcome.proof.plots]
    known = _pictures_of(place) or set()
    pictures = [f"{plot.name}.png" for plot in plots]
    guard.check_folder(
        place, pictures, "page of proofs", ours=lambda file: file.name in known, force=True
    )
    place.mkdir(parents=True, exist_ok=True)
    for plot, name in zip(plots, pictures, strict=True):
        draw_plot(plot, place / name)
    write_text(
        place / NUMBERS,
        json.dumps(_numbers(outcomes, pictures), indent=1, ensure_ascii=False) + "\n",
    )
    write_text(place / PAGE, _page(outcomes))
    return place / PAGE


def draw_plot(plot: Plot, path: Path) -> Path:
    """Draw the curves of one plot."""
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    with style():
        figure, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
        for index, curve in enumerate(plot.curves):
            _draw(axes, curve, index)
        axes.set(xlabel=plot.x_label, ylabel=plot.y_label, title=plot.title)
        for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            if name in plot.log:
                axes.set(**{f"{name}scale": "log"})
                low, high = axis.get_view_interval()
                axis.set_major_locator(
                    LogLocator(subs=(1.0, 2.0, 5.0) if high < 300 * low else (1.0,))
                )
                axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
                axis.set_minor_formatter(NullFormatter())
        axes.grid(alpha=0.3)
        figure.legend(loc="outside lower center", ncols=2, fontsize=10)
        figure.savefig(path, dpi=130)
        plt.close(figure)
    return path


def _page(outcomes: Sequence[Outcome]) -> str:
    lines = [
        "# Proofs of the laminate model",
        "",
        (
            "Cases whose answer is known, computed anew by `sheetmorph verify`, which wrote this "
            f"page (sheetmorph {__version__}). Errors are relative unless said otherwise."
        ),
        "",
        "| proof | checks | worst error | of its limit | seconds | |",
        "|---|---|---|---|---|---|",
    ]
    for outcome in outcomes:
        proof = outcome.proof
        if proof is None:
            lines.append(f"| {outcome.name} | – | – | – | {outcome.seconds:.1f} | not done |")
            continue
        within = [check for check in proof.checks if check.kind in ("relative", "absolute")]
        worst = max(within, key=lambda check: check.error / check.limit, default=None)
        lines.append(
            f"| [{proof.title}](#{_anchor(proof.title)}) | {len(proof.checks)} "
            f"| {'–' if worst is None else _error(worst)} "
            f"| {'–' if worst is None else f'{worst.error / worst.limit:.0%}'} "
            f"| {outcome.seconds:.1f} | {'holds' if proof.passed else '**fails**'} |"
        )
    for outcome in outcomes:
        lines += ["", *(_section(outcome.proof) if outcome.proof else _missing(outcome))]
    return "\n".join(lines) + "\n"


def _section(proof: Proof) -> list[str]:
    lines = [f"## {proof.title}", "", proof.statement, "", f"Source: {proof.source}.", ""]
    for plot in proof.plots:
        lines += [f"![{plot.title}]({plot.name}.png)", ""]
    lines += [
        "| quantity | known | found | error | limit | |",
        "|---|---|---|---|---|---|",
        *(_row(check) for check in _shown(proof.checks)),
    ]
    if len(proof.checks) > LONG:
        lines += [
            "",
            f"The {LONG} of {len(proof.checks)} checks that come closest to their limits.",
        ]
    for note in proof.notes:
        lines += ["", note]
    return lines


def _shown(checks: Sequence[Check]) -> Sequence[Check]:
    if len(checks) <= LONG:
        return checks
    return sorted(checks, key=_closeness, reverse=True)[:LONG]


def _closeness(check: Check) -> float:
    """How near a check is to failing: above 1 it fails."""
    if check.kind in ("relative", "absolute"):
        return check.error / check.limit
    return 2.0 + check.error if not check.passed else 1.0


def _row(check: Check) -> str:
    bound = {"at least": "≥ ", "at most": "≤ "}.get(check.kind, "")
    unit = f" {check.unit}" if check.unit else ""
    limit = {"relative": f"{100 * check.limit:g} %", "absolute": f"{check.limit:g}{unit}"}
    return (
        f"| {check.what} | {bound}{check.expected:.5g}{unit} | {check.found:.5g}{unit} "
        f"| {'' if bound else _error(check)} | {limit.get(check.kind, '')} "
        f"| {'holds' if check.passed else '**fails**'} |"
    )


def _error(check: Check) -> str:
    return f"{100 * check.error:.2g} %" if check.kind == "relative" else f"{check.error:.2g}"


def _missing(outcome: Outcome) -> list[str]:
    return [f"## {outcome.name.replace('_', ' ')}", "", f"Not done: {outcome.lack}."]


def _anchor(title: str) -> str:
    kept = "".join(c for c in title.lower() if c.isalnum() or c in " -")
    return kept.replace(" ", "-")


def _draw(axes: object, curve: Curve, index: int) -> None:
    looks = {
        "line": {"linestyle": "-", "linewidth": 1.6},
        "dashes": {"linestyle": "--", "linewidth": 1.0, "color": "0.5"},
        "marks": {"linestyle": "", "marker": "osD^v"[index % 5], "markersize": 5},
    }
    axes.plot(curve.x, curve.y, label=curve.label, **looks[curve.style])  # type: ignore[attr-defined]


def _numbers(outcomes: Sequence[Outcome], pictures: Sequence[str]) -> dict[str, object]:
    return {
        "format": FORMAT,
        "version": __version__,
        "pictures": list(pictures),
        "proofs": [
            {
                "name": outcome.name,
                "passed": outcome.passed,
                "lack": outcome.lack,
                "seconds": round(outcome.seconds, 2),
                "checks": [
                    {
                        "id": check.id,
                        "what": check.what,
                        "expected": check.expected,
                        "found": check.found,
                        "error": check.error,
                        "limit": check.limit,
                        "kind": check.kind,
                        "unit": check.unit,
                        "passed": check.passed,
                    }
                    for check in (outcome.proof.checks if outcome.proof else ())
                ],
            }
            for outcome in outcomes
        ],
    }
