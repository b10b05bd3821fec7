"""Who may open the page: this machine, from this page, with the link that the command printed."""

import socket
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from secrets import compare_digest
from typing import Any, Final, final
from urllib.parse import parse_qsl, urlencode

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

HOST: Final = "127.0.0.1"
"""Where the page listens: no other machine reaches it."""

NAMES: Final = HOST, "localhost"
"""What a browser may call this machine; another name may be somebody's domain that leads here."""

TOKEN: Final = "token"
"""Name of the token in the query of the link."""


def free_port(port: int) -> int:
    """Return a port that can be listened at, 0 being any.

    Raises:
        OSError: it cannot.
    """
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind((HOST, port))
        return int(probe.getsockname()[1])


@final
class Guard:
    """ASGI middleware that refuses another host, another origin and whoever lacks the token.

    A request with the token in its query gets it as a cookie, which this origin's scripts and other origins'
    pages cannot read or send, and is sent on to the same page without it.

    Args:
        app: what is guarded, HTTP and websockets alike.
        port: at which it listens.
        token: the secret of this start.
    """

    def __init__(self, app: App, port: int, token: str) -> None:
        self._app, self._token, self._cookie = app, token, f"contactlab_{port}"
        self._hosts = {f"{name}:{port}" for name in NAMES}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a connection on, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        host, origin = headers.get("host", ""), headers.get("origin")
        if host not in self._hosts or origin not in (None, f"http://{host}"):
            await self._refuse(scope, send)
            return
        cookie = SimpleCookie(headers.get("cookie", "")).get(self._cookie)
        if cookie is not None and compare_digest(cookie.value.encode(), self._token.encode()):
            await self._app(scope, receive, send)
            return
        query = parse_qsl(scope["query_string"].decode("latin-1"))
        given = dict(query).get(TOKEN, "")
        if scope["type"] == "http" and compare_digest(given.encode(), self._token.encode()):
            rest = urlencode([each for each in query if each[0] != TOKEN])
            place = f"{scope['path']}{rest and '?'}{rest}"
            kept = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"
            location = [(b"location", place.encode("latin-1")), (b"set-cookie", kept.encode("latin-1"))]
            await send({"type": "http.response.start", "status": 303, "headers": location})
            await send({"type": "http.response.body", "body": b""})
            return
        await self._refuse(scope, send)

    async def _refuse(self, scope: Scope, send: Send) -> None:
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
            return
        text = b"This page opens by the link that `contactlab explore` printed, on its own machine."
        plain = [(b"content-type", b"text/plain")]
        await send({"type": "http.response.start", "status": 403, "headers": plain})
        await send({"type": "http.response.body", "body": text})
