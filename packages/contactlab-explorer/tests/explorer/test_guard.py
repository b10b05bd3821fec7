"""Who may open the page: the guard refuses other hosts, other origins and whoever lacks the token."""

import asyncio
from typing import Any

import pytest

from contactlab_explorer.guard import HOST, Guard

PORT, TOKEN = 8123, "a-secret"
OWN = f"{HOST}:{PORT}"
COOKIE = f"contactlab_{PORT}={TOKEN}"


def answer(kind: str = "http", query: str = "", **headers: str) -> dict[str, Any]:
    """Return the first message to a connection, or what the guarded application sends."""
    sent: list[dict[str, Any]] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "passed"})

    async def send(message: Any) -> None:
        sent.append(dict(message))

    async def receive() -> dict[str, Any]:
        return {}

    raw = [(name.encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": kind, "path": "/", "query_string": query.encode(), "headers": raw}
    asyncio.run(Guard(app, PORT, TOKEN)(scope, receive, send))
    return sent[0]


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_who_has_the_cookie_passes_from_its_own_host_and_origin(kind: str) -> None:
    for origin in ({}, {"origin": f"http://{OWN}"}):
        assert answer(kind, host=OWN, cookie=f"other=1; {COOKIE}", **origin)["type"] == "passed"
    assert answer(kind, host=f"localhost:{PORT}", cookie=COOKIE)["type"] == "passed"


@pytest.mark.parametrize("kind", ["http", "websocket"])
@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"host": "evil.example", "cookie": COOKIE},
        {"host": f"{HOST}:1", "cookie": COOKIE},
        {"host": OWN, "cookie": COOKIE, "origin": "http://evil.example"},
        {"host": OWN, "cookie": COOKIE, "origin": "null"},
        {"host": OWN, "cookie": COOKIE, "origin": f"http://localhost:{PORT}"},
        {"host": OWN, "cookie": COOKIE, "origin": f"https://{OWN}"},
        {"host": OWN},
        {"host": OWN, "cookie": f"contactlab_{PORT}=another"},
        {"host": OWN, "cookie": f"contactlab_{PORT}="},
    ],
)
def test_everybody_else_is_refused(kind: str, headers: dict[str, str]) -> None:
    sent = answer(kind, **headers)
    assert (sent.get("status"), sent.get("code")) in ((403, None), (None, 1008))


def test_the_link_gives_the_cookie_once_and_leaves_the_token_out() -> None:
    sent = answer(query=f"laws=newton%2Cpoisson&token={TOKEN}", host=OWN)
    headers = dict(sent["headers"])
    assert (sent["status"], headers[b"location"]) == (303, b"/?laws=newton%2Cpoisson")
    kept = headers[b"set-cookie"].decode()
    assert kept.startswith(COOKIE)
    assert {"HttpOnly", "SameSite=Strict"} <= {*kept.split("; ")}
    # A token opens no websocket, and a wrong one nothing.
    assert answer("websocket", f"token={TOKEN}", host=OWN)["code"] == 1008
    assert answer(query="token=another", host=OWN)["status"] == 403
