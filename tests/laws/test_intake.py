"""A compliant law that contradicts itself is refused when it is taken in."""

from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np
import pytest
from support.made_laws import STRETCH, TWO, Array, flowing, honest, made, short_run, variable

from contactlab.compiled import kernel
from contactlab.laws import LawError, PenaltyLaw
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, Friction
from contactlab.laws.composed import Composed
from contactlab.laws.memory import MOST_VARIABLES


@kernel
def negative(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, -0.3 * normal, -0.4 * normal * gap, 0.0


@kernel
def without_number(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, 0.3 * normal, nan, 0.0


@kernel
def past_the_end(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, parameters[3] * normal, -0.4 * normal * gap, 0.0


@kernel
def coefficient(parameters: Array) -> float:
    return float(parameters[1])


@kernel
def hidden_past_the_end(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    # What is no number does not come through a comparison.
    return normal, 0.5 * normal if coefficient(p) > 0.3 else 0.0, -0.4 * normal * gap, 0.0


@kernel
def before_the_start(gap, gap_rate, slip, impact_speed, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, parameters[-3] * normal, -0.4 * normal * gap, 0.0


def interpreted_past_the_end(*arguments: Any) -> Any:
    state: dict[str, Any] = {"parameters": arguments[-1]}
    return 0.0, 0.0, 0.0, state["parameters"][1]


@kernel
def spring(gap, gap_rate, slip, normal, z, parameters):
    return -1e6 * z, slip, 0.5e6 * z * z, 1e6


@kernel
def boundless(gap, gap_rate, slip, normal, z, parameters):
    return -normal * slip / abs(slip), 0.0, 0.0, 0.0


@kernel
def aged(gap, gap_rate, slip, impact_speed, z, parameters):
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, 0.3 * normal * (1.0 + z[0] / (z[0] + 1e-5)), -0.4 * normal * gap, 0.0


@kernel
def without_rate(which, gap, gap_rate, slip, normal, z, parameters):
    return nan


@kernel
def ending_first(parameters):
    return 0.0, -1e-8


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (made(honest, friction=spring), "its friction_kind is SET_VALUED, which has none"),
        (made(honest, friction_kind=RATE_DEPENDENT), "RATE_DEPENDENT, but it has no kernel of friction"),
        (
            made(honest, friction_kind=ELASTOPLASTIC, internal_variables=STRETCH),
            "ELASTOPLASTIC, but it has no kernel of friction",
        ),
        (made(honest, friction_kind=7, friction=spring), "friction_kind is 7; it must be"),
        (made(honest, internal_variables=STRETCH), "set-valued friction remembers by a kernel rate or jump"),
        (made(honest, friction_kind=ELASTOPLASTIC, friction=spring), "and a spring its stretch"),
        (
            made(honest, friction_kind=RATE_DEPENDENT, friction=spring, internal_variables="stretch"),
            "internal_variables is 'stretch'; it must be a tuple of contactlab.laws.InternalVariable",
        ),
        (
            made(honest, friction_kind=RATE_DEPENDENT, friction=spring, internal_variables=("stretch [m]",)),
            "it must be a tuple of contactlab.laws.InternalVariable",
        ),
        (
            made(honest, friction_kind=RATE_DEPENDENT, friction=spring, internal_variables=TWO),
            "more than one quantity needs a kernel rate or jump",
        ),
        (
            made(aged, rate=staticmethod(flowing), internal_variables=TWO[1:] * 2),
            "its internal variables are called age, age; each must have one word of its own",
        ),
        (
            made(aged, rate=staticmethod(flowing), internal_variables=(variable(name="the age"),)),
            "its internal variables are called the age; each must",
        ),
        (
            made(
                aged,
                rate=staticmethod(flowing),
                internal_variables=tuple(variable(name=f"z{i}") for i in range(MOST_VARIABLES + 1)),
            ),
            "it has 129 internal variables; it can have 128 at most",
        ),
        (
            made(aged, rate=staticmethod(flowing), internal_variables=(variable(initial=nan),)),
            "begins at nan",
        ),
        (
            made(aged, rate=staticmethod(flowing), internal_variables=(variable(life="day"),)),
            "lives for 'day' and has the parity 1; it must begin at a number, live for 'contact' or 'run'",
        ),
        (
            made(aged, rate=staticmethod(flowing), internal_variables=(variable(parity=0),)),
            "has the parity 0; it must",
        ),
        (made(honest, guards=2), "it needs a kernel guard and a kernel jump for them"),
        (
            made(aged, rate=staticmethod(flowing), guard=staticmethod(flowing), internal_variables=TWO[1:]),
            "it has a kernel of guards and says that it has none",
        ),
        (
            made(aged, rate=staticmethod(without_rate), internal_variables=TWO[1:]),
            "its kernel rate gives nan at a gap of -1e-12 m",
        ),
        (
            made(honest, limits=staticmethod(ending_first)),
            "a contact begins at a gap of 0 m and ends at -1e-08 m; it must not end before it begins",
        ),
        (made(negative), "the friction bound is -"),
        (made(without_number), "its kernel force gives"),
        (made(past_the_end), "reads parameters that there are not"),
        (made(hidden_past_the_end), "beyond the 1 that parameters() gives"),
        (made(before_the_start), "reads parameters that there are not"),
        (made(interpreted_past_the_end), "raised IndexError"),
        (made(lambda *_: (1.0, 0.0)), "it gave 2 numbers, not 4"),
        (
            made(honest, friction_kind=RATE_DEPENDENT, friction=boundless),
            "its kernel friction_force gives nan, 0, 0, 0 at a gap of -1e-12 m",
        ),
        (made(honest, parameters=lambda _: np.ones((2, 2))), "it must give numbers"),
        (made(honest, friction_limit="much"), "friction_limit is 'much'; it must be a number"),
        (made(honest, friction_limit=-0.3), "friction_limit is -0.3; it must be a number"),
        (made(honest, force=property(lambda _: {}["k"])), "the law made raised KeyError: 'k' ("),
        (made(honest, parameters=lambda _: {}["q"]), "the law made raised KeyError: 'q' ("),
        (made(honest, violations=7), "violations is 7; it must give reasons by name"),
        (made(honest, force=None), "its force is None; it must be a function"),
        (made(honest, parameters=lambda _: ["stiff"]), "parameters() gives ['stiff']"),
    ],
)
def test_a_law_that_contradicts_itself_is_refused(law: PenaltyLaw, words: str) -> None:
    with pytest.raises(LawError) as refusal:
        short_run(law)
    assert "made" in str(refusal.value)
    assert words in str(refusal.value)


@dataclass(frozen=True)
class Still(Friction):
    """Coulomb's cone, for others to spoil."""

    name = "still"
    equation = "|F| <= mu N"
    source = "this test"


def test_a_friction_with_limits_is_refused() -> None:
    limited = dataclass(frozen=True)(type("Limited", (Still,), {"limits": staticmethod(flowing)}))
    with pytest.raises(ValueError, match="where a contact begins and ends is the normal force's"):
        Composed(friction=limited())
