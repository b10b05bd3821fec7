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
"""Calls that the slow-down is measured over."""


@contextmanager
def law_errors(name: str, callbacks: list["Callback"]) -> Iterator[None]:
    """Around compiled code that calls a law: what the law raises comes out as a `LawError`.

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
        self._signature = signature
        self._given = len(signature.args) - 1
        self._answered = len(signature.return_type)
        self._memory = np.zeros(self._given + self._answered)
        self._parameters: dict[tuple[int, int], Any] = {}
        # Kept here as long as the kernel: it holds their bare addresses.
        self._pointer = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)(self._call)
        self.kernel = self._wrapper()
        self.kernel.compile(signature)

    def take_failure(self) -> BaseException | None:
        """What the function has raised since the last look, if anything."""
        failure, self.failure = self.failure, None
        return failure

    def slow_down(self) -> str:
        """How much longer a call takes than that of a compiled kernel, in words."""
        compiled_answer = ", ".join("0" if t == types.int64 else "0.0" for t in self._returns)
        idle = _function(f"def idle({self._names}):\n    return {compiled_answer}\n", {})
        idle = fleeting_kernel(idle)
        idle.compile(self._signature)
        times = [self._time(kernel) for kernel in (idle, self.kernel)]
        if self.take_failure() is not None:
            return "far longer"
        return f"about {float(f'{times[1] / times[0]:.1g}'):g} times as long"

    @property
    def _returns(self) -> list[Any]:
        return list(self._signature.return_type)

    @property
    def _names(self) -> str:
        return ", ".join([*(f"a{i}" for i in range(self._given)), "parameters"])

    def _call(self, address: int, size: int) -> None:
        """What the wrapper calls: an exception must not leave it, there is nobody to take it."""
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
        self._memory[self._given :] = np.nan

    def _answer(self, address: int, size: int) -> None:
        """Ask the function and leave its answer in the memory."""
        memory, given = self._memory, self._given
        answer = self.function(*memory[:given].tolist(), self._view(address, size))
        if len(answer) != self._answered:
            raise TypeError(f"it gave {len(answer)} numbers, not {self._answered}")
        memory[given:] = answer

    def _view(self, address: int, size: int) -> Any:
        """The law's parameters at an address, as an array."""
        view = self._parameters.get((address, size))
        if view is None:
            numbers = (ctypes.c_double * size).from_address(address)
            view = self._parameters[address, size] = np.ctypeslib.as_array(numbers)
            view.flags.writeable = False
        return view

    def _wrapper(self) -> Any:
        """The kernel that stands for the function."""
        places = [self._memory.ctypes.data + 8 * i for i in range(self._memory.size)]
        names = self._names.split(", ")[:-1]
        given, answered = places[: self._given], places[self._given :]
        lines = [f"    write({at}, {name})" for at, name in zip(given, names, strict=True)]
        answer = [
            f"as_integer(read({at}))" if t == types.int64 else f"read({at})"
            for at, t in zip(answered, self._returns, strict=True)
        ]
        source = [
            f"def wrapper({self._names}):",
            *lines,
            "    call(parameters.ctypes.data, parameters.size)",
            f"    return {', '.join(answer)}",
        ]
        names_of = {"call": self._pointer, "read": read, "write": write, "as_integer": as_integer}
        return fleeting_kernel(_function("\n".join(source), names_of))

    def _time(self, kernel: Any) -> float:
        """Time of some calls from compiled code [s]."""
        source = (
            f"def repeat(kernel, {self._names}, count):\n    total = 0.0\n    for _ in range(count):\n"
            f"        total += kernel({self._names})[0]\n    return total\n"
        )
        repeat: Any = fleeting_kernel(_function(source, {}))
        repeat.compile((types.FunctionType(self._signature), *self._signature.args, types.int64))
        # A contact that approaches: every law answers to one.
        state = [-1e-6, *[1.0] * (self._given - 1)]
        parameters = np.ones(32)
        parameters.flags.writeable = False
        arguments = (kernel, *state, parameters, CALLS)
        repeat(*arguments)
        started = perf_counter()
        repeat(*arguments)
        return perf_counter() - started


def is_of_a_signal(error: BaseException) -> bool:
    """Whether the handler of a signal raised it: that time is up on a cluster is no fault of the law's."""
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    codes = [getattr(getattr(h, "__func__", h), "__code__", None) for h in handlers]
    return any(frame.f_code in codes for frame, _ in walk_tb(error.__traceback__))


def _place(error: BaseException) -> str:
    """Where an exception was raised, in words; nothing for one out of compiled code."""
    frames = [frame for frame in extract_tb(error.__traceback__) if frame.filename != __file__]
    # The loop itself is called from here too.
    if not frames or frames[-1].name == "simulate":
        return ""
    return f" ({frames[-1].filename}, line {frames[-1].lineno})"


def _function(source: str, names: dict[str, Any]) -> Any:
    """A function from its text: the compiler wants as many arguments as the signature has."""
    exec(source, names)
    return names[source[4 : source.index("(")]]


@fleeting_kernel
def as_integer(value: float) -> int:
    """A mode that Python gave, -1 where it gave none."""
    return int(value) if value == value else -1


@intrinsic
def read(typing_context: Any, address: Any) -> Any:
    """The double at an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_pointer(context, builder, arguments[0]))

    return types.float64(types.intp), generate


@intrinsic
def write(typing_context: Any, address: Any, value: Any) -> Any:
    """Put a double to an address."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[1], _pointer(context, builder, arguments[0]))
        return context.get_dummy_value()

    return types.void(types.intp, types.float64), generate


def _pointer(context: Any, builder: Any, address: Any) -> Any:
    return builder.inttoptr(address, context.get_value_type(types.CPointer(types.float64)))
