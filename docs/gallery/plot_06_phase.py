"""
The phase between the tones
===========================

The rotor velocity after 2 ms over the phase of the first tone, under a compliant and a rigid law. The phase
decides the sense of rotation, and the laws do not agree where. It is one sweep over law and phase.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

sweep = cl.sweep(
    {"law": ["hertz_penalty", "lagrange_stick"], "drive.phase": np.linspace(-np.pi, np.pi, 25)},
    base=["solver.duration=2e-3"],
    workers=1,
)
figure, axes = plt.subplots(layout="constrained")
for law in sweep["law"].values:
    of_law = sweep["final_rotor_velocity"].sel(law=law)
    axes.plot(of_law["phase"], of_law, ".-", label=str(law))
axes.set(xlabel="phase (rad)", ylabel="rotor velocity after 2 ms (rad/s)")
axes.legend()
plt.show()
