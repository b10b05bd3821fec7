"""
Loops of friction
=================

Laws of friction on one prescribed path, without a motor: to and fro under a constant gap, with a small swing
inside a large one. What returns to where it turned differs from law to law.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

time = np.linspace(0.0, 1e-3, 1001)
turn = 2e3 * np.pi * time
path = 1e-6 * (np.sin(turn) + 0.5 * np.sin(3.0 * turn))
frictions = {
    "Coulomb": cl.Coulomb(),
    "Mindlin": cl.Mindlin(),
    "Dahl": cl.Dahl(),
    "Iwan": cl.Iwan(full_slip=5e-7),
}
figure, panels = plt.subplots(2, 2, sharex=True, sharey=True, figsize=(6.2, 4.6), layout="constrained")
for axes, (name, friction) in zip(panels.flat, frictions.items(), strict=True):
    loop = cl.drive(
        cl.Composed(friction=friction),
        time[:-1],
        gap=-1e-6,
        slip=path[:-1],
        degree=7,
        period=1e-3,
        duration=2e-3,
    )
    middle = 0.5 * (
        loop["tip_tangential_displacement"].values[1:] + loop["tip_tangential_displacement"].values[:-1]
    )
    axes.plot(1e6 * middle, loop["friction_force"][1:])
    axes.set_title(name)
for axes in panels[-1]:
    axes.set_xlabel("displacement (um)")
for axes in panels[:, 0]:
    axes.set_ylabel("friction (N)")
plt.show()
