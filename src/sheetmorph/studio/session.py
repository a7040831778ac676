"""One tab of a browser: its design, what is computed for it, what it is told."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Coroutine
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sheetmorph.core.files import writing
from sheetmorph.studio.frames import pack
from sheetmorph.studio.history import History
from sheetmorph.studio.outbox import Outbox
from sheetmorph.studio.pool import Ended, Pool, Ticket, Worker
from sheetmorph.studio.uploads import ROOM

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

QUICK = 0.8
"""A full solve that took longer than this [s] is announced by a preview."""
MAX_TEXT = 5_000_000
DIED = "the computation ended before its time, probably for want of memory; take a larger mesh.size"


@dataclass(eq=False)
class Wish:
    """What a tab wants to be computed next.

    Attributes:
        values: keys to set in the design.
        text: a new text for the design; None for the one it has.
        drag: it will be followed by others; a preview is enough.
        commit: the design that it makes goes into the history.
        ticket: to cancel it by.
    """

    values: dict[str, Any] = field(default_factory=dict)
    text: str | None = None
    drag: bool = False
    commit: bool = True
    ticket: Ticket = field(default_factory=Ticket)


class Session:
    """A tab.

    Args:
        name: its random name.
        text: the design that it begins with.
        folder: where files that the design names are looked up; None for nowhere.
        solvers: compute shapes.
        helpers: do what takes longer.
    """

    def __init__(
        self, name: str, text: str, folder: Path | None, solvers: Pool, helpers: Pool
    ) -> None:
        self.name, self.folder = name, folder
        self.history = History((text,))
        self.outbox = Outbox()
        self.wire: WebSocket | None = None
        self.begun = False
        self.scanned = False
        self.file: Path | None = None
        self.saved = text
        self.downloads: dict[str, dict[str, Path]] = {}
        self.uploads: dict[str, Path] = {}
        self._solvers, self._helpers = solvers, helpers
        self._pending: dict[str, Any] = {}
        self._wanted: Wish | None = None
        self._running: Wish | None = None
        self._solving = False
        self._errand: Ticket | None = None
        self._tasks: set[asyncio.Task[None]] = set()
        self._last: dict[str, bytes] = {}
        self._full_seconds = float("inf")
        self._scratch: tempfile.TemporaryDirectory[str] | None = None

    # What the tab asks for.

    def edit(self, values: dict[str, Any], drag: bool) -> None:
        """Set keys of the design; while dragging, for a look only."""
        if drag:
            self._want(Wish({**self._pending, **values}, drag=True, commit=False))
        else:
            self._pending.update(values)
            self._want(Wish(dict(self._pending)))

    def open(self, text: str) -> None:
        """Take another design; it can be undone."""
        self._pending.clear()
        self._full_seconds = float("inf")
        self._want(Wish(text=text))

    def step(self, back: bool) -> None:
        """Undo or redo."""
        self._pending.clear()
        self.history = self.history.undone() if back else self.history.redone()
        self._want(Wish(commit=False))

    def begin(self) -> None:
        """Show the design: from what was computed before, where there is any."""
        for kind in ("design", "scan", "scene", "checked"):
            if kind in self._last:
                self.outbox.put("again", self._last[kind])
        self.tell("history", **self._steps())
        if not self.begun or "scene" not in self._last:
            self.begun = True
            self._want(Wish(commit=False))
        else:
            self.tell("settled", drag=False)

    def tell(self, kind: str, **head: Any) -> None:
        """Send a packet without arrays."""
        self.outbox.put(kind, pack({"kind": kind, **head}))

    def help(self, task: str, content: dict[str, Any], what: str) -> None:
        """Have a task done that takes longer, beside the solving; one at a time.

        Args:
            task: its name in `tasks.TASKS`.
            content: of the job.
            what: for people, as in "comparing the scan".
        """
        if self._errand is not None:
            self.tell("problem", text="wait for what is being done, or stop it", about=what)
            return
        self._errand = Ticket()
        self.tell("busy", what=what)
        self._start(self._help(task, content, what, self._errand))

    def stop_help(self) -> None:
        """Stop that task."""
        if self._errand is not None:
            self._errand.cancel()

    @property
    def scratch(self) -> Path:
        """A folder for what this tab uploads and exports; gone with it.

        Raises:
            OutputError: it cannot be made.
        """
        if self._scratch is None:
            with writing("a folder for this tab", ROOM):
                self._scratch = tempfile.TemporaryDirectory(
                    prefix="sheetmorph-studio-", ignore_cleanup_errors=True
                )
        return Path(self._scratch.name)

    def leave(self) -> None:
        """The browser is gone: nothing is computed any more for nobody."""
        self.outbox.clear()
        self._wanted = None
        if self._running is not None:
            self._running.ticket.cancel()
            self._last.pop("scene", None)
        self.stop_help()

    async def close(self) -> None:
        """End all and remove the files."""
        self.leave()
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        if self._scratch is not None:
            self._scratch.cleanup()
            self._scratch = None

    def forget_scan(self) -> None:
        """Take the scan away."""
        from sheetmorph.studio.scans import LAID

        self.scanned = False
        self._last.pop("scan", None)
        (self.scratch / LAID).unlink(missing_ok=True)
        self._want(Wish(commit=False))

    # How it is computed.

    def _want(self, wish: Wish) -> None:
        running = self._running
        self._wanted = wish
        if running is not None and not (wish.drag and running.drag):
            running.ticket.cancel()
        if not self._solving:
            self._solving = True
            self._start(self._solve())

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _solve(self) -> None:
        try:
            while self._wanted is not None:
                async with self._solvers.worker() as worker:
                    wish = self._next()
                    if wish is not None:
                        await self._solve_one(wish, worker)
        finally:
            self._solving = False

    def _next(self) -> Wish | None:
        """The newest wish; it is not wanted any more when it is taken up."""
        wish, self._wanted = self._wanted, None
        return wish

    async def _solve_one(self, wish: Wish, worker: Worker) -> None:
        self._running = wish
        try:
            ended = await worker.run(self._job(wish), partial(self._take, wish), wish.ticket)
        finally:
            self._running = None
        self._conclude(wish, ended)

    def _job(self, wish: Wish) -> dict[str, Any]:
        levels = ["preview"] if wish.drag else ["full"]
        if not wish.drag and self._full_seconds > QUICK:
            levels = ["preview", "full"]
        return {
            "task": "design",
            "text": self.history.text if wish.text is None else wish.text,
            "values": wish.values,
            "folder": None if self.folder is None else str(self.folder),
            "levels": levels,
            "commit": wish.commit,
            "panel": not wish.drag,
            "scratch": str(self.scratch) if self.scanned else None,
        }

    def _take(self, wish: Wish, head: dict[str, Any], packet: bytes) -> None:
        if wish.ticket.cancelled:
            return
        kind = head["kind"]
        if kind == "design" and wish.commit:
            self.history = self.history.with_text(head["text"])
            for key, value in wish.values.items():
                if self._pending.get(key) == value:
                    del self._pending[key]
        if kind == "scene" and not head["preview"]:
            self._full_seconds = head["numbers"]["seconds"]
        if kind in ("design", "scene", "checked") and not wish.drag:
            self._last[kind] = packet
        self.outbox.put(kind, packet)
        if kind == "design":
            self.tell("history", **self._steps())

    def _conclude(self, wish: Wish, ended: Ended) -> None:
        if ended["ended"] == "cancelled":
            return
        if ended["ended"] in ("error", "died"):
            for key in wish.values:
                self._pending.pop(key, None)
            text = ended.get("text", DIED)
            self.tell("problem", text=text, key=ended.get("key"), drag=wish.drag, about="design")
        self.tell("settled", drag=wish.drag)

    async def _help(self, task: str, content: dict[str, Any], what: str, ticket: Ticket) -> None:
        def on_packet(head: dict[str, Any], packet: bytes) -> None:
            if not ticket.cancelled:
                self._take_help(head, packet)

        job = {
            "task": task,
            "text": self.history.text,
            "folder": None if self.folder is None else str(self.folder),
            **content,
        }
        try:
            async with self._helpers.worker() as worker:
                ended = await worker.run(job, on_packet, ticket)
        finally:
            self._errand = None
        if ended["ended"] in ("error", "died"):
            self.tell("problem", text=ended.get("text", DIED), about=what)
        self.tell("idle", what=what)

    def _take_help(self, head: dict[str, Any], packet: bytes) -> None:
        kind = head["kind"]
        if kind == "exported":
            places = head.pop("places")  # where files lie is not for the browser
            self.downloads[head["name"]] = {name: Path(place) for name, place in places.items()}
            self.outbox.put(kind, pack(head))
        elif kind == "opened":
            self.open(head["text"])
        elif kind == "progress":
            self.tell("helping", fraction=head["fraction"], text=head["text"])
        else:
            self.outbox.put(kind, packet)
        if kind == "scan":
            self.scanned = True
            self._last["scan"] = packet
            self._want(Wish(commit=False))  # the shape with its distances to the scan

    def _steps(self) -> dict[str, bool]:
        return {
            "undo": self.history.can_undo,
            "redo": self.history.can_redo,
            "saved": self.history.text == self.saved,
        }
