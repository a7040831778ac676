"""Who may talk to the studio: the page that it served itself, and with a token no one else.

Bound to this machine, the studio answers only to the names of this machine (so that no name on
the internet can be pointed at it, DNS rebinding) and takes orders only from its own page (so
that no other page can open a socket to it). Bound elsewhere it wants a random token besides.
"""

from __future__ import annotations

import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
COOKIE = "sheetmorph-studio"

HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
        "connect-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}
"""Sent with every answer: no scripts, styles or connections but our own; no frames."""


class Guard:
    """Middleware that lets in whom the module says, and adds `HEADERS`.

    Args:
        app: what it protects.
        port: the port that it is served at.
        token: asked of everyone; None for no token, which is for this machine alone.
    """

    def __init__(self, app: App, port: int, token: str | None) -> None:
        self._app, self._port, self._token = app, port, token

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        status = self._refusal(scope)
        if status:
            await _refuse(scope, receive, send, *status)
            return
        first = scope["type"] == "http" and self._token is not None and self._by_query(scope)

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = {name for name, _ in message["headers"]}
                extra = {k: v for k, v in HEADERS.items() if k.encode() not in given}
                if first:
                    extra["set-cookie"] = self._cookie()
                pairs = [(k.encode(), v.encode()) for k, v in extra.items()]
                message = {**message, "headers": [*message["headers"], *pairs]}
            await send(message)

        await self._app(scope, receive, with_headers)

    def _refusal(self, scope: Message) -> tuple[int, str] | None:
        """Status and reason where a request is turned away."""
        host = _header(scope, b"host")
        if self._token is None and host not in {f"{name}:{self._port}" for name in LOOPBACK}:
            return 421, "the studio answers to the names of this machine only"
        orders = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if orders:
            origin = urlsplit(_header(scope, b"origin") or "")
            if origin.scheme not in ("http", "https") or origin.netloc != host:
                return 403, "this comes from another page"
        if self._token is not None and not (self._by_query(scope) or self._by_cookie(scope)):
            return 401, "open the address that sheetmorph studio printed, with its token"
        return None

    def _by_query(self, scope: Message) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        return self._matches(given)

    def _by_cookie(self, scope: Message) -> bool:
        try:
            cookies = SimpleCookie(_header(scope, b"cookie") or "")
        except CookieError:
            return False
        morsel = cookies.get(f"{COOKIE}-{self._port}")
        return morsel is not None and self._matches(morsel.value)

    def _matches(self, given: str) -> bool:
        return hmac.compare_digest(given.encode(), (self._token or "").encode())

    def _cookie(self) -> str:
        return f"{COOKIE}-{self._port}={self._token}; Path=/; HttpOnly; SameSite=Strict"


def _header(scope: Message, name: bytes) -> str | None:
    """A header that is there once; None where it is not, or several times."""
    found = [value for key, value in scope["headers"] if key == name]
    return found[0].decode("latin-1") if len(found) == 1 else None


async def _refuse(scope: Message, receive: Receive, send: Send, status: int, text: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": text[:100]})
        return
    headers = {**HEADERS, "content-type": "text/plain; charset=utf-8"}
    pairs = [(key.encode(), value.encode()) for key, value in headers.items()]
    await send({"type": "http.response.start", "status": status, "headers": pairs})
    await send({"type": "http.response.body", "body": f"{text}\n".encode()})
