"""Set up and run sheetmorph on a fresh machine with Python and pip; nothing else is needed.

    python make.py bowl     make the environment, write bowl.toml and run it
    python make.py test     make the environment with the test tools and pass all tests
    python make.py fast     the same without the slow proofs
    python make.py docs     build the documentation site into build/site and check its links

The environment is the folder .venv beside this file. It is brought up to date when
pyproject.toml has changed; delete it to make it anew.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
BIN = VENV / ("Scripts" if os.name == "nt" else "bin")
SITE = ROOT / "build" / "site"
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")


def main(arguments: list[str]) -> int:
    """Run one of the jobs; returns its exit code."""
    if sys.version_info < (3, 11):
        print("sheetmorph needs Python 3.11 or newer; this is", sys.version.split()[0])
        return 2
    jobs = {"bowl": bowl, "test": test, "fast": fast, "docs": docs}
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


def _checks(*selection: str) -> int:
    install("[dev]")
    steps = (
        (PYTHON, "-m", "ruff", "check", "."),
        (PYTHON, "-m", "ruff", "format", "--check", "."),
        (PYTHON, "-m", "mypy"),
        (PYTHON, "-m", "pytest", "-q", "-n", "auto", "--dist", "worksteal", *selection),
    )
    # The tests come last, so that their count closes the output; all steps are run.
    codes = [run(*step, check=False) for step in steps]
    return max(codes)


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


def run(*command: str | Path, check: bool = True) -> int:
    """Run a command in the project's folder and show what it prints."""
    sys.stdout.flush()
    code = subprocess.run([str(part) for part in command], cwd=ROOT, check=False).returncode
    if check and code != 0:
        sys.exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
