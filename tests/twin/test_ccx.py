"""The solver is found, watched and stopped; here a script stands in for it."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

import sheetmorph as sm
from sheetmorph.twin import ccx

pytestmark = pytest.mark.skipif(os.name != "posix", reason="the stand-in is a script of a shell")

STATUS = """SUMMARY OF JOB INFORMATION
  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME
     1          1     1     2  0.100000E+01  0.100000E+01  0.100000E+01
     2          1     1U   26  0.100000E+01  0.000000E+00  0.100000E+01
     2          1     2    22  0.125000E+01  0.250000E+00  0.250000E+00
     2          2     1     3  0.200000E+01  0.100000E+01  0.750000E+00
"""


def stand_in(folder: Path, code: str) -> str:
    path = folder / "fake-ccx"
    path.write_text(f"#!{sys.executable}\nimport sys, time, pathlib\njob = sys.argv[1]\n{code}\n")
    path.chmod(0o755)
    return str(path)


def test_the_variable_names_the_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = stand_in(tmp_path, "print('This is Version 9.1')")
    monkeypatch.setenv(ccx.VARIABLE, program)
    assert ccx.find_program() == program
    assert ccx.version(program) == "9.1"


def test_absence_says_how_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv(ccx.VARIABLE, raising=False)
    with pytest.raises(sm.InputError, match="apt-get install calculix-ccx"):
        ccx.find_program()
    monkeypatch.setenv(ccx.VARIABLE, "no-such-program")
    with pytest.raises(sm.InputError, match="SHEETMORPH_CCX: there is no such program"):
        ccx.find_program()


def test_a_run_that_ends_well(tmp_path: Path) -> None:
    program = stand_in(
        tmp_path,
        f"pathlib.Path(job + '.sta').write_text({STATUS!r}); time.sleep(0.5)\n"
        "while time.process_time() < 0.3: pass\n"
        "print(' Job finished')",
    )
    heard: list[float] = []
    ran = ccx.run(program, tmp_path, "twin", time_limit=60.0, on_time=heard.append)
    assert ran.ending == "completed"
    assert ran.times == (1.0, 1.25, 2.0)
    assert ran.iterations == 27
    assert heard[-1] == 2.0
    assert ran.message == ""
    assert 0.28 < ran.processor_seconds < 30.0  # the clock counts in hundredths


def test_a_run_that_gives_up_tells_its_last_error(tmp_path: Path) -> None:
    program = stand_in(
        tmp_path,
        "print(' *ERROR: solution seems to diverge; please try \\n"
        "        automatic incrementation; program stops\\n best solution'); sys.exit(201)",
    )
    ran = ccx.run(program, tmp_path, "twin", time_limit=60.0)
    assert ran.ending == "stopped"
    assert ran.message == (
        "solution seems to diverge; please try automatic incrementation; program stops"
    )


def test_a_run_is_stopped_in_time_with_all_that_it_started(tmp_path: Path) -> None:
    program = stand_in(
        tmp_path,
        "import subprocess\n"
        f"pathlib.Path(job + '.sta').write_text({STATUS!r})\n"
        "child = subprocess.Popen(['sleep', '60'])\n"
        "pathlib.Path('child').write_text(str(child.pid))\n"
        "time.sleep(60)",
    )
    began = time.monotonic()
    ran = ccx.run(program, tmp_path, "twin", time_limit=1.5)
    assert time.monotonic() - began < 20.0
    assert ran.ending == "time_limit"
    assert ran.times[-1] == 2.0
    child = int((tmp_path / "child").read_text("utf-8"))
    for _ in range(100):
        if not _alive(child):
            break
        time.sleep(0.05)
    assert not _alive(child)


def _alive(process: int) -> bool:
    """False also for one that has ended and whose parent has not looked."""
    try:
        return (
            Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0]
            != "Z"
        )
    except OSError:
        return False


def test_results_of_an_earlier_run_are_not_taken_for_new(tmp_path: Path) -> None:
    (tmp_path / "twin.sta").write_text(STATUS)
    (tmp_path / "twin.frd").write_text("old")
    ran = ccx.run(stand_in(tmp_path, "sys.exit(1)"), tmp_path, "twin", time_limit=60.0)
    assert ran.times == ()
    assert not (tmp_path / "twin.frd").exists()


def test_a_program_that_cannot_start_is_told(tmp_path: Path) -> None:
    (tmp_path / "no-script").write_text("nothing")
    with pytest.raises(sm.InputError, match="cannot be started"):
        ccx.run(str(tmp_path / "no-script"), tmp_path, "twin", time_limit=1.0)


def test_a_run_that_is_interrupted_leaves_nothing_running(tmp_path: Path) -> None:
    program = stand_in(
        tmp_path,
        "import os\n"
        "pathlib.Path('own').write_text(str(os.getpid()))\n"
        f"pathlib.Path(job + '.sta').write_text({STATUS!r})\n"
        "time.sleep(60)",
    )

    def interrupt(reached: float) -> None:
        if reached:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ccx.run(program, tmp_path, "twin", time_limit=60.0, on_time=interrupt)
    assert not _alive(int((tmp_path / "own").read_text("utf-8")))
