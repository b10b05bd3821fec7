"""Amplitude and phase along branches: linear, bilinear, a Jenkins element, a lever that taps a sample."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, root
from support.harmonic_balance import JenkinsOscillator

import contactlab as cl
from contactlab.simulation import setup_of

Array = np.ndarray


def branch_of(result: cl.Result, law: int = 1) -> xarray.Dataset:
    """Return the branch under one law."""
    return result.data[f"law_{law}"].to_dataset()


def test_without_contact_it_is_that_of_a_linear_oscillator() -> None:
    """X = F/(k - m w^2 + i c w), over frequency and over the force."""
    swing = cl.oscillator(2.0, 2e4, damping=20.0, gap=1.0, force=3.0)
    law = cl.Composed(cl.Linear(3e4))
    for quantity, sign in (("tip_normal_displacement", 1.0), ("gap", -1.0)):
        result = cl.response(swing, "drive.frequency", 15.0, 16.5, law=law, quantity=quantity, step=0.3)
        for data in (branch_of(result), result["linear"].to_dataset()):
            omega = 2.0 * pi * data["value"].values
            expected = sign * 3.0 / (2e4 - 2.0 * omega**2 + 20.0j * omega)
            assert_allclose(data["amplitude"] * np.exp(1j * data["phase"]), expected, rtol=1e-9)
    result = cl.response(swing, "drive.amplitude", 1.0, 2.0, law=law, step=0.5)
    data = branch_of(result)
    omega = 2.0 * pi * 1.0
    assert_allclose(data["amplitude"], data["value"] / abs(2e4 - 2.0 * omega**2 + 20.0j * omega), rtol=1e-9)
    assert_allclose(data["mean"], 0.0, atol=1e-12)


def test_a_bilinear_oscillator_is_in_resonance_at_the_frequency_of_its_halves() -> None:
    """Half a period on each spring: f = 2 f_1 f_2/(f_1 + f_2), at any amplitude (Shaw and Holmes 1983)."""
    mass, first, second = 1.0, 1e4, 3e4
    swing = cl.oscillator(mass, first, damping=2.0, force=1.0, frequency=20.0)
    expected = 2.0 * sqrt(first) * sqrt(first + second) / (sqrt(first) + sqrt(first + second)) / (2.0 * pi)
    result = cl.response(
        swing, "drive.frequency", 0.985 * expected, 1.015 * expected, law=cl.Composed(cl.Linear(second))
    )
    data = branch_of(result)
    # The phase passes a quarter of a turn behind the force; damping shifts that by its square.
    frequency = np.interp(0.5 * pi, -data["phase"], data["value"])
    assert frequency == pytest.approx(expected, rel=1e-4)
    assert bool(data["stable"].all())


def jenkins(
    mass: float, stiffness: float, damping: float, spring: float, limit: float, force: float, frequency: float
) -> tuple[float, complex]:
    """Return mean and part at f of m xdd + c xd + k x + z = F cos(2 pi f t), |z| <= limit, dz = spring dx.

    Stick and slip are linear: each is stepped by its exact map, on a grid and up to where the state changes.
    """
    omega, count = 2.0 * pi * frequency, 2048
    step = 2.0 * pi / omega / count
    sticks = np.array(
        [[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, -1.0 / mass], [0.0, spring, 0.0]]
    )
    matrices = {False: sticks, True: sticks * [[1.0], [1.0], [0.0]]}
    # The steady part is Re A exp(i omega t), the rest an exponential.
    parts = {
        slips: np.linalg.solve(1j * omega * np.eye(3) - matrix, [0.0, force / mass, 0.0])
        for slips, matrix in matrices.items()
    }
    whole = {slips: expm(matrix * step) for slips, matrix in matrices.items()}

    def moved(slips: bool, y: Array, time: float, after: float) -> Array:
        rest = y - (parts[slips] * np.exp(1j * omega * time)).real
        grown = whole[slips] if after == step else expm(matrices[slips] * after)
        return grown @ rest + (parts[slips] * np.exp(1j * omega * (time + after))).real

    def left(slips: bool, y: Array) -> float:
        return float(y[1] * y[2] if slips else limit - abs(y[2]))

    y, slips, values = np.zeros(3), False, np.zeros(count)
    # The slider forgets where it began with its first slip, the rest decays as exp(-c t/(2 m)).
    for number in range(80 * count):
        time, still = number * step, step
        values[number % count] = y[0]
        while still > 0.0:
            ahead = moved(slips, y, time, still)
            if left(slips, ahead) >= 0.0:
                y, still = ahead, 0.0
                continue
            after = brentq(lambda s, k=slips, y=y, t=time: left(k, moved(k, y, t, s)), 0.0, still, xtol=1e-15)
            y = moved(slips, y, time, after)
            if not slips:
                y[2] = np.copysign(limit, y[2])
            slips, time, still = not slips, time + after, still - after
    harmonic = 2.0 * np.mean(values * np.exp(-1j * omega * step * np.arange(count)))
    return float(values.mean()), complex(harmonic)


def test_a_block_on_a_jenkins_element_is_the_exact_one_from_stick_to_slip() -> None:
    mass, stiffness, damping, spring, load, force = 1.0, 1e4, 10.0, 1e4, 10.0, 8.0
    normal = 1e5
    block = cl.block(
        mass,
        height=-load / normal,
        weight=load,
        stiffness=stiffness,
        damping=damping,
        normal_damping=600.0,
        push_amplitude=force,
        push_frequency=14.0,
    )
    law = cl.Composed(cl.Linear(normal), friction=cl.Mindlin(0.3, stiffness_ratio=spring / normal))
    setup = setup_of(block, law, {"duration": 1.0, "contact_step": 1e-3})
    result = cl.response(
        setup, "drive.frequency", 14.0, 19.0, quantity="tip_tangential_displacement", step=0.5
    )
    data = branch_of(result)
    assert data.sizes["point"] > 5
    for point in (0, data.sizes["point"] // 2, data.sizes["point"] - 1):
        each = data.isel(point=point)
        mean, part = jenkins(mass, stiffness, damping, spring, 0.3 * load, force, float(each["value"]))
        result_part = complex(float(each["amplitude"]) * np.exp(1j * float(each["phase"])))
        assert abs(result_part - part) < 1e-6 * abs(part)
        assert float(each["mean"]) == pytest.approx(mean, abs=1e-6 * abs(part))
    # The harmonic balance comes to the same by another way; a single harmonic is up to 0.5 % off.
    judge = JenkinsOscillator(mass, stiffness, damping, spring, 0.3 * load)
    frequencies, amplitudes = data["value"].values, data["amplitude"].values
    for harmonics, least, most in ((8, 0.0, 2e-5), (1, 3e-3, 8e-3)):
        balanced = [abs(judge.balanced(force, f, harmonics)[0]) for f in frequencies]
        assert least <= np.abs(balanced / amplitudes - 1.0).max() < most
    alone = [abs(judge.single_harmonic(force, f)) for f in frequencies]
    assert_allclose(balanced, alone, rtol=1e-5)


@pytest.mark.parametrize("work", [5e-4, pytest.param(0.0, marks=pytest.mark.long)])
def test_a_lever_taps_a_sample_as_its_own_integration_does(work: float) -> None:
    """Amplitude and phase over distance of one mode, Q = 100 at resonance, under Hertz and under DMT."""
    quality, modulus, radius = 100.0, 1e9, 1e-3
    lever = cl.cantilever(modes=1, damping_ratio=0.5 / quality, gap=12e-6, acceleration=0.018)
    modes, frequency = lever.modes, float(lever.modes.natural_frequency[0])
    lever = replace(lever, drive=lever.drive.with_first_tone(frequency))
    normal = cl.Dmt(radius, modulus, work) if work else cl.HertzPoint(4.0 / 3.0 * modulus * radius**0.5)
    law = cl.Composed(normal, friction=cl.Coulomb(0.0))
    data = branch_of(cl.response(lever, "contact.clearance", 12e-6, 8e-6, law=law))
    assert data["stable"].all()
    assert_allclose(data["value"][[0, -1]], [12e-6, 8e-6])
    end, omega, row = data.isel(point=-1), 2.0 * pi * frequency, float(modes.tip_displacement[0])

    def flow(t: float, y: Array) -> list[float]:
        depth = row * y[0] - 8e-6
        normal = (
            4.0 / 3.0 * modulus * radius**0.5 * depth**1.5 - 2.0 * pi * work * radius if depth > 0.0 else 0.0
        )
        pushed = 0.018 * modes.coupling[0, 0] * np.cos(omega * t) - row * normal
        return [y[1], pushed - modes.damping[0] * y[1] - modes.stiffness[0] * y[0]]

    def after(y: Array, times: Array | None = None) -> Array:
        span = (0.0, 2.0 * pi / omega)
        solved = solve_ivp(
            flow, span, y / [1.0, 1.0 / omega], "DOP853", times, rtol=1e-10, atol=1e-17, max_step=1e-4
        )
        return solved.y * [[1.0], [1.0 / omega]]

    # The orbit of a map of one's own, from an amplitude of the distance and a sixth of a turn late.
    guess = 8e-6 / row * np.exp(2j * pi / 3.0) * np.exp(1j * np.angle(modes.coupling[0, 0]))
    orbit = root(lambda y: (after(y)[:, -1] - y) * 1e5, [guess.real, -guess.imag], tol=1e-12)
    assert orbit.success
    times = np.arange(512) * (2.0 * pi / omega / 512)
    motion = row * after(orbit.x, times)[0]
    part = 2.0 * np.mean(motion * np.exp(-1j * omega * times))
    assert abs(float(end["amplitude"]) * np.exp(1j * float(end["phase"])) - part) < 1e-5 * abs(part)
    assert float(end["mean"]) == pytest.approx(float(motion.mean()), abs=1e-5 * abs(part))
