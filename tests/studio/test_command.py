"""The command: its help, its mistakes, its end."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from driving import SMALL, open_tab, start_studio, stop_studio
from websockets.exceptions import ConnectionClosed, InvalidStatus

from sheetmorph.cli import main
from sheetmorph.studio import bundle


def test_help_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["studio", "--help"]) == 0
    said = capsys.readouterr().out
    assert "sheetmorph studio bowl.toml" in said
    assert "--no-browser" in said


def test_a_file_that_is_no_design_is_told_in_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "x.toml"
    assert main(["studio", str(file), "--no-browser"]) == 2
    assert "no such file" in capsys.readouterr().err
    file.write_text(SMALL.replace("3 mm", "3 bananas"), encoding="utf-8")
    assert main(["studio", str(file), "--no-browser"]) == 2
    assert "bananas" in capsys.readouterr().err


def test_a_port_that_is_taken_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        assert main(["studio", "--port", str(port), "--no-browser"]) == 2
    said = capsys.readouterr().err
    assert str(port) in said
    assert "--port" in said


def test_an_address_of_nobody_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["studio", "--host", "no.such.host.invalid", "--no-browser"]) == 2
    assert "--host" in capsys.readouterr().err


def test_what_to_install_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bundle, "find_spec", lambda name: None)
    assert main(["studio", "--no-browser"]) == 2
    assert "sheetmorph[studio]" in capsys.readouterr().err


def test_three_js_is_where_it_is_looked_for() -> None:
    text = bundle.three_js().read_text("utf-8")
    assert "Three.js Authors" in text[:200]
    exports = text[text.rindex("export{") :]
    for name in ("as THREE", "OrbitControls"):
        assert name in exports


def test_a_token_is_asked_for_and_ctrl_c_ends_server_and_workers(tmp_path: Path) -> None:
    """One studio for both, because starting takes seconds."""
    studio = start_studio(tmp_path, "--token")
    query = "?" + studio.address.split("?")[1]
    assert len(query) > 30
    assert studio.request("/")[0] == 401
    assert studio.request("/page/main.js?token=wrong")[0] == 401
    status, _, headers = studio.request("/" + query)
    assert status == 200
    cookie = headers["set-cookie"].split(";")[0]
    assert studio.request("/page/main.js", Cookie=cookie)[0] == 200
    with pytest.raises((InvalidStatus, ConnectionClosed)):
        open_tab(studio).socket.recv(5)
    tab = open_tab(studio, Cookie=cookie)
    tab.solved()
    tab.socket.close()
    workers = studio.children()
    code, said = stop_studio(studio)
    assert code in (0, 130)
    assert "Traceback" not in said
    assert workers
    assert not [pid for pid in workers if Path(f"/proc/{pid}/cmdline").exists()]
