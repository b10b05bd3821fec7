"""A kernel that the Python interpreter runs, because the compiler does not take it.

The loop calls a tiny compiled wrapper by address like any kernel, which leaves the arguments in memory,
calls Python and reads the answer from there, at the cost of speed.
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
from numba.extending import intrinsic

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
        self._given, self._answered = len(signature.args) - 1, len(signature.return_type)
        self._exchange = np.zeros(self._given + self._answered)
        self._parameters: dict[tuple[int, int], Any] = {}
        # Kept here as long as the kernel: it holds their bare addresses.
        self._pointer = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)(self._call)
        self.kernel = self._wrapper(signature)

    def take_failure(self) -> BaseException | None:
        """Give what the function has raised since the last look, if anything."""
        failure, self.failure = self.failure, None
        return failure

    def slowness(self) -> str:
        """Say how long a call takes, in words."""
        # A contact that approaches: every law answers to one.
        self._exchange[: self._given] = [-1e-6, *[1.0] * (self._given - 1)]
        parameters = np.ones(32)
        started = perf_counter()
        for _ in range(CALLS):
            self._pointer(parameters.ctypes.data, parameters.size)
        taken = (perf_counter() - started) / CALLS
        time = "far longer" if self.take_failure() else f"about {float(f'{1e6 * taken:.1g}'):g} us"
        return f"{time}, that of a compiled kernel some ns"

    def _call(self, address: int, size: int) -> None:
        """Answer to the wrapper: an exception must not leave it, there is nobody to take it."""
        if self.failure is None or isinstance(self.failure, KeyboardInterrupt):
            try:
                self._answer(address, size)
                return
            except KeyboardInterrupt as error:
                if self.failure is None:
                    # It waits for the next look, with a sound answer until then.
                    self.failure = error
                    self._call(address, size)
                    return
            except BaseException as error:
                self.failure = error
        # The loop ends at once where nothing is finite.
        self._exchange[self._given :] = np.nan

    def _answer(self, address: int, size: int) -> None:
        """Ask the function and leave its answer in the memory."""
        given = self._given
        view = self._parameters.get((address, size))
        if view is None:
            view = np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))
            view.flags.writeable = False
            self._parameters[address, size] = view
        answer = self.function(*self._exchange[:given].tolist(), view)
        if len(answer) != self._answered:
            raise TypeError(f"it gave {len(answer)} numbers, not {self._answered}")
        self._exchange[given:] = answer

    def _wrapper(self, signature: Any) -> Any:
        """Give the kernel that stands for the function, of as many arguments as the signature has."""
        places = [self._exchange.ctypes.data + 8 * i for i in range(self._exchange.size)]
        names = [f"a{i}" for i in range(self._given)]
        writes = [f"    write({at}, {name})" for at, name in zip(places, names, strict=False)]
        answer = [
            f"as_integer(read({at}))" if kind == types.int64 else f"read({at})"
            for at, kind in zip(places[self._given :], signature.return_type, strict=True)
        ]
        source = [
            f"def wrapper({', '.join(names)}, parameters):",
            *writes,
            "    call(parameters.ctypes.data, parameters.size)",
            f"    return {', '.join(answer)}",
        ]
        known = {"call": self._pointer, "read": read, "write": write, "as_integer": as_integer}
        exec("\n".join(source), known)
        wrapper: Any = fleeting_kernel(known["wrapper"])  # type: ignore[type-var]
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


@intrinsic
def read(typing_context: Any, address: Any) -> Any:
    """The double at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_double(context, builder, arguments[0]))

    return types.float64(types.intp), generate


@intrinsic
def write(typing_context: Any, address: Any, value: Any) -> Any:
    """Put a double to an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[1], _double(context, builder, arguments[0]))
        return context.get_dummy_value()

    return types.void(types.intp, types.float64), generate


def _double(context: Any, builder: Any, address: Any) -> Any:
    return builder.inttoptr(address, context.get_value_type(types.CPointer(types.float64)))
