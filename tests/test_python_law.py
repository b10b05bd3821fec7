"""A law whose kernel is an ordinary Python function: compiled if that can be done, else called back."""

import os
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, final

import numpy as np
import pytest

from contactlab.engine import callback, simulate
from contactlab.laws import HertzPenalty, LagrangeStick, LawError, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import PENALTY_SIGNATURE, PenaltyKernel
from contactlab.laws.parameter import FRICTION_COEFFICIENT, Parameter
from contactlab.motor import Motor
from contactlab.testing.contract.bench import paper_motor
from contactlab.trajectory import Ending, Trajectory

Answer = tuple[float, float, float, float]


def plain(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> Answer:
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, parameters[1] * normal, -0.4 * normal * gap, 0.0


def interpreted(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> Answer:
    state: dict[str, Any] = {"depth": max(-gap, 0.0), "text": [f"{gap}"]}
    normal = parameters[0] * state["depth"] ** 1.5
    return normal, parameters[1] * normal, -0.4 * normal * gap, 0.0


@final
@dataclass(frozen=True)
class Chosen(PenaltyLaw):
    """Hertz by whatever function."""

    name: ClassVar[str] = "chosen"
    equation: ClassVar[str] = "N = K d^1.5"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6
    function: ClassVar[Callable[..., Any]]

    stiffness: Annotated[float, Parameter("K", "N m-1.5", "contact stiffness", above=0.0)] = 1e10
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def force(self) -> PenaltyKernel:
        return type(self).function  # type: ignore[return-value]


@pytest.fixture(scope="module")
def motor() -> Motor:
    return paper_motor()


def run(motor: Motor, law: PenaltyLaw | MultiplierLaw) -> Trajectory:
    return simulate(motor, law, duration=1e-3, record_interval=1e-6)


def chosen(monkeypatch: pytest.MonkeyPatch, function: Callable[..., Any]) -> Chosen:
    monkeypatch.setattr(Chosen, "function", staticmethod(function), raising=False)
    return Chosen()


def same(first: Trajectory, second: Trajectory) -> bool:
    return all(
        np.array_equal(first.series[k], second.series[k], equal_nan=True) for k in first.series
    )


def test_a_plain_function_is_compiled_without_a_word(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run(motor, HertzPenalty())
    capsys.readouterr()
    found = run(motor, chosen(monkeypatch, plain))
    assert found.complete
    assert len(found.contacts["start_time"]) > 1
    assert capsys.readouterr().err == ""


def test_what_cannot_be_compiled_runs_the_same_and_says_once_how_slowly(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    callback.compiled.cache_clear()
    compiled = run(motor, chosen(monkeypatch, plain))
    capsys.readouterr()
    found = run(motor, chosen(monkeypatch, interpreted))
    warning = capsys.readouterr().err
    assert warning.startswith("contactlab: interpreted cannot be compiled (")
    assert "the Python interpreter runs it: a call takes about " in warning
    assert same(found, compiled)
    assert same(run(motor, chosen(monkeypatch, interpreted)), found)
    assert capsys.readouterr().err == ""


def test_a_rigid_law_may_be_interpreted_too(motor: Motor, monkeypatch: pytest.MonkeyPatch) -> None:
    inner: Any = LagrangeStick().solve

    def solve(*arguments: Any) -> Any:
        return (*inner(*arguments),)

    @final
    @dataclass(frozen=True)
    class Interpreted(MultiplierLaw):
        name: ClassVar[str] = "interpreted"
        equation: ClassVar[str] = source
        source: ClassVar[str] = source
        default_contact_step: ClassVar[float] = 5e-8
        friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

        @property
        def solve(self) -> Any:
            return solve

    assert same(run(motor, Interpreted()), run(motor, LagrangeStick()))


source = "this test"


@pytest.mark.parametrize("how", ["interpreted", "compiled"])
def test_an_exception_of_the_law_ends_the_run_with_a_sentence(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    def raising(
        gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
    ) -> Answer:
        if gap < -1e-8:
            raise ValueError("too deep")
        return -1e6 * gap, 0.0, 5e5 * gap * gap, 0.0

    def also(*arguments: Any) -> Any:
        return raising(*arguments)

    function = raising if how == "compiled" else also
    with pytest.raises(LawError, match="the law chosen raised ValueError: too deep") as caught:
        run(motor, chosen(monkeypatch, function))
    assert isinstance(caught.value.__cause__, ValueError)
    if how == "interpreted":
        assert Path(__file__).name in str(caught.value)


def test_an_answer_of_the_wrong_length_is_told(
    motor: Motor, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(LawError, match="it gave 2 numbers, not 4"):
        run(motor, chosen(monkeypatch, lambda *_: (1.0, 0.0)))


def test_ctrl_c_inside_the_law_interrupts_the_run(
    motor: Motor, monkeypatch: pytest.MonkeyPatch
) -> None:
    came = []

    def interrupting(*arguments: Any) -> Any:
        if arguments[0] < -1e-8 and not came:
            came.append(True)
            raise KeyboardInterrupt
        return interpreted(*arguments)

    callback.compiled(interrupting, PENALTY_SIGNATURE)
    came.clear()
    found = run(motor, chosen(monkeypatch, interrupting))
    assert came
    assert found.ending is Ending.INTERRUPTED
    assert np.isfinite(found.series["normal_force"]).all()


@pytest.mark.parametrize("how", ["compiled", "interpreted"])
def test_what_the_handler_of_a_signal_raises_is_none_of_the_laws(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    def handler(*_: object) -> None:
        raise TimeoutError("time is up")

    def signalled(*arguments: Any) -> Any:
        os.kill(os.getpid(), signal.SIGUSR2)
        return interpreted(*arguments)

    before = signal.signal(signal.SIGUSR2, handler)
    law = chosen(monkeypatch, plain if how == "compiled" else signalled)
    if how == "compiled":
        # It comes while compiled code runs, and is handled when that has ended.
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGUSR2)).start()
    try:
        with pytest.raises(TimeoutError, match="time is up"):
            simulate(motor, law, duration=100.0, record_interval=1.0)
    finally:
        signal.signal(signal.SIGUSR2, before)


def test_the_law_that_readme_writes_in_a_script_runs(motor: Motor, tmp_path: Path) -> None:
    readme = Path(__file__).resolve().parents[1] / "README.md"
    (code,) = [
        block.partition("```")[0]
        for block in readme.read_text(encoding="utf-8").split("```python\n")
        if "class Spring(PenaltyLaw)" in block.partition("```")[0]
    ]
    names: dict[str, Any] = {"__name__": "script"}
    exec(code, names)
    found = run(motor, names["Spring"](2e7))
    assert found.complete
    assert len(found.contacts["start_time"]) > 1
