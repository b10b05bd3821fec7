"""Stick begins and ends at the static cone of the instant: motors with mu_s > mu against the oracle.

A reversal at which stick would demand more than mu_s N must slip on, even where a growing N closes the cone
within the first part of the step; and stick must not end by the round-off of the slip that it holds.
"""

import pytest
from oracle import solve_hertz
from support.motors import default_motor, oracle_motor, random_motor, random_stiffness

from contactlab.engine import simulate
from contactlab.laws import Composed
from contactlab.laws.friction import Coulomb
from contactlab.laws.normal import HertzPoint

DURATION = 3e-3


@pytest.mark.parametrize(
    ("seed", "ratio", "tolerance", "agreement"),
    [
        # The demand at a reversal lies outside the cone by 1e-3 of it, and inside 0.1 us later: the rotor was
        # 4e-7 rad/s off.
        (216, 1.2, 1e-7, 5e-8),
        # A slip of 1e-15 m/s that the step before had left was an error to no step's liking: stick ended
        # at 0.98 of the cone, and the rotor was 1.4e-3 rad/s off.
        (291, 2.5, 1e-12, 1e-9),
    ],
)
def test_static_friction_ends_where_the_oracle_ends(
    seed: int, ratio: float, tolerance: float, agreement: float
) -> None:
    changes, stiffness = random_motor(seed), random_stiffness(seed)
    friction = Coulomb(changes["friction_coefficient"], static_ratio=ratio)
    law = Composed(HertzPoint(stiffness), friction=friction)
    settings = {"duration": DURATION, "record_interval": DURATION, "tolerance": tolerance}
    made = simulate(default_motor(**changes), law, **settings)
    reference = solve_hertz(oracle_motor(**changes), stiffness, DURATION, 1e-12, static_ratio=ratio)
    assert made.complete, made.message
    assert made.series["rotor_velocity"][-1] == pytest.approx(reference.rotor_velocity, abs=agreement)
    assert made.contacts["stick_duration"] == pytest.approx(reference.stick_duration, abs=1e-9)
