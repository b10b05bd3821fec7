"""A law that contradicts itself is refused before its first run; a sound one passes."""

from dataclasses import dataclass
from math import log, nan
from typing import Any

import numpy as np
import pytest
from support.made_laws import STRETCH, TWO, flowing, honest, made, short_run, variable

from contactlab.compiler.kernels import kernel
from contactlab.engine import simulate
from contactlab.engine.binding import bind, row_of
from contactlab.laws import ContactLaw, LawError, MultiplierLaw
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, Friction
from contactlab.laws.composed import Composed
from contactlab.laws.consistency import claims_of_kernels
from contactlab.laws.memory import EVEN, MOST_VARIABLES
from contactlab.testing.contract import check
from contactlab.testing.plants import Bench, paper_motor


@kernel
def negative(depth, stiffness):
    normal = stiffness * depth**1.5
    return normal, -0.3 * normal, 0.4 * normal * depth, 0.0


@kernel
def without_number(depth, stiffness):
    return stiffness * depth**1.5, 0.0, nan, 0.0


@kernel
def past_the_end(depth, stiffness, parameters):
    normal = stiffness * depth**1.5
    return normal, parameters[3] * normal, 0.4 * normal * depth, 0.0


@kernel
def hidden_past_the_end(depth, stiffness, parameters):
    normal = stiffness * depth**1.5
    # NaN does not come through a comparison.
    return normal, 0.5 * normal if parameters[1] > 0.3 else 0.0, 0.4 * normal * depth, 0.0


def interpreted_past_the_end(gap, parameters):
    return 0.0, 0.0, 0.0, {"parameters": parameters}["parameters"][1]


@kernel
def spring(slip, stretch):
    return -1e6 * stretch, slip, 0.5e6 * stretch * stretch, 1e6


@kernel
def boundless(slip, normal):
    return -normal * slip / abs(slip), 0.0, 0.0, 0.0


@kernel
def aged(depth, age, stiffness):
    normal = stiffness * depth**1.5
    return normal, 0.3 * normal * (1.0 + age / (age + 1e-5)), 0.4 * normal * depth, 0.0


@kernel
def without_rate(age):
    return nan


@kernel
def ending_first(stiffness):
    return 0.0, -1e-8


@kernel
def of_nothing_known(depth, hardness):
    return depth * hardness, 0.0, 0.0, 0.0


def refuse(*_: Any) -> Any:
    raise KeyError("k")


FLOW = {"rate": staticmethod(flowing)}
RATE = {"friction_kind": RATE_DEPENDENT, "friction": spring}
MANY = tuple(variable(name=f"z{i}") for i in range(MOST_VARIABLES + 1))

CONTRADICTORY = {
    "friction without a kind": lambda: made(honest, friction=spring, internal_variables=STRETCH),
    "no kernel of friction": lambda: made(honest, friction_kind=RATE_DEPENDENT),
    "no kernel of a spring": lambda: made(honest, friction_kind=ELASTOPLASTIC, internal_variables=STRETCH),
    "no such kind": lambda: made(honest, friction_kind=7),
    "a variable that nothing changes": lambda: made(honest, internal_variables=STRETCH),
    "a spring without stretch": lambda: made(honest, friction_kind=ELASTOPLASTIC, friction=boundless),
    "variables that are text": lambda: made(honest, internal_variables="stretch", **RATE),
    "a variable that is text": lambda: made(honest, internal_variables=("stretch [m]",), **RATE),
    "two variables without rate": lambda: made(honest, internal_variables=TWO, **RATE),
    "one name for two": lambda: made(aged, internal_variables=TWO[1:] * 2, **FLOW),
    "a name of two words": lambda: made(aged, internal_variables=(variable(name="the age"),), **FLOW),
    "too many variables": lambda: made(honest, internal_variables=MANY, **FLOW),
    "a start that is no number": lambda: made(aged, internal_variables=(variable(initial=nan),), **FLOW),
    "no such life": lambda: made(aged, internal_variables=(variable(life="day"),), **FLOW),
    "no such parity": lambda: made(aged, internal_variables=(variable(parity=0),), **FLOW),
    "guards without kernels": lambda: made(honest, guards=2),
    "guards that are not counted": lambda: made(
        aged, guard=staticmethod(flowing), internal_variables=TWO[1:], **FLOW
    ),
    "a rate that is no number": lambda: made(
        aged, rate=staticmethod(without_rate), internal_variables=TWO[1:]
    ),
    "an end before the beginning": lambda: made(honest, limits=staticmethod(ending_first)),
    "a negative bound": lambda: made(negative),
    "an energy that is no number": lambda: made(without_number),
    "more parameters than there are": lambda: made(past_the_end),
    "a parameter behind a comparison": lambda: made(hidden_past_the_end),
    "the same in Python": lambda: made(interpreted_past_the_end),
    "an unknown name": lambda: made(of_nothing_known),
    "two numbers": lambda: made(lambda gap: (-gap, 0.0)),
    "friction without a number at rest": lambda: made(
        honest, friction_kind=RATE_DEPENDENT, friction=boundless
    ),
    "coefficients without names": lambda: made(honest, coefficients=lambda _: (1.0,)),
    "coefficients that are text": lambda: made(honest, coefficients=lambda _: {"stiffness": "stiff"}),
    "coefficients that fail": lambda: made(honest, coefficients=refuse),
    "a friction limit that is text": lambda: made(honest, friction_limit="much"),
    "a negative friction limit": lambda: made(honest, friction_limit=-0.3),
    "a force that fails": lambda: made(honest, force=property(refuse)),
    "no force": lambda: made(honest, force=None),
    "violations without reasons": lambda: made(honest, violations=7),
}


@pytest.mark.parametrize("fault", CONTRADICTORY)
def test_a_compliant_law_that_contradicts_itself_is_refused(fault: str) -> None:
    with pytest.raises(LawError, match="made"):
        short_run(CONTRADICTORY[fault]())


@kernel
def half_stored(depth, stiffness):
    normal = stiffness * depth**1.5
    return normal, 0.3 * normal, 0.2 * normal * depth, 0.0


@pytest.mark.parametrize("function", [negative, half_stored])
def test_the_claim_that_refuses_a_law_is_one_of_its_contract(function: Any) -> None:
    law = made(function, friction_limit=0.3)
    at_first = {c.statement for c in claims_of_kernels(law, row_of(law), *bind(law).kernels) if not c.true}
    assert at_first == {c.statement for c in check(Bench(law), "kernel_is_consistent") if not c.true} != set()


@kernel
def endless(slip, d_nn):
    return 0.1 / d_nn, -1e-3 * slip / abs(slip)


@kernel
def halfway(approach, d_nn):
    return -0.5 * approach / d_nn, 0.0


@kernel
def pulling(normal):
    return -0.1 * normal


@kernel
def bouncing(approach, d_nn):
    return -approach / d_nn, 0.0


@dataclass(frozen=True)
class Rigid(MultiplierLaw):
    """A sound rigid law, for others to spoil."""

    name = "rigid"
    equation = "g = 0"
    source = "this test"
    default_contact_step = 5e-8

    impact = staticmethod(bouncing)


@pytest.mark.parametrize(
    "arguments",
    [
        {"impact": staticmethod(endless)},
        {"impact": staticmethod(halfway)},
        {"bound": staticmethod(pulling)},
        {"internal_variables": TWO[1:]},
        {"limits": staticmethod(flowing)},
        {"guard": staticmethod(flowing)},
    ],
    ids=["number", "approach", "bound", "variable", "limits", "guard"],
)
def test_a_rigid_law_that_contradicts_itself_is_refused(arguments: dict[str, Any]) -> None:
    spoilt = dataclass(frozen=True)(type("Spoilt", (Rigid,), arguments))
    with pytest.raises(LawError, match="rigid"):
        short_run(spoilt())


def test_a_rigid_law_with_the_former_kernel_is_refused_by_its_name() -> None:
    with pytest.raises(LawError, match="old_law"):
        type("OldLaw", (Rigid,), {"name": "old_law", "solve": staticmethod(bouncing)})


def test_a_friction_with_limits_is_refused() -> None:
    @dataclass(frozen=True)
    class Limited(Friction):
        name = "limited"
        equation = "|F| <= mu N"
        source = "this test"
        limits = staticmethod(flowing)

    with pytest.raises(ValueError, match="limits"):
        Composed(friction=Limited())


@kernel
def thin_layer(gap):
    # N = -P log(1 - d/h): no number from the depth h on.
    load, thickness = 1e2, 1e-5
    left = 1.0 + gap / thickness
    energy = load * (thickness * left * np.log(left) - gap)
    normal = -load * np.log(left)
    return normal, 0.3 * normal, energy, 0.0


def interpreted_layer(gap):
    # It raises from the depth h on, as Python does.
    left = 1.0 + gap / 1e-5
    state: dict[str, Any] = {"log": log(left), "text": [f"{gap}"]}
    normal, energy = -1e2 * state["log"], 1e-3 * (left * log(left) - left + 1.0)
    return normal, 0.0, energy, 0.0


@pytest.mark.parametrize("function", [thin_layer, interpreted_layer])
def test_a_law_whose_domain_ends_runs(function: Any) -> None:
    law = made(function, friction_limit=0.3)
    run = simulate(paper_motor(), law, duration=3e-4, record_interval=1e-6)
    assert run.complete
    assert run.series["normal_force"].max() > 0.0


@kernel
def ageing(slip, normal, age):
    """Drag that grows with the time of contact without slip [s], which is the same in a mirror."""
    share = slip / np.sqrt(slip * slip + 1e-6)
    strength = 1.0 + 0.2 * age / (age + 1e-5)
    return -0.3 * normal * share * strength, 1.0 - 1e4 * abs(slip) * age, 0.0, 0.0


@pytest.mark.parametrize("parity", [EVEN, -EVEN])
def test_a_variable_of_friction_may_be_even_in_a_mirror(parity: int) -> None:
    law = made(
        honest,
        friction=ageing,
        friction_kind=RATE_DEPENDENT,
        internal_variables=(variable(parity=parity),),
        exact_stick=False,
        friction_limit=0.36,
    )
    assert all(claim.holds for claim in check(Bench(law), "mirrors")) == (parity == EVEN)


@dataclass(frozen=True)
class OfNoFamily(ContactLaw):
    """Neither compliant nor rigid."""

    name = "of_no_family"
    equation = "none"
    source = "this test"
    default_contact_step = 1e-7


def test_a_law_of_neither_family_is_refused() -> None:
    with pytest.raises(TypeError, match="PenaltyLaw"):
        short_run(OfNoFamily())
