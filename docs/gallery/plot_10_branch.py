"""
Orbits over the clearance
=========================

`cl.branch` follows a steady state while a number changes, through folds and along orbits that no run would
ever show, because they are unstable. Solid lines are stable; marks are where something happens to them.
"""

import matplotlib.pyplot as plt

import contactlab as cl
from contactlab.studies.orbit_figures import draw_curve

# %%
# As the clearance grows the tip reaches the rotor later and later, until it does not at all. On the right is
# the end of the branches: a rigid law folds there, and two motions share a clearance.

figure, panels = plt.subplots(2, 2, figsize=(7.0, 4.2), sharex="col", layout="constrained")
for number, law in enumerate(("hertz_penalty", "lagrange_stick", "newton")):
    branch = cl.branch(cl.build([f"law={law}"]), "contact.clearance", 1e-6, 4.5e-6)
    print(f"{law}: {branch.end}")
    data = branch.to_xarray()
    for upper, lower in panels.T:
        draw_curve(upper, data, "rotor_velocity", law, f"C{number}")
        draw_curve(lower, data, "largest_multiplier", law, f"C{number}")

for lower in panels[1]:
    lower.axhline(1.0, color="0.6", linewidth=0.6, zorder=0)
    lower.set(xlabel="clearance (um)", ylim=(0.96, 1.04))
panels[0, 0].set_ylabel("rotor velocity (rad/s)")
panels[1, 0].set_ylabel("largest multiplier")
panels[0, 1].set(xlim=(3.885, 3.9), ylim=(1.6, 2.6))
panels[0, 0].legend()
plt.show()
