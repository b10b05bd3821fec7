"""The server of the page: on this machine alone, by a link with a token."""

from collections.abc import Callable
from os import cpu_count
from secrets import token_urlsafe
from typing import Final

from nicegui import app, ui
from starlette.middleware.trustedhost import TrustedHostMiddleware

from contactlab_explorer.guard import HOST, NAMES, TOKEN, Guard
from contactlab_explorer.page import add_page
from contactlab_explorer.pool import Pool
from contactlab_explorer.state import MOST, State

RECONNECTION: Final = 30.0
"""Time for which the state of a page without connection is kept, as that of a busy machine is [s]."""


def serve(state: State, port: int, opens: Callable[[str], object] | None) -> None:
    """Serve the page until Ctrl-C.

    Args:
        state: that a page begins with.
        port: to listen at.
        opens: receives the link, as a browser does; None opens nothing.
    """
    pool, token = Pool(min(MOST, cpu_count() or 1)), token_urlsafe(24)
    link = f"http://{HOST}:{port}/?{TOKEN}={token}"
    add_page(state, pool)
    app.add_middleware(TrustedHostMiddleware, allowed_hosts=[*NAMES])
    app.add_middleware(Guard, port=port, token=token)

    def begun() -> None:
        print(f"The page is at {link}\nCtrl-C ends it.", flush=True)
        if opens is not None:
            opens(link)

    app.on_startup(begun)
    app.on_shutdown(pool.close)
    ui.run(
        host=HOST,
        port=port,
        title="contactlab explore",
        show=False,
        reload=False,
        show_welcome_message=False,
        fastapi_docs=False,
        reconnect_timeout=RECONNECTION,
    )
