"""Claims on orbits that are followed from known ones: closed forms, states from rest, and refusals."""

from dataclasses import replace

import numpy as np
import pytest
from oscillator_with_stop import ImpactOscillator

import contactlab as cl
from contactlab.steady_state.arrival import followed, is_followed
from contactlab.steady_state.period_map import PeriodMap
from contactlab.steady_state.shooting import Orbit, orbit_from

FAST, SLOW = 0, 1
"""Motions of one impact, by their place in `ImpactOscillator.impacts`; the slow one is a saddle."""

HEAVY = 4.0 * cl.build().motor.rotor.inertia
"""[kg m2]: a state counts the rotor's velocity by its root."""

PRESSED = ("contact.preload=5", "rotor.bearing_damping=300")


def plant(stop: float) -> ImpactOscillator:
    return ImpactOscillator(stop, restitution=0.8, force=1.0, frequency=1.7, damping=0.1)


def orbit_of(stop: float, number: int) -> Orbit:
    it = plant(stop)
    phase, z = it.impacts()[number].later(0.5)
    section = PeriodMap(it.setup(), phase=phase, belt=0.0)
    return orbit_from(section, z * np.append(section.scale, 1.0))


def test_a_followed_orbit_is_the_closed_form_on_its_branch_and_no_other() -> None:
    """An oscillator beside a stop also swings free, which from rest it may come to."""
    known = orbit_of(0.6, FAST)
    assert is_followed(known)
    for stop in (0.62, 0.66, 0.75, 0.82, 0.9):
        state = followed(plant(stop).setup(), known)
        assert state is not None
        exact = plant(stop).impacts()[FAST]
        assert -state.impacts["approach_velocity"] == pytest.approx([exact.speed], rel=1e-7)
        assert np.sum(state.multipliers).real == pytest.approx(np.trace(exact.jacobian), rel=1e-5)
        known = state.orbit


def test_where_a_branch_has_ended_nothing_is_followed() -> None:
    stops = np.arange(1.0, 1.4, 0.005)
    last = max(stop for stop in stops if plant(stop).impacts())
    known = orbit_of(last - 0.01, FAST)
    assert followed(plant(last - 0.005).setup(), known) is not None
    assert followed(plant(last + 0.005).setup(), known) is None


def test_a_branch_is_followed_no_farther_than_newton_steps_contract() -> None:
    """Another orbit might be found from there."""
    assert followed(plant(0.6).setup(), orbit_of(0.9, FAST)) is not None
    assert followed(plant(0.3).setup(), orbit_of(0.9, FAST)) is None


def test_an_orbit_that_is_not_stable_is_none_that_a_motor_comes_to() -> None:
    assert not orbit_of(0.9, SLOW).stable
    assert followed(plant(0.901).setup(), orbit_of(0.9, SLOW)) is None


@pytest.mark.parametrize(
    ("overrides", "changes"),
    [
        (["law=hertz_penalty"], {"law.stiffness": 1.1e10, "rotor.load_torque": -1e-4}),
        (["law=newton"], {"contact.friction_coefficient": 0.31, "rotor.inertia": HEAVY}),
        (["law=hertz_penalty", *PRESSED], {"contact.friction_coefficient": 0.31, "contact.preload": 5.1}),
        (["law=newton", *PRESSED], {"drive.voltage_1": 101.0}),
    ],
)
def test_a_followed_state_is_that_which_the_motor_reaches_from_rest(overrides, changes) -> None:
    """In flight and in contact, for numbers of law, drive, rotor and bearing, in which states have units."""
    setup = cl.build(overrides)
    known, other = cl.orbit(setup).orbit, setup.with_(changes)
    state, from_rest = followed(other, known), cl.orbit(other)
    assert is_followed(known)
    assert state is not None
    assert (
        abs(state.velocity.value - from_rest.velocity.value) < state.velocity.error + from_rest.velocity.error
    )
    assert np.abs(state.multipliers) == pytest.approx(np.abs(from_rest.multipliers), abs=1e-5)
    # What the drive puts in goes out again, and in the mean the contact turns what brakes.
    assert state.energy["drive_work"] == pytest.approx(sum([*state.energy.values()][1:]), rel=1e-6)
    rotor, radius = other.motor.rotor, other.motor.geometry.rotor_radius
    braked = rotor.load_torque + rotor.damping * state.velocity.value
    assert state.torque.value == pytest.approx(
        braked, abs=1e-7 * radius * state.average("normal_force").value
    )


def test_a_contact_that_counts_the_impact_that_began_it_is_not_followed() -> None:
    overrides = ["law=composed", "law/normal=hertz_point", *PRESSED]
    assert is_followed(cl.orbit(cl.build(overrides)).orbit)
    assert not is_followed(cl.orbit(cl.build([*overrides, "law/damping=lankarani_nikravesh"])).orbit)


def test_another_kind_of_law_or_motor_and_several_periods_are_not_followed() -> None:
    known = cl.orbit(cl.build(["law=hertz_penalty"])).orbit
    assert followed(cl.build(["law=hertz_penalty", "resonator.shapes=5"]), known) is None
    assert followed(cl.build(["law=composed", "law/friction=dahl"]), known) is None
    assert not is_followed(replace(known, map=replace(known.map, periods=2)))
