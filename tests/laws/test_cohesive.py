"""Coulomb's cone with cohesion: what it holds and how it slides, pressed and pulled."""

from dataclasses import dataclass
from math import pi
from typing import Annotated, Any

import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from support.closed_forms import SPRING, WEIGHT, resting

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.composed import Composed
from contactlab.laws.friction import Cohesive
from contactlab.laws.normal import Dmt, Jkr, Linear
from contactlab.parameter import positive
from contactlab.testing.plants import block, last, run

MU, RATIO, C = 0.3, 1.4, 4.0


@kernel
def attracted_force(depth, stiffness, attraction):
    stored = (0.5 * stiffness * depth - attraction) * depth
    return stiffness * depth - attraction, stored, stiffness, 0.0


@dataclass(frozen=True)
class Attracted(NormalForce):
    """A spring and a constant attraction, N = k d - P."""

    name = "attracted"
    equation = "N = k d - P"
    source = "this test"
    allows_tension = True

    stiffness: Annotated[float, positive("k", "N m-1", "stiffness")] = SPRING
    attraction: Annotated[float, positive("P", "N", "pull-off force")] = 3.0

    @property
    def elastic(self) -> Any:
        return attracted_force


def test_the_bound_is_a_cone_with_its_apex_at_the_cohesion() -> None:
    friction = Cohesive(MU, RATIO, C)
    assert friction.friction_offset == C
    assert friction.friction_limit == MU * RATIO
    for normal, slip, expected in (
        (2.0, 0.0, MU * RATIO * (2.0 + C)),
        (2.0, 1e-300, MU * (2.0 + C)),
        (0.0, 1.0, MU * C),
        (-3.0, 1.0, MU * (C - 3.0)),
        (-5.0, 0.0, 0.0),
    ):
        assert friction.evaluate("bound", normal=normal, slip=slip) == pytest.approx(expected, rel=1e-15)
        assert friction.evaluate("bound", normal=normal, slip=-slip) == friction.evaluate(
            "bound", normal=normal, slip=slip
        )


@pytest.mark.parametrize(("share", "moves"), [(0.999, False), (1.001, True)])
def test_a_block_holds_up_to_mu_s_of_weight_and_cohesion(share: float, moves: bool) -> None:
    push = share * MU * RATIO * (WEIGHT + C)
    assert push > 1.3 * MU * RATIO * WEIGHT
    law = Composed(Linear(SPRING), friction=Cohesive(MU, RATIO, C))
    slip = last(run(resting(push=push), law, 0.01, 1e-3), "slip_velocity")
    assert_allclose(slip, 0.01 * (push - MU * (WEIGHT + C)) if moves else 0.0, rtol=1e-6, atol=1e-15)


def test_a_block_that_hangs_from_its_attraction_still_rubs() -> None:
    """Thornton (1991): |F| = mu (N + 2 F_c), here N = -2 N with F_c = 3 N."""
    pull, normal, start = 2.0, Attracted(), 0.05
    law = Composed(normal, friction=Cohesive(MU, RATIO, 2.0 * normal.attraction))
    depth = (normal.attraction - pull) / normal.stiffness
    made = run(block(1.0, height=-depth, weight=-pull, velocity=start), law, 0.02, 1e-3, 0.01)
    slowing = MU * (2.0 * normal.attraction - pull)
    assert_allclose(made.series["slip_velocity"], start - slowing * made.time, atol=1e-9)
    assert_allclose(made.series["normal_force"][1:], -pull, rtol=1e-9)


@pytest.mark.parametrize("velocity", [0.01, 0.0])
@pytest.mark.parametrize("kind", [Jkr, Dmt])
def test_adhesion_without_load_leaves_the_friction_of_the_cohesion(kind: type, velocity: float) -> None:
    """What slides at N = 0, or under next to no load, is dragged by mu C (Thornton 1991)."""
    part = kind(radius=1e-3, effective_modulus=10e9, work_of_adhesion=0.05)
    pull_off = (1.5 if kind is Jkr else 2.0) * pi * 0.05 * 1e-3
    law = Composed(part, friction=Cohesive(MU, cohesion=2.0 * pull_off))
    for share in (0.0, 1e-12, -1e-9, 0.5, -0.5):

        def excess(depth: float, load: float = share * pull_off) -> float:
            return float(part.evaluate("elastic", depth=depth)[0]) - load

        depth = brentq(excess, 0.0 if kind is Dmt else -2e-9, 1e-6, xtol=1e-30)
        for tolerance in (1e-7, 1e-9):
            motor = block(1e-3, height=-depth, velocity=velocity, weight=share * pull_off)
            result = run(motor, law, 1e-4, tolerance=tolerance)
            expected = -MU * (2.0 + share) * pull_off if velocity else 0.0
            assert last(result, "friction_force") == pytest.approx(expected, rel=1e-9, abs=1e-15)
            assert result.statistics["contact_steps"] < 100
