"""Who may import whom: nothing imports upward, lazy imports count."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "src" / "sheetmorph"

STUDY = {"core", "geometry", "compare", "measure", "design", "energy", "solve"}
MAY_IMPORT: dict[str, set[str]] = {
    "core": set(),
    "geometry": {"core"},
    "drawing": {"core"},
    "design": {"core", "geometry", "drawing"},
    "energy": {"core", "geometry"},
    "solve": {"core"},
    "compare": {"core", "geometry"},
    "measure": {"core", "geometry"},
    "study": STUDY,
    "calibrate": {*STUDY, "study"},
    "paper": {*STUDY, "study"},
    "proofs": {*STUDY, "study"},
    "twin": {"core", "geometry", "design", "solve", "study"},
    "sweep": {"core", "geometry", "design", "study"},
    "branches": {"core", "geometry", "design", "solve", "study"},
    "inverse": {"core", "geometry", "compare", "design", "study", "sweep"},
    "show": {
        "core",
        "geometry",
        "compare",
        "measure",
        "design",
        "study",
        "calibrate",
        "paper",
        "proofs",
        "sweep",
        "branches",
        "inverse",
    },
    "fabricate": {"core", "geometry", "drawing", "design"},
    "studio": {
        *("core", "geometry", "drawing", "compare", "design"),
        *("study", "branches", "show", "fabricate"),
    },
    "cli": {
        *STUDY,
        *(
            "study",
            "calibrate",
            "paper",
            "proofs",
            "twin",
            "sweep",
            "branches",
            "inverse",
            "show",
            "fabricate",
            "studio",
        ),
    },
}
PLOTTING = {"matplotlib", "vtkmodules", "vtk", "PIL", "jinja2", "rich", "click"}
MAY_PLOT = {"show", "cli"}
MAY_TEMPLATE = {"fabricate"}  # jinja2 alone, for its page
EVERYWHERE = {"sheetmorph"}  # the package itself: its version


def imports_of(file: Path) -> list[tuple[int, str]]:
    found = []
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}:{node.lineno}: write the import absolutely"
            found.append((node.lineno, str(node.module)))
            if node.module == "sheetmorph":
                found += [(node.lineno, f"sheetmorph.{alias.name}") for alias in node.names]
    return found


def rooms() -> list[Path]:
    return sorted(p for p in SOURCE.rglob("*.py") if p.parent != SOURCE)


@pytest.mark.parametrize("file", rooms(), ids=lambda p: str(p.relative_to(SOURCE)))
def test_imports_point_downward(file: Path) -> None:
    room = file.relative_to(SOURCE).parts[0]
    for line, module in imports_of(file):
        parts = module.split(".")
        if parts[0] == "sheetmorph" and len(parts) > 1 and parts[1] in MAY_IMPORT:
            allowed = MAY_IMPORT[room] | {room}
            assert parts[1] in allowed, f"{file.name}:{line}: {room} may not import {module}"
        if parts[0] in PLOTTING:
            draws = room in MAY_PLOT or (parts[0] == "jinja2" and room in MAY_TEMPLATE)
            assert draws, f"{file.name}:{line}: {room} may not import {module}"


def test_every_room_has_its_rule() -> None:
    folders = {p.name for p in SOURCE.iterdir() if p.is_dir() and p.name != "__pycache__"}
    assert folders == set(MAY_IMPORT)


def test_files_are_short() -> None:
    lengths = {p: len(p.read_text("utf-8").splitlines()) for p in SOURCE.rglob("*.py")}
    assert {p.name: n for p, n in lengths.items() if n > 400} == {}
