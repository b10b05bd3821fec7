"""
A map of the motor
==================

One sweep over clearance and phase between the tones, 775 motors: how fast the rotor turns after 3 ms, and
which way. Numbers alone are kept, and a motor costs a few milliseconds.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

swept = cl.sweep(
    {"contact.clearance": np.linspace(0.0, 2e-6, 25), "drive.phase": np.linspace(-np.pi, np.pi, 31)},
    base=["solver.duration=3e-3"],
    workers=1,
)
velocity = swept["final_rotor_velocity"].transpose("clearance", "phase")

# %%
# White is a motor that stands. A quarter turn of the phase changes the sense of rotation, and after half a
# turn all is as before: with tones at 1 : 2 that is the same motor, begun at another time.

figure, axes = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
largest = float(np.abs(velocity).max())
shown = axes.pcolormesh(
    velocity["phase"], 1e6 * velocity["clearance"], velocity, cmap="PuOr", vmin=-largest, vmax=largest
)
axes.contour(velocity["phase"], 1e6 * velocity["clearance"], velocity, [0.0], colors="0.3", linewidths=0.8)
figure.colorbar(shown, label="rotor velocity after 3 ms (rad/s)")
axes.set(xlabel="phase (rad)", ylabel="clearance (um)")
plt.show()
