"""Compliant laws of kernels of choice, sound or not, and a short run that takes them in."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np

from contactlab.compiler.kernels import kernel
from contactlab.engine import simulate
from contactlab.laws import PenaltyLaw
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.parameter import Parameter
from contactlab.testing.plants import paper_motor

Array = np.ndarray
STRETCH = (InternalVariable("stretch", "z", "m", "stretch of the spring", parity=ODD),)
TWO = (*STRETCH, InternalVariable("age", "theta", "s", "age of the contact"))
STIFFNESS = Parameter("K", "N m-1.5", "contact stiffness", above=0.0)


@dataclass(frozen=True)
class Made(PenaltyLaw):
    """Hertz by the functions of a test; kind, memory and parity are those of a subclass."""

    name = "made"
    equation = "N = K d^1.5"
    source = "this test"
    default_contact_step = 4e-6
    function: ClassVar[Callable[..., Any]]
    friction: ClassVar[Callable[..., Any] | None] = None

    stiffness: Annotated[float, STIFFNESS] = 1e10

    @property
    def force(self) -> Any:
        return type(self).function

    @property
    def friction_force(self) -> Any:
        return type(self).friction


def made(function: Callable[..., Any], **arguments: Any) -> Made:
    """A law of a kernel, and of what it says."""
    members = arguments | {"function": staticmethod(function)}
    if members.get("friction") is not None:
        members["friction"] = staticmethod(arguments["friction"])
    subclass = dataclass(frozen=True)(type("Subclass", (Made,), members))
    return subclass()  # type: ignore[no-any-return]


def short_run(law: Any) -> Any:
    return simulate(paper_motor(), law, duration=1e-4, record_interval=1e-5)


@kernel
def honest(depth, stiffness):
    normal = stiffness * max(depth, 0.0) ** 1.5
    return normal, 0.3 * normal, 0.4 * normal * depth, 0.0


@kernel
def flowing():
    return 1.0


def variable(**arguments: Any) -> InternalVariable:
    return replace(TWO[1], **arguments)
