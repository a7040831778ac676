"""The server of the studio: its page, a socket for each tab, uploads and downloads."""

from __future__ import annotations

import asyncio
import contextlib
import os
import re
import secrets
import socket
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import uvicorn
from starlette.applications import Starlette
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocketDisconnect

from sheetmorph import __version__
from sheetmorph.core.errors import SheetmorphError
from sheetmorph.design.presets import PRESETS
from sheetmorph.studio.bundle import three_js
from sheetmorph.studio.guard import App, Guard
from sheetmorph.studio.orders import obey
from sheetmorph.studio.pool import Pool
from sheetmorph.studio.session import Session
from sheetmorph.studio.uploads import KINDS, stored

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

PAGE = Path(__file__).parent / "page"
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
}
_NAME = re.compile(r"[a-z0-9]{16,64}")


@dataclass(frozen=True)
class Settings:
    """How the studio is served.

    Attributes:
        text: the design that a new tab begins with.
        file: the design file that it came from and is saved to; None for none.
        port: that it is served at.
        token: asked of everyone; None for none.
        memory: bytes that one computation may have.
        workers: processes that solve.
        max_tabs: tabs at once.
        keep: seconds for which a tab that has lost its connection is kept.
    """

    text: str
    file: Path | None = None
    port: int = 0
    token: str | None = None
    memory: int = 4 * 2**30
    workers: int = max(1, min(2, os.cpu_count() or 1))
    max_tabs: int = 40
    keep: float = 300.0


class Studio:
    """All tabs and the processes that compute for them.

    Args:
        settings: how it is served.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.solvers = Pool(settings.workers, settings.memory, warm=True)
        self.helpers = Pool(1, settings.memory, warm=False)
        self.sessions: dict[str, Session] = {}
        self._left: dict[str, float] = {}
        self._closing: set[asyncio.Task[None]] = set()

    async def start(self) -> None:
        """Start the processes."""
        await self.solvers.start()

    async def close(self) -> None:
        """End everything."""
        for session in list(self.sessions.values()):
            await session.close()
        self.sessions.clear()
        await asyncio.gather(self.solvers.close(), self.helpers.close())

    def session(self, name: str) -> Session | None:
        """The tab of that name, made if need be; None where there are too many."""
        found = self.sessions.get(name)
        if found is None:
            if len(self.sessions) >= self.settings.max_tabs:
                self._forget_oldest()
            if len(self.sessions) >= self.settings.max_tabs:
                return None
            file = self.settings.file
            folder = None if file is None else file.parent
            found = Session(name, self.settings.text, folder, self.solvers, self.helpers)
            found.file = file
            self.sessions[name] = found
        self._left.pop(name, None)
        return found

    def left(self, session: Session) -> None:
        """A tab has lost its connection."""
        session.leave()
        self._left[session.name] = monotonic()

    async def sweep(self) -> None:
        """Forget, for ever and ever, tabs that were left long ago."""
        while True:
            await asyncio.sleep(min(10.0, self.settings.keep))
            for name, when in list(self._left.items()):
                if monotonic() - when > self.settings.keep:
                    await self._forget(name)

    async def _forget(self, name: str) -> None:
        self._left.pop(name, None)
        session = self.sessions.pop(name, None)
        if session is not None:
            await session.close()

    def _forget_oldest(self) -> None:
        """Make room by the tab that was left first."""
        if self._left:
            name = min(self._left, key=lambda one: self._left[one])
            session = self.sessions.pop(name)
            del self._left[name]
            self._closing.add(asyncio.get_running_loop().create_task(session.close()))


def make_app(studio: Studio) -> App:
    """The web application of a studio, guarded."""
    script = three_js()
    files = {file.name: file for file in PAGE.iterdir() if file.suffix in TYPES}

    @contextlib.asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        await studio.start()
        sweeper = asyncio.get_running_loop().create_task(studio.sweep())
        try:
            yield
        finally:
            sweeper.cancel()
            await studio.close()

    async def page(request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        if name == "three.js":
            return FileResponse(script, media_type=TYPES[".js"])
        file = files.get(name)
        if file is None:
            return PlainTextResponse("there is no such page\n", 404)
        return FileResponse(file, media_type=TYPES[file.suffix])

    async def upload(request: Request) -> Response:
        session = studio.sessions.get(request.path_params["session"])
        what = request.path_params["what"]
        if session is None or what not in KINDS:
            return JSONResponse({"error": "there is no such tab"}, 404)
        name = request.query_params.get("name", "")
        announced = request.headers.get("content-length")
        try:
            file = await stored(what, name, announced, request.stream(), session.scratch)
        except SheetmorphError as error:
            return JSONResponse({"error": str(error)}, 400)
        session.uploads[what] = file
        return JSONResponse({"stored": what})

    async def download(request: Request) -> Response:
        places = request.path_params
        session = studio.sessions.get(places["session"])
        files = {} if session is None else session.downloads.get(places["export"], {})
        file = files.get(places["name"])
        if file is None or not file.is_file():
            return PlainTextResponse("there is no such file; export it again\n", 404)
        return FileResponse(file, filename=file.name)  # as an attachment, never shown in the page

    async def live(wire: WebSocket) -> None:
        name = wire.path_params["name"]
        session = studio.session(name) if _NAME.fullmatch(name) else None
        await wire.accept()
        if session is None:
            await wire.close(1013, "too many tabs are open; close some of them")
            return
        await _serve(studio, session, wire)

    routes = [
        Route("/", page),
        Route("/page/{name}", page),
        Route("/upload/{session}/{what}", upload, methods=["POST"]),
        Route("/out/{session}/{export}/{name:path}", download),
        WebSocketRoute("/live/{name}", live),
    ]
    app = Starlette(routes=routes, lifespan=life)
    return Guard(app, studio.settings.port, studio.settings.token)


async def _serve(studio: Studio, session: Session, wire: WebSocket) -> None:
    """Talk with a tab until it goes."""
    file = studio.settings.file
    if session.wire is not None:  # the tab was copied: the copy has taken its name
        with contextlib.suppress(RuntimeError, OSError):
            await session.wire.close(4001, "this tab was opened a second time")
    session.wire = wire
    session.outbox.clear()
    session.tell(
        "hello",
        version=__version__,
        presets=list(PRESETS),
        file=None if file is None else file.name,
        fresh=not session.begun,
    )
    sender = asyncio.get_running_loop().create_task(session.outbox.send_all(wire))
    try:
        session.begin()
        while True:
            message = await wire.receive()
            if message["type"] == "websocket.disconnect":
                break
            text = message.get("text")
            if isinstance(text, str):
                obey(session, text)
    except (WebSocketDisconnect, RuntimeError, OSError):
        pass
    finally:
        sender.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):
            await sender
        if session.wire is wire:
            session.wire = None
            studio.left(session)


def new_token() -> str:
    """A token that cannot be guessed."""
    return secrets.token_urlsafe(24)


class _Server(uvicorn.Server):
    """Says when it answers."""

    ready: Callable[[], None] | None = None

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        if self.started and self.ready is not None:
            self.ready()


def serve(
    studio: Studio, sockets: list[socket.socket], ready: Callable[[], None] | None = None
) -> None:
    """Serve until it is interrupted.

    Args:
        studio: what to serve.
        sockets: bound and ready to listen on.
        ready: called once the server answers.
    """
    config = uvicorn.Config(
        make_app(studio),
        log_level="critical",
        access_log=False,
        ws_max_size=6_000_000,
        ws_ping_interval=20.0,
        ws_ping_timeout=20.0,
        timeout_graceful_shutdown=2,
        server_header=False,
        date_header=False,
    )
    server = _Server(config)
    server.ready = ready
    server.run(sockets=sockets)
