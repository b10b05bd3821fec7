"""
Which start leads where
=======================

Near the end of its branch the motor under Newton's restitution has two motions, and the start decides which
one it comes to. Each of these starts has a tip velocity and a phase of the drive of its own.
"""

import numpy as np

import contactlab as cl

setup = cl.build(["law=newton", "contact.clearance=3.895e-6"])
starts = {
    "tip_velocity": np.linspace(-0.3, 0.3, 20),
    "drive_phase": np.linspace(0.0, 1.0, 20, endpoint=False),
}
basins = cl.basins(setup, starts)
picture = basins.plot()
