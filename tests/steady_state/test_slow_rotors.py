"""Rotors that settle slowly: a steady state is where their torque is zero, or there is none to compute."""

import warnings
from typing import Any

import numpy as np
import pytest

import contactlab as cl
from contactlab.steady_state import NotSettledError
from contactlab.steady_state.branches import NoBranchError
from contactlab.steady_state.shooting import Orbit

FREE = "contact.friction_coefficient=0"
NEWTON = -3.0489617667
"""Velocity of the default motor under Newton's law, whatever the inertia [rad/s]."""


@pytest.mark.parametrize("law", ["hertz_penalty", "newton"])
@pytest.mark.parametrize("damping", [1e-7, 1e-10])
def test_a_rotor_without_friction_turns_as_load_and_damping_balance(law: str, damping: float) -> None:
    rotor = f"rotor.damping={damping}", "rotor.initial_velocity=1"
    for load in (0.0, damping):
        result = cl.steady(cl.build([f"law={law}", FREE, *rotor, f"rotor.load_torque={load}"]))
        # The round-off of a period, over 1 - lambda, which goes with the damping.
        assert abs(result.velocity.value + load / damping) <= result.velocity.error < 2e-15 / damping
        assert not result.details.orbit.neutral.any()


@pytest.mark.parametrize("start", [0, 1])
def test_a_heavy_rotor_turns_as_fast_as_a_light_one(start: int) -> None:
    result = cl.steady(cl.build(["law=newton", "rotor.inertia=144", f"rotor.initial_velocity={start}"]))
    assert abs(result.velocity.value - NEWTON) <= result.velocity.error < 1e-4


def test_a_rotor_that_hardly_rubs_turns_where_its_torque_is_zero() -> None:
    rubs = ["law=hertz_penalty", "contact.friction_coefficient=1e-6"]
    result = cl.steady(cl.build(rubs))
    velocity, error = result.velocity
    assert error < 1e-5
    setup = cl.build(rubs)
    slower, faster = (cl.steady(setup, belt=velocity + s * 1e-4).torque for s in (1.0, -1.0))
    assert faster.value > 0.0 > slower.value


@pytest.mark.parametrize("friction", [1e-6, 1e-9])
def test_a_rotor_far_from_where_its_torque_is_zero_has_no_steady_state_there(friction: float) -> None:
    setup = cl.build(
        ["law=hertz_penalty", f"contact.friction_coefficient={friction}", "rotor.initial_velocity=1"]
    )
    try:
        velocity, error = cl.steady(setup).velocity
    except NotSettledError:
        return
    assert abs(velocity + 2.913) <= error + 1e-3


@pytest.mark.parametrize("load", [0.0, 1e-13])
def test_what_round_off_does_not_tell_from_a_neutral_direction_is_refused(load: float) -> None:
    rotor = "rotor.damping=1e-13", "rotor.initial_velocity=1", f"rotor.load_torque={load}"
    with pytest.raises(NotSettledError, match="torque"):
        cl.steady(cl.build(["law=newton", FREE, *rotor]))


def test_a_rotor_that_nothing_brakes_keeps_its_velocity_and_has_no_branch() -> None:
    setup = cl.build(["law=newton", FREE, "rotor.initial_velocity=1"])
    result = cl.steady(setup)
    assert result.velocity.value == pytest.approx(1.0, rel=1e-12)
    assert result.details.orbit.neutral.sum() == 1
    with pytest.raises(NoBranchError, match="belt"):
        cl.branch(setup, "contact.clearance", 1e-6, 1.1e-6)


class Forgetful:
    """A map that ends in the same state, whatever it begins with."""

    belt = 0.0

    def ends(self, starts: np.ndarray) -> np.ndarray:
        return np.ones_like(starts)


def test_a_map_that_forgets_everything_has_no_rough_derivative() -> None:
    section: Any = Forgetful()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        orbit = Orbit.at(section, np.ones(2))
    assert (orbit.roughness, orbit.largest) == (0.0, 0.0)
