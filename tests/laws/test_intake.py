"""A law that contradicts itself is refused when it is taken in, and a sound one is not, however narrow."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import log, nan
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest

from contactlab.compiled import kernel
from contactlab.engine import simulate
from contactlab.laws import LAWS, LawError, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, SLIP, Friction
from contactlab.laws.composed import Composed
from contactlab.laws.damping import DAMPINGS
from contactlab.laws.friction import FRICTIONS
from contactlab.laws.memory import EVEN, MOST_VARIABLES, ODD, InternalVariable
from contactlab.laws.normal import NORMAL_FORCES
from contactlab.parameter import Parameter
from contactlab.testing.contract import check
from contactlab.testing.plants import Bench, block, paper_motor

Array = np.ndarray
Forces = tuple[float, float, float, float]
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
    length = 1

    stiffness: Annotated[float, STIFFNESS] = 1e10

    def parameters(self) -> Array:
        return np.full(self.length, self.stiffness)

    @property
    def force(self) -> Any:
        return type(self).function

    @property
    def friction_force(self) -> Any:
        return type(self).friction


def made(function: Callable[..., Any], **words: Any) -> Made:
    """A law of a kernel, and of what it says."""
    members = words | {"function": staticmethod(function)}
    if members.get("friction") is not None:
        members["friction"] = staticmethod(words["friction"])
    subclass = dataclass(frozen=True)(type("Subclass", (Made,), members))
    return subclass()  # type: ignore[no-any-return]


def short_run(law: Any) -> Any:
    return simulate(paper_motor(), law, duration=1e-4, record_interval=1e-5)


@kernel
def honest(gap, gap_rate, slip, impact_speed, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    return normal, 0.3 * normal, -0.4 * normal * gap, 0.0


@kernel
def negative(gap, gap_rate, slip, impact_speed, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    return normal, -0.3 * normal, -0.4 * normal * gap, 0.0


@kernel
def without_number(gap, gap_rate, slip, impact_speed, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    return normal, 0.3 * normal, nan, 0.0


@kernel
def past_the_end(gap, gap_rate, slip, impact_speed, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    return normal, p[3] * normal, -0.4 * normal * gap, 0.0


@kernel
def coefficient(p: Array) -> float:
    return float(p[1])


@kernel
def hidden_past_the_end(gap, gap_rate, slip, impact_speed, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    # What is no number does not come through a comparison.
    return normal, 0.5 * normal if coefficient(p) > 0.3 else 0.0, -0.4 * normal * gap, 0.0


@kernel
def before_the_start(gap, gap_rate, slip, impact_speed, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    return normal, p[-3] * normal, -0.4 * normal * gap, 0.0


def interpreted_past_the_end(*arguments: Any) -> Any:
    state: dict[str, Any] = {"parameters": arguments[-1]}
    return 0.0, 0.0, 0.0, state["parameters"][1]


@kernel
def spring(gap, gap_rate, slip, normal, z, p):
    return -1e6 * z, slip, 0.5e6 * z * z, 1e6


@kernel
def boundless(gap, gap_rate, slip, normal, z, p):
    return -normal * slip / abs(slip), 0.0, 0.0, 0.0


@kernel
def aged(gap, gap_rate, slip, impact_speed, z, p):
    normal = p[0] * max(-gap, 0.0) ** 1.5
    return normal, 0.3 * normal * (1.0 + z[0] / (z[0] + 1e-5)), -0.4 * normal * gap, 0.0


@kernel
def flowing(which, gap, gap_rate, slip, normal, z, p):
    return 1.0


@kernel
def without_rate(which, gap, gap_rate, slip, normal, z, p):
    return nan


@kernel
def ending_first(p):
    return 0.0, -1e-8


def variable(**words: Any) -> InternalVariable:
    return replace(TWO[1], **words)


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


@kernel
def nowhere(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return -normal_rate / d_nn, 0.0, 7


@kernel
def endless(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return 0.1 / d_nn, -1e-3 * slip / abs(slip), SLIP


@kernel
def halfway(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return -0.5 * normal_rate / d_nn, 0.0, SLIP


@kernel
def bouncing(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, p):
    return -normal_rate / d_nn, 0.0, SLIP


@pytest.mark.parametrize(
    "words", [{}, {"rate": staticmethod(flowing)}, {"told": True}], ids=["none", "rate", "told"]
)
def test_a_rigid_law_that_remembers_without_being_told_is_refused(words: dict[str, Any]) -> None:
    @dataclass(frozen=True)
    class Rigid(MultiplierLaw):
        name = "rigid"
        equation = "g = 0"
        source = "this test"
        default_contact_step = 5e-8
        internal_variables = TWO[1:]

        solve = staticmethod(bouncing)

    remembering = dataclass(frozen=True)(type("Remembering", (Rigid,), words))
    with pytest.raises(LawError, match="no kernel rate or jump, or does not say told = True"):
        short_run(remembering())


@pytest.mark.parametrize("name", ["limits", "guard"])
def test_a_rigid_law_with_limits_or_guards_is_refused(name: str) -> None:
    @dataclass(frozen=True)
    class Rigid(MultiplierLaw):
        name = "rigid"
        equation = "g = 0"
        source = "this test"
        default_contact_step = 5e-8

        solve = staticmethod(bouncing)

    limited = dataclass(frozen=True)(type("Limited", (Rigid,), {name: staticmethod(flowing)}))
    with pytest.raises(LawError, match="a rigid contact begins and ends at a gap of zero"):
        short_run(limited())


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


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (nowhere, "the mode is 7"),
        (endless, "its kernel solve gives"),
        (halfway, "leaves an approach of 0.005 m/s in an impact with a gap rate of -0.01 m/s"),
    ],
)
def test_a_rigid_law_that_cannot_be_is_refused(function: Any, words: str) -> None:
    @dataclass(frozen=True)
    class Rigid(MultiplierLaw):
        name = "rigid"
        equation = "g = 0"
        source = "this test"
        default_contact_step = 5e-8

        @property
        def solve(self) -> Any:
            return function

    with pytest.raises(LawError, match=words):
        short_run(Rigid())


@kernel
def thin_layer(gap, gap_rate, slip, impact_speed, p):
    # N = -P log(1 - d/h): no number from the depth h on.
    load, thickness = 1e2, 1e-5
    left = 1.0 + gap / thickness
    energy = load * (thickness * left * np.log(left) - gap)
    normal = -load * np.log(left)
    return normal, 0.3 * normal, energy, 0.0


def interpreted_layer(gap, gap_rate, slip, impact_speed, p):
    # It raises from the depth h on, as Python does.
    left = 1.0 + gap / 1e-5
    state: dict[str, Any] = {"log": log(left), "text": [f"{gap}"]}
    normal, energy = -1e2 * state["log"], 1e-3 * (left * log(left) - left + 1.0)
    return normal, 0.0, energy, 0.0


@pytest.mark.parametrize("function", [thin_layer, interpreted_layer])
def test_a_law_that_has_an_end_of_its_domain_is_taken(function: Any) -> None:
    law = made(function, friction_limit=0.3)
    run = simulate(paper_motor(), law, duration=3e-4, record_interval=1e-6)
    assert run.complete
    assert run.series["normal_force"].max() > 0.0


@pytest.mark.parametrize(
    "law",
    [
        *(law() for law in LAWS.values()),
        *(Composed(normal=part()) for part in NORMAL_FORCES.values()),
        *(Composed(damping=part()) for part in DAMPINGS.values()),
        *(Composed(friction=part()) for part in FRICTIONS.values()),
    ],
    ids=lambda law: law.title,
)
def test_every_law_of_the_package_is_taken(law: Any) -> None:
    still = block(height=1.0)
    assert simulate(still, law, duration=1e-6, record_interval=1e-6).complete


@kernel
def ageing(gap, gap_rate, slip, normal, z, p):
    """The longer contact lasts without slip, the more it drags; its age [s] is the same in a mirror."""
    share = slip / np.sqrt(slip * slip + 1e-6)
    strength = 1.0 + 0.2 * z / (z + 1e-5)
    return -0.3 * normal * share * strength, 1.0 - 1e4 * abs(slip) * z, 0.0, 0.0


@pytest.mark.parametrize("parity", [EVEN, -EVEN])
def test_what_friction_remembers_may_be_even_in_a_mirror(parity: int) -> None:
    law = made(
        honest,
        friction=ageing,
        friction_kind=RATE_DEPENDENT,
        internal_variables=(variable(parity=parity),),
        exact_stick=False,
        friction_limit=0.36,
    )
    assert all(claim.holds for claim in check(Bench(law), "mirrors")) == (parity == EVEN)
