"""
A waveform of your own
======================

A drive is any number of tones, so a square wave is its harmonics. What both electrodes share drives one
bending mode, what they have with opposite signs the other: here a sine of twice the frequency on the second,
and three waveforms on the first.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

frequency, amplitude, count = 3210.0, 100.0, 4
turn = np.arange(512) / 512


def tones(waveform: np.ndarray) -> np.ndarray:
    """Complex amplitudes of the first harmonics of one period."""
    return 2.0 * np.fft.rfft(waveform)[1 : count + 1] / waveform.size


angle = 2.0 * np.pi * turn
first = {
    "sine": np.sin(angle - 0.63),
    "triangle": 2.0 / np.pi * np.arcsin(np.sin(angle - 0.63)),
    "square": np.sign(np.sin(angle - 0.63)),
}
second = np.sin(2.0 * angle)

# %%
# The motor is the default one in all but its drive. The tip goes another way under each, and the rotor comes
# to another velocity.

setup = cl.build()
figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.2), width_ratios=(1, 1.3), layout="constrained")
for name, waveform in first.items():
    shared, opposite = amplitude * tones(waveform), amplitude * tones(second)
    drive = cl.Drive(frequency * np.arange(1, count + 1), np.array([shared + opposite, shared - opposite]))
    motor = cl.Motor(setup.motor.modes, drive, setup.motor.geometry, setup.motor.rotor)
    run = cl.simulate(motor, setup.law, duration=0.06)
    right.plot(1e3 * run["time"], run["rotor_velocity"], label=name)
    last = run["time"] > 0.06 - 1.0 / frequency
    left.plot(1e6 * run["tip_tangential_displacement"][last], -1e6 * run["gap"][last])
left.axhline(0.0, color="0.6", linewidth=0.6)
left.set(
    xlabel="along the rotor (um)",
    ylabel="into the rotor (um)",
    title="path of the tip at the end",
    aspect="equal",
)
right.set(xlabel="time (ms)", ylabel="rotor velocity (rad/s)")
right.legend(title="waveform of the first mode")
plt.show()
