"""Files from strangers, addresses from strangers, and computations that ask for too much."""

from __future__ import annotations

import ast
import asyncio
import http.client
import io
import zipfile
from pathlib import Path

import pytest
from driving import Running, Tab, open_tab
from small import SMALL
from websockets import Origin
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from sheetmorph.studio import uploads

SOURCE = Path(uploads.__file__).parent
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'


def said_of(tab: Tab, name: str, data: bytes) -> str:
    """What the studio says of a drawing that was dropped on it."""
    status, answer = tab.upload("drawing", name, data)
    assert status == 200, answer
    tab.order("look")
    return str(tab.wait("problem")["text"])


def test_entities_are_refused(tab: Tab) -> None:
    laughs = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10}">' for k in range(1, 10))
    bomb = f'<!DOCTYPE svg [<!ENTITY l0 "ha">{laughs}]>{SVG}<text>&l9;</text></svg>'
    assert "entities" in said_of(tab, "a.svg", bomb.encode())
    entity = '<!ENTITY x SYSTEM "file:///etc/passwd">'
    outside = f"<!DOCTYPE svg [{entity}]>{SVG}<text>&x;</text></svg>"
    told = said_of(tab, "a.svg", outside.encode())
    assert "entities" in told
    assert "root:" not in told


def test_a_zip_bomb_is_refused(tab: Tab) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        archive.writestr("3D/3dmodel.model", b" " * (200 * 2**20))
    assert len(packed.getvalue()) < 2**20
    told = said_of(tab, "a.3mf", packed.getvalue())
    assert "MB" in told or "large" in told


def test_a_broken_drawing_is_told_in_words(tab: Tab) -> None:
    assert "damaged" in said_of(tab, "a.svg", b"<svg><path d='M 0 0 L")
    assert said_of(tab, "a.dxf", b"\x00\xff" * 50)
    assert said_of(tab, "a.3mf", b"no zip")
    tab.order("edit", values={"actuation.eps_pre": -0.3})
    assert tab.solved()["numbers"]["status"] == "completed"


def test_other_kinds_of_files_are_refused(tab: Tab) -> None:
    for what, names in (
        ("drawing", ("a.exe", "a", "a.svg.exe", ".svg/", "a.toml", "a.pkl")),
        ("scan", ("a.svg", "a.stl.zip", "a.npz", "a.pickle")),
    ):
        for name in names:
            status, answer = tab.upload(what, name, b"data")
            assert (status, f"no {what}" in answer["error"]) == (400, True), name


def test_files_that_are_too_large_or_empty_are_refused(tab: Tab) -> None:
    wire = http.client.HTTPConnection(tab.studio.host, timeout=20)
    wire.putrequest("POST", f"/upload/{tab.name}/drawing?name=a.svg")
    wire.putheader("Origin", f"http://{tab.studio.host}")
    wire.putheader("Content-Length", str(uploads.KINDS["drawing"].most + 1))
    wire.endheaders()
    refused = wire.getresponse()  # before a single byte of it was sent
    assert (refused.status, b"too large" in refused.read()) == (400, True)
    wire.close()
    status, answer = tab.upload("drawing", "a.svg", b"")
    assert (status, "empty" in answer["error"]) == (400, True)


@pytest.mark.parametrize(
    "name",
    ["../../../../tmp/evil.svg", "/etc/evil.svg", "C:\\evil.svg", "a\x00b.svg", "..%2fevil.svg"],
)
def test_names_of_uploads_never_become_paths(tmp_path: Path, name: str) -> None:
    async def chunks():  # type: ignore[no-untyped-def]
        yield b"<svg/>"

    stored = asyncio.run(uploads.stored("drawing", name, None, chunks(), tmp_path))
    assert stored == tmp_path / "drawing.svg"
    assert [path.name for path in tmp_path.iterdir()] == ["drawing.svg"]


def test_a_size_that_was_not_announced_is_counted(tmp_path: Path) -> None:
    async def endless():  # type: ignore[no-untyped-def]
        while True:
            yield b" " * uploads.MB

    with pytest.raises(Exception, match="too large"):
        asyncio.run(uploads.stored("drawing", "a.svg", "12", endless(), tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_designs_read_no_files_of_others(tab: Tab) -> None:
    for file in ("../secret.svg", "/etc/passwd", "..\\x.svg"):
        drawing = f'[outline]\nkind = "drawing"\nfile = {file!r}\n'
        head, tail = SMALL.split("[outline]")[0], SMALL[SMALL.index("[[pattern]]") :]
        tab.order("open", text=head + drawing + tail)
        assert "out of its folder" in tab.wait("problem")["text"]


@pytest.mark.parametrize(
    "path",
    [
        *("/page/../server.py", "/page/..%2fserver.py", "/page/%2e%2e/server.py", "/server.py"),
        *("/page/server.py", "/out/x/y/../../etc/passwd", "/out/x/y/z", "/page/"),
    ],
)
def test_only_the_files_of_the_page_are_served(studio: Running, path: str) -> None:
    assert studio.request(path)[0] == 404


def test_uploads_and_sockets_of_other_pages_are_refused(studio: Running, tab: Tab) -> None:
    path = f"/upload/{tab.name}/drawing?name=a.svg"
    assert studio.request(path, b"<svg/>", Origin="http://evil.example")[0] == 403
    assert studio.request(path, b"<svg/>")[0] == 403
    assert studio.request("/", Host="evil.example")[0] == 421
    address = f"ws://{studio.host}/live/{'a' * 32}"
    with pytest.raises(InvalidStatus), connect(address, origin=Origin("http://evil.example")):
        pass


def test_names_of_tabs_are_checked(studio: Running) -> None:
    with pytest.raises((InvalidStatus, ConnectionClosed)):
        open_tab(studio, name="A-b.c").socket.recv(5)
    path, own = "/upload/nobody/drawing?name=a.svg", f"http://{studio.host}"
    assert studio.request(path, b"x", Origin=own)[0] == 404


def test_nothing_is_unpickled_or_evaluated() -> None:
    names = set()
    for file in SOURCE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names.add(str(node.module))
            elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in ("eval", "exec", "compile"), file
    assert not names & {"pickle", "dill", "cloudpickle", "marshal", "shelve", "multiprocessing"}


def test_the_page_takes_nothing_from_elsewhere() -> None:
    for file in (SOURCE / "page").iterdir():
        if file.suffix in (".js", ".html", ".css"):
            text = file.read_text("utf-8").replace("http://www.w3.org/2000/svg", "")
            for foreign in ("http:", "https://", "//cdn", "innerHTML", "eval("):
                assert foreign not in text.replace('"https:"', ""), (file.name, foreign)
            assert len(text.splitlines()) < 400, file.name
