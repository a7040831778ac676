"""Figs 2 and 5–7: the three designs at their three actuations."""

from __future__ import annotations

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.paper.rows import Findings, Row, ShapeFigure, Table, claims, judged, near
from sheetmorph.paper.runs import ACTUATIONS, LETTERS, Outcome, Outcomes, Run, Setting
from sheetmorph.paper.sections import (
    WITHOUT_MESHES,
    Section,
    failures,
    listed,
    result_of,
    rising,
)
from sheetmorph.study.result import Result

FIGURES = {"bowl": "Fig. 5", "canoe": "Fig. 6", "petals": "Fig. 7"}
COUNTS = {"bowl": "970, 2800, 1831", "canoe": "1215, 3505, 2291", "petals": "388, 1087, 700"}
MEAN_EDGES = {"bowl": 3.2, "canoe": 4.0, "petals": 5.8}
RELEASED_RESULT = "petals_eps-0.30.npz"
LARGEST_FILE = 50_000_000
BY_CONSTRUCTION = (
    "The meshes are the paper's own, so their counts agree by construction. Figs 5–7 are pictures "
    "without stated numbers: what their text claims is tested here, the pictures are for the eye."
)


def stage(design: str, eps_pre: float) -> Run:
    """A design at one of the paper's actuations."""
    return Run.of(design, {"actuation.eps_pre": eps_pre})


def final(design: str) -> Run:
    """A design at the last of the paper's actuations."""
    return stage(design, ACTUATIONS[design][-1])


def stages(design: str) -> tuple[Run, ...]:
    """A design at its three actuations."""
    return tuple(stage(design, eps_pre) for eps_pre in ACTUATIONS[design])


def _runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    return tuple(run for design in LETTERS for run in stages(design))


def _evaluate(setting: Setting, outcomes: Outcomes) -> Findings:
    rows: list[Row] = []
    figures, table = [], []
    for design, letter in LETTERS.items():
        runs = stages(design)
        lack = failures(outcomes, *runs)
        first = outcomes[runs[0]].result
        rows += _mesh_rows(design, None if first is None else first)
        rows += _stage_rows(design, [outcomes[run] for run in runs], lack)
        columns = tuple(
            (f"εₚᵣₑ = {run_eps(run):.2f}".replace("-", "−"), run)
            for run in runs
            if outcomes[run].result is not None
        )
        if columns:
            caption = (
                f"Design {letter}, the {design}: shape, dihedral angle |θ| and axial strain ε at "
                f"the three actuations of {FIGURES[design]}, ii to iv."
            )
            figures.append(ShapeFigure(design, caption, columns, ("shape", "angle", "strain")))
        table += [_table_row(letter, run, outcomes[run]) for run in runs]
    rows.append(_released_row(setting, outcomes))
    head = (
        *("design", "εₚᵣₑ", "height [mm]", "h/d", "largest |θ| [rad]", "strain ε from, to"),
        *("stable", "status"),
    )
    notes = (BY_CONSTRUCTION if setting.reference else WITHOUT_MESHES,)
    return Findings(rows, figures, [Table("The nine stages", head, tuple(table))], notes)


def run_eps(run: Run) -> float:
    """The actuation that a run sets."""
    value = dict(run.values)["actuation.eps_pre"]
    assert isinstance(value, float)  # noqa: S101
    return value


def _mesh_rows(design: str, result: Result | None) -> list[Row]:
    letter = LETTERS[design]
    counts = None if result is None else ", ".join(str(count) for count in result.mesh.counts)
    stated = COUNTS[design]
    nodes = 0 if result is None else result.mesh.counts[0]
    close = abs(nodes / int(stated.split(",")[0]) - 1) <= 0.05
    return [
        judged(
            f"mesh-{design}",
            f"Mesh of {letter}: nodes, edges, triangles",
            "Fig. 4",
            stated,
            counts,
            claims(
                ("the three counts are equal", counts == stated),
                ("the nodes are as many within 5 %", close),
            ),
        ),
        judged(
            f"mean-edge-{design}",
            f"Mean edge length l₀ of {letter}",
            "Discrete Elastic Shells Method",
            MEAN_EDGES[design],
            None if result is None else 1e3 * result.mesh.mean_edge_length,
            near(0.05, 0.1, relative=True),
            unit="mm",
        ),
    ]


def _stage_rows(design: str, stages: list[Outcome], lack: str) -> list[Row]:
    letter, figure = LETTERS[design], FIGURES[design]
    if lack:
        heights = angles = strains = np.zeros(3)
        stable, place = False, (0.0, "")
        told: tuple[str | None, ...] = (None, None, None, None)
    else:
        results = [result_of(outcome) for outcome in stages]
        heights = np.array([1e3 * r.summary["height_m"] for r in results])
        angles = np.array([np.abs(r.dihedral[-1]).max() for r in results])
        strains = np.array([np.abs(r.strain[-1]).max() for r in results])
        stable = all(r.summary["stable"] for r in results)
        place = _localised(design, results[-1])
        told = (
            "stable: " + ", ".join("yes" if r.summary["stable"] else "no" for r in results),
            f"height {listed(list(heights), 1)} mm",
            f"largest |θ| {listed(list(angles))} rad; largest |ε| {listed(list(strains))}",
            f"{100 * place[0]:.0f} % of the most strained twentieth",
        )
    return [
        judged(
            f"stable-{design}",
            f"{letter}: each stage is a stable equilibrium",
            figure,
            "stable equilibria",
            told[0],
            claims(
                ("all three are reached", not lack),
                ("the Hessian of each is positive definite", stable),
            ),
            lack=lack,
        ),
        judged(
            f"growth-{design}",
            f"{letter}: more actuation, more deformation",
            figure,
            "deformation grows with the stages",
            told[1],
            claims(("the height rises from stage to stage", rising(heights))),
            lack=lack,
        ),
        judged(
            f"fields-{design}",
            f"{letter}: |θ| and ε grow with actuation",
            figure,
            "larger strains, larger dihedral angles",
            told[2],
            claims(
                ("the largest |ε| rises", rising(strains)),
                ("the largest |θ| rises", rising(angles)),
            ),
            lack=lack,
        ),
        judged(
            f"place-{design}",
            f"{letter}: where deformation concentrates",
            figure,
            _STATED_PLACE[design],
            told[3],
            claims(
                (f"more than half of the most strained twentieth {place[1]}", place[0] > 0.5),
                ("all but a tenth of it does", place[0] > 0.9),
            ),
            lack=lack,
        ),
    ]


_STATED_PLACE = {
    "bowl": "between the arms, where the film shrinks most",
    "canoe": "near the four corners",
    "petals": "between the arms, in four zones",
}


def _localised(design: str, result: Result) -> tuple[float, str]:
    """Share of the most strained twentieth of the edges that lies where the paper says.

    Returns:
        The share, and the place as the end of a sentence.
    """
    mesh = result.mesh
    size = np.abs(result.strain[-1])
    most = size >= np.quantile(size, 0.95)
    if design == "canoe":
        low, high = mesh.nodes.min(axis=0), mesh.nodes.max(axis=0)
        share = np.abs((mesh.edge_midpoints - low[:2]) / (high - low)[:2] - 0.5)
        inside = (share > 0.25).all(axis=1)
        text = "lies in the quarters of the sheet next to its corners (1/16 of its area each)"
        return float(inside[most].mean()), text
    wanted: Floats = np.abs(result.thermal_strain_full)
    inside = (wanted > 0.5 * wanted.max()) & ~result.edge_in_pattern
    text = "lies outside the pattern where the film shrinks by more than half of the most"
    return float(inside[most].mean()), text


def _table_row(letter: str, run: Run, outcome: Outcome) -> tuple[str, ...]:
    eps = f"{run_eps(run):.2f}".replace("-", "−")
    if outcome.result is None:
        return (letter, eps, *["–"] * 5, outcome.failure)
    result = outcome.result
    strain = result.strain[-1]
    return (
        letter,
        eps,
        f"{1e3 * result.summary['height_m']:.1f}",
        f"{result.summary['aspect_ratio']:.3f}",
        f"{np.abs(result.dihedral[-1]).max():.2f}",
        listed([float(strain.min()), float(strain.max())]),
        "yes" if result.summary["stable"] else "no",
        result.status,
    )


def _released_row(setting: Setting, outcomes: Outcomes) -> Row:
    run = stage("petals", -0.30)
    moved, lack = None, failures(outcomes, run)
    file = None if setting.reference is None else setting.reference / RELEASED_RESULT
    if file is None or not file.is_file():
        lack = lack or f"The released result ({RELEASED_RESULT}) is not here."
    elif not lack:
        released = read_positions(file)
        shape = outcomes[run].shape
        if released.shape == shape.shape:
            moved = float(np.linalg.norm(released - shape, axis=1).max())
        else:
            lack = "The released result is of another mesh."
    return judged(
        "released-petals",
        "C at −0.30: largest distance of a node to the released result",
        "released data of Fig. 7B",
        0.0,
        moved,
        near(1e-7, 1e-4),
        unit="m",
        lack=lack,
    )


def read_positions(file: object) -> Floats:
    """The array `positions` of an npz file [m], shape (V, 3).

    Raises:
        InputError: it is too large, not such a file, or holds no such array.
    """
    from pathlib import Path

    path = Path(str(file))
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InputError("the file is too large", file=path, allowed="≤ 50 MB")
        with np.load(path, allow_pickle=False) as data:
            return np.asarray(data["positions"], dtype=np.float64)
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise InputError(f"is no released result ({error})", file=path) from None


SHAPES = Section(
    "shapes",
    "Three designs at three actuations",
    "Figs 2, 4A–C, 5–7",
    _runs,
    _evaluate,
)
