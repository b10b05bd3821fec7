"""A law whose kernel is an ordinary Python function: compiled if that can be done, else called back."""

import linecache
import os
import signal
import threading
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, final

import numpy as np
import pytest
from numba import njit
from scipy import special  # noqa: F401

from contactlab.compiled import fleeting_kernel
from contactlab.engine import law_kernels, obstacle, simulate
from contactlab.laws import HertzPenalty, LagrangeStick, LawError, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import PENALTY_SIGNATURE, PenaltyKernel
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.motor.motor import Motor
from contactlab.parameter import Parameter
from contactlab.testing.plants import paper_motor
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
    law_kernels.forget()
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

    law_kernels.compiled(interrupting, PENALTY_SIGNATURE)
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
    readme = Path(__file__).resolve().parents[2] / "README.md"
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


def interpreted_around(held: object) -> Callable[..., Any]:
    def around(*arguments: Any) -> Any:
        return (*interpreted(*arguments)[:3], float(len(f"{held}") * 0))

    return around


def compiled_around(stiffness: float) -> Callable[..., Any]:
    def around(
        gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
    ) -> Answer:
        return -stiffness * gap, 0.0, 0.5 * stiffness * gap * gap, 0.0

    return around


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of what is compiled for laws, from now on."""
    law_kernels.forget()
    names: list[str] = []

    def compiling(kernel: Any, signature: Any) -> None:
        names.append(kernel.py_func.__name__)
        compile_it(kernel, signature)

    compile_it = law_kernels._compile
    monkeypatch.setattr(law_kernels, "_compile", compiling)
    return names


@pytest.mark.parametrize("made", [compiled_around, interpreted_around])
def test_a_kernel_that_is_made_anew_every_time_is_compiled_once(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, compilations: list[str], made: Any
) -> None:
    @final
    @dataclass(frozen=True)
    class Anew(Chosen):  # type: ignore[misc]
        @property
        def force(self) -> Any:
            return made(2e7)

    law = Anew()
    first = run(motor, law)
    once = list(compilations)
    assert once.count("around") == 1 + (made is interpreted_around)
    assert same(run(motor, law), first)
    assert same(run(motor, Anew()), first)
    assert compilations == once


def test_a_kernel_that_is_made_around_ever_other_values_is_told_once(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    law_kernels.forget()
    for number in range(law_kernels.OFTEN + 1):
        law_kernels.compiled(compiled_around(1e7 + number), PENALTY_SIGNATURE)
    (line,) = capsys.readouterr().err.splitlines()
    assert "has been compiled 8 times" in line
    assert "let it read what varies from the law's parameters" in line


SLOPE = 1e7


def reading(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> Answer:
    return -SLOPE * gap, 0.0, 0.5 * SLOPE * gap * gap, 0.0


@njit
def slope() -> float:
    return SLOPE


@njit
def asking(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> Answer:
    return -slope() * gap, 0.0, 0.5 * slope() * gap * gap, 0.0


@pytest.mark.parametrize("function", [reading, asking])
def test_a_constant_that_is_changed_while_the_program_runs_counts(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, function: Any
) -> None:
    law = chosen(monkeypatch, function)
    peaks = []
    for value in (1e7, 4e7, 1e7):
        monkeypatch.setitem(reading.__globals__, "SLOPE", value)
        peaks.append(float(run(motor, law).contacts["peak_normal_force"][0]))
    assert peaks[0] == peaks[2]
    assert 1.5 < peaks[1] / peaks[0] < 2.5


def test_a_kernel_with_signatures_of_its_own_is_compiled_for_the_engine(
    motor: Motor, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run(motor, chosen(monkeypatch, plain))
    capsys.readouterr()
    eager = njit("UniTuple(f8, 4)(f8, f8, f8, f8, f8[::1])", error_model="numpy")(plain)
    found = run(motor, chosen(monkeypatch, eager))
    assert capsys.readouterr().err == ""
    assert same(found, run(motor, chosen(monkeypatch, plain)))


def writing(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> Answer:
    if gap < -1e-8:
        parameters[0] *= 0.5
    return plain(gap, gap_rate, slip, approach, parameters)


def test_parameters_cannot_be_written_to(motor: Motor, monkeypatch: pytest.MonkeyPatch) -> None:
    helped = njit(plain)

    def also(
        gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
    ) -> Answer:
        part = parameters[:1]
        part[0] = 1.0
        return helped(gap, gap_rate, slip, approach, parameters)  # type: ignore[no-any-return]

    with pytest.raises(
        LawError, match=r"also writes to the law's parameters \(.*`part\[0\] = 1.0`"
    ):
        run(motor, chosen(monkeypatch, also))
    # What is interpreted is seen when it comes to it.
    with pytest.raises(LawError, match="assignment destination is read-only"):
        run(motor, chosen(monkeypatch, writing))


class Thing:
    factor = 2.0

    def force(self, *arguments: float) -> Answer:
        return plain(*arguments)  # type: ignore[arg-type]


THING, WORDS = Thing(), {"a": 1.0}


def undecorated(gap: float) -> float:
    return 2.0 * gap


@njit
def lost(gap: float) -> float:
    return gap + nowhere  # type: ignore[name-defined]  # noqa: F821


def body(text: str) -> Callable[..., Any]:
    """A kernel with these lines."""
    lines = "\n".join(f"    {line}" for line in text.splitlines())
    source = f"def kernel(gap, gap_rate, slip, approach, parameters):\n{lines}\n"
    name = f"<kernel {len(linecache.cache)}>"
    linecache.cache[name] = (len(source), None, source.splitlines(True), name)
    exec(compile(source, name, "exec"), names := dict(globals()))
    return names["kernel"]  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("n = 1.0\nreturn n, missing, 0.0, 0.0", "line 3, `{}`: name 'missing' is not defined"),
        ("n = lost(gap)\nreturn n, 0.0, 0.0, 0.0", "name 'nowhere' is not defined"),
        (
            "n = undecorated(gap)",
            "line 2, `{}`: undecorated is a Python function; decorate it with",
        ),
        ("return special.ellipk(gap), 0.0, 0.0, 0.0", "scipy.special.ellipk has no compiled form"),
        ("return gap, 0.0", "line 2, `{}`: it gives 2 numbers and not 4 numbers"),
        ("return gap", "line 2, `{}`: it gives 1 number and not 4 numbers"),
        ("n = gap", "it gives nothing where it ends and not 4 numbers"),
        ("return gap, 0.0, 'x', 0.0", "it gives (float, float, text, float) and not 4 numbers"),
        ("return (gap + 1j), 0.0, 0.0, 0.0", "it gives (complex, float, float, float) and not 4"),
        ("return THING.factor, 0.0, 0.0, 0.0", "THING is a Python object (Thing), where only"),
        ("return WORDS['a'], 0.0, 0.0, 0.0", "WORDS is a Python object (dict), where only"),
        ("n = {'a': gap}\nreturn n['a'], 0.0, 0.0, 0.0", obstacle.ALLOCATES),
        ("n = [f'{gap}']\nreturn gap * len(n), 0.0, 0.0, 0.0", obstacle.ALLOCATES),
        (
            "n = np.zeros(3)\nreturn n[0], 0.0, 0.0, 0.0",
            f"line 2, `n = np.zeros(3)`: {obstacle.ALLOCATES}",
        ),
        (
            "parameters[0] = 2.0\nreturn gap, 0.0, 0.0, 0.0",
            "`parameters[0] = 2.0`: it writes to an array",
        ),
        ("import math\nreturn gap, 0.0, 0.0, 0.0", "line 2, `import math`: it imports a module"),
        ("with open('x') as f:\n    pass\nreturn gap, 0.0, 0.0, 0.0", "construct is not supported"),
    ],
)
def test_the_reason_why_a_kernel_is_not_compiled_is_its_cause(text: str, reason: str) -> None:
    found = obstacle_of(body(text))
    statement = text.splitlines()[-1 if "missing" in text else 0]
    assert reason.replace("{}", statement) in found
    assert "\n" not in found
    assert not any(word in found for word in ("nopython", "pipeline", "frontend", "UniTuple"))


def test_what_is_no_function_of_five_arguments_is_told() -> None:
    assert obstacle_of(undecorated) == "it is called with 5 arguments and names 1"
    assert obstacle_of(partial(plain, 1.0)) == "it is a partial and no function of its own"
    assert (
        obstacle_of(Thing().force) == "it is a method of an object; decorate it with @staticmethod"
    )


def obstacle_of(function: Any) -> str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fleeting_kernel(function).compile(PENALTY_SIGNATURE)  # type: ignore[attr-defined]
    except Exception as error:
        return obstacle.obstacle(error, function, PENALTY_SIGNATURE)
    return ""
