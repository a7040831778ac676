"""What waits to be sent to a browser: only the newest shape, only the newest progress."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import Any

MAX_WAITING = 200
_LATEST = ("scene", "progress")


class Outbox:
    """Packets for a browser that may be slow: one that lags gets fewer shapes, not late ones."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[str, bytes]] = deque(maxlen=MAX_WAITING)
        self._filled = asyncio.Event()

    def put(self, kind: str, packet: bytes) -> None:
        """Add a packet; one of the kinds that age replaces its predecessor."""
        if kind in _LATEST:
            kept = [entry for entry in self._waiting if entry[0] != kind]
            self._waiting = deque(kept, maxlen=MAX_WAITING)
        self._waiting.append((kind, packet))
        self._filled.set()

    def clear(self) -> None:
        """Throw all away: the browser is gone."""
        self._waiting.clear()

    async def send_all(self, socket: Any) -> None:
        """Send what comes, until the socket closes or the task is cancelled."""
        while True:
            await self._filled.wait()
            while self._waiting:
                _, packet = self._waiting.popleft()
                await socket.send_bytes(packet)
            self._filled.clear()
