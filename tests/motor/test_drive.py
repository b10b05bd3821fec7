"""Phasors give the voltages of eqs. 1 and 2."""

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


@pytest.mark.parametrize("frequency", [0.0, -3210.0, float("nan")])
def test_a_tone_that_is_not_positive_is_refused_with_its_value(frequency: float) -> None:
    with pytest.raises(ValueError, match="frequency"):
        Drive.two_mode(100.0, 100.0, frequency)
