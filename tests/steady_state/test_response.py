"""Amplitude and phase along branches: linear, bilinear, a Jenkins element, a lever over an adhesive sample."""

from collections.abc import Callable
from math import pi, sqrt

import numpy as np
import pytest
import xarray
from numpy.testing import assert_allclose
from scipy.linalg import expm

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

    Stick and slip are linear; each is stepped by its exact map, on a grid and up to where the state changes.
    """
    omega = 2.0 * pi * frequency
    count = 4096
    step = 2.0 * pi / omega / count
    sticks = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, -1.0 / mass], [0.0, spring, 0.0]])
    slips = sticks.copy()
    slips[2] = 0.0

    def motion(matrix: Array, start: Array, time: float) -> Callable[[float], Array]:
        """Return the exact motion from a start, with the force from a time on."""
        push = np.array([0.0, force / mass, 0.0])
        # A steady part Re A exp(i omega t), and the rest by the exponential.
        part = np.linalg.solve(1j * omega * np.eye(3) - matrix, push)
        rest = start - (part * np.exp(1j * omega * time)).real
        return lambda after: (
            expm(matrix * after) @ rest + (part * np.exp(1j * omega * (time + after))).real
        )

    whole = {False: expm(sticks * step), True: expm(slips * step)}
    parts = {
        kind: np.linalg.solve(1j * omega * np.eye(3) - matrix, np.array([0.0, force / mass, 0.0]))
        for kind, matrix in ((False, sticks), (True, slips))
    }
    state, sliding, values = np.zeros(3), False, []
    for turn in range(60):
        values = []
        for number in range(count):
            time, left = number * step, step
            values.append(state[0])
            while left > 0.0:
                matrix = slips if sliding else sticks
                if left == step:
                    rest = state - (parts[sliding] * np.exp(1j * omega * time)).real
                    ahead = whole[sliding] @ rest + (parts[sliding] * np.exp(1j * omega * (time + step))).real
                else:
                    ahead = motion(matrix, state, time)(left)
                sense = np.sign(state[2])

                def crossed(at: Array, sliding: bool = sliding, sense: float = sense) -> float:
                    return float(at[1] * sense if sliding else limit - abs(at[2]))

                if crossed(ahead) >= 0.0:
                    state, left = ahead, 0.0
                    continue
                path = motion(matrix, state, time)
                low, high = 0.0, left
                for _ in range(60):
                    middle = 0.5 * (low + high)
                    low, high = (middle, high) if crossed(path(middle)) >= 0.0 else (low, middle)
                state = path(high)
                if not sliding:
                    state[2] = np.copysign(limit, state[2])
                sliding = not sliding
                time, left = time + high, left - high
        if turn == 0:
            continue
    x, t = np.array(values), np.arange(count) * step
    return float(x.mean()), complex(2.0 * np.mean(x * np.exp(-1j * omega * t)))


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
    result = cl.response(setup, "drive.frequency", 14.0, 19.0, quantity="tip_tangential_displacement", step=0.5)
    data = branch_of(result)
    assert data.sizes["point"] > 5
    for point in (0, data.sizes["point"] // 2, data.sizes["point"] - 1):
        each = data.isel(point=point)
        mean, part = jenkins(mass, stiffness, damping, spring, 0.3 * load, force, float(each["value"]))
        result_part = complex(float(each["amplitude"]) * np.exp(1j * float(each["phase"])))
        assert abs(result_part - part) < 1e-6 * abs(part)
        assert float(each["mean"]) == pytest.approx(mean, abs=1e-6 * abs(part))
