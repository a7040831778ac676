"""Whom the studio answers."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from sheetmorph.studio.guard import Guard

PORT = 8777


def ask(
    token: str | None = None,
    kind: str = "http",
    method: str = "GET",
    query: str = "",
    **headers: str,
) -> tuple[Any, dict[str, str]]:
    """Status (or "connected", or the code of the refusal) and headers of the answer."""
    sent: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "websocket":
            await send({"type": "websocket.accept"})
        else:
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b"page"})

    async def receive() -> dict[str, Any]:
        return {"type": "websocket.connect"}

    async def send(message: Any) -> None:
        sent.append(message)

    pairs = [(key.replace("_", "-").encode(), value.encode()) for key, value in headers.items()]
    scope = {"type": kind, "method": method, "query_string": query.encode(), "headers": pairs}
    asyncio.run(Guard(app, PORT, token)(scope, receive, send))
    first = sent[0]
    if first["type"] == "websocket.accept":
        return "connected", {}
    if first["type"] == "websocket.close":
        return first["code"], {}
    return first["status"], {k.decode(): v.decode() for k, v in first["headers"]}


HERE = f"127.0.0.1:{PORT}"


@pytest.mark.parametrize("host", [HERE, f"localhost:{PORT}", f"[::1]:{PORT}"])
def test_names_of_this_machine_are_answered(host: str) -> None:
    assert ask(host=host)[0] == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", f"evil.example:{PORT}", f"127.0.0.1.evil.example:{PORT}", HERE + "0", ""],
)
def test_a_name_that_was_pointed_here_is_not(host: str) -> None:
    assert ask(host=host)[0] == 421
    assert ask(kind="websocket", host=host, origin=f"http://{host}")[0] == 1008


def test_a_request_without_a_host_is_not() -> None:
    assert ask()[0] == 421


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", f"http://{HERE}.evil.example", f"http://127.0.0.1:{PORT + 1}"],
)
def test_orders_come_from_our_own_page_only(origin: str) -> None:
    assert ask(kind="websocket", host=HERE, origin=origin)[0] == 1008
    assert ask(method="POST", host=HERE, origin=origin)[0] == 403


def test_orders_without_an_origin_are_refused() -> None:
    assert ask(kind="websocket", host=HERE)[0] == 1008
    assert ask(method="POST", host=HERE)[0] == 403
    assert ask(method="DELETE", host=HERE)[0] == 403


def test_our_own_page_may_order() -> None:
    assert ask(kind="websocket", host=HERE, origin=f"http://{HERE}")[0] == "connected"
    assert ask(method="POST", host=HERE, origin=f"http://{HERE}")[0] == 200


def test_with_a_token_nothing_is_answered_without_it() -> None:
    away = {"host": "10.0.0.7:8777"}
    assert ask("secret", **away)[0] == 401
    assert ask("secret", query="token=wrong", **away)[0] == 401
    assert ask("secret", cookie=f"sheetmorph-studio-{PORT}=wrong", **away)[0] == 401
    assert ask("secret", cookie="\x00=;;", **away)[0] == 401
    assert ask("secret", kind="websocket", origin="http://10.0.0.7:8777", **away)[0] == 1008


def test_the_token_is_taken_once_and_kept_in_a_cookie() -> None:
    away = {"host": "10.0.0.7:8777"}
    status, headers = ask("secret", query="token=secret", **away)
    assert status == 200
    cookie = headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    kept = cookie.split(";")[0]
    assert ask("secret", cookie=kept, **away)[0] == 200
    assert (
        ask("secret", kind="websocket", cookie=kept, origin="http://10.0.0.7:8777", **away)[0]
        == "connected"
    )
    assert (
        ask("secret", kind="websocket", cookie=kept, origin="http://evil.example", **away)[0]
        == 1008
    )


def test_answers_forbid_foreign_scripts_and_frames() -> None:
    for status, headers in (ask(host=HERE), ask(host="evil.example")):
        policy = headers["content-security-policy"]
        assert status in (200, 421)
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        assert "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
