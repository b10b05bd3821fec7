"""A law whose kernel is an ordinary Python function: compiled if that can be done, else interpreted."""

import os
import signal
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from numba import njit

from contactlab.engine import simulate
from contactlab.laws import FRICTION_COEFFICIENT, ContactLaw, LagrangeStick, LawError
from contactlab.laws.base import Kernel, MultiplierLaw, PenaltyLaw
from contactlab.parameter import Parameter
from contactlab.testing.plants import paper_motor
from contactlab.trajectory import Ending, Trajectory

Runs = Callable[..., Trajectory]
SLOPE = 1e7


def plain(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, parameters[1] * normal, -0.4 * normal * gap, 0.0


def interpreted(gap, gap_rate, slip, impact_speed, parameters):
    state: dict[str, Any] = {"depth": max(-gap, 0.0), "text": [f"{gap}"]}
    normal = parameters[0] * state["depth"] ** 1.5
    return normal, parameters[1] * normal, -0.4 * normal * gap, 0.0


def raising(gap):
    if gap < -1e-8:
        raise ValueError("too deep")
    return -1e6 * gap, 0.0, 5e5 * gap * gap, 0.0


def raising_interpreted(gap):
    return {"result": raising(gap)}["result"]


def writing(gap, parameters):
    parameters[0] *= 0.5
    return 0.0, 0.0, 0.0, 0.0


def writing_interpreted(gap, parameters):
    return {"result": writing(gap, parameters)}["result"]


def reading(gap):
    return -SLOPE * gap, 0.0, 0.5 * SLOPE * gap * gap, 0.0


@njit
def slope() -> float:
    return SLOPE


@njit
def calling(gap):
    return -slope() * gap, 0.0, 0.5 * slope() * gap * gap, 0.0


@dataclass(frozen=True)
class Chosen(PenaltyLaw):
    """Hertz by a function of choice."""

    name = "chosen"
    equation = "N = K d^1.5"
    source = "this test"
    default_contact_step = 4e-6
    function: ClassVar[Callable[..., Any]]

    stiffness: Annotated[float, Parameter("K", "N m-1.5", "contact stiffness", above=0.0)] = 1e10
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def force(self) -> Kernel:
        return type(self).function  # type: ignore[return-value]


def run(law: ContactLaw, duration: float = 1e-3, **others: Any) -> Trajectory:
    return simulate(paper_motor(), law, duration=duration, record_interval=1e-3 * duration, **others)


@pytest.fixture
def run_of(monkeypatch: pytest.MonkeyPatch) -> Runs:
    """A run with a law of a function."""

    def with_function(function: Any, **arguments: Any) -> Trajectory:
        monkeypatch.setattr(Chosen, "function", staticmethod(function), raising=False)
        return run(Chosen(), **arguments)

    return with_function


def same(first: Trajectory, second: Trajectory) -> bool:
    return all(np.array_equal(first.series[k], second.series[k], equal_nan=True) for k in first.series)


def test_a_function_runs_compiled_and_interpreted_to_the_same_bits(run_of: Runs) -> None:
    compiled = run_of(plain)
    assert compiled.complete
    assert len(compiled.contacts["start_time"]) > 1
    assert same(run_of(interpreted), compiled)
    eager = njit("UniTuple(f8, 4)(f8, f8, f8, f8, f8[::1])", error_model="numpy")(plain)
    assert same(run_of(eager), compiled)


def test_a_rigid_law_may_be_interpreted_too() -> None:
    inner: Any = LagrangeStick().impact

    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient):
        return (*inner(approach, slip, d_nn, d_nt, d_tt, friction_coefficient),)

    @dataclass(frozen=True)
    class Interpreted(MultiplierLaw):
        name = "interpreted"
        equation = source = "this test"
        default_contact_step = 5e-8
        friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

        @property
        def impact(self) -> Any:
            return impact

    assert same(run(Interpreted()), run(LagrangeStick()))


@pytest.mark.parametrize("function", [raising, raising_interpreted])
def test_an_exception_of_the_law_is_the_cause_of_a_law_error(run_of: Runs, function: Any) -> None:
    with pytest.raises(LawError, match="chosen") as caught:
        run_of(function)
    assert isinstance(caught.value.__cause__, ValueError)


@pytest.mark.parametrize("function", [writing, writing_interpreted])
def test_parameters_cannot_be_written_to(run_of: Runs, function: Any) -> None:
    with pytest.raises(LawError, match="chosen"):
        run_of(function)


def test_ctrl_c_inside_the_law_interrupts_the_run(run_of: Runs) -> None:
    under_way: list[float] = []
    came = []

    # The kernel is evaluated before the run too, where nothing can be lost yet.
    def interrupting(gap, gap_rate, slip, impact_speed, parameters):
        if under_way and gap < -1e-8 and not came:
            came.append(True)
            signal.raise_signal(signal.SIGINT)
        return interpreted(gap, gap_rate, slip, impact_speed, parameters)

    # Another package may have set a handler of its own.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        made = run_of(interrupting, progress=under_way.append)
    finally:
        signal.signal(signal.SIGINT, before)
    assert came
    assert made.ending is Ending.INTERRUPTED
    assert np.isfinite(made.series["normal_force"]).all()


@pytest.mark.parametrize("how", ["compiled", "interpreted"])
def test_an_exception_of_a_signal_handler_passes_through(run_of: Runs, how: str) -> None:
    def handler(*_: object) -> None:
        raise TimeoutError("time is up")

    def signalled(gap, gap_rate, slip, impact_speed, parameters):
        os.kill(os.getpid(), signal.SIGUSR2)
        return interpreted(gap, gap_rate, slip, impact_speed, parameters)

    before = signal.signal(signal.SIGUSR2, handler)
    if how == "compiled":
        # It comes while compiled code runs, and is handled when that has ended.
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGUSR2)).start()
    try:
        with pytest.raises(TimeoutError):
            run_of(plain if how == "compiled" else signalled, duration=100.0)
    finally:
        signal.signal(signal.SIGUSR2, before)


@pytest.mark.parametrize("function", [reading, calling])
def test_a_constant_that_changes_between_runs_counts(
    run_of: Runs, monkeypatch: pytest.MonkeyPatch, function: Any
) -> None:
    peaks = []
    for value in (1e7, 4e7, 1e7):
        monkeypatch.setitem(reading.__globals__, "SLOPE", value)
        peaks.append(float(run_of(function).contacts["peak_normal_force"][0]))
    assert peaks[0] == peaks[2]
    assert 1.5 < peaks[1] / peaks[0] < 2.5


def test_what_a_signal_handler_raises_while_compiled_code_takes_its_arguments_over_is_not_lost(
    run_of: Runs,
) -> None:
    came: list[str] = []

    def handler(*_: object) -> None:
        raise TimeoutError("time is up")

    def on_call(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and "numba" in Path(frame.f_code.co_filename).parts and not came:
            came.append(frame.f_code.co_name)
            signal.raise_signal(signal.SIGUSR2)

    run_of(plain)
    before = signal.signal(signal.SIGUSR2, handler)

    def begun(_time: float) -> None:
        sys.setprofile(on_call)

    try:
        with pytest.raises(TimeoutError):
            run_of(plain, progress=begun)
    finally:
        sys.setprofile(None)
        signal.signal(signal.SIGUSR2, before)
    assert came
