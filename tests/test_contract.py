"""The contract of every law that comes with the package, and of the laws that prove the engine."""

from contactlab.laws import LAWS, HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.testing import LawContract
from contactlab.testing.laws import HuntCrossley, NewtonRestitution, SpringDashpot, TensileDashpot


class TestHertzPenalty(LawContract):
    law = HertzPenalty(stiffness=1e10, friction_coefficient=0.3)


class TestHertzPenaltyWithoutFriction(LawContract):
    law = HertzPenalty(stiffness=1e9, friction_coefficient=0.0)


class TestLagrangeStick(LawContract):
    law = LagrangeStick(friction_coefficient=0.3)


class TestLagrangeStickWithMuchFriction(LawContract):
    law = LagrangeStick(friction_coefficient=0.8)


class TestLagrangeSlip(LawContract):
    law = LagrangeSlip(friction_coefficient=0.3)


class TestSpringDashpot(LawContract):
    law = SpringDashpot(stiffness=1e7, damping=5.0, static_friction=0.4, kinetic_friction=0.3)


class TestTensileDashpot(LawContract):
    law = TensileDashpot(stiffness=1e7, damping=5.0)


class TestHuntCrossley(LawContract):
    law = HuntCrossley(stiffness=1e10, loss=0.5, friction_coefficient=0.3)


class TestNewtonRestitution(LawContract):
    law = NewtonRestitution(friction_coefficient=0.3, restitution=0.5)


def test_no_law_of_the_package_is_left_out() -> None:
    held = {contract.law.name for contract in LawContract.__subclasses__()}
    assert held >= set(LAWS)
