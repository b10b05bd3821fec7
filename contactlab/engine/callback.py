"""A kernel that the Python interpreter runs, because the compiler does not take it.

The loop calls a tiny compiled stand-in by address like any kernel, one for each signature. It asks the
function that stands behind it at the time, at the cost of speed.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, partial
from traceback import extract_tb, walk_tb
from typing import Any

import numba

from contactlab.laws.declaration import LawError

Callback = tuple[str, Callable[..., Any]]
"""The name of a kernel, and the Python function that is in its place within `law_errors`."""

_standing: ContextVar[tuple[dict[str, Callable[..., Any]], list[KeyboardInterrupt]]]
_standing = ContextVar("_standing")
"""The functions behind the stand-ins by name, and what waits until the loop has ended."""


@contextmanager
def law_errors(name: str, *callbacks: Callback) -> Iterator[None]:
    """Let functions answer for a law, and let what its code raises come out as a `LawError`."""
    interrupts: list[KeyboardInterrupt] = []
    token = _standing.set((dict(callbacks), interrupts))
    try:
        yield
    # What a law raises passes through the loop, which raises nothing itself; a law that leaves the program
    # is no run that ended well.
    except (Exception, SystemExit) as error:
        if isinstance(error, LawError) or is_of_a_signal(error):
            raise
        raise LawError(
            f"The run ended because the law {name} raised {type(error).__name__}: {error}{_place(error)}. "
            "A law must answer to every state of a contact; mend the law."
        ) from error
    finally:
        _standing.reset(token)
    for interrupt in interrupts:
        raise interrupt


def _answer(name: str, signature: Any, given: tuple[Any, ...]) -> Any:
    """Give the numbers that the function behind a name answers; Ctrl-C waits for the end of the loop."""
    functions, interrupts = _standing.get()
    try:
        answer = functions[name](*given)
    except KeyboardInterrupt as error:
        interrupts.append(error)
        answer = functions[name](*given)
    if isinstance(signature.return_type, numba.types.Float):
        return float(answer)
    answer, count = tuple(answer), len(signature.return_type)
    if len(answer) != count:
        raise TypeError(f"it gave {len(answer)} numbers, not {count}")
    return tuple(map(float, answer))


@cache
def stand_in(name: str, signature: Any) -> Any:
    """Give the kernel that asks the function behind a name."""
    names = ", ".join(f"a{i}" for i in range(len(signature.args)))
    source = (
        f"def stand_in({names}):\n"
        "    with objmode(answer=kinds):\n"
        f"        answer = ask(({names}))\n"
        "    return answer\n"
    )
    known: dict[str, Any] = {
        "objmode": numba.objmode,
        "kinds": signature.return_type,
        "ask": partial(_answer, name, signature),
    }
    exec(source, known)
    # It allocates, as no other kernel does.
    kernel: Any = numba.njit(error_model="numpy")(known["stand_in"])
    kernel.compile(signature)
    return kernel


def is_of_a_signal(error: BaseException) -> bool:
    """Tell whether a signal's handler raised it: that time is up on a cluster is no fault of the law's."""
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    codes = [getattr(getattr(h, "__func__", h), "__code__", None) for h in handlers]
    return any(frame.f_code in codes for frame, _ in walk_tb(error.__traceback__))


def _place(error: BaseException) -> str:
    """Say where an exception was raised; nothing for one out of compiled code."""
    frames = [frame for frame in extract_tb(error.__traceback__) if frame.filename != __file__]
    # The loop itself is called from here too.
    if not frames or frames[-1].name == "simulate":
        return ""
    return f" ({frames[-1].filename}, line {frames[-1].lineno})"
