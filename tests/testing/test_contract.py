"""The contract of every law that comes with the package, and of the laws that prove the engine."""

import subprocess
import sys
from pathlib import Path

from contactlab.laws import (
    LAWS,
    HertzPenalty,
    LagrangeSlip,
    LagrangeStick,
    MoreauJean,
    Newton,
    Poisson,
    Stronge,
)
from contactlab.testing import LawContract
from contactlab.testing.laws import SpringDashpot, TensileDashpot


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


class TestNewton(LawContract):
    law = Newton(friction_coefficient=0.3, restitution=0.5)


class TestPoisson(LawContract):
    law = Poisson(friction_coefficient=0.3, restitution=0.5)


class TestStronge(LawContract):
    law = Stronge(friction_coefficient=0.3, restitution=0.5)


class TestStrongeWithoutLoss(LawContract):
    law = Stronge(friction_coefficient=0.3, restitution=1.0)


class TestMoreauJean(LawContract):
    law = MoreauJean(friction_coefficient=0.3, restitution=0.5)


def test_no_law_of_the_package_is_left_out() -> None:
    held = {contract.law.name for contract in LawContract.__subclasses__()}
    # A composed law is as good as its parts, which have tests of their own.
    assert held >= set(LAWS) - {"composed"}


ELSEWHERE = """\
from contactlab.laws import {law}
from contactlab.testing import LawContract

class TestIt(LawContract):
    law = {law}(friction_coefficient=0.2)
    {more}
"""


def run_elsewhere(folder: Path, law: str, more: str = "") -> tuple[int, str]:
    """Exit status and output of pytest on three lines in another folder."""
    (folder / "test_it.py").write_text(ELSEWHERE.format(law=law, more=more))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_it.py"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout


def test_another_project_has_the_contract_in_three_lines(tmp_path: Path) -> None:
    status, out = run_elsewhere(tmp_path, "LagrangeStick")
    assert status == 0
    assert "16 passed" in out


def test_a_law_that_the_motor_does_not_suit_brings_its_own(tmp_path: Path) -> None:
    status, out = run_elsewhere(
        tmp_path, "LagrangeStick", "make_motor = staticmethod(lambda: 1 / 0)"
    )
    assert status == 1
    assert "ZeroDivisionError" in out
