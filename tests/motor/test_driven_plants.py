"""Driven tables, grounds and tips beside a free body: closed forms, and the ledger of each closes."""

from dataclasses import replace
from math import asin, cos, hypot, pi, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import PPoly
from scipy.optimize import brentq

import contactlab as cl
from contactlab.engine import simulate

G, MU = 9.81, 0.2
STIFFNESS = 1e8
RIGID = cl.LagrangeStick(friction_coefficient=MU)
COMPLIANT = cl.Composed(cl.Linear(STIFFNESS), cl.Undamped(), cl.Coulomb(MU))
LAWS = pytest.mark.parametrize("law", [RIGID, COMPLIANT], ids=["rigid", "compliant"])


def sunk(law: cl.ContactLaw, weight: float) -> float:
    """Penetration under a weight."""
    return weight / STIFFNESS if law is COMPLIANT else 0.0


def open_share(run: cl.Solution) -> float:
    """Residual of the energy ledger over what the drive gives and takes."""
    return float(abs(run["energy_residual"]).max() / abs(run["drive_work"]).max())


@LAWS
def test_newmarks_block_slides_as_far_as_the_pulse_says(law: cl.ContactLaw) -> None:
    mass, pulse, lasts = 50.0, 0.5 * G, 0.4
    velocity = pulse * lasts
    # Accelerated for a time, then at a constant velocity.
    ground = cl.Waveform(PPoly(np.array([[[pulse], [0.0]], [[0.0], [velocity]]]), [0.0, lasts, 0.5]))
    block = cl.block(mass, weight=mass * G, height=-sunk(law, mass * G), base=ground.integral())
    run = cl.simulate(block, law, duration=3.0, record_interval=1e-2)
    expected = 0.5 * velocity**2 * (1.0 / (MU * G) - 1.0 / pulse)
    assert_allclose(run["point_base"][-1] - run["point_body"][-1], expected, rtol=1e-9)
    assert_allclose(run["point_base"][-1], velocity * (3.0 - 0.5 * lasts), rtol=1e-12)
    # Friction has lost what the slip took, mu N over the way.
    assert_allclose(run["friction_loss"][-1], MU * mass * G * expected, rtol=1e-9)
    assert open_share(run) < 1e-9


@LAWS
def test_what_is_laid_on_a_conveyor_comes_to_its_speed(law: cl.ContactLaw) -> None:
    mass, speed = 2.0, 0.5
    belt = cl.Waveform(PPoly(np.array([[[speed]], [[0.0]]]), [0.0, 1.0]))
    # A belt is a base of constant velocity, or a heavy rotor, whose energy no double resolves.
    for motion in ({"base": belt}, {"belt_velocity": speed}):
        block = cl.block(mass, weight=mass * G, height=-sunk(law, mass * G), **motion)
        run = cl.simulate(block, law, duration=0.5, record_interval=1e-3)
        time, reached = run["time"].values, speed / (MU * G)
        assert_allclose(run["slip_velocity"], np.minimum(MU * G * time - speed, 0.0), atol=1e-9)
        assert reached < time[run["contact_mode"].values == 2][0] < reached + 1e-3
        assert_allclose(run["friction_loss"][-1], 0.5 * mass * speed**2, rtol=1e-9)
        if "base" in motion:
            assert abs(run["energy_residual"]).max() < 1e-9 * mass * speed**2


def step_of(sawtooth: cl.Sawtooth, friction: float) -> float:
    """Way in a period of a body that sticks in the slow flank and slides in the fast one, by hand.

    From the corner on it slows down by mu N / m, whatever the base does, until the base is as fast again;
    then it is drawn along until it has the velocity of the slow flank.
    """
    period, corner = 1.0 / sawtooth.frequency, sawtooth.corner / sawtooth.frequency
    slow = sawtooth.stroke / (sawtooth.rise * period)
    fast = sawtooth.stroke / ((1.0 - sawtooth.rise) * period)
    bends = (slow + fast) / corner
    # Both from the start of the first corner; the second one ends where the slow flank begins.
    again = (1.0 - sawtooth.rise) * period + corner
    # slow - a t = slow - bends (again - t) in the second corner.
    meets = bends * again / (bends + friction)
    # It takes as long to regain its velocity as to lose it.
    return slow * period - friction * meets**2


@LAWS
def test_a_sawtooth_carries_a_block_by_its_slow_flank(law: cl.ContactLaw) -> None:
    mass, weight = 0.1, 0.5
    sawtooth = cl.Sawtooth("1 um", "1 kHz", rise=0.8, corner=0.02)
    expected = step_of(sawtooth, MU * weight / mass)
    block = cl.block(mass, weight=weight, height=-sunk(law, weight), velocity=1.25e-3, base=sawtooth)
    run = cl.simulate(block, law, duration=5e-3, record_interval=1e-5)
    assert_allclose(np.diff(run["point_body"].values[::100]), expected, rtol=1e-8)
    assert open_share(run) < 1e-9
    slider = cl.slider(mass, weight=weight, tip=sawtooth, velocity=1.25e-3, penetration=sunk(law, weight))
    run = cl.simulate(slider, law, duration=5e-3, record_interval=1e-5)
    # Its radius of 1 m is round by x^2 / 2 m.
    assert_allclose(np.diff(run["rotor_angle"].values[::100]), expected, rtol=1e-6)
    assert open_share(run) < 1e-6


def test_the_steady_speed_of_an_inertia_drive_is_its_step_over_the_period() -> None:
    sawtooth = cl.Sawtooth("1 um", "1 kHz", rise=0.8, corner=0.02)
    state = cl.steady(cl.slider(0.1, weight=0.5, tip=sawtooth), RIGID)
    assert_allclose(state.velocity.value, 1e3 * step_of(sawtooth, 1.0), rtol=1e-6)


@pytest.mark.parametrize(
    "law", [RIGID, cl.LagrangeSlip(friction_coefficient=MU), cl.Newton(friction_coefficient=MU)]
)
def test_a_velocity_that_jumps_breaks_the_stick_without_an_impulse(law: cl.ContactLaw) -> None:
    """The normal force is finite, so that its friction has no impulse: the slider keeps its velocity.

    In the fast flank it slows down by mu N / m, and as long again until it has its velocity back.
    """
    mass, weight, stroke, rise, period = 0.1, 0.5, 1e-6, 0.8, 1e-3
    up, down = stroke / (rise * period), -stroke / ((1.0 - rise) * period)
    edges = period * np.array([0.0, 0.5 * rise, 1.0 - 0.5 * rise, 1.0])
    velocity = np.array([up, down, up])
    place = np.append(0.0, np.cumsum(velocity * np.diff(edges)))[:-1]
    sharp = cl.Waveform(PPoly(np.stack([velocity, place])[:, :, None], edges), periodic=True)
    slider = cl.slider(mass, weight=weight, tip=cl.Sawtooth(stroke, 1.0 / period, rise=rise), velocity=up)
    slider = replace(slider, drive=replace(slider.drive, waveform=sharp))
    run = cl.simulate(slider, law, duration=5e-3, record_interval=1e-5)
    expected = up * period - MU * weight / mass * ((1.0 - rise) * period) ** 2
    assert_allclose(np.diff(run["rotor_angle"].values[::100]), expected, rtol=1e-6)
    assert abs(run["energy_residual"]).max() < 1e-7 * float(run["friction_loss"][-1])


@pytest.mark.parametrize("speed", [0.5, -0.5, 0.0])
@pytest.mark.parametrize(
    "law", [RIGID, cl.Newton(friction_coefficient=MU), COMPLIANT], ids=["rigid", "newton", "compliant"]
)
def test_a_contact_that_goes_on_over_another_belt_slides_until_it_has_its_velocity(
    law: cl.ContactLaw, speed: float
) -> None:
    """The stick of a block goes on at a slip -v, which ends after v / a, by a = mu N (1/m + 1/M)."""
    mass, heavy = 2.0, 50.0
    weight = mass * G

    def block(velocity: float) -> cl.Motor:
        height = -sunk(law, weight)
        return cl.block(mass, weight=weight, height=height, belt_mass=heavy, belt_velocity=velocity)

    lying = simulate(block(0.0), law, duration=1e-2, record_interval=1e-3)
    assert lying.contact_mode[-1] == 2
    run = simulate(block(speed), law, duration=0.4, record_interval=1e-3, contact=lying.state)
    rate = MU * weight * (1.0 / mass + 1.0 / heavy)
    slides = np.maximum(abs(speed) - rate * run.time, 0.0)
    assert_allclose(run.series["slip_velocity"], -np.sign(speed) * slides, atol=1e-9)
    assert abs((run.contact_mode == 1).sum() - abs(speed) / rate / 1e-3) <= 1.0
    lost = MU * weight * speed**2 / (2.0 * rate)
    assert_allclose(run.series["friction_loss"][-1], lost, rtol=1e-9)
    assert abs(run.series["energy_residual"]).max() < 1e-10


def test_a_slider_goes_on_under_a_faster_tip_by_its_friction() -> None:
    """The tip of the second motor is twice as fast from its start on: v = v_1 + mu N t / m."""
    mass, weight, period = 0.1, 5.0, 1e-3
    slow, fast = (
        cl.slider(mass, weight=weight, tip=cl.Sawtooth(stroke, 1.0 / period, rise=0.8), velocity=1.25e-3)
        for stroke in (1e-6, 2e-6)
    )
    first = simulate(slow, RIGID, duration=2.0 * period, record_interval=period)
    assert first.contact_mode[-1] == 2
    run = simulate(fast, RIGID, duration=0.35 * period, record_interval=1e-5, start=first.state)
    time = run.time - run.time[0]
    expected = np.minimum(1.25e-3 + MU * weight / mass * time, 2.5e-3)
    assert_allclose(run.series["rotor_velocity"], expected, rtol=1e-6)


@pytest.mark.parametrize("belt", [0.0, 5e-4])
def test_the_force_of_a_driven_tip_on_a_held_slider_is_that_of_its_slip(belt: float) -> None:
    """mu N (2 p - 1) with the share p of the period in which the tip is faster, stick or not before."""
    stroke, frequency, rise, corner, weight = 1e-6, 1e3, 0.9, 0.01, 1.0
    free = cl.slider(tip=cl.Sawtooth(stroke, frequency, rise=rise, corner=corner), weight=weight)
    up, down = stroke * frequency / rise, stroke * frequency / (1.0 - rise)
    share = rise - corner + 2.0 * corner * (up - belt) / (up + down)
    # The motion under a prescribed velocity goes on from a stick at another one.
    state = cl.steady(free, RIGID, belt=belt, start=cl.steady(free, RIGID))
    # The slider is round by x^2 / 2 m: its normal force by 1e-6.
    assert_allclose(state.torque.value, MU * weight * (2.0 * share - 1.0), rtol=3e-6)


def test_a_slider_that_is_laid_on_a_hertzian_tip_bounces_in_stick_as_long_as_it_likes() -> None:
    """W d = 2/5 K d^(5/2): it comes back to a contact without force, and its slip is round-off."""
    weight, law = 1.0, cl.HertzPenalty()
    slider = cl.slider(tip=cl.Sawtooth(), weight=weight)
    run = cl.simulate(slider, law, duration=0.02)
    assert run.complete, run.message
    assert law.stiffness is not None
    deepest = (2.5 * weight / law.stiffness) ** (2.0 / 3.0)
    # The slider is round by x^2 / 2 m.
    assert_allclose(run.contacts["max_penetration"], deepest, rtol=1e-5)
    assert abs(run["energy_residual"]).max() < 1e-9 * weight * deepest


def test_impacts_on_a_driven_tip_take_their_work_from_its_drive() -> None:
    mass, height = 0.1, 1e-6
    slider = cl.slider(mass, weight=0.5, tip=cl.Sawtooth("1 um", "1 kHz", rise=0.8), velocity=6e-4)
    assert slider.start is not None
    above = replace(slider.start, displacement=np.array([-np.sqrt(mass) * height, 0.0]))
    law = cl.Newton(friction_coefficient=MU, restitution=0.5)
    run = cl.simulate(replace(slider, start=above), law, duration=5e-3, record_interval=1e-5)
    assert run.contacts.sizes["contact"] > 3
    assert abs(run["energy_residual"]).max() < 1e-7 * float(run["friction_loss"][-1])


E_BALL, FREQUENCY = 0.8, 50.0
OMEGA, PERIOD = 2.0 * pi * FREQUENCY, 1.0 / FREQUENCY
LEAST = pi * (1.0 - E_BALL) / (1.0 + E_BALL)
"""A w^2 / g from which a ball can meet the table once a period: v = g T / 2 = w A sin (1 + e) / (1 - e)."""

BOUNCES = cl.Newton(friction_coefficient=0.2, restitution=E_BALL)


def bouncing(acceleration: float, **others: Any) -> tuple[cl.Motor, float]:
    """Return a ball that meets a table of an acceleration over g once a period, and when."""
    amplitude = acceleration * G / OMEGA**2
    meets, speed = -asin(LEAST / acceleration) / OMEGA, 0.5 * G * PERIOD
    # At t = 0 the table is highest and at rest.
    height = amplitude * cos(OMEGA * meets) - speed * meets - 0.5 * G * meets**2 - amplitude
    table = cl.Vibration(amplitude, FREQUENCY)
    return cl.ball(0.01, height=height, speed=-speed - G * meets, table=table, **others), meets


def test_a_ball_meets_a_vibrating_table_at_one_phase() -> None:
    ball, meets = bouncing(0.8)
    run = cl.simulate(ball, BOUNCES, duration=10.0 * PERIOD, record_interval=1e-3)
    times = run.contacts["start_time"].values
    assert_allclose(times, meets + PERIOD * np.arange(1, times.size + 1), atol=1e-12)
    assert_allclose(run["point_table"], 0.8 * G / OMEGA**2 * np.cos(OMEGA * run["time"]), atol=1e-18)
    assert open_share(run) < 1e-9


def test_its_multipliers_and_period_doubling_are_those_of_the_exact_map() -> None:
    # Without Holmes' assumption of high bounces: the determinant is e^2, the trace as below, and -1 a
    # multiplier where the table's acceleration at the impact is -2 g (1 + e^2) / (1 + e)^2.
    e = E_BALL
    ball, meets = bouncing(0.8, damping=0.1)
    state = cl.orbit(ball, BOUNCES)
    at_impact = -0.8 * G * cos(OMEGA * meets)
    trace = 1.0 + e**2 + (1.0 + e) ** 2 * at_impact / G
    assert_allclose(state.multipliers[:2], np.roots([1.0, -trace, e**2]), rtol=1e-6)
    doubles = hypot(LEAST, 2.0 * (1.0 + e**2) / (1.0 + e) ** 2) * G / OMEGA**2
    branch = cl.branch(ball, "plant.table.amplitude", 0.95 * doubles, 1.05 * doubles, law=BOUNCES)
    (event,) = branch.details.events
    assert event.mark.name == "PERIOD_DOUBLING"
    assert_allclose(event.value, doubles, rtol=1e-6)


def test_a_table_that_lifts_what_lies_on_it_loses_it_at_g() -> None:
    """A body leaves where the table is slowed by more than g: A w^2 cos(w t) = g."""
    amplitude = 1.5 * G / OMEGA**2
    table = cl.Vibration(amplitude, FREQUENCY, phase=-0.5 * pi)
    run = cl.simulate(cl.ball(0.1, table=table), RIGID, duration=0.4 * PERIOD, record_interval=1e-5)
    # With -pi/2 it is A sin(w t), which begins at its fastest: gap and its rate are those over the table.
    leaves = asin(1.0 / 1.5) / OMEGA
    assert_allclose(run.contacts["start_time"][0] + run.contacts["duration"][0], leaves, rtol=1e-12)
    assert run["gap"][-1] > 0.0
    flown = 0.4 * PERIOD - leaves
    height = amplitude * (1.0 / 1.5 - np.sin(0.8 * pi)) + amplitude * OMEGA * cos(asin(1.0 / 1.5)) * flown
    assert_allclose(run["gap"][-1], height - 0.5 * G * flown**2, rtol=1e-9)


def test_springs_and_dashpots_to_the_ground_feel_the_motion_of_the_base() -> None:
    """A block that slides freely is left behind by its base, and is moved by nothing else."""
    free = cl.Composed(cl.Linear(STIFFNESS), cl.Undamped(), cl.Coulomb(0.0))
    base = cl.Vibration(1e-3, 7.0, phase=0.3)
    block = cl.block(2.0, weight=1.0, height=-1e-8, stiffness=800.0, damping=3.0, way=1e-3, base=base)
    run = cl.simulate(block, free, duration=0.3, record_interval=1e-3)
    decay, time = 3.0 / 4.0, run["time"].values
    omega = sqrt(400.0 - decay**2)
    expected = 1e-3 * np.exp(-decay * time) * (np.cos(omega * time) + decay / omega * np.sin(omega * time))
    place = 1e-3 * cos(0.3)
    assert_allclose(run["point_body"] - place, expected, atol=1e-15)


def test_a_sawtooth_has_the_stroke_but_for_its_corners() -> None:
    sawtooth = cl.Sawtooth(2e-6, 100.0, rise=0.7, corner=0.05)
    wave = sawtooth.drive().waveform
    values = wave.voltage(np.linspace(0.0, 0.01, 200_001))[0]
    assert_allclose(np.ptp(values), 2e-6 * (1.0 - 0.05), rtol=1e-6)
    assert_allclose(values.mean(), 0.0, atol=1e-11)
    assert_allclose(wave.voltage(0.0, 1), 2e-6 * 100.0 / 0.7)


def test_a_waveform_goes_on_as_it_ends() -> None:
    time = np.linspace(1.0, 2.0, 11)
    wave = cl.Waveform.sampled(time, 0.1 * (time - 1.0)[None] ** 2, degree=3)
    block = cl.block(1.0, weight=1.0, base=wave)
    run = cl.simulate(block, RIGID, duration=3.0, record_interval=0.5)
    assert_allclose(run["point_base"], [0.0, 0.0, 0.0, 0.025, 0.1, 0.2, 0.3], atol=1e-12)
    assert_allclose(run["point_body"], run["point_base"], atol=1e-12)


def test_two_motions_shake_one_block() -> None:
    """Along and across at once: friction follows the normal force m (g + zdd)."""
    mass, along, across = 1.0, cl.Vibration(2e-3, 40.0), cl.Vibration(5e-5, 40.0, phase=1.0)
    block = cl.block(mass, weight=mass * G, base=along, table=across)
    run = cl.simulate(block, RIGID, duration=0.01, record_interval=1e-5)
    omega = 2.0 * pi * 40.0

    def normal(t: float) -> float:
        return mass * (G - 5e-5 * omega**2 * cos(omega * t + 1.0))

    middles = run["time"].values[1:] - 0.5e-5
    slides = (run["contact_mode"].values == 1)[1:]
    assert_allclose(run["normal_force"][1:], [normal(t) for t in middles], rtol=1e-5)
    assert slides.sum() > 500
    inside = slides & np.roll(slides, 1) & np.roll(slides, -1)
    ratio = abs(run["friction_force"].values[1:] / run["normal_force"].values[1:])[inside]
    assert_allclose(ratio, MU, rtol=1e-6)
    # It slips first where the inertia of the base exceeds friction.
    starts = brentq(lambda t: 2e-3 * omega**2 * cos(omega * t) - MU * normal(t) / mass, 0.0, 0.00625)
    assert starts > 0.0
    assert open_share(run) < 1e-9


def pieces(*rows: list[float], periodic: bool = False) -> cl.Waveform:
    """A waveform of two pieces of a second each."""
    return cl.Waveform(PPoly(np.array(rows)[:, :, None], [0.0, 1.0, 2.0]), periodic)


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: cl.block(base=pieces([0.0, 1.0])), "base"),
        (lambda: cl.block(table=pieces([1.0, 0.0], [0.0, 1.0])), "table"),
        (lambda: cl.slider(tip=pieces([1.0, 1.0], [0.0, 1.0], periodic=True)), "tip"),
        (lambda: cl.ball(table=cl.Waveform(PPoly(np.zeros((1, 1, 2)), [0.0, 1.0]))), "table"),
        (lambda: cl.block(base=cl.Sawtooth(), table=pieces([0.0, 0.0])), "times"),
        (lambda: cl.Sawtooth(rise=0.99, corner=0.02), "corner"),
        (lambda: cl.Vibration(amplitude=-1.0), "amplitude"),
        (lambda: pieces([1.0, 1.0], periodic=True).integral(), "mean"),
    ],
)
def test_a_motion_that_jumps_or_does_not_fit_is_refused(make: Any, key: str) -> None:
    with pytest.raises(ValueError, match=key):
        make()


def test_the_numbers_of_a_plant_are_keys_until_something_is_replaced() -> None:
    setup = cl.Setup.of(bouncing(0.8)[0], BOUNCES, "1 ms")
    numbers = setup.numbers()
    assert numbers["plant.table.frequency"].value == FREQUENCY
    assert "drive.frequency" not in numbers
    heavier = setup.with_("plant.mass=20 g", "plant.table.phase=0.5")
    assert heavier.motor == cl.ball(
        **{
            **setup.motor.plant.arguments,
            "mass": 0.02,
            "table": cl.Vibration(numbers["plant.table.amplitude"].value, FREQUENCY, 0.5),
        }
    )
    assert heavier.configuration["plant"]["table"]["phase"] == 0.5
    with pytest.raises(cl.ConfigurationError, match=r"plant\.mass"):
        setup.with_("plant.mass=-1 g")
    braked = setup.with_("rotor.damping=1")
    assert braked.motor.plant is None
    assert "plant" not in braked.configuration


def test_a_flat_contact_has_a_force_and_no_torque() -> None:
    amplitude, mass, weight = 2e-5, 0.1, 0.5
    shaken = cl.block(mass, weight=weight, base=cl.Vibration(amplitude, FREQUENCY), damping=1.0)
    state = cl.steady(shaken, RIGID)
    assert np.isnan(state.torque.value)
    assert "torque" not in state.tables["quantities"]["quantity"].to_numpy()
    # It slides to and fro alike.
    written = state.text()
    assert "N m" not in written.replace("N ms", "")
    assert "torque" not in written
    assert "mean friction force" in written
    with pytest.raises(cl.ConfigurationError, match="plant"):
        cl.characterise(shaken, RIGID)
    run = cl.simulate(shaken, RIGID, duration=0.1)
    assert "torque" not in cl.compare([run]).text()
