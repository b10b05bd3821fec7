"""The reason why a kernel is not compiled is told in a line: place, statement and cause."""

import linecache
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np  # noqa: F401
import pytest
from numba import njit
from scipy import special  # noqa: F401

from contactlab.compiled import fleeting_kernel
from contactlab.engine import obstacle
from contactlab.laws.base import PENALTY_SIGNATURE


def plain(*arguments: Any) -> Any:
    return arguments


class Thing:
    factor = 2.0

    def force(self, *arguments: float) -> Any:
        return arguments


THING, WORDS = Thing(), {"a": 1.0}


def undecorated(gap: float) -> float:
    return 2.0 * gap


@njit
def lost(gap: float) -> float:
    return gap + nowhere  # type: ignore[name-defined]  # noqa: F821


def body(text: str) -> Callable[..., Any]:
    """A kernel with these lines."""
    lines = "\n".join(f"    {line}" for line in text.splitlines())
    source = f"def kernel(gap, gap_rate, slip, impact_speed, parameters):\n{lines}\n"
    name = f"<kernel {len(linecache.cache)}>"
    linecache.cache[name] = (len(source), None, source.splitlines(True), name)
    exec(compile(source, name, "exec"), names := dict(globals()))
    return names["kernel"]  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("n = 1.0\nreturn n, missing, 0.0, 0.0", "line 3, `{}`: name 'missing' is not defined"),
        ("n = lost(gap)\nreturn n, 0.0, 0.0, 0.0", "name 'nowhere' is not defined"),
        ("n = undecorated(gap)", "line 2, `{}`: undecorated is a Python function; decorate it with"),
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
        ("n = np.zeros(3)\nreturn n[0], 0.0, 0.0, 0.0", f"line 2, `n = np.zeros(3)`: {obstacle.ALLOCATES}"),
        ("parameters[0] = 2.0\nreturn gap, 0.0, 0.0, 0.0", "`parameters[0] = 2.0`: it writes to an array"),
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
    assert obstacle_of(Thing().force) == "it is a method of an object; decorate it with @staticmethod"


def obstacle_of(function: Any) -> str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fleeting_kernel(function).compile(PENALTY_SIGNATURE)  # type: ignore[attr-defined]
    except Exception as error:
        return obstacle.obstacle(error, function, PENALTY_SIGNATURE)
    return ""
