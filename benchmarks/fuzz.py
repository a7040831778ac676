"""Coverage-guided fuzzing of every reader: bytes that no one wrote, for minutes.

    python benchmarks/fuzz.py svg dxf --seconds 600
    python benchmarks/fuzz.py all --seconds 600

Readers: design, mesh, svg, dxf, stl, result, 3mf, scan, curve, sweep. Each is fed with changed
files of the tests, examples and presets by libFuzzer (Atheris, which is no dependency:
`pip install atheris`). A finding is any exception but `InputError`, a message of more than one
line, more than 2 GB of memory, or 20 s of the processor for one file. Findings are written into
the folder fuzzing/, one file for each kind, with the traceback beside it; the exit code is then 1.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import process_time

for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

ROOT = Path(__file__).resolve().parents[1]
FINDINGS = ROOT / "fuzzing"
SLOWEST = 20.0
"""Seconds of the processor that a file may take."""

LARGEST = 200_000
"""Bytes of the largest file that is tried."""

Reader = Callable[[Path], object]


def _design(path: Path) -> object:
    from sheetmorph.design.spec import Design

    design = Design.load(path)
    return design.hash, design.layout.pattern.area, design.notes


def _mesh(path: Path) -> object:
    from sheetmorph.geometry.files import read_mesh

    return read_mesh(path, 1e-3)


def _drawing(path: Path) -> object:
    from sheetmorph.drawing.read import read_drawing

    drawing = read_drawing(path)
    return drawing.area(strokes=True), drawing.lines()


def _result(path: Path) -> object:
    from sheetmorph.study.result import Result

    result = Result.load(path)
    return result.strain, result.dihedral, result.aspect_ratio, result.mean_curvature


def _scan(path: Path) -> object:
    from sheetmorph.compare.scan import read_surface

    return read_surface(path)


def _curve(path: Path) -> object:
    from sheetmorph.core.columns import parse_table, read_text

    return parse_table(read_text(path))


def _sweep(path: Path) -> object:
    from sheetmorph.sweep.plan import Plan

    plan = Plan.load(path)
    return plan.fingerprint, plan.task(len(plan) - 1).id


READERS: dict[str, tuple[Reader, tuple[str, ...]]] = {
    "design": (_design, (".toml",)),
    "mesh": (_mesh, (".msh", ".vtu", ".obj", ".ply", ".txt", ".stl")),
    "svg": (_drawing, (".svg",)),
    "dxf": (_drawing, (".dxf",)),
    "stl": (_drawing, (".stl",)),
    "result": (_result, (".h5",)),
    "3mf": (_drawing, (".3mf",)),
    "scan": (_scan, (".stl", ".obj", ".ply")),
    "curve": (_curve, (".csv",)),
    "sweep": (_sweep, (".toml",)),
}
"""Name of the reader: what reads a file, and the endings of its files; the first byte chooses."""


def main() -> int:
    """Fuzz readers, each in a process of its own, one after the other; 1 if anything is found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="+", choices=(*READERS, "all"))
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--corpus", type=Path, help="fuzz here, with these files")
    arguments = parser.parse_args()
    if arguments.corpus is not None:
        fuzz(arguments.readers[0], arguments.corpus, arguments.seconds, arguments.seed)
    FINDINGS.mkdir(exist_ok=True)
    total = 0
    for name in READERS if "all" in arguments.readers else arguments.readers:
        before = set(FINDINGS.glob(f"{name}-*"))
        corpus = Path(tempfile.mkdtemp(prefix="fuzz"))
        endings = READERS[name][1]
        for number, (ending, data) in enumerate(seeds(name)):
            (corpus / f"seed{number}").write_bytes(bytes([endings.index(ending)]) + data)
        options = [
            "--corpus",
            str(corpus),
            "--seconds",
            str(arguments.seconds),
            "--seed",
            str(arguments.seed),
        ]
        child = subprocess.run(  # noqa: S603
            [sys.executable, __file__, name, *options], stderr=subprocess.PIPE, text=True
        )
        told = dict(line.split(": ", 1) for line in child.stderr.splitlines() if "stat::" in line)
        found = sorted(path.name for path in set(FINDINGS.glob(f"{name}-*")) - before)
        total += len(found)
        print(
            f"{name}: {told.get('stat::number_of_executed_units', '?').strip()} files, "
            f"{told.get('stat::new_units_added', '?').strip()} that reached new code, at most "
            f"{told.get('stat::peak_rss_mb', '?').strip()} MB and "
            f"{told.get('stat::slowest_unit_time_sec', '?').strip()} s for one, exit code "
            f"{child.returncode}, findings: {', '.join(found) or 'none'}",
            flush=True,
        )
        if child.returncode:
            print("\n".join(child.stderr.splitlines()[-15:]), flush=True)
    return 1 if total else 0


def fuzz(name: str, corpus: Path, seconds: int, seed: int) -> None:
    """Feed one reader until the time is over; does not return.

    The first byte of what libFuzzer makes chooses the ending of the file.
    """
    import atheris

    with atheris.instrument_imports(include=["sheetmorph", "ezdxf", "svg.path", "tinycss2"]):
        from sheetmorph.core.errors import InputError

        read, endings = READERS[name]
        place = Path(tempfile.mkdtemp(prefix="fuzz"))
        for file in sorted(corpus.iterdir()):  # imports what the reader imports
            data = file.read_bytes()
            first = place / f"first{endings[data[0]]}"
            first.write_bytes(data[1:])
            with suppress(InputError):
                read(first)
    known: set[str] = set()

    def one(data: bytes) -> None:
        if not data:
            return
        ending = endings[data[0] % len(endings)]
        path = place / f"a{ending}"
        path.write_bytes(data[1:])
        began = process_time()
        try:
            read(path)
        except InputError as error:
            if "\n" in str(error):
                report("more than one line", data[1:], ending, str(error))
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)
            line = f"{Path(frames[-1].filename).name}-{frames[-1].lineno}"
            report(f"{type(error).__name__}-{line}", data[1:], ending, traceback.format_exc())
        if process_time() - began > SLOWEST:
            report("slow", data[1:], ending, f"{process_time() - began:.1f} s of the processor")

    def report(kind: str, data: bytes, ending: str, text: str) -> None:
        if kind in known:
            return
        known.add(kind)
        (FINDINGS / f"{name}-{kind}{ending}").write_bytes(data)
        (FINDINGS / f"{name}-{kind}.trace").write_text(text, encoding="utf-8")
        print(f"FOUND {name}: {kind}", flush=True)

    options = [
        *(sys.argv[0], str(corpus), f"-max_total_time={seconds}", f"-seed={seed}"),
        *("-timeout=600", "-rss_limit_mb=2048", f"-max_len={LARGEST}", "-print_final_stats=1"),
        *("-verbosity=1", f"-artifact_prefix={FINDINGS}/{name}-"),
    ]
    atheris.Setup(options, one)
    atheris.Fuzz()


def seeds(name: str) -> list[tuple[str, bytes]]:
    """Files of the tests, examples and presets for a reader, with their endings."""
    from fuzz_seeds import made

    _, endings = READERS[name]
    found = [(ending, data) for ending, data in made(name) if ending in endings]
    folders = (ROOT / "examples", ROOT / "tests", ROOT / "docs")
    for folder in folders:
        for path in sorted(folder.rglob("*")):
            if path.suffix in endings and path.is_file() and path.stat().st_size < LARGEST:
                text = path.read_bytes()
                is_sweep = path.suffix == ".toml" and b"[grid]" in text
                if path.suffix != ".toml" or is_sweep == (name == "sweep"):
                    found.append((path.suffix, text))
    return found


if __name__ == "__main__":
    sys.exit(main())
