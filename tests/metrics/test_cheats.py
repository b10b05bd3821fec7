"""Laws that cheat on purpose: each fails on exactly its line."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
import pytest
import xarray
from support.motors import hertz
from support.plausibility_runs import of_law

from contactlab.compiled import kernel
from contactlab.laws import ContactLaw, LagrangeStick, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import MultiplierKernel, PenaltyKernel
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.lagrange_stick import stick_or_slip_impulse
from contactlab.metrics import FAIL, METRICS, PASS, assess

STIFFNESS = 1e10
PUMP = 0.2
"""Of N = K d^1.5 (1 + PUMP g_dot) [s/m]: weaker on the way in than on the way out."""
ADHESION = 3e6
"""Of N = K d^1.5 - ADHESION d [N/m]: it pulls where d is below (ADHESION / K)^2, 90 nm."""
REACH = 1.5
"""Friction over what the coefficient allows."""
CREEP = 1e5
"""Slip that a friction impulse leaves in stick [1/kg]."""


@kernel
def pump_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> tuple[float, float, float, float]:
    elastic = STIFFNESS * max(-gap, 0.0) ** 1.5
    normal = elastic * (1.0 + PUMP * gap_rate)
    stored = 0.4 * STIFFNESS * max(-gap, 0.0) ** 2.5
    return normal, parameters[0] * normal, stored, (elastic - normal) * gap_rate


@kernel
def pulling_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> tuple[float, float, float, float]:
    normal = STIFFNESS * max(-gap, 0.0) ** 1.5 + ADHESION * gap
    stored = 0.4 * STIFFNESS * max(-gap, 0.0) ** 2.5 - 0.5 * ADHESION * gap * gap
    return normal, 0.0, stored, 0.0


@kernel
def reaching_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: np.ndarray
) -> tuple[float, float, float, float]:
    normal = STIFFNESS * max(-gap, 0.0) ** 1.5
    return normal, REACH * parameters[0] * normal, 0.4 * STIFFNESS * max(-gap, 0.0) ** 2.5, 0.0


@kernel
def drifting_impulse(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: np.ndarray,
) -> tuple[float, float, int]:
    # What sticks gives way in proportion to its friction, and calls it stick all the same.
    return stick_or_slip_impulse(
        normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt + CREEP, parameters
    )


@final
@dataclass(frozen=True)
class Pump(PenaltyLaw):
    """Gives back more than it took."""

    name: ClassVar[str] = "pump"
    equation: ClassVar[str] = "N = K d^1.5 (1 + c g_dot)"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def force(self) -> PenaltyKernel:
        return pump_force


@final
@dataclass(frozen=True)
class Pulling(PenaltyLaw):
    """Pulls before it pushes, without friction."""

    name: ClassVar[str] = "pulling"
    equation: ClassVar[str] = "N = K d^1.5 - c d"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6
    allows_tension: ClassVar[bool] = True

    @property
    def force(self) -> PenaltyKernel:
        return pulling_force


@final
@dataclass(frozen=True)
class Reaching(PenaltyLaw):
    """Rubs harder than its coefficient allows."""

    name: ClassVar[str] = "reaching"
    equation: ClassVar[str] = "|F| <= 1.5 mu N"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def force(self) -> PenaltyKernel:
        return reaching_force


@final
@dataclass(frozen=True)
class Drifting(MultiplierLaw):
    """Creeps while it says that it sticks."""

    name: ClassVar[str] = "drifting"
    equation: ClassVar[str] = "v = -c p_t in stick"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 5e-8
    exact_stick: ClassVar[bool] = False

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def solve(self) -> MultiplierKernel:
        return drifting_impulse


CHEATS = {
    "normal_gain": Pump(),
    "tension": Pulling(),
    "cone_excess": Reaching(),
    "stick_slip": Drifting(),
}


STICKING = {"rotor": {"initial_velocity": -2.0, "load_torque": -5e-3}}
"""Near its steady state the motor sticks in lasting contact too, which the drift needs to show."""


def failed(tree: xarray.DataTree) -> list[str]:
    return [key for key, value in assess(tree).items() if METRICS[key].verdict(value) == FAIL]


@pytest.mark.parametrize("interval", [1e-6, 1e-7])
@pytest.mark.parametrize("line", CHEATS)
def test_a_law_that_cheats_fails_on_exactly_its_line(line: str, interval: float) -> None:
    assert failed(of_law(CHEATS[line], interval, **STICKING)) == [line]


@pytest.mark.parametrize("law", [hertz(), LagrangeStick(0.3)], ids=lambda law: law.name)
def test_the_honest_laws_fail_none(law: ContactLaw) -> None:
    tree = of_law(law, **STICKING)
    assert failed(tree) == []
    assert METRICS["stick_slip"].verdict(assess(tree)["stick_slip"]) == PASS


def tampered(changes: dict[str, float], group: str = "") -> xarray.DataTree:
    """An honest run in which one number of a variable, the largest, is replaced by a multiple of itself."""
    tree = of_law(hertz(), **STICKING).copy(deep=True)
    node = tree[group] if group else tree
    for name, factor in changes.items():
        values = node[name].values
        values[values.argmax()] *= factor
    return tree


@pytest.mark.parametrize(
    ("changes", "group", "line"),
    [
        ({"energy_loss": -1.0}, "contacts", "contact_gain"),
        ({"normal_impulse": 1.1}, "contacts", "impulse_balance"),
        ({"max_penetration": 1e3}, "contacts", "penetration_over_radius"),
        ({"strain_energy": 2.0}, "", "energy_residual"),
    ],
)
def test_a_dataset_that_is_tampered_with_fails_on_exactly_its_line(
    changes: dict[str, float], group: str, line: str
) -> None:
    assert failed(tampered(changes, group)) == [line]


def test_a_rotor_that_is_turned_by_hand_fails_its_momentum_alone() -> None:
    tree = of_law(hertz(), **STICKING).copy(deep=True)
    tree["rotor_velocity"].values[-1] *= 1.01
    assert failed(tree) == ["rotor_momentum"]
