"""Laws that cheat on purpose: each fails on exactly its line."""

from dataclasses import dataclass
from typing import Annotated, final

import pytest
import xarray
from support.configurations import of_law

from contactlab.compiler.kernels import kernel
from contactlab.laws import LagrangeStick, PenaltyLaw
from contactlab.laws.base import STICK
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.metrics import FAIL, METRICS, PASS, assess

STIFFNESS = 1e10
PUMP = 0.2
"""Of N = K d^1.5 (1 + PUMP g_dot) [s/m]: weaker on the way in than on the way out."""
ADHESION = 3e6
"""Of N = K d^1.5 - ADHESION d [N/m]: it pulls where d is below (ADHESION / K)^2, 90 nm."""
REACH = 1.5
"""Friction over what the coefficient allows."""
CREEP = 1e-3
"""Slip over the friction force in stick [m/s/N]."""


@kernel
def honest(gap: float) -> tuple[float, float]:
    """Force [N] and stored energy [J] of the honest law."""
    depth = max(-gap, 0.0)
    return STIFFNESS * depth**1.5, 0.4 * STIFFNESS * depth**2.5


@final
@dataclass(frozen=True)
class Pump(PenaltyLaw):
    """Gives back more than it took."""

    name = "pump"
    equation = "N = K d^1.5 (1 + c g_dot)"
    source = "this test"
    default_contact_step = 4e-6

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, parameters):
        elastic, stored = honest(gap)
        normal = elastic * (1.0 + PUMP * gap_rate)
        return normal, parameters[0] * normal, stored, (elastic - normal) * gap_rate


@final
@dataclass(frozen=True)
class Pulling(PenaltyLaw):
    """Pulls before it pushes, without friction."""

    name = "pulling"
    equation = "N = K d^1.5 - c d"
    source = "this test"
    default_contact_step = 4e-6
    allows_tension = True

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, parameters):
        elastic, stored = honest(gap)
        return elastic + ADHESION * gap, 0.0, stored - 0.5 * ADHESION * gap * gap, 0.0


@final
@dataclass(frozen=True)
class Reaching(PenaltyLaw):
    """Has more friction than its coefficient allows."""

    name = "reaching"
    equation = "|F| <= 1.5 mu N"
    source = "this test"
    default_contact_step = 4e-6

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, parameters):
        normal, stored = honest(gap)
        return normal, REACH * parameters[0] * normal, stored, 0.0


CHEATS = {"normal_gain": Pump(), "tension": Pulling(), "cone_excess": Reaching()}


STICKING = {"rotor": {"initial_velocity": -2.0, "load_torque": -5e-3}}
"""Near its steady state the motor sticks in lasting contact too, which the drift needs to show."""


def failed(tree: xarray.DataTree) -> list[str]:
    return [key for key, value in assess(tree).items() if METRICS[key].verdict(value) == FAIL]


@pytest.mark.parametrize("interval", [1e-6, 1e-7])
@pytest.mark.parametrize("line", CHEATS)
def test_a_law_that_cheats_fails_on_exactly_its_line(line: str, interval: float) -> None:
    assert failed(of_law(CHEATS[line], interval, None, **STICKING)) == [line]


def test_a_stick_that_creeps_fails_on_exactly_its_line() -> None:
    tree = of_law(LagrangeStick(0.3), **STICKING)
    assert METRICS["stick_slip"].verdict(assess(tree)["stick_slip"]) == PASS
    sticks = tree["contact_mode"].values == STICK
    tree["slip_velocity"].values[sticks] += CREEP * tree["friction_force"].values[sticks]
    assert failed(tree) == ["stick_slip"]
