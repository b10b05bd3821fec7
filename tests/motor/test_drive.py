"""Phasors give the voltages of eqs. 1 and 2, and whatever else is asked of them."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from contactlab.motor.drive import Drive

amplitude = st.floats(-500.0, 500.0)


@settings(deadline=None)
@given(
    voltage_1=amplitude,
    voltage_2=amplitude,
    frequency=st.floats(1.0, 1e5),
    ratio=st.floats(0.1, 5.0),
    phase=st.floats(-7.0, 7.0),
    time=st.floats(0.0, 1e-2),
)
def test_two_mode_drive_is_the_sum_and_the_difference_of_two_sines(
    voltage_1: float, voltage_2: float, frequency: float, ratio: float, phase: float, time: float
) -> None:
    omega = 2.0 * np.pi * frequency
    first = voltage_1 * np.sin(omega * time + phase)
    second = voltage_2 * np.sin(ratio * omega * time)
    voltages = Drive.two_mode(voltage_1, voltage_2, frequency, ratio, phase).voltage(time)
    # Round-off of the phase, up to 3e4 rad, times the amplitude.
    assert voltages == pytest.approx([first + second, first - second], abs=1e-8)


def test_phase_belongs_to_the_first_tone_and_shifts_it_forward() -> None:
    drive = Drive.two_mode(100.0, 0.0, 1000.0, phase=np.pi / 2.0)
    assert drive.voltage(0.0) == pytest.approx([100.0, 100.0])
    assert drive.voltage(0.25e-3) == pytest.approx([0.0, 0.0], abs=1e-10)
    second = Drive.two_mode(0.0, 100.0, 1000.0, phase=np.pi / 2.0)
    assert second.voltage(0.0) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert second.voltage(0.125e-3) == pytest.approx([100.0, -100.0])


def test_second_tone_is_twice_the_first_unless_asked_otherwise() -> None:
    assert Drive.two_mode(1.0, 1.0, 3210.0).frequency.tolist() == [3210.0, 6420.0]
    assert Drive.two_mode(1.0, 1.0, 3210.0, 1.5).frequency.tolist() == [3210.0, 4815.0]


def test_a_negative_second_voltage_exchanges_the_electrodes() -> None:
    time = np.linspace(0.0, 1e-3, 57)
    plus = Drive.two_mode(100.0, 60.0, 3210.0, 2.0, -0.6).voltage(time)
    minus = Drive.two_mode(100.0, -60.0, 3210.0, 2.0, -0.6).voltage(time)
    assert np.array_equal(plus, minus[::-1])


def test_a_phasor_is_amplitude_and_phase_of_a_cosine() -> None:
    drive = Drive(np.array([50.0]), np.array([[3.0 * np.exp(0.4j)], [2.0j]]))
    time = np.linspace(0.0, 0.1, 33)
    omega = 2.0 * np.pi * 50.0
    expected = [3.0 * np.cos(omega * time + 0.4), -2.0 * np.sin(omega * time)]
    assert drive.voltage(time) == pytest.approx(np.array(expected), abs=1e-12)


@settings(deadline=None)
@given(st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_any_number_of_tones_adds_up(tones: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    frequency = rng.uniform(1.0, 1e4, tones)
    phasors = rng.normal(size=(2, tones)) + 1j * rng.normal(size=(2, tones))
    time = rng.uniform(0.0, 1e-2, 5)
    alone = [Drive(frequency[k : k + 1], phasors[:, k : k + 1]).voltage(time) for k in range(tones)]
    assert Drive(frequency, phasors).voltage(time) == pytest.approx(sum(alone), abs=1e-12)


def test_voltage_has_one_row_an_electrode_and_the_shape_of_time() -> None:
    drive = Drive.two_mode(1.0, 1.0, 100.0)
    assert drive.voltage(0.0).shape == (2,)
    assert drive.voltage(np.zeros(5)).shape == (2, 5)


def test_angular_frequency_counts_radians() -> None:
    assert Drive.two_mode(1.0, 1.0, 1.0).angular_frequency == pytest.approx([6.2831853, 12.5663706])


@pytest.mark.parametrize("frequency", [0.0, -3210.0, float("nan")])
def test_a_tone_that_is_not_positive_is_refused_with_its_value(frequency: float) -> None:
    with pytest.raises(ValueError, match=r"frequency is .*; it must be (at least 1e-09 Hz|finite)"):
        Drive.two_mode(100.0, 100.0, frequency)


def test_phasors_that_do_not_fit_the_tones_are_refused_with_both_shapes() -> None:
    with pytest.raises(ValueError, match=r"phasors has shape \(2, 1\); it must have shape \(2, 2\)"):
        Drive(np.array([1.0, 2.0]), np.ones((2, 1), dtype=np.complex128))
    with pytest.raises(ValueError, match=r"must have shape \(2, 1\), a row for each of two electrodes"):
        Drive(np.array([1.0]), np.ones((3, 1), dtype=np.complex128))
