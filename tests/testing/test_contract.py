"""The contract of every law and part of the package, and how it fails; test_saboteurs.py has what."""

from dataclasses import replace
from typing import Any

import pytest
from support.tensile_dashpot import TensileDashpot

from contactlab.laws import LAWS, PARTS, HertzPenalty, LagrangeSlip, LagrangeStick, MultiplierLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import Flores, LinearDamping
from contactlab.laws.friction import AgeingStick, Coulomb, LuGre, Microslip, Mindlin
from contactlab.laws.normal import Line, Linear, WaltonBraun
from contactlab.testing import LawContract, plants
from contactlab.testing.contract import check
from contactlab.testing.plants import Bench, attempt
from contactlab.trajectory import Ending, Trajectory

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
    # Each part in a law that is Hertz and Coulomb but for it, as that of the default of every family is.
    **{
        f"{family}_{name}": Composed(**{family: part()})
        for family, parts in PARTS.items()
        for name, part in parts.items()
        if name not in ("none", "coulomb")
    },
    # Each internal variable is changed by itself, and of twelve rings there are many.
    "friction_microslip": Composed(friction=Microslip(rings=3)),
    "walton_braun_ageing_stick": Composed(WaltonBraun(), friction=AgeingStick()),
    "line_flores_mindlin": Composed(Line(), Flores(0.6), Mindlin(0.2)),
    "coulomb_with_viscous_friction": Composed(viscous_friction=2.0),
    "mindlin_with_viscous_friction": Composed(friction=Mindlin(0.3), viscous_friction=2.0),
    "mindlin_with_a_dashpot": Composed(friction=Mindlin(0.3, viscous_time=1e-6)),
    "hertz_linear_lugre": Composed(damping=LinearDamping(0.7), friction=LuGre(0.4, 1.3)),
}

RIGID = [law for law in LAWS.values() if issubclass(law, MultiplierLaw)]

LONG = {
    "hertz_penalty_without_friction",
    "spring_dashpot",
    "walton_braun_ageing_stick",
    "lagrange_stick_with_much_friction",
    "stronge_without_loss",
    "line_flores_mindlin",
    "mindlin_with_viscous_friction",
    "hertz_linear_lugre",
}
"""Of the same classes as others, at other values or together."""

for _name, _law in HELD.items():
    _tests = type(f"Test_{_name}", (LawContract,), {"law": _law})
    globals()[f"Test_{_name}"] = pytest.mark.long(_tests) if _name in LONG else _tests


def test_no_law_of_the_package_is_left_out() -> None:
    assert {law.name for law in HELD.values()} >= set(LAWS)


def test_a_law_may_bring_its_motor() -> None:
    class Elsewhere(LawContract):
        law = LagrangeStick(friction_coefficient=0.2)
        make_motor = staticmethod(lambda: 1 / 0)

    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        Elsewhere().assert_property("converges")


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


@pytest.mark.parametrize("mu", [0.0, 0.05, 0.3, 1.0, 5.0])
@pytest.mark.parametrize("law", RIGID, ids=lambda law: law.name)
def test_no_law_of_the_package_fails_for_what_has_no_answer(law: Any, mu: float) -> None:
    bench = Bench(law(friction_coefficient=mu))
    assert [str(claim) for claim in check(bench, "kernel_is_consistent") if not claim.holds] == []
