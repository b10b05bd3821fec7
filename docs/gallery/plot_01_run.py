"""
A run and its picture
=====================

The default motor for 20 ms from rest: rotor velocity, path of the tip, and gap and force over the last
periods of the drive. Colours distinguish slip from stick.
"""

import contactlab as cl

solution = cl.simulate(cl.build())
print(solution)
overview = solution.plot()
