"""The tolerance is a promise for every compliant law, and a run states its own error."""

from collections.abc import Iterator
from functools import cache
from itertools import combinations, product
from math import exp, pi, sqrt

import numpy as np
import pytest
from support.motors import default_motor

import contactlab as cl
from contactlab.arrays import Array
from contactlab.laws.base import Part
from contactlab.laws.registry import PARTS
from contactlab.motor.motor import Motor
from contactlab.results.netcdf import to_datatree
from contactlab.testing.plants import block, completed, first, run
from contactlab.trajectory import Trajectory

SIGMA = 20.0
"""Viscous friction of every law here [N s/m]."""

DURATION = 8e-4
"""Three contacts of the free motor [s]."""

TOLERANCES = [10.0**-k for k in range(5, 11)]

MOST = 100.0
"""Error over the tolerance and the normal impulse."""

ROUND_OFF = 1e-12
"""Of an impulse, relative to all of it."""

FREE, PRESSED = {}, {"rotor_mass": 0.05, "preload": 5.0, "bearing_damping": 300.0}


@cache
def every() -> tuple[cl.Composed, ...]:
    """Every normal force with every damping that it takes and every friction, viscous friction beside it.

    Left out is what says of itself that it does not keep the tolerance.
    """
    return tuple(_every())


def _every() -> Iterator[cl.Composed]:
    for names in product(*PARTS.values()):
        parts: list[Part] = [PARTS[family][name]() for family, name in zip(PARTS, names, strict=True)]
        try:
            law = cl.Composed(*parts, viscous_friction=SIGMA)  # type: ignore[arg-type]
        except ValueError:
            continue
        if law.keeps_tolerance:
            yield law


@cache
def covering(number: int) -> tuple[cl.Composed, ...]:
    """Composed laws that together have whatever `number` parts of one law there are."""
    has = {law: set(combinations(names_of(law), number)) for law in every()}
    left, chosen = set().union(*has.values()), []
    while left:
        chosen.append(max(reversed(every()), key=lambda law: len(left & has[law])))
        left -= has[chosen[-1]]
    return tuple(chosen)


def names_of(law: cl.Composed) -> list[tuple[str, str]]:
    """Family and name of the parts."""
    return [(part.family, part.name) for part in law.parts]


@cache
def typical() -> tuple[cl.Composed, ...]:
    """Composed laws that have every part once, the friction without viscous friction as well.

    And a spring along the slip on a normal stiffness that has kinks, and a patch whose limits hang on more
    than the depth.
    """
    chosen = covering(1)
    alone = (cl.Composed(friction=law.friction) for law in chosen)
    patch, spring = cl.Microslip(), cl.Composed(cl.Lining(), friction=cl.Mindlin())
    return (
        *chosen,
        *alone,
        spring,
        cl.Composed(damping=cl.Tsuji(), friction=patch),
        cl.Composed(cl.Line(), friction=patch),
    )


def called(law: cl.Composed) -> str:
    """The names of the parts, and whether there is viscous friction."""
    return "-".join(part.name for part in law.parts) + ("-viscous" if law.viscous_friction else "")


def impulses(motor: Motor, made: Trajectory) -> Array:
    """The friction impulse that the rotor shows, and both impulses of the contacts [N s]."""
    velocity = made.series["rotor_velocity"][-1]
    of_rotor = velocity * motor.rotor.inertia / motor.geometry.rotor_radius
    return np.array([of_rotor, *(made.contacts[f"{way}_impulse"].sum() for way in ("normal", "friction"))])


def check(law: cl.Composed, pressed: bool) -> None:
    """Hold errors to the tolerance, and what the runs state of them to the errors."""
    motor = default_motor(**(PRESSED if pressed else FREE))
    step = 0.25 * law.default_contact_step
    expected = impulses(motor, run(motor, law, DURATION, contact_step=step, tolerance=1e-12))
    scale = abs(expected[1])
    for tolerance in TOLERANCES:
        made = run(motor, law, DURATION, tolerance=tolerance)
        error = float(np.abs(impulses(motor, made) - expected).max())
        assert error <= MOST * tolerance * scale, f"{error / scale / tolerance:.3g} at {tolerance:g}"
        assert error <= made.impulse_error + ROUND_OFF * scale, f"{made.impulse_error / error:.3g} stated"


@pytest.mark.parametrize("pressed", [False, True], ids=["free", "pressed"])
@pytest.mark.parametrize("law", typical(), ids=called)
def test_the_error_of_a_law_is_within_its_tolerance_and_what_the_run_states(
    law: cl.Composed, pressed: bool
) -> None:
    check(law, pressed)


@pytest.mark.long
@pytest.mark.parametrize("law", covering(2), ids=called)
def test_the_error_of_any_two_parts_together_is_within_its_tolerance(law: cl.Composed) -> None:
    check(law, pressed=False)
    check(law, pressed=True)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("sigma", [0.0, 20.0, 50.0])
def test_a_block_that_skips_over_a_belt_keeps_the_slip_of_the_closed_form(
    sigma: float, tolerance: float
) -> None:
    """dv/dt = -mu gdot_0 w sin(w t) - sigma_2 v/m over the half swing 0 < t < pi/w of a linear contact.

    Viscous friction is there in full from the touch to the release, where the normal force is not.
    """
    mass, stiffness, mu, approach, speed = 2e-3, 1e7, 0.3, 0.1, 0.5
    law = cl.Composed(cl.Linear(stiffness), friction=cl.Coulomb(mu), viscous_friction=sigma)
    turn, decay = sqrt(stiffness / mass), sigma / mass
    plant = block(mass, height=1e-6, gap_rate=-approach, velocity=speed)
    made = run(plant, law, 1e-6 / approach + 1.5 * pi / turn, tolerance=tolerance)
    left = exp(-decay * pi / turn)
    # Integral of exp(-decay (T - s)) mu approach turn sin(turn s) ds over the half swing.
    braked = mu * approach * turn * turn * (1.0 + left) / (turn * turn + decay * decay)
    expected = speed * left - braked
    assert first(completed(made), "duration") == pytest.approx(pi / turn, rel=1e-9)
    assert abs(made.series["slip_velocity"][-1] - expected) < 10.0 * tolerance * speed


@pytest.mark.parametrize(
    ("normal", "friction", "kept"),
    [
        (cl.HertzPoint(), cl.Microslip(), 1),
        (cl.Lining(), cl.Microslip(), 0),
        (cl.HertzPoint(), cl.Mindlin(), 1),
        (cl.Lining(), cl.Mindlin(), 1),
    ],
)
def test_a_run_says_whether_its_law_keeps_the_tolerance(
    normal: cl.NormalForce, friction: cl.Friction, kept: int
) -> None:
    made = to_datatree(run(default_motor(), cl.Composed(normal, friction=friction), 3e-4))
    assert made.attrs["keeps_tolerance"] == kept


def test_time_stepping_states_no_error_and_a_rigid_limit_does() -> None:
    motor = default_motor()
    assert np.isnan(run(motor, cl.Newton(), DURATION, contact_step=1e-6).impulse_error)
    assert 0.0 <= run(motor, cl.LagrangeStick(), DURATION).impulse_error < 1e-6


def test_the_velocity_error_is_that_of_the_friction_impulse_on_the_rotor() -> None:
    setup = cl.build()
    made = cl.simulate(setup, duration=DURATION)
    attributes, motor = made.tree.attrs, setup.motor
    assert 0.0 < attributes["impulse_error"] < 1e-6 * float(made.contacts["normal_impulse"].sum())
    turned = attributes["impulse_error"] * motor.geometry.rotor_radius
    assert attributes["rotor_velocity_error"] == pytest.approx(turned / motor.rotor.inertia, rel=1e-12)
