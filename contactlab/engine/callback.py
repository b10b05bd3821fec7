"""A kernel that the Python interpreter runs, because the compiler does not take it.

The loop calls a tiny compiled stand-in by address like any kernel, one for each signature. It asks the
function that stands behind it at the time, and reads the numbers of its answer, at the cost of speed.
"""

import ctypes
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, lru_cache
from math import nan
from traceback import extract_tb, walk_tb
from typing import Any, final

import numpy as np
from numba import types

from contactlab.arrays import Array
from contactlab.compiled import fleeting_kernel
from contactlab.laws.declaration import LawError


@final
class Callback:
    """A Python function that compiled code calls, for the time of a `law_errors`.

    Args:
        function: takes numbers and the array of parameters, gives a tuple of numbers.
        signature: of the kernel that it is in place of.
    """

    def __init__(self, function: Callable[..., Any], signature: Any) -> None:
        self.function, self.signature = function, signature
        self.failure: BaseException | None = None
        self._kinds = [int if kind == types.int64 else float for kind in signature.return_type]
        # The loop ends at once where nothing is finite.
        self._nothing = tuple(-1 if kind is int else nan for kind in self._kinds)
        self.answer: tuple[float, ...] = self._nothing

    def call(self, *given: Any) -> None:
        """Answer to the stand-in: an exception must not leave it, there is nobody to take it."""
        if self.failure is None or isinstance(self.failure, KeyboardInterrupt):
            try:
                self.answer = self._asked(*given)
                return
            except KeyboardInterrupt as error:
                if self.failure is None:
                    # It waits until the loop has ended, with a sound answer until then.
                    self.failure = error
                    self.call(*given)
                    return
            except BaseException as error:
                self.failure = error
        self.answer = self._nothing

    def _asked(self, *given: Any) -> tuple[float, ...]:
        """Give the function's answer to a state and the parameters at an address."""
        *state, address, size = given
        answer = tuple(self.function(*state, _parameters_at(address, size)))
        if len(answer) != len(self._kinds):
            raise TypeError(f"it gave {len(answer)} numbers, not {len(self._kinds)}")
        return tuple(kind(x) for kind, x in zip(self._kinds, answer, strict=True))


_standing: ContextVar[dict[Any, Callback]] = ContextVar("_standing")
"""The functions behind the stand-ins, by signature."""


@contextmanager
def law_errors(name: str, *callbacks: Callback) -> Iterator[None]:
    """Let functions answer for a law, and let what its code raises come out as a `LawError`.

    Raises:
        LawError: with a sentence; its cause is the law's own exception.
        KeyboardInterrupt: it came while an interpreted function ran.
    """
    token = _standing.set({callback.signature: callback for callback in callbacks})
    passed: BaseException | None = None
    try:
        yield
    # A compiled function's exception passes through the loop, which raises none itself.
    except (Exception, SystemExit) as error:
        passed = error
    finally:
        _standing.reset(token)
    failures = [callback.failure for callback in callbacks]
    for callback in callbacks:
        callback.failure = None
    for failure in (*failures, passed):
        # A law that leaves the program is no run that ended well.
        if (
            isinstance(failure, Exception | SystemExit)
            and not isinstance(failure, LawError)
            and not is_of_a_signal(failure)
        ):
            raise LawError(
                f"The run ended because the law {name} raised {type(failure).__name__}: {failure}"
                f"{_place(failure)}. A law must answer to every state of a contact; mend the law."
            ) from failure
        if failure is not None:
            raise failure


@cache
def stand_in(signature: Any) -> Any:
    """Give the kernel that asks the function behind a signature."""
    count = len(signature.args) - 1
    arguments: Any = *[ctypes.c_double] * count, ctypes.c_int64, ctypes.c_int64
    names = ", ".join(f"a{i}" for i in range(count))
    answer = [
        f"int(read({i}))" if kind == types.int64 else f"read({i})"
        for i, kind in enumerate(signature.return_type)
    ]
    known: dict[str, Any] = {
        "ask": ctypes.CFUNCTYPE(None, *arguments)(
            lambda *given: _standing.get()[signature].call(*given)
        ),
        "read": ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(
            lambda i: _standing.get()[signature].answer[i]
        ),
    }
    source = (
        f"def stand_in({names}, parameters):\n"
        f"    ask({names}, parameters.ctypes.data, parameters.size)\n"
        f"    return {', '.join(answer)}\n"
    )
    exec(source, known)
    kernel: Any = fleeting_kernel(known["stand_in"])
    kernel.compile(signature)
    return kernel


def is_of_a_signal(error: BaseException) -> bool:
    """Tell whether a signal's handler raised it: that time is up on a cluster is no fault of the law's."""
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    codes = [getattr(getattr(h, "__func__", h), "__code__", None) for h in handlers]
    return any(frame.f_code in codes for frame, _ in walk_tb(error.__traceback__))


@lru_cache(maxsize=16)
def _parameters_at(address: int, size: int) -> Array:
    """Give a law's parameters, which cannot be written to."""
    view: Array = np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))
    view.flags.writeable = False
    return view


def _place(error: BaseException) -> str:
    """Say where an exception was raised; nothing for one out of compiled code."""
    frames = [frame for frame in extract_tb(error.__traceback__) if frame.filename != __file__]
    # The loop itself is called from here too.
    if not frames or frames[-1].name == "simulate":
        return ""
    return f" ({frames[-1].filename}, line {frames[-1].lineno})"
