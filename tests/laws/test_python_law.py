"""A law whose kernel is an ordinary Python function: compiled if that can be done, else called back."""

import os
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from numba import njit

from contactlab.engine import binding, simulate
from contactlab.laws import FRICTION_COEFFICIENT, ContactLaw, HertzPenalty, LagrangeStick, LawError
from contactlab.laws.base import Kernel, MultiplierLaw, PenaltyLaw
from contactlab.motor.motor import Motor
from contactlab.parameter import Parameter
from contactlab.testing.plants import paper_motor
from contactlab.trajectory import Ending, Trajectory

Told = pytest.CaptureFixture[str]
Runs = Callable[..., Trajectory]


def plain(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, parameters[1] * normal, -0.4 * normal * gap, 0.0


def interpreted(gap, gap_rate, slip, impact_speed, parameters):
    state: dict[str, Any] = {"depth": max(-gap, 0.0), "text": [f"{gap}"]}
    normal = parameters[0] * state["depth"] ** 1.5
    return normal, parameters[1] * normal, -0.4 * normal * gap, 0.0


@dataclass(frozen=True)
class Chosen(PenaltyLaw):
    """Hertz by whatever function."""

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


@pytest.fixture(scope="module")
def motor() -> Motor:
    return paper_motor()


def run(motor: Motor, law: ContactLaw, duration: float = 1e-3, **others: Any) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=1e-3 * duration, **others)


@pytest.fixture
def run_of(motor: Motor, monkeypatch: pytest.MonkeyPatch) -> Runs:
    """A run with a law of a function."""

    def with_function(function: Any, **arguments: Any) -> Trajectory:
        monkeypatch.setattr(Chosen, "function", staticmethod(function), raising=False)
        return run(motor, Chosen(), **arguments)

    return with_function


def forget() -> None:
    """Forget what was compiled and said, as a new process would."""
    binding._made.cache_clear()
    binding._say_once.cache_clear()
    binding._made_from.clear()


def same(first: Trajectory, second: Trajectory) -> bool:
    return all(np.array_equal(first.series[k], second.series[k], equal_nan=True) for k in first.series)


def test_a_plain_function_is_compiled_without_a_word(run_of: Runs, motor: Motor, capsys: Told) -> None:
    run(motor, HertzPenalty())
    capsys.readouterr()
    found = run_of(plain)
    assert found.complete
    assert len(found.contacts["start_time"]) > 1
    assert capsys.readouterr().err == ""


def test_what_cannot_be_compiled_runs_the_same_and_says_once_how_slowly(run_of: Runs, capsys: Told) -> None:
    forget()
    compiled = run_of(plain)
    capsys.readouterr()
    found = run_of(interpreted)
    warning = capsys.readouterr().err
    assert "interpreted" in warning
    assert same(found, compiled)
    assert same(run_of(interpreted), found)
    assert capsys.readouterr().err == ""


def test_a_rigid_law_may_be_interpreted_too(motor: Motor) -> None:
    inner: Any = LagrangeStick().solve

    def solve(normal_rate, tangential_rate, slip, d_nn, d_nt, d_tt, friction_coefficient):
        return (*inner(normal_rate, tangential_rate, slip, d_nn, d_nt, d_tt, friction_coefficient),)

    @dataclass(frozen=True)
    class Interpreted(MultiplierLaw):
        name = "interpreted"
        equation = source = "this test"
        default_contact_step = 5e-8
        friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

        @property
        def solve(self) -> Any:
            return solve

    assert same(run(motor, Interpreted()), run(motor, LagrangeStick()))


@pytest.mark.parametrize("how", ["interpreted", "compiled"])
def test_an_exception_of_the_law_ends_the_run_with_a_sentence(run_of: Runs, how: str) -> None:
    def raising(gap, gap_rate, slip, impact_speed, parameters):
        if gap < -1e-8:
            raise ValueError("too deep")
        return -1e6 * gap, 0.0, 5e5 * gap * gap, 0.0

    def also(gap, gap_rate, slip, impact_speed, parameters):
        state = {"answer": raising(gap, gap_rate, slip, impact_speed, parameters)}
        return state["answer"]

    function = raising if how == "compiled" else also
    with pytest.raises(LawError, match="the law chosen raised ValueError: too deep") as caught:
        run_of(function)
    assert isinstance(caught.value.__cause__, ValueError)
    if how == "interpreted":
        assert Path(__file__).name in str(caught.value)


def test_ctrl_c_inside_the_law_interrupts_the_run(run_of: Runs) -> None:
    under_way: list[float] = []
    came = []

    # The law is asked before the run too, where there is nothing to lose yet.
    def interrupting(gap, gap_rate, slip, impact_speed, parameters):
        if under_way and gap < -1e-8 and not came:
            came.append(True)
            raise KeyboardInterrupt
        return interpreted(gap, gap_rate, slip, impact_speed, parameters)

    found = run_of(interrupting, progress=under_way.append)
    assert came
    assert found.ending is Ending.INTERRUPTED
    assert np.isfinite(found.series["normal_force"]).all()


@pytest.mark.parametrize("how", ["compiled", "interpreted"])
def test_what_the_handler_of_a_signal_raises_is_none_of_the_laws(run_of: Runs, how: str) -> None:
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
        with pytest.raises(TimeoutError, match="time is up"):
            run_of(plain if how == "compiled" else signalled, duration=100.0)
    finally:
        signal.signal(signal.SIGUSR2, before)


def interpreted_around(held: object) -> Callable[..., Any]:
    def around(gap, gap_rate, slip, impact_speed, parameters):
        found = interpreted(gap, gap_rate, slip, impact_speed, parameters)
        return (*found[:3], float(len(f"{held}") * 0))

    return around


def compiled_around(stiffness: float) -> Callable[..., Any]:
    def around(gap, gap_rate, slip, impact_speed, parameters):
        return -stiffness * gap, 0.0, 0.5 * stiffness * gap * gap, 0.0

    return around


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of what is compiled for laws, from now on."""
    forget()
    names: list[str] = []

    def compiling(kernel: Any, signature: Any) -> None:
        names.append(kernel.py_func.__name__)
        compile_it(kernel, signature)

    compile_it = binding._compile
    monkeypatch.setattr(binding, "_compile", compiling)
    return names


@pytest.mark.parametrize("made", [compiled_around, interpreted_around])
def test_a_kernel_that_is_made_anew_every_time_is_compiled_once(
    motor: Motor, compilations: list[str], made: Any
) -> None:
    @dataclass(frozen=True)
    class Anew(Chosen):
        @property
        def force(self) -> Any:
            return made(2e7)

    law = Anew()
    first = run(motor, law)
    assert same(run(motor, law), first)
    assert same(run(motor, Anew()), first)
    assert compilations.count("around") == 1


SLOPE = 1e7


def reading(gap, gap_rate, slip, impact_speed, parameters):
    return -SLOPE * gap, 0.0, 0.5 * SLOPE * gap * gap, 0.0


@njit
def slope() -> float:
    return SLOPE


@njit
def asking(gap, gap_rate, slip, impact_speed, parameters):
    return -slope() * gap, 0.0, 0.5 * slope() * gap * gap, 0.0


@pytest.mark.parametrize("function", [reading, asking])
def test_a_constant_that_is_changed_while_the_program_runs_counts(
    run_of: Runs, monkeypatch: pytest.MonkeyPatch, function: Any
) -> None:
    peaks = []
    for value in (1e7, 4e7, 1e7):
        monkeypatch.setitem(reading.__globals__, "SLOPE", value)
        peaks.append(float(run_of(function).contacts["peak_normal_force"][0]))
    assert peaks[0] == peaks[2]
    assert 1.5 < peaks[1] / peaks[0] < 2.5


def test_a_kernel_with_signatures_of_its_own_is_compiled_for_the_engine(run_of: Runs, capsys: Told) -> None:
    run_of(plain)
    capsys.readouterr()
    eager = njit("UniTuple(f8, 4)(f8, f8, f8, f8, f8[::1])", error_model="numpy")(plain)
    found = run_of(eager)
    assert capsys.readouterr().err == ""
    assert same(found, run_of(plain))


def writing(gap, gap_rate, slip, impact_speed, parameters):
    if gap < -1e-8:
        parameters[0] *= 0.5
    return plain(gap, gap_rate, slip, impact_speed, parameters)


@pytest.mark.parametrize("how", ["compiled", "interpreted"])
def test_parameters_cannot_be_written_to(run_of: Runs, capsys: Told, how: str) -> None:
    helped = njit(plain)

    def also(gap, gap_rate, slip, impact_speed, parameters):
        part = parameters[:1]
        part[0] = 1.0
        return helped(gap, gap_rate, slip, impact_speed, parameters)  # type: ignore[no-any-return]

    with pytest.raises(LawError, match="assignment destination is read-only"):
        run_of(also if how == "compiled" else writing)
