"""
How a motor settles
===================

Floquet's multipliers tell what a period of the drive leaves of a deviation from the steady state. The
largest is that of the slow rotor, and with it the run comes to the velocity that was found without waiting
for it.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

setup = cl.build(["solver.duration=0.06", "record.interval=1e-5"])
state = cl.steady(setup)
run = cl.simulate(setup)

figure, (left, right) = plt.subplots(1, 2, figsize=(6.6, 3.0), width_ratios=(1, 1.6), layout="constrained")
angle = np.linspace(0.0, 2.0 * np.pi, 200)
left.plot(np.cos(angle), np.sin(angle), color="0.7", linewidth=0.8)
left.plot(state.orbit.multipliers.real, state.orbit.multipliers.imag, "o")
left.set(aspect="equal", xlabel="real part", ylabel="imaginary part", title="multipliers")

time = run["time"].values
velocity, settling = state.velocity.value, state.orbit.settling_time
right.plot(1e3 * time, run["rotor_velocity"], label="run")
right.plot(1e3 * time, velocity * (1.0 - np.exp(-time / settling)), "--", label="settles by the largest")
right.axhline(velocity, color="0.6", linewidth=0.6)
right.set(xlabel="time (ms)", ylabel="rotor velocity (rad/s)")
right.legend()
plt.show()
