"""Steady states: which one it is, what it does on average, how stable it is, and where there is none."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import contactlab as cl
from contactlab.motor import NormalModes
from contactlab.steady_state import NotSettledError, converged
from contactlab.steady_state.arrival import DEVIATION, _missed
from contactlab.steady_state.shooting import Orbit, derivative_of
from contactlab.testing.plants import FLAT


@cache
def setup_of(*overrides: str) -> cl.Setup:
    return cl.build(overrides)


@cache
def free(*overrides: str) -> cl.Steady:
    return cl.steady(setup_of(*overrides))


@cache
def at_rest(*overrides: str) -> cl.Steady:
    return cl.steady(setup_of(*overrides), belt=0.0)


NEGATIVE, POSITIVE, RIGID = (), ("contact.clearance=3 um",), ("law=newton",)
"""The default motor, which turns negative, one that turns positive, and a rigid one."""


@pytest.mark.parametrize("overrides", [NEGATIVE, POSITIVE, RIGID])
def test_a_motor_on_its_orbit_stays_there_and_comes_to_it_from_elsewhere(overrides: tuple[str, ...]) -> None:
    result = free(*overrides)
    assert result.kind == "periodic"
    assert result.orbit is not None
    velocity = result.velocity[0]
    for start in (result, (result.end[1], 1.5 * velocity)):
        again = cl.steady(result.setup, start=start).velocity[0]
        assert again == pytest.approx(velocity, rel=1e-8)


@pytest.mark.parametrize("overrides", [NEGATIVE, RIGID])
def test_a_run_comes_to_the_orbit_as_fast_as_its_largest_multiplier_says(overrides: tuple[str, ...]) -> None:
    orbit = free(*overrides).orbit
    assert orbit is not None
    times = np.arange(12, 37)
    state, away = orbit.state.copy(), []
    state[-1] *= 1.0 + 1e-3
    for _ in range(times[-1] + 1):
        state = orbit.map(state)
        away.append(np.linalg.norm(state - orbit.state))
    slope = np.polyfit(times, np.log(np.array(away)[times]), 1)[0]
    # The way there is straight but for the square of the distance.
    assert slope == pytest.approx(np.log(abs(orbit.multipliers[0])), rel=1e-3)


@pytest.mark.parametrize("overrides", [NEGATIVE, POSITIVE, RIGID])
def test_multipliers_hang_on_no_step_of_their_differences(overrides: tuple[str, ...]) -> None:
    orbit = free(*overrides).orbit
    assert orbit is not None
    assert orbit.roughness < 1e-4

    def jacobian(step: float) -> np.ndarray:
        every = np.eye(orbit.state.size)
        return np.column_stack([derivative_of(orbit.map, orbit.state, along, step) for along in every])

    # The error of central differences falls with the square of their step.
    extrapolated = (4.0 * jacobian(2e-6) - jacobian(4e-6)) / 3.0
    for other in (jacobian(1e-7), extrapolated):
        values = np.linalg.eigvals(other)
        for value in orbit.multipliers:
            assert np.abs(values - value).min() < 1e-6


@pytest.mark.parametrize("overrides", [NEGATIVE, RIGID, ("law=lagrange_stick", "rotor.damping=1e-4")])
def test_what_the_drive_gives_is_lost_or_taken_from_the_rotor(overrides: tuple[str, ...]) -> None:
    result = cl.steady(setup_of(*overrides), load=-1e-3)
    losses = ("damping_loss", "friction_loss", "contact_loss", "load_work")
    drive = result.average("drive_work")[0]
    # The rigid laws put the tip back onto the closed gap, which is in no term.
    assert sum(result.average(name)[0] for name in losses) == pytest.approx(drive, rel=2e-4)
    rotor, velocity = result.setup.motor.rotor, result.velocity[0]
    assert rotor.load_torque == result.setup.configuration["rotor"]["load_torque"] == -1e-3
    torque = rotor.load_torque + rotor.damping * velocity
    assert result.torque[0] == pytest.approx(torque, abs=1e-9)
    assert result.average("load_work")[0] == pytest.approx(-1e-3 * velocity, rel=1e-6)


@pytest.mark.parametrize("overrides", [NEGATIVE, POSITIVE])
def test_a_brake_slows_either_rotation_and_beyond_the_holding_torque_the_rotor_stands(
    overrides: tuple[str, ...],
) -> None:
    holding, velocity = abs(at_rest(*overrides).torque[0]), free(*overrides).velocity[0]
    setup = setup_of(*overrides)
    braked = cl.steady(setup, brake=0.5 * holding)
    assert 0.0 < braked.velocity[0] / velocity < 1.0
    assert braked.setup.motor.rotor.load_torque == pytest.approx(0.5 * holding * np.sign(velocity))
    stands = cl.steady(setup, brake=1.1 * holding)
    assert (stands.kind, stands.velocity) == ("standing", (0.0, 0.0))
    assert stands.torque[0] == pytest.approx(np.sign(velocity) * holding, rel=1e-6)


def test_a_belt_as_fast_as_the_free_rotor_is_hardly_pushed() -> None:
    result = free()
    ripple = float(np.abs(result.curves().series["rotor_velocity"] - result.velocity[0]).max())
    on_belt = cl.steady(result.setup, belt=result.velocity[0])
    slope = at_rest().torque[0] / result.velocity[0]
    assert on_belt.velocity == (result.velocity[0], 0.0)
    assert abs(on_belt.torque[0] / slope) < ripple


def test_a_belt_gives_the_slope_that_the_rotor_settles_by() -> None:
    result, step = free(*RIGID), 0.1
    v = result.velocity[0]
    before, after = (cl.steady(result.setup, belt=v + s).torque[0] for s in (-step, step))
    slow = -(after - before) / (2.0 * step)
    assert result.orbit is not None
    # The rotor is slow and the resonator fast, but not endlessly so.
    settling = result.setup.motor.rotor.inertia / slow
    assert result.orbit.settling_time == pytest.approx(settling, rel=0.05)


def test_without_contact_the_rotor_keeps_its_velocity_or_that_of_load_and_damping() -> None:
    far = ("contact.clearance=100 um", "rotor.initial_velocity=2")
    result = free(*far)
    assert (result.kind, result.contact_share, result.peak_force) == (
        "without contact",
        (0.0, 0.0),
        (0.0, 0.0),
    )
    assert result.velocity[0] == pytest.approx(2.0, rel=1e-12)
    # By then a thousandth of the free vibration is left.
    assert result.warm_up >= 8
    damped = cl.steady(setup_of(*far, "rotor.damping=1e-5"), load=1e-5)
    assert damped.velocity[0] == pytest.approx(-1.0, rel=1e-9)
    with pytest.raises(NotSettledError, match="load"):
        cl.steady(setup_of(*far), load=1e-5)


@pytest.mark.parametrize(
    "overrides", [("drive.voltage_2=0",), ("drive.frequency_ratio=1.5", "rotor.damping=1e-3")]
)
def test_a_drive_of_one_tone_or_of_a_broken_ratio_has_its_period(overrides: tuple[str, ...]) -> None:
    result = free(*overrides)
    assert result.kind == "periodic"
    frequency = result.setup.motor.drive.frequency
    assert result.period * frequency == pytest.approx(np.round(result.period * frequency), abs=1e-9)
    again = result.setup.run(duration=600 * result.period, record_interval=result.period)
    velocity = np.diff(again.series["rotor_angle"])[-1] / result.period
    assert velocity == pytest.approx(result.velocity[0], abs=1e-4)


@pytest.mark.parametrize("law", [cl.HertzPenalty(1e10, 0.3), cl.LagrangeStick(0.3)])
def test_a_motor_pressed_together_has_an_orbit(law: cl.ContactLaw) -> None:
    motor = setup_of("rotor.damping=0.05").motor
    # Far more than what the drive lifts.
    pressed = replace(motor, preload=60.0 * motor.modes.tip_displacement)
    pressed = replace(pressed, geometry=replace(motor.geometry, clearance=0.0))
    result = cl.steady(pressed, law, contact_step=5e-7 if isinstance(law, cl.PenaltyLaw) else None)
    assert result.kind == "periodic"
    assert result.orbit.stable
    assert result.contact_share.value == pytest.approx(1.0, abs=1e-9)
    assert result.average("normal_force")[0] > 0.0
    # What turns the rotor is what its damping takes.
    torque = motor.rotor.damping * result.velocity[0]
    assert result.torque[0] == pytest.approx(torque, abs=1e-6)


def test_a_coordinate_that_nothing_brings_back_is_no_orbit_and_no_failure() -> None:
    modes = NormalModes(
        stiffness=np.array([1e6, 0.0]),
        damping=np.array([300.0, 0.0]),
        coupling=np.array([[1.0, 0.0], [0.0, 0.0]]),
        tip_displacement=np.array([1.0, 0.0]),
        tip_slope=np.array([0.0, -1.0 / FLAT]),
        shape_coupling=np.zeros((2, 2)),
    )
    drive = cl.Drive(np.array([100.0]), np.array([[10.0], [0.0]], dtype=complex))
    geometry = cl.ContactGeometry(FLAT, FLAT, 5e-6)
    motor = cl.Motor(modes, drive, geometry, cl.Rotor(inertia=FLAT**2))
    result = cl.steady(motor, cl.HertzPenalty(1e10, 0.3), belt=0.0)
    assert result.kind == "periodic"
    assert result.contact_share.value > 0.0


def test_a_law_without_stick_whose_slip_changes_sense_has_means_and_says_why_no_orbit_closes() -> None:
    slides = free("law=lagrange_slip")
    assert slides.details.orbit is None
    assert slides.facts["reason"] == slides.details.reason
    # Not after the thousands of periods that a motion is waited for which might come to an orbit.
    assert slides.details.warm_up + slides.details.motion.time.size < 1000
    setup = setup_of("law=lagrange_slip")
    period = slides.details.period
    long = setup.run(duration=4000 * period, record_interval=period)
    velocity = float(np.diff(long.series["rotor_angle"][[1000, -1]])[0]) / (3000 * period)
    assert abs(velocity - slides.velocity.value) < slides.velocity.error
    # Held where every contact slips in one sense, the same law has an orbit.
    assert at_rest("law=lagrange_slip").details.orbit is not None


def test_a_cycle_of_two_periods_has_its_orbit_while_the_rotor_still_drifts() -> None:
    twice = free("resonator.stiffness_damping=8e-7")
    assert (twice.details.orbit.map.periods, twice.periods) == (2, 2)
    # The rotor settles within some hundred periods, and the orbit is found within these.
    assert twice.warm_up < 300
    period = twice.details.period
    long = setup_of("resonator.stiffness_damping=8e-7").run(duration=6000 * period, record_interval=period)
    velocity = float(np.diff(long.series["rotor_angle"][[4000, -1]])[0]) / (2000 * period)
    assert velocity == pytest.approx(twice.velocity.value, rel=1e-6)


@pytest.mark.parametrize("overrides", [NEGATIVE, RIGID, ("resonator.stiffness_damping=8e-7",)])
def test_a_rotor_stopped_on_its_orbit_has_the_torque_of_one_held_from_the_start(
    overrides: tuple[str, ...],
) -> None:
    orbit, at_once = free(*overrides), at_rest(*overrides)
    stopped = cl.steady(setup_of(*overrides), belt=0.0, start=orbit)
    assert stopped.periods == at_once.periods
    assert stopped.torque.value == pytest.approx(at_once.torque.value, rel=1e-7)
    assert stopped.warm_up <= at_once.warm_up


def test_numbers_of_a_result_are_those_of_its_data_which_are_made_when_read() -> None:
    for refine in (False, True):
        result = cl.Steady(refine=refine)(setup_of())
        assert result.numbers == result.study.numbers(result.data)
        assert result.data is result.data


def test_what_steps_leave_is_told_with_the_mean() -> None:
    rough, fine = (setup_of(*RIGID, f"solver.contact_step={step}") for step in (2e-7, 2e-9))
    mean, error = converged(rough).velocity
    assert 1e-5 < error < 1e-2
    assert abs(cl.steady(fine).velocity[0] - mean) < 1.1 * error
    assert converged(setup_of(), refine=False).velocity[1] < 1e-7


class Line:
    """A map of one state that goes down a slope from 0 to where it stays first, at -1; it stays at -2 too."""

    periods = 1

    def step(self, z: np.ndarray) -> np.ndarray:
        return z - 0.05 * (z + 1.0) * (z + 1.5) * (z + 2.0)

    def ends(self, starts: np.ndarray, times: int) -> np.ndarray:
        for _ in range(times):
            starts = self.step(starts)
        return starts


@pytest.mark.parametrize(("place", "goes"), [(-1.0, True), (-2.0, False)])
def test_an_orbit_behind_another_is_not_where_a_motor_goes(place: float, goes: bool) -> None:
    line: Any = Line()
    orbit = Orbit(line, np.array([place]), np.array([[1.0 - 0.025]]), 0.0)
    # From about -0.4 it goes down as fast as if it went to -2; half way there it does not.
    for start in (0.0, *np.linspace(-0.5, -0.3, 9), -0.6, -0.9):
        assert _missed(orbit, np.array([start]), 5) > DEVIATION or goes
    assert _missed(orbit, np.array([place + 0.05]), 5) < DEVIATION


def test_a_stable_orbit_that_is_found_first_is_left_where_the_motor_does_not_go() -> None:
    """After 118 periods Newton's method finds one at 5.80 rad/s; the motor settles at 5.10."""
    motor = {"clearance": 1.645e-6}, {"initial_velocity": 2.25}, {"stiffness_damping": 1.02e-6}
    groups = dict(zip(("contact", "rotor", "resonator"), motor, strict=True))
    setup = cl.build({"law": "newton", "drive": {"phase": 0.394}, **groups})
    period = 1.0 / float(setup.motor.drive.frequency[0])
    angle = setup.run(duration=6000 * period, record_interval=2000 * period).series["rotor_angle"]
    mean = (angle[-1] - angle[-2]) / (2000 * period)
    assert cl.steady(setup).velocity.value == pytest.approx(mean, rel=1e-4)


@pytest.mark.parametrize(
    ("arguments", "error", "key"),
    [
        ({"belt": 1.0, "load": 1.0}, ValueError, "belt and load"),
        ({"brake": -1.0}, ValueError, "brake"),
        ({"belt": np.nan}, ValueError, "belt"),
        ({"load": "much"}, TypeError, "load"),
        ({"longest": 3}, ValueError, "longest"),
        ({"start": (1.0, 2.0)}, TypeError, "start"),
        ({"law": cl.Newton()}, ValueError, "law"),
        ({"load": 0.05, "longest": 400}, NotSettledError, "longest"),
    ],
)
def test_what_makes_no_steady_state_is_told_in_a_sentence(
    arguments: dict[str, Any], error: type[Exception], key: str
) -> None:
    with pytest.raises(error, match=key):
        cl.steady(setup_of(), **arguments)


@pytest.mark.parametrize("law", ["newton", "hertz_penalty"])
def test_a_motor_and_a_law_made_in_python_have_the_steady_states_of_their_setup(law: str) -> None:
    setup = setup_of(f"law={law}")
    options = {"contact_step": setup.contact_step}
    of_setup, of_parts = cl.converged(setup), cl.converged(setup.motor, setup.law, **options)
    for name in ("velocity", "torque"):
        assert getattr(of_parts, name) == getattr(of_setup, name)
    for name in ("velocity", "torque", "impulse", "peak_force", "contact_share"):
        value, error = number = getattr(of_parts.best, name)
        assert (number.value, number.error) == (value, error)
        # The torque of a free rotor is zero, whatever its error.
        assert 0.0 <= error <= max(1e-6 * abs(value), 1e-9)


def test_the_peak_of_a_motion_without_period_has_no_known_error() -> None:
    result = cl.steady(setup_of("resonator=finite_element"), longest=200)
    chaotic = replace(result.details, orbit=None, periods=0)
    assert chaotic.peak_force.value == result.peak_force.value
    assert np.isnan(chaotic.peak_force.error)
