"""The redone paper as one HTML page that carries all its pictures, and its numbers beside it."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.core.files import write_text
from sheetmorph.paper.redo import Chapter, Paper
from sheetmorph.paper.rows import Row, Table, Value
from sheetmorph.show import guard, style
from sheetmorph.show.citations import references
from sheetmorph.show.page import rendered
from sheetmorph.show.paper_figures import draw_figure
from sheetmorph.show.render import RenderWorker

PAGE, NUMBERS = "paper.html", "paper.json"
FORMAT = "sheetmorph paper"

_KINDS = {
    "agrees": "agrees",
    "agrees in part": "part",
    "differs": "differs",
    "not comparable": "other",
    "not redone": "other",
}


def check_paper_folder(folder: str | Path, force: bool = False) -> None:
    """Refuse a folder into which the report cannot be written, before anything is computed.

    Raises:
        InputError, OutputError: see `guard.check_folder`.
    """
    place = Path(folder)
    guard.check_folder(
        place,
        (PAGE, NUMBERS),
        "report",
        ours=lambda _file: guard.wrote(place / NUMBERS, FORMAT),
        force=force,
    )


def write_paper(
    paper: Paper,
    folder: str | Path,
    worker: RenderWorker | None = None,
    *,
    on_event: Listener = silent,
    started: float | None = None,
) -> tuple[Path, list[str]]:
    """Write paper.json and paper.html.

    Args:
        paper: what was redone.
        folder: where to write; made when absent. Files of these names are replaced.
        worker: draws the shapes; one is started and ended here when absent.
        on_event: told of the progress.
        started: `time.perf_counter()` at the beginning of the job, for the time in all.

    Returns:
        The path of the page, and notes for the user.

    Raises:
        OutputError: a file cannot be written; no half-written file is left.
    """
    place = Path(folder)
    begun = perf_counter()
    painter = worker or RenderWorker.start()
    try:
        pictures = _pictures(paper, painter, on_event)
    finally:
        if worker is None:
            painter.close()
    notes = [painter.note] if painter.note else []
    drawn = perf_counter() - begun
    whole = None if started is None else perf_counter() - started
    numbers = {**paper.to_json(), "drawing_seconds": round(drawn, 2)}
    if whole is not None:
        numbers["seconds_in_all"] = round(whole, 2)
    page = render(paper, pictures, drawn, whole, painter.renderer, notes)
    text = json.dumps(numbers, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(place / NUMBERS, text + "\n")
    write_text(place / PAGE, page)
    on_event(Progress(1.0, "done"))
    return place / PAGE, notes


def render(
    paper: Paper,
    pictures: dict[str, dict[str, Any]],
    drawn: float,
    whole: float | None,
    renderer: str,
    notes: list[str],
) -> str:
    """The page as text.

    Args:
        pictures: of the figures, by chapter and name.
        drawn, whole: seconds for the drawings and for all.
        renderer: who drew the shapes, "vtk" or "drawn".
        notes: lines for the reader.
    """
    solver = next(
        (o.result.summary["solver"] for o in paper.outcomes.values() if o.result is not None), ""
    )
    used = {"model": "published", "solver": solver, "renderer": renderer}
    return rendered(
        PAGE,
        title="The paper redone",
        lead=_lead(paper),
        notes=notes,
        counts=[
            {"verdict": verdict, "kind": _KINDS[verdict], "count": count}
            for verdict, count in paper.counts.items()
        ],
        chapters=[_chapter(chapter, pictures) for chapter in paper.chapters],
        times=_times(paper, drawn, whole),
        machine=paper.machine,
        references=references(used),
    )


def _lead(paper: Paper) -> str:
    meshes = (
        "the paper's own meshes" if paper.setting.reference else "meshes made here, not the paper's"
    )
    scan = f"the scan {paper.setting.scan.name}" if paper.setting.scan else "no scan"
    return (
        f"The results that the paper states, computed anew on {meshes} and compared with {scan}: "
        f"{len(paper.outcomes)} simulations, {len(paper.rows)} rows. Each verdict follows from the "
        "numbers by the rule that stands beside it."
    )


def _chapter(chapter: Chapter, pictures: dict[str, dict[str, Any]]) -> dict[str, Any]:
    key = chapter.section.key
    return {
        "key": key,
        "title": chapter.section.title,
        "where": chapter.section.where,
        "rows": [_row(row) for row in chapter.findings.rows],
        "pictures": [
            pictures[f"{key}/{figure.name}"]
            for figure in chapter.findings.figures
            if f"{key}/{figure.name}" in pictures
        ],
        "tables": [_table(table) for table in chapter.findings.tables],
        "notes": list(chapter.findings.notes),
    }


def _row(row: Row) -> dict[str, str]:
    return {
        "id": row.id,
        "what": row.what,
        "where": row.where,
        "paper": value_text(row.paper, row.unit),
        "ours": value_text(row.ours, row.unit),
        "verdict": row.verdict,
        "kind": _KINDS[row.verdict],
        "reason": row.reason,
    }


def value_text(value: Value | None, unit: str = "") -> str:
    """A number with three digits and its unit, or the words."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    text = f"{value:.4g}".replace("-", "−")
    if "e" in text:
        mantissa, _, power = f"{value:.2e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"10{raised}" if mantissa == "1" else f"{mantissa} · 10{raised}".replace("-", "−")
    return f"{text} {unit}".strip()


def _table(table: Table) -> dict[str, Any]:
    """The cells of a table; a column of numbers stands to the right, its head too."""
    numeric = [all(map(_is_number, column)) for column in zip(*table.rows, strict=True)]
    numeric = numeric or [False] * len(table.head)
    rows = [
        [
            {"text": cell.replace("-", "−") if right else cell, "number": right}
            for cell, right in zip(row, numeric, strict=True)
        ]
        for row in table.rows
    ]
    head = [
        {"text": cell, "number": right} for cell, right in zip(table.head, numeric, strict=True)
    ]
    return {"title": table.title, "head": head, "rows": rows}


def _is_number(text: str) -> bool:
    try:
        float(text.replace("−", "-").rstrip(" %").removeprefix("+"))
    except ValueError:
        return text == "–"
    return True


def _times(paper: Paper, drawn: float, whole: float | None) -> list[dict[str, str]]:
    rows = [
        {
            "what": chapter.section.title,
            "runs": str(chapter.runs),
            "simulations": f"{chapter.run_seconds:.1f}",
            "evaluation": f"{chapter.seconds:.1f}",
        }
        for chapter in paper.chapters
    ]
    once = sum(outcome.cpu_seconds for outcome in paper.outcomes.values())
    rows.append(
        {
            "what": "all, each simulation once",
            "runs": str(len(paper.outcomes)),
            "simulations": f"{once:.1f}",
            "evaluation": f"{sum(chapter.seconds for chapter in paper.chapters):.1f}",
        }
    )
    walls = [
        f"computing {paper.seconds:.1f} s with {paper.workers} "
        + ("worker" if paper.workers == 1 else "workers"),
        f"drawing {drawn:.1f} s",
    ]
    if whole is not None:
        walls.append(f"in all {whole:.1f} s")
    rows.append(
        {"what": "wall: " + ", ".join(walls), "runs": "", "simulations": "", "evaluation": ""}
    )
    return rows


def _pictures(paper: Paper, worker: RenderWorker, on_event: Listener) -> dict[str, dict[str, Any]]:
    """All figures as data of the page, by chapter and name."""
    from PIL import Image

    wanted = [
        (f"{chapter.section.key}/{figure.name}", figure)
        for chapter in paper.chapters
        for figure in chapter.findings.figures
    ]
    drawn: dict[str, dict[str, Any]] = {}
    with TemporaryDirectory() as folder, style.style():
        for count, (name, figure) in enumerate(wanted):
            on_event(Progress(0.9 + 0.1 * count / len(wanted), f"drawing {name}"))
            path = draw_figure(figure, paper.outcomes, worker, Path(folder) / f"{count}.png")
            with Image.open(path) as image:
                width, height = image.size
            data = base64.b64encode(path.read_bytes()).decode("ascii")
            drawn[name] = {
                "data": f"data:image/png;base64,{data}",
                "width": width,
                "height": height,
                "caption": figure.caption,
            }
    return drawn
