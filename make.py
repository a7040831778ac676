"""Set up and run sheetmorph on a fresh machine with Python and pip; nothing else is needed.

    python make.py bowl     make the environment, write bowl.toml and run it
    python make.py test     make the environment with the test tools and pass all tests
    python make.py fast     the same without the slow proofs
    python make.py docs     build the documentation site into build/site and check its links
    python make.py oldest   try the oldest versions that pyproject.toml allows, apart from .venv
    python make.py trial    try the newest, apart from .venv, by the Python that runs this: another
                            than that of .venv, as in `python3.13 make.py trial`
    python make.py wheel    build the wheel, install it into an empty environment, and try it
    python make.py audit    list its parts (SBOM), and ask which have known vulnerabilities

The environment is the folder .venv beside this file. It is brought up to date when
pyproject.toml has changed; delete it to make it anew.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
SITE = ROOT / "build" / "site"
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
COPY = "OSV_SCANNER_LOCAL_DB_CACHE_DIRECTORY"
"""The variable that names the folder with a local copy of the advisories, for osv-scanner."""
SIDE_BY_SIDE = ("-n", str((os.cpu_count() or 1) + 1), "--dist", "worksteal")
"""Tests run so: one more than there are cores, for some wait for the processes that they start."""
LARGEST_INSTALL = 1_600_000_000
"""Most bytes that the wheel and all it brings may take on disk."""
TRIAL = (
    *("core", "drawing", "energy", "solve", "gallery", "measure", "fabricate/test_package.py"),
    *("design/test_design.py", "geometry/test_generate.py", "compare/test_scan.py"),
    *("cli/test_run.py", "cli/test_sweep.py", "show/test_pictures.py", "studio/test_notebook.py"),
)
"""Tests that are run with other versions and other Pythons: something of every library."""


def main(arguments: list[str]) -> int:
    """Run one of the jobs; returns its exit code."""
    if sys.version_info < (3, 11):
        print("sheetmorph needs Python 3.11 or newer; this is", sys.version.split()[0])
        return 2
    jobs = {job.__name__: job for job in (bowl, test, fast, docs, oldest, trial, wheel, audit)}
    if len(arguments) != 1 or arguments[0] not in jobs:
        print(__doc__)
        return 2
    return jobs[arguments[0]]()


def bowl() -> int:
    """The main job: from the bowl's design file to a folder of results."""
    install("")
    design = ROOT / "bowl.toml"
    if not design.exists():
        run(PYTHON, "-m", "sheetmorph", "new", "bowl", "--preset", "bowl")
    return run(PYTHON, "-m", "sheetmorph", "run", "bowl.toml", "-o", "results/bowl", "--force")


def test() -> int:
    """Lint, format, types and every test."""
    return _checks()


def fast() -> int:
    """Lint, format, types and the tests that are not slow."""
    return _checks("-m", "not slow")


def docs() -> int:
    """The documentation site: every warning is an error, every link leads somewhere."""
    install("[dev]")
    shutil.rmtree(SITE, ignore_errors=True)
    build = ("-m", "sphinx", "-W", "--keep-going", "-q", "-E", "-b", "html", "-c", "docs/site")
    run(PYTHON, *build, "-d", SITE.parent / "doctrees", ".", SITE)
    return run(PYTHON, "docs/site/check.py", SITE, check=False)


def oldest() -> int:
    """The lower bounds in pyproject.toml: a trial of every room with exactly those versions."""
    import tomllib  # not there in the Pythons that main() refuses

    python = _empty("oldest")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    bounds = {*project["dependencies"], *project["optional-dependencies"]["dev"]}
    pinned = sorted(re.sub(r">=([^,; ]+)[^;]*", r"==\1", bound) for bound in bounds)
    constraints = ROOT / "build" / "oldest.txt"
    constraints.write_text("\n".join(pinned) + "\n")
    run(python, "-m", "pip", "install", "--quiet", "--editable", ".[dev]", "-c", constraints)
    return _tried(python, "-W", "ignore::DeprecationWarning")


def trial() -> int:
    """The newest versions and this Python: the same trial."""
    python = _empty(f"trial-{sys.version_info.major}.{sys.version_info.minor}")
    run(python, "-m", "pip", "install", "--quiet", "--editable", ".[dev]")
    return _tried(python)


def wheel() -> int:
    """The wheel by itself: its size, that of all it brings, and a bowl computed with it."""
    python = _empty("wheel")
    before = _size(python.parent.parent)
    run(python, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", "build", ".")
    made = max((ROOT / "build").glob("sheetmorph-*.whl"), key=lambda path: path.stat().st_mtime)
    run(python, "-m", "pip", "install", "--quiet", made)
    brought = _size(python.parent.parent) - before
    print(
        f"{made.name}: {made.stat().st_size / 1e6:.1f} MB; installed {brought / 1e6:.0f} MB in all"
    )
    work = python.parent.parent / "trial"
    work.mkdir()
    code = 0
    for command in ("new bowl --preset bowl", "check bowl.toml", "run bowl.toml -o bowl"):
        code |= run(python, "-m", "sheetmorph", *command.split(), check=False, cwd=work)
    return code or int(brought > LARGEST_INSTALL)


def audit() -> int:
    """A CycloneDX list of all that the wheel brings; then which of it has known vulnerabilities.

    The list, build/sbom/sheetmorph.cdx.json, needs no network. The advisories are those of
    pip-audit, which asks for them; or those of a local copy, where there is no network: with
    osv-scanner on the path and OSV_SCANNER_LOCAL_DB_CACHE_DIRECTORY naming the folder of the copy.
    Returns 0: none is known; 1: some are; 2: it could not be asked.
    """
    installed = PYTHON.relative_to(VENV)
    target = ROOT / "build" / "venv-wheel"
    if not (target / installed).exists() and wheel() != 0:
        return 1
    tools = _empty("audit")
    run(tools, "-m", "pip", "install", "--quiet", "cyclonedx-bom", "pip-audit")
    listed = ROOT / "build" / "sbom" / "sheetmorph.cdx.json"
    listed.parent.mkdir(parents=True, exist_ok=True)
    output = ("--output-format", "JSON", "--output-file", listed)
    listing = ("environment", target / installed, "--pyproject", ROOT / "pyproject.toml")
    run(tools, "-m", "cyclonedx_py", *listing, *output)
    parts = len(json.loads(listed.read_text("utf-8"))["components"])
    print(f"{listed.relative_to(ROOT)}: {parts} components, each with its licence")
    scanner, copy = shutil.which("osv-scanner"), os.environ.get(COPY)
    if scanner and copy:
        print(f"advisories: the local copy in {copy}, as old as it is, by osv-scanner")
        return run(
            scanner, "scan", "source", "--offline", "--no-ignore", listed.parent, check=False
        )
    (packages,) = (*target.glob("lib/*/site-packages"), *target.glob("Lib/site-packages"))
    verdict = ROOT / "build" / "vulnerabilities.json"
    verdict.unlink(missing_ok=True)
    asked = ("--progress-spinner", "off", "--path", packages)
    code = run(tools, "-m", "pip_audit", *asked, "-f", "json", "-o", verdict, check=False)
    told = json.loads(verdict.read_text("utf-8"))["dependencies"] if verdict.exists() else []
    # One that nobody knows is skipped, and so are all where nobody answers: that is no verdict.
    checked = [one["name"] for one in told if "skip_reason" not in one]
    skipped = [one["name"] for one in told if "skip_reason" in one and one["name"] != "sheetmorph"]
    print(f"advisories: asked for {len(checked)} packages, without an answer for {len(skipped)}")
    if code != 0 and checked:
        return 1
    if not checked or skipped:
        which = ", ".join(skipped) if checked else "all of them"
        print(
            f"NOT CHECKED for known vulnerabilities: {which}.\n"
            "With a network: python make.py audit. Without: osv-scanner and a copy of the "
            f"advisories (PyPI/all.zip), whose folder {COPY} names."
        )
        return 2
    return 0


def _tried(python: Path, *options: str) -> int:
    """What the trial makes of an environment."""
    tests = (f"tests/{name}" for name in TRIAL)
    fast = ("-q", "-n", "auto", "-m", "not slow")
    return run(python, "-m", "pytest", *fast, *options, *tests, check=False)


def _empty(name: str) -> Path:
    """The Python of a new environment in build/."""
    folder = ROOT / "build" / f"venv-{name}"
    shutil.rmtree(folder, ignore_errors=True)
    run(sys.executable, "-m", "venv", folder)
    return folder / PYTHON.relative_to(VENV)


def _size(folder: Path) -> int:
    return sum(p.stat().st_size for p in folder.rglob("*") if p.is_file() and not p.is_symlink())


def _checks(*selection: str) -> int:
    install("[dev]")
    steps = (
        (PYTHON, "-m", "ruff", "check", "."),
        (PYTHON, "-m", "ruff", "format", "--check", "."),
        (PYTHON, "-m", "mypy"),
        (PYTHON, "-m", "pytest", "-q", *SIDE_BY_SIDE, *selection),
    )
    # The tests come last, so that their count closes the output; all steps are run.
    codes = [run(*step, check=False) for step in steps[:-1]]
    # What it costs: printed before the tests load the machine, judged by no one.
    run(PYTHON, "benchmarks/ratios.py", "--rounds", "3", check=False)
    return max(*codes, run(*steps[-1], check=False))


def install(extra: str) -> None:
    """Make the environment, unless it is there and up to date."""
    wanted = hashlib.sha256(
        (ROOT / "pyproject.toml").read_bytes() + sys.version.encode()
    ).hexdigest()
    stamp = VENV / f"made-for{extra.replace('[', '-').rstrip(']')}.txt"
    if PYTHON.exists() and stamp.exists() and stamp.read_text() == wanted:
        return
    if not PYTHON.exists():
        print("making the environment in .venv (about a minute)", flush=True)
        shutil.rmtree(VENV, ignore_errors=True)
        run(sys.executable, "-m", "venv", VENV)
    run(PYTHON, "-m", "pip", "install", "--quiet", "--editable", f".{extra}")
    stamp.write_text(wanted)


def run(*command: str | Path, check: bool = True, cwd: Path = ROOT) -> int:
    """Run a command, in the project's folder by default, and show what it prints."""
    sys.stdout.flush()
    code = subprocess.run([str(part) for part in command], cwd=cwd, check=False).returncode
    if check and code != 0:
        sys.exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
