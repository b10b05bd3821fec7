"""The contract of every law and part of the package, of the laws of the plants, and in another project."""

import subprocess
import sys
from pathlib import Path

import pytest
from support.tensile_dashpot import TensileDashpot

from contactlab.laws import LAWS, HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.laws.composed import Composed
from contactlab.laws.damping import DAMPINGS, Flores, LinearDamping
from contactlab.laws.friction import FRICTIONS, AgeingStick, Coulomb, LuGre, Microslip, Mindlin
from contactlab.laws.normal import NORMAL_FORCES, Line, Linear, WaltonBraun
from contactlab.testing import LawContract
from contactlab.testing.contract import PROPERTIES

HELD = {
    "hertz_penalty": HertzPenalty(stiffness=1e10, friction_coefficient=0.3),
    "hertz_penalty_without_friction": HertzPenalty(stiffness=1e9, friction_coefficient=0.0),
    "lagrange_stick": LagrangeStick(friction_coefficient=0.3),
    "lagrange_stick_with_much_friction": LagrangeStick(friction_coefficient=0.8),
    "lagrange_slip": LagrangeSlip(friction_coefficient=0.3),
    "spring_dashpot": Composed(Linear(1e7), LinearDamping(0.95), Coulomb(0.3, static_ratio=1.5)),
    "tensile_dashpot": TensileDashpot(stiffness=1e7, damping=5.0),
    "newton": LAWS["newton"](friction_coefficient=0.3, restitution=0.5),
    "poisson": LAWS["poisson"](friction_coefficient=0.3, restitution=0.5),
    "stronge": LAWS["stronge"](friction_coefficient=0.3, restitution=0.5),
    "stronge_without_loss": LAWS["stronge"](friction_coefficient=0.3, restitution=1.0),
    "moreau_jean": LAWS["moreau_jean"](friction_coefficient=0.3, restitution=0.5),
    "brach": LAWS["brach"](friction_coefficient=0.3, restitution=0.5),
    "chatterjee_ruina": LAWS["chatterjee_ruina"](friction_coefficient=0.3, tangential_restitution=0.4),
    "johnson": LAWS["johnson"](friction_coefficient=0.3),
    "lagrange_ageing": LAWS["lagrange_ageing"](friction_coefficient=0.3),
    "archard": LAWS["archard"](friction_coefficient=0.3),
    # Each part in a law that is Hertz and Coulomb but for it.
    **{f"normal_{name}": Composed(normal=part()) for name, part in NORMAL_FORCES.items()},
    **{f"damping_{name}": Composed(damping=part()) for name, part in DAMPINGS.items()},
    **{f"friction_{name}": Composed(friction=part()) for name, part in FRICTIONS.items()},
    # Each internal variable is changed by itself, and of twelve rings there are many.
    "friction_microslip": Composed(friction=Microslip(rings=3)),
    "walton_braun_ageing_stick": Composed(WaltonBraun(), friction=AgeingStick()),
    "line_flores_mindlin": Composed(Line(), Flores(0.6), Mindlin(0.2)),
    "hertz_linear_lugre": Composed(damping=LinearDamping(0.7), friction=LuGre(0.4, 1.3)),
}

LONG = {
    "hertz_penalty_without_friction",
    "spring_dashpot",
    "walton_braun_ageing_stick",
    "lagrange_stick_with_much_friction",
    "stronge_without_loss",
    "line_flores_mindlin",
    "hertz_linear_lugre",
}
"""Of the same classes as others, at other values or together."""

for _name, _law in HELD.items():
    _tests = type(f"Test_{_name}", (LawContract,), {"law": _law})
    globals()[f"Test_{_name}"] = pytest.mark.long(_tests) if _name in LONG else _tests


def test_no_law_of_the_package_is_left_out() -> None:
    assert {law.name for law in HELD.values()} >= set(LAWS)


ELSEWHERE = """\
from contactlab.laws import LagrangeStick
from contactlab.testing import LawContract

class TestIt(LawContract):
    law = LagrangeStick(friction_coefficient=0.2)

class TestOnAnotherMotor(LawContract):
    law = LagrangeStick(friction_coefficient=0.2)
    make_motor = staticmethod(lambda: 1 / 0)
"""


@pytest.mark.long
def test_another_project_has_the_contract_in_three_lines_and_may_bring_its_motor(tmp_path: Path) -> None:
    (tmp_path / "test_it.py").write_text(ELSEWHERE)
    command = [sys.executable, "-m", "pytest", "-q", "-rp", "-p", "no:cacheprovider", "test_it.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stdout.count("PASSED test_it.py::TestIt::") == len(PROPERTIES) >= 16
    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stdout
