"""Claims on drives that are no sum of tones: closed forms, another integration, and the tones themselves."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.polynomial import Chebyshev, Polynomial
from scipy.integrate import solve_ivp
from scipy.interpolate import PPoly
from scipy.optimize import brentq

import contactlab as cl
from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine import simulate
from contactlab.motor.waveform import MOST_DEGREE, SAMPLED_TURN

FAR = 1.0
"""Gap that nothing bridges [m]."""


def forced(waveform: cl.Waveform, damping: float = 0.0, stiffness: float = 1e8) -> cl.Motor:
    """An oscillator of 1 kg, far from its stop; the voltage is its force [N]."""
    motor = cl.oscillator(1.0, stiffness, damping=damping, gap=FAR)
    both = PPoly(np.repeat(waveform.pieces.c, 2, axis=2), waveform.pieces.x)
    return replace(motor, drive=cl.Drive(waveform=replace(waveform, pieces=both)))


def displacement(motor: cl.Motor, duration: float) -> tuple[Array, Array]:
    run = simulate(motor, cl.HertzPenalty(), duration=duration, record_interval=duration / 200)
    assert run.complete
    assert abs(run.series["energy_residual"][-1]) <= 1e-12 * np.abs(run.series["drive_work"]).max()
    return run.time, run.series["tip_normal_displacement"]


def sampled(setup: Setup, turn: float, degree: int, periodic: bool) -> Setup:
    """A setup whose tones are samples."""
    drive = setup.motor.drive
    last = 1.0 / drive.frequency[0] if periodic else setup.duration
    count = int(np.ceil(2.0 * pi * drive.frequency[-1] * last / turn)) + degree + 1
    time = np.linspace(0.0, last, count, endpoint=not periodic)
    waveform = cl.Waveform.sampled(time, drive.voltage(time), degree, last if periodic else None)
    return replace(setup, motor=replace(setup.motor, drive=cl.Drive(waveform=waveform)))


@pytest.mark.parametrize("law", [["law=newton"], ["law=hertz_penalty", "solver.tolerance=1e-12"]])
@pytest.mark.parametrize("periodic", [True, False])
def test_a_sampled_sine_is_the_tone(law: list[str], periodic: bool) -> None:
    setup = cl.build([*law, "solver.duration=5e-3"])
    tones, samples = setup.run(), sampled(setup, 0.15, MOST_DEGREE, periodic).run()
    assert tones.contacts["start_time"].size > 2
    assert samples.contacts["start_time"].size == tones.contacts["start_time"].size
    for name in ("gap", "rotor_velocity", "drive_work"):
        values = tones.series[name]
        assert samples.series[name] == pytest.approx(values, abs=1e-10 * np.abs(values).max()), name


def swinging(long: float) -> PPoly:
    """A piece that swings as Chebyshev's polynomial of the highest degree [V]."""
    swings = Chebyshev.basis(MOST_DEGREE, domain=[0.0, long]).convert(kind=Polynomial, domain=[0.0, long])
    powers = swings.convert(domain=[-1.0, 1.0], window=[-1.0, 1.0]).coef[::-1]
    return PPoly(powers[:, None, None], np.array([0.0, long]))


@pytest.mark.parametrize("law", [cl.MoreauJean(), cl.HertzPenalty()], ids=lambda law: law.name)
def test_the_work_of_a_drive_that_turns_many_times_within_a_step_is_exact(law: cl.ContactLaw) -> None:
    """One piece of degree 7 with six turns: the steps resolve the oscillator, which is slower than that."""
    long = 0.02
    motor = forced(cl.Waveform(swinging(long)), damping=2.0, stiffness=100.0)
    swings = Chebyshev.basis(MOST_DEGREE, domain=[0.0, long])
    ran = simulate(motor, law, duration=0.03, record_interval=1e-3, contact_step=0.01)
    assert ran.statistics["flight_steps"] <= 12

    def motion(time: float, y: Array) -> list[float]:
        force = float(swings(time)) if time <= long else 0.0
        return [y[1], force - 2.0 * y[1] - 100.0 * y[0], force * y[1], 2.0 * y[1] ** 2]

    exact = solve_ivp(motion, (0.0, 0.03), np.zeros(4), "DOP853", ran.time, rtol=1e-11, atol=1e-20)
    work = np.abs(exact.y[2]).max()
    assert ran.series["drive_work"] == pytest.approx(exact.y[2], abs=1e-5 * work)
    assert ran.series["damping_loss"] == pytest.approx(exact.y[3], abs=1e-5 * work)


@pytest.mark.parametrize("degree", [3, 5, 7])
def test_a_spline_misses_a_sine_by_its_order(degree: int) -> None:
    errors = []
    for count in (20, 40):
        time = np.arange(count) / count
        spline = cl.Waveform.sampled(time, np.sin(2.0 * pi * time)[None], degree, 1.0)
        fine = np.linspace(0.0, 1.0, 1009)
        errors.append(np.abs(spline.voltage(fine)[0] - np.sin(2.0 * pi * fine)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(degree + 1, abs=0.3)


def test_a_ramp_moves_an_oscillator_by_the_closed_form() -> None:
    """x = a / k (t - sin(omega t) / omega) under the force a t."""
    ramp = cl.Waveform.sampled(np.array([0.0, 2e-3]), np.array([[0.0, 200.0]]), 1)
    time, x = displacement(forced(ramp), 2e-3)
    omega, rise = 1e4, 1e5
    expected = rise / omega**2 * (time - np.sin(omega * time) / omega)
    assert x == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


@given(st.floats(1e-5, 9e-4), st.floats(1e-5, 9e-4))
@settings(max_examples=10, deadline=None)
def test_a_pulse_moves_an_oscillator_by_the_closed_form(begin: float, length: float) -> None:
    """Before nothing, then x = F / k (1 - cos), and free motion from there: jumps are where they are."""
    pulse = cl.Waveform(PPoly(np.full((1, 1, 1), 5.0), np.array([begin, begin + length])))
    time, x = displacement(forced(pulse), 2e-3)
    omega = 1e4

    def step(since: Array) -> Array:
        return np.where(since > 0.0, 1.0 - np.cos(omega * since), 0.0)

    expected = 5.0 / omega**2 * (step(time - begin) - step(time - begin - length))
    assert x == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_a_chirp_through_resonance_is_that_of_an_independent_integration() -> None:
    """The closed form of the voltage, integrated by DOP853, not the spline of it."""
    chirp = cl.Chirp(first_frequency=1000.0, last_frequency=2200.0, duration=0.02)
    motor = cl.oscillator(1.0, 1e8, damping=50.0, gap=FAR)
    time, x = displacement(replace(motor, drive=chirp.drive()), 0.02)

    def rate(t: float, y: Array) -> list[float]:
        phase = 2.0 * pi * (1000.0 * t + 0.5 * 1200.0 * t * t / 0.02)
        return [y[1], 100.0 * np.sin(phase) - 50.0 * y[1] - 1e8 * y[0]]

    other = solve_ivp(rate, (0.0, 0.02), [0.0, 0.0], "DOP853", time, rtol=1e-13, atol=1e-18)
    assert x == pytest.approx(other.y[0], abs=1e-8 * np.abs(x).max())


@pytest.mark.parametrize("law", ["hertz_penalty", "lagrange_stick"])
def test_a_run_that_goes_on_is_the_uncut_one(law: str) -> None:
    setup = sampled(cl.build([f"law={law}", "solver.duration=3e-3"]), 1.0, 3, periodic=True)
    whole = setup.run()
    first = replace(setup, duration=1.2345e-3).run()
    rest = replace(setup, duration=3e-3 - first.state["end"]).run(start=first.state)
    assert rest.series["rotor_velocity"][-1] == whole.series["rotor_velocity"][-1]
    assert rest.series["energy_residual"][-1] == whole.series["energy_residual"][-1]


def test_the_last_work_of_a_run_is_that_of_its_last_step_wherever_its_records_lie() -> None:
    """The drive turns many times within a step, so that the step's work is a sum of many pieces."""
    motor = forced(cl.Waveform(swinging(0.02)), damping=2.0, stiffness=100.0)
    runs = [
        simulate(motor, cl.HertzPenalty(), duration=0.017, record_interval=interval, contact_step=0.01)
        for interval in (1e-3, 1.3e-3, 1.9e-3, 0.016)
    ]
    assert len({float(run.series["drive_work"][-1]) for run in runs}) == 1


def test_a_periodic_waveform_has_the_steady_state_of_its_tones() -> None:
    setup = cl.build()
    tones, samples = (cl.steady(each) for each in (setup, sampled(setup, 0.3, MOST_DEGREE, periodic=True)))
    assert samples.kind == tones.kind == "periodic"
    assert samples.velocity.value == pytest.approx(tones.velocity.value, rel=1e-7)
    assert np.abs(samples.orbit.multipliers).max() == pytest.approx(
        np.abs(tones.orbit.multipliers).max(), rel=1e-4
    )


def test_a_drive_that_does_not_repeat_itself_has_no_steady_state() -> None:
    with pytest.raises(cl.NoPeriodError):
        cl.steady(sampled(cl.build(), 0.3, 3, periodic=False))


@given(st.integers(0, 3), st.floats(-1.0, 2.0), st.booleans())
def test_a_delayed_waveform_is_the_waveform_later(degree: int, delay: float, periodic: bool) -> None:
    rng = np.random.default_rng(5)
    edges = np.array([0.1, 0.25, 0.7, 1.1])
    waveform = cl.Waveform(PPoly(rng.normal(size=(degree + 1, 3, 2)), edges), periodic)
    time = np.linspace(0.013, 1.9, 101)
    assert waveform.delayed(delay).voltage(time) == pytest.approx(waveform.voltage(time + delay), abs=1e-9)


@pytest.mark.parametrize(
    "make",
    [
        lambda: cl.Waveform(PPoly(np.ones((MOST_DEGREE + 2, 1, 1)), np.array([0.0, 1.0]))),
        lambda: cl.Waveform(PPoly(np.ones((2, 1)), np.array([0.0, 1.0]))),
        lambda: cl.Waveform(PPoly(np.full((1, 1, 1), np.nan), np.array([0.0, 1.0]))),
        lambda: cl.Waveform.sampled(np.array([0.0, 2.0, 1.0, 3.0]), np.zeros((1, 4))),
        lambda: cl.Waveform.sampled(np.arange(3.0), np.zeros((1, 3))),
        lambda: cl.Waveform.sampled(np.arange(9.0), np.zeros((1, 9)), 2),
        lambda: cl.Waveform.sampled(np.arange(9.0), np.zeros((1, 9)), 3, 8.0),
        lambda: cl.Drive(waveform=cl.Waveform.sampled(np.arange(9.0), np.zeros((3, 9)))),
    ],
)
def test_impossible_samples_are_refused(make: object) -> None:
    assert callable(make)
    with pytest.raises(ValueError, match=r"must|takes"):
        make()


def test_samples_of_a_formula_lie_close_enough() -> None:
    drive = cl.Chirp(first_frequency=100.0, last_frequency=900.0, duration=0.05).drive()
    assert drive.waveform is not None
    assert np.diff(drive.waveform.pieces.x[8:-8]).max() * 2.0 * pi * 900.0 <= SAMPLED_TURN * (1.0 + 1e-9)


def test_a_waveform_that_begins_before_zero_is_read_from_its_own_beginning() -> None:
    """Against these samples with their clock ahead: what came before the drive was switched on."""
    time = np.linspace(-1e-3, 1e-3, 9)
    force = np.sin(4e3 * time + 0.3)[None]
    early = cl.Waveform.sampled(time, force, 7)
    shifted = cl.Waveform.sampled(time + 1e-3, force, 7).delayed(1e-3)
    made, expected = (displacement(forced(each), 8e-4)[1] for each in (early, shifted))
    np.testing.assert_allclose(made, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


MICRO = 1e-6


@pytest.mark.parametrize(("samples", "duration"), [(64, 1e-2), (512, 3e-3)])
def test_a_motor_runs_on_a_waveform_of_many_samples_a_period(samples: int, duration: float) -> None:
    """A tip that is led on an ellipse, above a slider: no net impulse of friction at its no-load speed.

    Of a linear contact the slider moves with the tip at the angle phi at which half of the impulse of the
    normal force, over +-acos(c/A), is within +-phi. The ripple of so light a slider is 6e-5 of it.
    """
    frequency, normal, along, clearance = 4e4, 1.0 * MICRO, 2.0 * MICRO, 0.3 * MICRO
    omega, stiffness, radius, root = 2.0 * pi * frequency, 5e6, 0.025, 1e10
    touch = np.arccos(clearance / normal)

    def impulse(phi: float) -> float:
        return float(normal * np.sin(phi) - clearance * phi)

    phi = brentq(lambda each: impulse(each) - 0.5 * impulse(touch), 0.0, touch)
    speed = along * omega * np.cos(phi)
    angle = 2.0 * pi * np.arange(samples) / samples
    volts = np.stack([-normal * np.cos(angle), along * np.sin(angle)])
    waveform = cl.Waveform.sampled(angle / omega, volts, 7, 1.0 / frequency)
    modes = cl.NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.diag([-root, root]),
        tip_displacement=np.array([1.0 / root, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (radius * root)]),
        prescribed=np.array([True, True]),
    )
    motor = cl.Motor(
        modes,
        cl.Drive(waveform=waveform),
        cl.ContactGeometry(radius, radius, clearance),
        cl.Rotor(inertia=1e-3 * radius**2, initial_velocity=speed / radius),
        start=cl.ModalState(np.array([root * normal, 0.0]), np.array([0.0, root * along * omega])),
    )
    law = cl.Composed(cl.Linear(stiffness), cl.Undamped(), cl.Coulomb(0.2))
    run = simulate(motor, law, duration=duration, record_interval=1e-5)
    assert run.complete, run.message
    assert speed == pytest.approx(0.457177, abs=5e-7)
    assert run.series["rotor_velocity"] * radius == pytest.approx(speed, rel=1e-4)
