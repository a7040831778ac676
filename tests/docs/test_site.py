"""The site builds without a warning, its notebooks run, its links lead somewhere, offline."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CHECK = (sys.executable, str(ROOT / "docs" / "site" / "check.py"))


def check(folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*CHECK, str(folder)], capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_the_site_builds_without_warnings_and_every_link_leads_somewhere(tmp_path: Path) -> None:
    site = tmp_path / "site"
    options = ("-W", "--keep-going", "-q", "-E", "-b", "html", "-c", "docs/site")
    command = (sys.executable, "-m", "sphinx", *options, "-d", str(tmp_path / "trees"), ".")
    built = subprocess.run(
        [*command, str(site)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert built.returncode == 0, built.stderr[-3000:]
    found = check(site)
    assert found.returncode == 0, found.stdout
    first = (site / "docs" / "notebooks" / "first-run.html").read_text("utf-8")
    assert "largest angle" in first and "<img" in first  # the cells were run
    assert "<math" in (site / "docs" / "equations.html").read_text("utf-8")
    assert "--resume" in (site / "docs" / "commands" / "run.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("body", "complaint"),
    [
        ('<a href="there.html">x</a>', "there.html leads nowhere"),
        ('<a href="#lost">x</a>', "there is no place lost"),
        ('<a href="two.html#lost">x</a>', "there is no place lost"),
        ('<img src="missing.png">', "missing.png leads nowhere"),
        ('<script src="https://cdn.example/x.js"></script>', "from elsewhere"),
        ('<link href="//fonts.example/f.css" rel="stylesheet">', "from elsewhere"),
        ('<a href="../outside.html">x</a>', "leads nowhere"),
        ('<a href="file:///etc/hosts">x</a>', "leads nowhere"),
    ],
)
def test_what_is_wrong_with_a_site_is_told(tmp_path: Path, body: str, complaint: str) -> None:
    site = tmp_path / "site"
    site.mkdir()
    (tmp_path / "outside.html").write_text("<p>", "utf-8")
    (site / "two.html").write_text('<p id="here">', "utf-8")
    (site / "one.html").write_text(f'<a href="two.html#here">y</a>{body}', "utf-8")
    found = check(site)
    assert found.returncode == 1 and complaint in found.stdout
    (site / "one.html").write_text('<a href="two.html#here">y</a> <a id="a" href="#a">', "utf-8")
    assert check(site).returncode == 0


def test_an_empty_folder_is_no_site(tmp_path: Path) -> None:
    assert check(tmp_path).returncode == 1
