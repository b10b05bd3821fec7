"""Laws and parts with one deliberate fault each, and which check catches it.

"consistency" is the check of a law before its first run, "run" the ending of a run, and anything else a
property of the contract. `docs/saboteurs.md` has the table.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import pytest
from support.laws_of_kernels import FRICTION, law_class_of

import contactlab as cl
from contactlab.compiler.kernels import fleeting_kernel
from contactlab.laws.base import RATE_DEPENDENT, coulomb
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.lagrange import stick_impulse, stick_or_slip_impulse
from contactlab.laws.memory import ODD
from contactlab.testing import LawContract
from contactlab.testing.contract import PROPERTIES, check
from contactlab.testing.plants import Bench

FAST = 0.02
"""Gap rate beyond which a fault shows [m/s]: beyond what is tried before a run."""

TABLE = Path(__file__).parents[2] / "docs" / "saboteurs.md"

Kernel = Callable[..., Any]


def law_of(kernel: Kernel, units: str = "N m-1.5", idle: bool = False) -> cl.PenaltyLaw:
    """A Hertzian law with a kernel of choice, and on demand with a parameter that it does not read."""
    parameters = {"stiffness": (cl.Parameter("K", units, "stiffness", above=0.0), 1e10), **FRICTION}
    if idle:
        parameters["idle"] = cl.Parameter("c", "1", "of no meaning", at_least=0.0), 1.0
    return law_class_of(cl.PenaltyLaw, "saboteur", parameters, force=kernel)()  # type: ignore[no-any-return]


def hertz(stored: float = 1.0, fast: float = 1.0, bound: float = 1.0, pull: float = 0.0) -> Kernel:
    """A Hertzian force whose energy, bound or pull are off by factors, everywhere or where it is FAST."""

    def force(gap, gap_rate, slip, impact_speed, parameters):
        depth = max(-gap, 0.0)
        normal = parameters[0] * depth * np.sqrt(depth)
        energy = 0.4 * normal * depth * stored
        if abs(gap_rate) > FAST:
            energy *= fast
        return normal - pull, bound * parameters[1] * normal, energy - pull * depth, 0.0

    return fleeting_kernel(force)


@fleeting_kernel
def beyond_the_row(gap, gap_rate, slip, impact_speed, parameters):
    depth = max(-gap, 0.0)
    normal = parameters[0] * depth * np.sqrt(depth)
    return normal, parameters[1] * normal * (1.0 + 1e-3 * parameters[2]), 0.4 * normal * depth, 0.0


@fleeting_kernel
def no_number(gap, gap_rate, slip, impact_speed, parameters):
    depth = max(-gap, 0.0)
    normal = parameters[0] * depth * np.sqrt(depth)
    return normal if abs(gap_rate) <= FAST else np.nan, parameters[1] * normal, 0.4 * normal * depth, 0.0


@fleeting_kernel
def undeclared_dashpot(gap, gap_rate, slip, impact_speed, parameters):
    depth = max(-gap, 0.0)
    elastic = parameters[0] * depth * np.sqrt(depth)
    normal = elastic * max(1.0 - gap_rate, 0.0)
    return normal, parameters[1] * normal, 0.4 * elastic * depth, 0.0


@fleeting_kernel
def active(gap, gap_rate, slip, impact_speed, parameters):
    depth = max(-gap, 0.0)
    elastic = parameters[0] * depth * np.sqrt(depth)
    normal = elastic * max(1.0 + 0.3 * gap_rate, 0.0)
    return normal, parameters[1] * normal, 0.4 * elastic * depth, (elastic - normal) * gap_rate


@fleeting_kernel
def one_sided(gap, gap_rate, slip, impact_speed, parameters):
    depth = max(-gap, 0.0)
    normal = parameters[0] * depth * np.sqrt(depth)
    return normal, (parameters[1] if slip >= 0.0 else 0.9 * parameters[1]) * normal, 0.4 * normal * depth, 0.0


CALLS: list[float] = []


def counts_its_calls(gap, gap_rate, slip, impact_speed, parameters):
    CALLS.append(gap)
    depth = max(-gap, 0.0)
    normal = parameters[0] * depth * np.sqrt(depth) * (1.0 + 1e-9 * len(CALLS))
    return normal, parameters[1] * normal, 0.4 * normal * depth, 0.0


def normal_of(stiffness: float = 1.0, slope: float = 1.0, stored: float = 1.0) -> cl.Composed:
    """A Hertzian normal force whose stiffness, slope or energy is off by a factor, with Mindlin's spring."""

    @fleeting_kernel
    def pressed(depth, parameters):
        root = np.sqrt(depth)
        force = parameters[0] * depth * root
        steep = 1.5 * parameters[0] * root
        bend = 0.5 * steep / depth if depth > 0.0 else 0.0
        return force, 0.4 * force * depth * stored, stiffness * steep, slope * bend

    @dataclass(frozen=True)
    class Pressed(cl.NormalForce):
        name: ClassVar[str] = "pressed"
        equation: ClassVar[str] = "N = K d^1.5"
        source: ClassVar[str] = "this test"

        stiffness: Annotated[float, cl.Parameter("K", "N m-1.5", "stiffness", above=0.0)] = 1e10

        elastic = staticmethod(pressed)

    return cl.Composed(normal=Pressed(), friction=cl.Mindlin())


def friction_of(stored: float = 1.0, push: float = 1.0) -> cl.Composed:
    """A bristle in proportion to the normal force, whose energy or sign is off."""

    @fleeting_kernel
    def bent(normal, slip, bend, friction_coefficient, bristle_stiffness):
        rate = slip - abs(slip) * bristle_stiffness * bend / friction_coefficient
        force = -push * bristle_stiffness * max(normal, 0.0) * bend
        return force, rate, stored * 0.5 * bristle_stiffness * max(normal, 0.0) * bend * bend, 0.0

    @dataclass(frozen=True)
    class Bristle(cl.Friction):
        name: ClassVar[str] = "bristle"
        equation: ClassVar[str] = "F = -sigma N z"
        source: ClassVar[str] = "this test"
        friction_kind: ClassVar[int] = RATE_DEPENDENT
        exact_stick: ClassVar[bool] = False
        internal_variables = (cl.InternalVariable("bend", "z", "m", "bend of the bristle", parity=ODD),)

        bristle_stiffness: Annotated[float, cl.Parameter("sigma", "m-1", "stiffness over N", above=0.0)] = 1e6

        state = staticmethod(bent)

    return cl.Composed(friction=Bristle())


def rigid_of(
    impact: Kernel, bound: Kernel = coulomb, text: Any = FRICTION_COEFFICIENT, **declared: Any
) -> cl.MultiplierLaw:
    """A rigid law of these kernels and declarations; `text` is that of its friction coefficient."""
    parameters = {"friction_coefficient": (text, 0.3)}
    kernels = {"impact": impact, "bound": bound}
    return law_class_of(cl.MultiplierLaw, "rigid", parameters, **kernels, **declared)()  # type: ignore[no-any-return]


@fleeting_kernel
def half_an_impulse(approach, d_nn):
    return -0.5 * approach / d_nn, 0.0


@fleeting_kernel
def bounces_too_high(approach, slip, d_nn, d_nt, d_tt, friction_coefficient):
    p_n, p_t = stick_or_slip_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient)
    return 2.2 * p_n, p_t


@fleeting_kernel
def sticks_always(approach, slip, d_nn, d_nt, d_tt):
    return stick_impulse(approach, slip, d_nn, d_nt, d_tt)


@fleeting_kernel
def holds_always(normal):
    return 1e3 * normal


@fleeting_kernel
def reverses(approach, slip, d_nn, d_nt, d_tt, friction_coefficient):
    _, p_t = stick_or_slip_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient)
    # The approach is stopped none the less.
    return max(-(approach - 0.5 * d_nt * p_t) / d_nn, 0.0), -0.5 * p_t


@fleeting_kernel
def beyond_the_cone(normal, friction_coefficient):
    return 1.1 * friction_coefficient * normal


@fleeting_kernel
def negative_in_slip(normal, slip, friction_coefficient):
    return (-1.0 if normal > 10.0 and slip != 0.0 else 1.0) * friction_coefficient * normal


@fleeting_kernel
def no_number_pressed(normal):
    return np.nan if normal > 10.0 else 0.0


@fleeting_kernel
def nothing(gap):
    return 0.0, 0.0, 0.0, 0.0


LAST = [0.0]


def remembers_the_last_call(gap, gap_rate, slip, impact_speed, parameters):
    # No run asks twice of a gap and its half; who asks more often does.
    mu = 0.9 * parameters[1] if LAST[0] == 0.5 * gap else parameters[1]
    LAST[0] = gap
    normal = parameters[0] * max(-gap, 0.0) ** 1.5
    return normal, mu * normal, -0.4 * normal * gap, 0.0


SABOTEURS: dict[str, tuple[Callable[[], cl.ContactLaw], str]] = {
    "stored energy too large by a half": (lambda: law_of(hertz(stored=1.5)), "consistency"),
    "stored energy twice too large": (lambda: law_of(hertz(stored=2.0)), "consistency"),
    "no stored energy": (lambda: law_of(hertz(stored=0.0)), "consistency"),
    "stored energy too large by a half in fast contacts": (lambda: law_of(hertz(fast=1.5)), "run"),
    "stored energy too large by a fifth in fast contacts": (
        lambda: law_of(hertz(fast=1.2)),
        "kernel_is_consistent",
    ),
    "no number in fast contacts": (lambda: law_of(no_number), "run"),
    "side effects": (lambda: law_of(counts_its_calls), "consistency"),
    "reads beyond its parameters": (lambda: law_of(beyond_the_row), "consistency"),
    "negative friction bound": (lambda: law_of(hertz(bound=-1.0)), "consistency"),
    "friction beyond the declared cone": (lambda: law_of(hertz(bound=1.1)), "inside_the_cone"),
    "pulls without saying so": (lambda: law_of(hertz(pull=0.3)), "no_tension"),
    "a dashpot whose loss is not declared": (lambda: law_of(undeclared_dashpot), "consistency"),
    "a damping that feeds energy": (lambda: law_of(active), "dissipates"),
    "friction that knows left from right": (lambda: law_of(one_sided), "mirrors"),
    "a parameter that no kernel reads": (lambda: law_of(hertz(), idle=True), "reads_what_it_declares"),
    "a stiffness in wrong units": (lambda: law_of(hertz(), units="N m-1"), "scales_with_units"),
    "normal force with half its stiffness": (lambda: normal_of(stiffness=0.5), "consistency"),
    "normal force with a wrong slope": (lambda: normal_of(slope=2.0), "part_says_its_stiffness"),
    "normal force with half its stored energy too much": (lambda: normal_of(stored=1.5), "consistency"),
    "bristle without stored energy": (lambda: friction_of(stored=0.0), "consistency"),
    "bristle with twice its stored energy": (
        lambda: friction_of(stored=2.0),
        "friction_stores_what_it_gives",
    ),
    "bristle that pushes along the slip": (lambda: friction_of(push=-1.0), "friction_opposes_slip"),
    "rigid law that leaves an approach": (lambda: rigid_of(half_an_impulse), "consistency"),
    "restitution above one": (lambda: rigid_of(bounces_too_high), "dissipates"),
    "rigid stick beyond the cone": (lambda: rigid_of(sticks_always, holds_always), "inside_the_cone"),
    "rigid friction that pushes along the slip": (lambda: rigid_of(reverses), "friction_opposes_slip"),
    **{
        f"rigid friction bound {fault}": (
            lambda bound=bound: rigid_of(stick_or_slip_impulse, bound),
            "kernel_is_consistent",
        )
        for fault, bound in {
            "beyond the declared cone": beyond_the_cone,
            "negative in slip under a load": negative_in_slip,
            "that is no number under a load": no_number_pressed,
        }.items()
    },
    "a force that carries no weight": (lambda: law_of(nothing), "stick_is_exact"),
    "a force that depends on the call before": (
        lambda: law_of(remembers_the_last_call),
        "calls_leave_no_trace",
    ),
}


def caught_by(law: cl.ContactLaw, way: str) -> bool:
    """Whether a check catches a law."""
    if way in PROPERTIES:
        return not all(claim.holds for claim in check(Bench(law), way))
    try:
        run = cl.simulate(cl.build().motor, law, duration=2e-3)
    except cl.LawError:
        return way == "consistency"
    return way == "run" and not run.complete


@pytest.mark.parametrize("fault", SABOTEURS)
def test_a_saboteur_is_caught_where_the_table_says(fault: str) -> None:
    make, way = SABOTEURS[fault]
    assert caught_by(make(), way)


def test_honest_laws_of_the_same_make_are_not_caught() -> None:
    # A bristle in proportion to N gains energy under a growing load, which dahl and others declare.
    loaded = {"friction_opposes_slip", "dissipates", "mirrors"}
    ways = {way for _, way in SABOTEURS.values()}
    for law, free in ((law_of(hertz()), ways), (normal_of(), ways - loaded), (friction_of(), ways - loaded)):
        assert [way for way in sorted(free) if caught_by(law, way)] == []


def test_the_page_has_the_table() -> None:
    rows = [
        line.strip("| \n").split(" | ") for line in TABLE.read_text().splitlines() if line.startswith("| ")
    ]
    assert {fault: way.strip("`") for fault, way in rows[2:]} == {f: way for f, (_, way) in SABOTEURS.items()}


def test_friction_that_pushes_is_found_in_impacts_and_in_runs() -> None:
    claims = check(Bench(rigid_of(reverses)), "friction_opposes_slip")
    assert sum(not claim.holds for claim in claims) >= 2


def test_a_law_that_depends_on_the_call_before_repeats_its_runs() -> None:
    assert all(claim.holds for claim in check(Bench(law_of(remembers_the_last_call)), "repeats_bit_for_bit"))


@pytest.mark.parametrize(
    ("law", "name", "reason"),
    [
        (
            {"text": "mu"},
            "declares_its_parameters",
            "parameters without declaration ['friction_coefficient']",
        ),
        ({"violations": {"is_pretty": "it is not"}}, "declares_what_it_breaks", "['is_pretty']"),
        ({"violations": {"mirrors": "no reason"}}, "mirrors", "HOLDS, declared broken"),
        ({"convergence_order": 2.0}, "converges", "order of convergence"),
    ],
    ids=["parameter", "no property", "kept", "order"],
)
def test_a_false_declaration_is_found(law: dict[str, Any], name: str, reason: str) -> None:
    class Contract(LawContract):
        pass

    Contract.law = rigid_of(stick_or_slip_impulse, **law)
    with pytest.raises(AssertionError) as failure:
        Contract().assert_property(name)
    assert reason in str(failure.value)


def test_a_law_that_raises_fails_with_its_error() -> None:
    def raises(d_nn: float) -> Any:
        raise ZeroDivisionError("by nothing")

    (claim,) = check(Bench(rigid_of(raises)), "kernel_is_consistent")
    assert not claim.holds
    assert "ZeroDivisionError" in claim.statement
