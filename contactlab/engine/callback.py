"""A kernel that the Python interpreter runs, because the compiler does not take it.

The loop calls a tiny compiled wrapper by address like any kernel, which calls Python with the state and
again for each number of the answer, at the cost of speed.
"""

import ctypes
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from traceback import extract_tb, walk_tb
from typing import Any, final

import numpy as np
from numba import types

from contactlab.compiled import fleeting_kernel
from contactlab.laws.declaration import LawError

CALLS = 300
"""Calls that the time of one is measured over."""


@contextmanager
def law_errors(name: str, callbacks: list["Callback"]) -> Iterator[None]:
    """Let what a law raises come out of compiled code that calls it as a `LawError`.

    Raises:
        LawError: with a sentence; its cause is the law's own exception.
        KeyboardInterrupt: it came while an interpreted function ran.
    """
    failure: BaseException | None = None
    try:
        yield
    # A compiled function's exception passes through the loop, which raises none itself.
    except Exception as error:
        failure = error
    found = [failure, *(callback.take_failure() for callback in callbacks)]
    for failure in found:
        # A law that leaves the program is no run that ended well.
        if isinstance(failure, Exception | SystemExit) and not is_of_a_signal(failure):
            raise LawError(
                f"The run ended because the law {name} raised {type(failure).__name__}: {failure}"
                f"{_place(failure)}. A law must answer to every state of a contact; mend the law."
            ) from failure
        if failure is not None:
            raise failure


@final
class Callback:
    """A Python function that compiled code calls.

    Args:
        function: takes numbers and the array of parameters, gives a tuple of numbers.
        signature: of the kernel that stands for it.
    """

    def __init__(self, function: Callable[..., Any], signature: Any) -> None:
        self.name = getattr(function, "__qualname__", None) or type(function).__qualname__
        self.failure: BaseException | None = None
        self.function = function
        self._answer = (np.nan,) * len(signature.return_type)
        self._parameters: dict[tuple[int, int], Any] = {}
        numbers = [ctypes.c_double] * (len(signature.args) - 1)
        # Kept here as long as the kernel: it holds their bare addresses.
        self._ask = ctypes.CFUNCTYPE(None, *numbers, ctypes.c_int64, ctypes.c_int64)(self._call)
        self._read = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(lambda i: self._answer[i])
        self.kernel = self._wrapper(signature)

    def take_failure(self) -> BaseException | None:
        """Give what the function has raised since the last look, if anything."""
        failure, self.failure = self.failure, None
        return failure

    def slowness(self) -> str:
        """Say how long a call takes, in words."""
        # A contact that approaches: every law answers to one.
        state = -1e-6, *[1.0] * (len(self._ask.argtypes) - 3)
        parameters = np.ones(32)
        started = perf_counter()
        for _ in range(CALLS):
            self._ask(*state, parameters.ctypes.data, parameters.size)
        taken = (perf_counter() - started) / CALLS
        time = "far longer" if self.take_failure() else f"about {float(f'{1e6 * taken:.1g}'):g} us"
        return f"{time}, that of a compiled kernel some ns"

    def _call(self, *given: Any) -> None:
        """Answer to the wrapper: an exception must not leave it, there is nobody to take it."""
        if self.failure is None or isinstance(self.failure, KeyboardInterrupt):
            try:
                self._answer = self._asked(*given)
                return
            except KeyboardInterrupt as error:
                if self.failure is None:
                    # It waits for the next look, with a sound answer until then.
                    self.failure = error
                    self._call(*given)
                    return
            except BaseException as error:
                self.failure = error
        # The loop ends at once where nothing is finite.
        self._answer = (np.nan,) * len(self._answer)

    def _asked(self, *given: Any) -> tuple[float, ...]:
        """Give the function's answer to a state and the parameters at an address."""
        *state, address, size = given
        view = self._parameters.get((address, size))
        if view is None:
            view = np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))
            view.flags.writeable = False
            self._parameters[address, size] = view
        answer = tuple(map(float, self.function(*state, view)))
        if len(answer) != len(self._answer):
            raise TypeError(f"it gave {len(answer)} numbers, not {len(self._answer)}")
        return answer

    def _wrapper(self, signature: Any) -> Any:
        """Give the kernel that stands for the function, of as many arguments as the signature has."""
        names = ", ".join(f"a{i}" for i in range(len(signature.args) - 1))
        answer = [
            f"as_integer(read({i}))" if kind == types.int64 else f"read({i})"
            for i, kind in enumerate(signature.return_type)
        ]
        source = (
            f"def wrapper({names}, parameters):\n"
            f"    ask({names}, parameters.ctypes.data, parameters.size)\n"
            f"    return {', '.join(answer)}\n"
        )
        known: dict[str, Any] = {"ask": self._ask, "read": self._read, "as_integer": as_integer}
        exec(source, known)
        wrapper: Any = fleeting_kernel(known["wrapper"])
        wrapper.compile(signature)
        return wrapper


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


@fleeting_kernel
def as_integer(value: float) -> int:
    """A mode that Python gave, -1 where it gave none."""
    return int(value) if value == value else -1
