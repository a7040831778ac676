"""The paper's results redone: the sections, and one call that runs them side by side."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

from sheetmorph import __version__
from sheetmorph.core.errors import InputError, nearest
from sheetmorph.core.events import Listener, Notice, Progress, Started, silent
from sheetmorph.paper.adhesive import ADHESIVE
from sheetmorph.paper.checks import CHECKS
from sheetmorph.paper.history import HISTORY
from sheetmorph.paper.machine import machine
from sheetmorph.paper.numbers import CONSTANTS, COST_TABLE, ELEMENTS
from sheetmorph.paper.rows import VERDICTS, Findings, Row
from sheetmorph.paper.runs import Job, Outcome, Outcomes, Run, Setting, perform, perform_all
from sheetmorph.paper.scan import SCAN
from sheetmorph.paper.sections import Section
from sheetmorph.paper.shapes import SHAPES
from sheetmorph.paper.stiffness import FACTOR
from sheetmorph.paper.thermal import THERMAL
from sheetmorph.paper.variants import BRANCHES, MESHES

SECTIONS: tuple[Section, ...] = (
    *(SHAPES, THERMAL, HISTORY, SCAN, MESHES, FACTOR),
    *(BRANCHES, ADHESIVE, COST_TABLE, CHECKS, CONSTANTS, ELEMENTS),
)
KEYS = tuple(section.key for section in SECTIONS)

MESH_FILES = tuple(f"{design}_mesh.txt" for design in ("bowl", "canoe", "petals"))
SCAN_FILE = "petals_scan.stl"


@dataclass(frozen=True, eq=False)
class Chapter:
    """A section and what came of it.

    Attributes:
        section: what it is.
        findings: its rows, figures, tables, notes.
        runs: number of its simulations.
        run_seconds: their processor time, those included that other sections use too.
        seconds: processor time of its evaluation.
    """

    section: Section
    findings: Findings
    runs: int
    run_seconds: float
    seconds: float


@dataclass(frozen=True, eq=False)
class Paper:
    """The paper's results, redone.

    Attributes:
        setting: meshes and scan that were there.
        chapters: in the order of `SECTIONS`.
        outcomes: of all simulations, for the figures.
        machine: what it was computed on, by name of the fact.
        seconds: wall time of all computations.
        workers: processes that shared them.
    """

    setting: Setting
    chapters: tuple[Chapter, ...]
    outcomes: Outcomes
    machine: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    workers: int = 1

    @property
    def rows(self) -> list[Row]:
        """The rows of all sections."""
        return [row for chapter in self.chapters for row in chapter.findings.rows]

    @property
    def counts(self) -> dict[str, int]:
        """How many rows have each verdict."""
        return {verdict: sum(row.verdict == verdict for row in self.rows) for verdict in VERDICTS}

    def to_json(self) -> dict[str, Any]:
        """All numbers, as plain data."""
        return {
            "format": "sheetmorph paper",
            "version": __version__,
            "meshes": "released" if self.setting.reference else "made here",
            "scan": None if self.setting.scan is None else self.setting.scan.name,
            "machine": self.machine,
            "seconds": round(self.seconds, 2),
            "workers": self.workers,
            "verdicts": self.counts,
            "sections": [
                {
                    "key": chapter.section.key,
                    "title": chapter.section.title,
                    "where": chapter.section.where,
                    "runs": chapter.runs,
                    "run_cpu_seconds": round(chapter.run_seconds, 2),
                    "evaluation_cpu_seconds": round(chapter.seconds, 2),
                    "tables": [
                        {"title": table.title, "head": table.head, "rows": table.rows}
                        for table in chapter.findings.tables
                    ],
                    "notes": list(chapter.findings.notes),
                }
                for chapter in self.chapters
            ],
            "rows": [
                {"section": chapter.section.key, **vars(row)}
                for chapter in self.chapters
                for row in chapter.findings.rows
            ],
        }


def find_setting(
    reference: str | Path | None = None, scan: str | Path | None = None, *, coarsen: float = 1.0
) -> Setting:
    """Look for the paper's meshes and the scan of the petals.

    Args:
        reference: the folder of reference data; by default that of the variable
            SHEETMORPH_REFERENCE_DATA, or shared/reference beside the current folder.
        scan: a scan of the petals; by default that of the reference data.
        coarsen: factor on the mesh sizes of the presets.

    Raises:
        InputError: the folder was named and lacks the meshes, or there is no such scan.
    """
    from sheetmorph.design.files import REFERENCE_VARIABLE, reference_folder

    if reference is not None:
        folder: Path | None = Path(reference)
        lacking = [name for name in MESH_FILES if not (Path(reference) / name).is_file()]
        if lacking:
            raise InputError(
                f"this folder lacks {', '.join(lacking)}", key="--reference", value=str(reference)
            )
    else:
        try:
            folder = reference_folder(None)
        except InputError:
            if os.environ.get(REFERENCE_VARIABLE):
                raise
            folder = None
        if folder and not all((folder / name).is_file() for name in MESH_FILES):
            folder = None
    if scan is not None and not Path(scan).is_file():
        raise InputError("there is no such file", key="--scan", value=str(scan))
    place = None if scan is None else Path(scan)
    if place is None and folder is not None and (folder / SCAN_FILE).is_file():
        place = folder / SCAN_FILE
    return Setting(folder, place, coarsen)


def chosen_sections(only: Sequence[str]) -> tuple[Section, ...]:
    """The sections of these keys, in the order of the paper; all of them where none is named.

    Raises:
        InputError: there is no such section.
    """
    for key in only:
        if key not in KEYS:
            guess = nearest(key, KEYS)
            hint = f"; did you mean {guess}?" if guess else ""
            raise InputError(
                f"no such section{hint}", key="--only", value=key, allowed=", ".join(KEYS)
            )
    return tuple(section for section in SECTIONS if not only or section.key in only)


def redo_paper(
    setting: Setting,
    *,
    only: Sequence[str] = (),
    workers: int | None = None,
    on_event: Listener = silent,
) -> Paper:
    """Compute the paper's results and compare them with what it states.

    Args:
        setting: meshes and scan, from `find_setting`.
        only: keys of sections; all of them by default.
        workers: processes side by side; the number of processors up to 8 by default.
        on_event: told of the progress.

    Returns:
        The rows, figures and tables of all sections. A simulation that fails is a row that
        says so, as is a section that cannot be evaluated.

    Raises:
        InputError: there is no such section.
    """
    sections = chosen_sections(only)
    count = max(1, workers if workers is not None else min(os.cpu_count() or 1, 8))
    start = perf_counter()
    on_event(Started("the paper's results"))
    needed = {section.key: section.runs(setting) for section in sections}
    runs = list(dict.fromkeys(run for some in needed.values() for run in some))
    runs.sort(key=_expected_seconds, reverse=True)
    outcomes: dict[Run, Outcome] = {}
    jobs = [Job(str(run), perform, (run, setting)) for run in runs]
    for index, outcome in perform_all(jobs, count):
        outcomes[runs[index]] = outcome if isinstance(outcome, Outcome) else _died(outcome)
        share = 0.7 * len(outcomes) / len(runs)
        on_event(Progress(share, f"{len(outcomes)} of {len(runs)} simulations"))
        if outcomes[runs[index]].failure:
            on_event(Notice(f"{runs[index]}: {outcomes[runs[index]].failure}"))
    # The largest first, so that all processes end about together.
    longest = sorted(sections, key=lambda section: -len(needed[section.key]))
    jobs = [
        Job(
            section.key,
            evaluate,
            (section.key, setting, {r: outcomes[r] for r in needed[section.key]}),
        )
        for section in longest
    ]
    found: dict[str, tuple[Findings, float]] = {}
    for index, answer in perform_all(jobs, count):
        key = longest[index].key
        found[key] = answer if isinstance(answer, tuple) else (_lost(key, answer), 0.0)
        on_event(Progress(0.7 + 0.2 * len(found) / len(sections), f"section {key}"))
    chapters = tuple(
        Chapter(
            section,
            found[section.key][0],
            len(needed[section.key]),
            sum(outcomes[run].cpu_seconds for run in needed[section.key]),
            found[section.key][1],
        )
        for section in sections
    )
    return Paper(setting, chapters, outcomes, machine(), perf_counter() - start, count)


def evaluate(key: str, setting: Setting, outcomes: Outcomes) -> tuple[Findings, float]:
    """What a section found, and the processor time it took. Failures are a row."""
    section = next(section for section in SECTIONS if section.key == key)
    cpu = process_time()
    try:
        findings = section.evaluate(setting, outcomes)
    except Exception as error:
        findings = _lost(key, error)
    return findings, process_time() - cpu


def _lost(key: str, error: object) -> Findings:
    section = next(section for section in SECTIONS if section.key == key)
    reason = f"The section could not be evaluated: {type(error).__name__}: {error}"
    return Findings(
        [Row(f"{key}-failed", section.title, section.where, None, None, "", "not redone", reason)]
    )


def _died(error: object) -> Outcome:
    import numpy as np

    return Outcome(None, np.empty(0), {}, f"The process of the run ended: {error}", 0.0, 0.0)


def _expected_seconds(run: Run) -> float:
    """A guess, so that the longest runs begin first."""
    values = dict(run.values)
    seconds = {"canoe": 0.8, "bowl": 0.6, "petals": 0.3}[run.design]
    if values.get("published.stretch_stiffness") == "printed":
        seconds *= 2.0 * float(str(values.get("published.stretch_factor", 10.0)))
    return seconds
