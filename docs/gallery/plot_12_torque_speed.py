"""
Torque over speed
=================

A belt holds the rotor at a velocity, and the mean torque on it is what the motor gives there. Each point is
a steady state, found by shooting. The motor turns in the negative sense; the curve is drawn in its own.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

velocities = np.linspace(0.0, -3.0, 7)
figure, axes = plt.subplots(layout="constrained")
setup = cl.build(["law=hertz_penalty"])
torques = [cl.steady(setup, belt=each).torque[0] for each in velocities]
axes.plot(-velocities, -1e3 * np.array(torques), "o-", label="hertz_penalty")
free = cl.steady(setup).velocity[0]
axes.plot(-free, 0.0, "k*", markersize=8, label="free rotor")
axes.axhline(0.0, color="0.6", linewidth=0.6)
axes.set(xlabel="rotor velocity (rad/s)", ylabel="torque (mN m)")
axes.legend()
plt.show()
