"""What the contract catches beside the saboteurs: no end, hidden state, rigid laws, false declarations."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, final

import numpy as np
import pytest

from contactlab.compiler.kernels import fleeting_kernel
from contactlab.laws import LAWS, LagrangeStick, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import Kernel, coulomb
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.lagrange import stick_or_slip_impulse
from contactlab.parameter import Parameter
from contactlab.testing import LawContract, plants
from contactlab.testing.contract import check
from contactlab.testing.plants import Bench, attempt
from contactlab.trajectory import Ending, Trajectory

Forces = tuple[float, float, float, float]
STIFFNESS = 1e10
RIGID = [law for law in LAWS.values() if issubclass(law, MultiplierLaw)]


@final
@dataclass(frozen=True)
class Cheat(PenaltyLaw):
    """Hertz with a kernel of choice."""

    name: ClassVar[str] = "cheat"
    equation: ClassVar[str] = "what it wants"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT]
    kernel: Annotated[Callable[..., Forces], Parameter("f", "1", "the kernel")]

    def __post_init__(self) -> None:
        """A kernel has no range."""

    def coefficients(self) -> dict[str, float]:
        return {"stiffness": STIFFNESS, "friction_coefficient": self.friction_coefficient}

    @property
    def force(self) -> Kernel:
        return self.kernel


def test_a_run_that_does_not_end_fails_with_its_sentence_and_is_made_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[Trajectory] = []

    def stalled(*arguments: Any) -> Trajectory:
        run = attempt(*arguments)
        made.append(replace(run, ending=Ending.DIVERGED, message="Its steps do not advance."))
        return made[-1]

    monkeypatch.setattr(plants, "attempt", stalled)
    bench = Bench(LAWS["newton"](0.3, 0.5))
    for name in ("no_force_when_open", "dissipates", "ledger_closes", "mirrors", "converges"):
        (claim,) = check(bench, name)
        # What a law declares to break is no excuse for a run without an end.
        assert not claim.holds
    assert len(made) == 1


def test_a_law_that_carries_nothing_fails_with_a_sentence() -> None:
    def nothing(gap, gap_rate, slip, impact_speed, parameters):
        return 0.0, 0.0, 0.0, 0.0

    (claim,) = check(Bench(Cheat(0.0, fleeting_kernel(nothing))), "stick_is_exact")
    assert not claim.holds


def test_a_law_that_remembers_what_it_was_asked_fails_there_alone() -> None:
    requested = [0.0]

    def remembers_the_last_call(gap, gap_rate, slip, impact_speed, parameters):
        # No run asks twice of a gap and its half; who asks more often does.
        mu = 0.9 * parameters[1] if requested[0] == 0.5 * gap else parameters[1]
        requested[0] = gap
        normal = parameters[0] * max(-gap, 0.0) ** 1.5
        return normal, mu * normal, -0.4 * normal * gap, 0.0

    bench = Bench(Cheat(0.3, remembers_the_last_call))
    assert all(claim.holds for claim in check(bench, "repeats_bit_for_bit"))
    assert not all(claim.holds for claim in check(bench, "calls_leave_no_trace"))


def reverses(approach, slip, d_nn, d_nt, d_tt, parameters):
    _, p_t = stick_or_slip_impulse(approach, slip, d_nn, d_nt, d_tt, parameters[0])
    # The approach is stopped none the less.
    return max(-(approach - 0.5 * d_nt * p_t) / d_nn, 0.0), -0.5 * p_t


@final
@dataclass(frozen=True)
class RigidCheat(MultiplierLaw):
    """The law with stick, with its answers changed."""

    name: ClassVar[str] = "rigid_cheat"
    equation: ClassVar[str] = "what it wants"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 5e-8

    kernel: Callable[..., tuple[float, float]] = stick_or_slip_impulse
    bounding: Callable[..., float] = coulomb

    @property
    def friction_limit(self) -> float:
        return 0.3

    def coefficients(self) -> dict[str, float]:
        return {"friction_coefficient": 0.3}

    @property
    def impact(self) -> Kernel:
        return self.kernel

    @property
    def bound(self) -> Kernel:  # type: ignore[override]
        return self.bounding


def test_friction_that_pushes_is_found() -> None:
    bench = Bench(RigidCheat(fleeting_kernel(reverses)))
    claims = check(bench, "friction_opposes_slip")
    assert sum(not claim.holds for claim in claims) >= 2


def beyond_the_cone(normal, friction_coefficient):
    return 1.1 * friction_coefficient * normal


def negative_in_slip(normal, slip, friction_coefficient):
    return (-1.0 if normal > 10.0 and slip != 0.0 else 1.0) * friction_coefficient * normal


def no_number(normal):
    return np.nan if normal > 10.0 else 0.0


@pytest.mark.parametrize("cheat", [beyond_the_cone, negative_in_slip, no_number])
def test_a_wrong_bound_of_a_rigid_contact_is_found(cheat: Callable[..., Any]) -> None:
    bench = Bench(RigidCheat(bounding=fleeting_kernel(cheat)))
    assert not all(claim.holds for claim in check(bench, "kernel_is_consistent"))


@pytest.mark.parametrize("mu", [0.0, 0.05, 0.3, 1.0, 5.0])
@pytest.mark.parametrize("law", RIGID, ids=lambda law: law.name)
def test_no_law_of_the_package_fails_for_what_has_no_answer(law: Any, mu: float) -> None:
    bench = Bench(law(friction_coefficient=mu))
    assert [str(claim) for claim in check(bench, "kernel_is_consistent") if not claim.holds] == []


def test_a_law_that_raises_fails_with_its_error() -> None:
    def raises(d_nn: float) -> Any:
        raise ZeroDivisionError("by nothing")

    (claim,) = check(Bench(RigidCheat(raises)), "kernel_is_consistent")
    assert not claim.holds
    assert "ZeroDivisionError" in claim.statement


@final
@dataclass(frozen=True)
class Declaring(MultiplierLaw):
    """The law with stick, with wrong declarations."""

    name: ClassVar[str] = "declaring"
    equation: ClassVar[str] = "that of lagrange_stick"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 5e-8
    convergence_order: ClassVar[float] = 2.0
    violations: ClassVar[Mapping[str, str]] = MappingProxyType(
        {"mirrors": "it does not say why", "is_pretty": "it is not"}
    )

    friction_coefficient: float = 0.3

    @property
    def impact(self) -> Kernel:
        return LagrangeStick(self.friction_coefficient).impact


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("declares_its_parameters", "parameters without declaration ['friction_coefficient']"),
        ("declares_what_it_breaks", "['is_pretty']"),
        ("converges", "order of convergence"),
        ("mirrors", "HOLDS, declared broken"),
    ],
)
def test_a_false_declaration_is_found(name: str, reason: str) -> None:
    class Contract(LawContract):
        law = Declaring()

    with pytest.raises(AssertionError) as failure:
        Contract().assert_property(name)
    assert reason in str(failure.value)
