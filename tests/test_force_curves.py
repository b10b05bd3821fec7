"""Claims on force curves: equilibria of a law with a cantilever, and where the tip jumps."""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from support.normal_balance import forces

import contactlab as cl

R, E, W = 20e-9, 1e9, 0.05
"""Radius [m], effective modulus [Pa] and work of adhesion [J/m^2]."""

PULL = 2.0 * np.pi * W * R
DOWN = np.linspace(12e-9, -6e-9, 901)
CYCLE = np.append(DOWN, DOWN[::-1])


def jkr_at(radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depth [m] and force [N] at a contact radius [m], as Johnson, Kendall and Roberts have them."""
    depth = radius**2 / R - np.sqrt(2.0 * np.pi * W * radius / E)
    return depth, 4.0 * E * radius**3 / (3.0 * R) - np.sqrt(8.0 * np.pi * W * E * radius**3)


@pytest.mark.parametrize("stiffness", [0.5, 1.0, 30.0])
def test_a_jkr_tip_jumps_in_at_the_touch_and_off_at_the_fold(stiffness: float) -> None:
    """The branch of contact is that of the contact radii from the deepest one to the fold of the base."""
    radius = np.linspace(1e-10, 3e-8, 2_000_001)
    depth, force = jkr_at(radius)
    base = -depth - force / stiffness
    # A depth belongs to the larger radius.
    stable = radius >= radius[np.argmin(depth)]
    fold = np.argmax(np.where(stable, base, -np.inf))
    branch, height = base[fold:][::-1], force[fold:][::-1]
    contact = np.append(DOWN <= 0.0, DOWN[::-1] <= base[fold])
    exact = np.where(contact, np.interp(CYCLE, branch, height), 0.0)
    measured = cl.force_curve(cl.Composed(cl.Jkr(R, E, W)), CYCLE, cantilever_stiffness=stiffness)
    assert base[fold] < 12e-9
    # Next to the fold a step of the radius moves the force by its root.
    assert_allclose(measured, exact, atol=1e-5 * PULL)


@pytest.mark.parametrize("stiffness", [None, 0.2, 5.0])
def test_a_spring_is_in_series_with_the_cantilever(stiffness: float | None) -> None:
    series = 1.0 / (1.0 / 3.0 + (0.0 if stiffness is None else 1.0 / stiffness))
    force = cl.force_curve(cl.Composed(cl.Linear(3.0)), CYCLE, cantilever_stiffness=stiffness)
    assert_allclose(force, series * np.maximum(-CYCLE, 0.0), atol=1e-9 * force.max())


def test_a_hertz_contact_is_in_balance_with_the_deflection() -> None:
    stiffness, k = 4.0 / 3.0 * E * np.sqrt(R), 0.7
    depths = [
        brentq(lambda d, y=y: stiffness * d**1.5 + k * (d + y), 0.0, -y, xtol=1e-22) if y < 0.0 else 0.0
        for y in CYCLE
    ]
    force = cl.force_curve(cl.HertzPenalty(stiffness), CYCLE, cantilever_stiffness=k)
    assert_allclose(force, stiffness * np.array(depths) ** 1.5, atol=1e-9 * force.max())


def test_a_dmt_tip_is_pulled_off_once_the_cantilever_bears_the_whole_pull() -> None:
    """Its contact is stable up to a gap of zero, at the base's position 2 pi w R/k."""
    k = 1.0
    force = cl.force_curve(cl.Composed(cl.Dmt(R, E, W)), CYCLE, cantilever_stiffness=k)
    touches = force != 0.0
    assert np.array_equal(touches, np.append(DOWN <= 0.0, DOWN[::-1] <= PULL / k))
    assert_allclose(force.min(), -PULL, rtol=0.01)


@pytest.mark.parametrize(("number", "error"), [(0.1, 1e-3), (1.0, 1e-6), (20.0, 1e-6)])
@pytest.mark.parametrize("stiffness", [None, 1.0])
def test_wherever_the_tip_touches_the_law_has_its_force_at_its_gap(
    number: float, error: float, stiffness: float | None
) -> None:
    """Next to the kink where the middles meet, which Tabor numbers below 0.811 have, the spline errs more."""
    part = cl.Maugis(R, E, W, number)
    force = cl.force_curve(cl.Composed(part), CYCLE, cantilever_stiffness=stiffness)
    gap = CYCLE + (0.0 if stiffness is None else force / stiffness)
    touches = np.flatnonzero(force)
    own = [forces(part, -gap[row])[0] for row in touches]
    assert_allclose(force[touches], own, atol=error * PULL)
    begins, ends = part.evaluate("limits")
    assert (gap[touches] <= ends).all()
    assert (gap[: DOWN.size][force[: DOWN.size] == 0.0] > begins).all()


def test_a_rigid_cycle_loses_what_breaks_the_neck() -> None:
    """Johnson, Kendall and Roberts: 7.09 (w^5 R^4/E*^2)^(1/3)."""
    fine = np.linspace(1e-9, -1e-9, 200_001)
    force = cl.force_curve(cl.Composed(cl.Jkr(R, E, W)), np.append(fine, fine[::-1]))
    lost = -np.trapezoid(force, np.append(fine, fine[::-1]))
    assert_allclose(lost, 7.09 * (W**5 * R**4 / E**2) ** (1.0 / 3.0), rtol=2e-3)


def test_baseline_and_tilt_add_and_the_contact_point_shifts() -> None:
    law, z = cl.Composed(cl.Jkr(R, E, W)), CYCLE + 50e-9
    shifted = cl.force_curve(
        law, z, contact_point="50 nm", baseline="0.2 nN", tilt=-0.01, cantilever_stiffness=1.0
    )
    plain = cl.force_curve(law, CYCLE, cantilever_stiffness=1.0)
    assert_allclose(shifted, 2e-10 - 0.01 * (z - z[0]) + plain, atol=1e-9 * PULL)


def test_a_tip_that_is_never_near_is_free_and_one_that_begins_in_contact_is_not() -> None:
    law = cl.Composed(cl.Jkr(R, E, W))
    assert not cl.force_curve(law, DOWN + 20e-9, cantilever_stiffness=1.0).any()
    retraction = cl.force_curve(law, DOWN[::-1], cantilever_stiffness=1.0)
    assert_allclose(retraction, cl.force_curve(law, CYCLE, cantilever_stiffness=1.0)[DOWN.size :])


@dataclass(frozen=True)
class Pulling(cl.PenaltyLaw):
    """A law that pulls by more the deeper the tip is."""

    name = "pulling"
    equation = "N = -k d"
    source = "this test"
    default_contact_step = 1e-6
    allows_tension = True
    stiffness: Annotated[float, cl.Parameter("k", "N m-1", "stiffness", above=0.0)] = 2.0

    @staticmethod
    def force(depth, stiffness):
        return -stiffness * depth, 0.0, -0.5 * stiffness * depth * depth, 0.0


def test_a_law_that_pulls_more_than_the_cantilever_holds_has_no_equilibrium() -> None:
    with pytest.raises(ValueError, match="cantilever_stiffness"):
        cl.force_curve(Pulling(), DOWN, cantilever_stiffness=1.0)
    assert_allclose(cl.force_curve(Pulling(), DOWN, cantilever_stiffness=4.0).min(), -2.4e-8, rtol=1e-6)


@pytest.mark.parametrize(
    ("law", "options", "word"),
    [
        (cl.Newton(), {}, "newton"),
        (cl.Composed(cl.Thornton()), {}, "thornton"),
        (cl.Composed(), {"cantilever_stiffness": -1.0}, "cantilever_stiffness"),
        (cl.Composed(), {"tilt": np.inf}, "tilt"),
    ],
)
def test_what_has_no_force_curve_is_refused(law: Any, options: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        cl.force_curve(law, DOWN, **options)
