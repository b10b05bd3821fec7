"""
A law by itself
===============

A law can be evaluated without a motor. A steel ball hits a plate at 1 m/s, at every angle from normal to
grazing, and each law gives its rebound: the restitution of the normal velocity and of the slip.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

mass = 2e-3
sphere = np.diag([1.0, 3.5]) / mass
angle = np.linspace(1.0, 85.0, 120)
before = np.column_stack([-np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])

# %%
# A ball that grips has lost all slip, and one that slides keeps the most of it; a spring along the contact,
# as Mindlin's, turns the slip round where the ball grips. A rigid law does that by a number.

laws = {
    "Newton": cl.Newton(friction_coefficient=0.2, restitution=0.8),
    "Chatterjee-Ruina": cl.ChatterjeeRuina(0.2, 0.8, tangential_restitution=0.5),
    "Hertz, Coulomb": cl.HertzPenalty(friction_coefficient=0.2),
    "Hertz, Mindlin": cl.Composed(cl.HertzPoint(), friction=cl.Mindlin(friction_coefficient=0.2)),
    "Thornton, Coulomb": cl.Composed(cl.Thornton(), friction=cl.Coulomb(friction_coefficient=0.2)),
}
figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 3.0), sharex=True, layout="constrained")
for style, (name, law) in zip(("-", "-", "--", "-", "-."), laws.items(), strict=True):
    after = cl.impact(law, sphere, before).velocity_after
    left.plot(angle, -after[:, 0] / before[:, 0], style, label=name)
    right.plot(angle, -after[:, 1] / before[:, 1], style)
left.set(xlabel="incidence (degrees)", ylabel="normal restitution", ylim=(0.0, 1.1))
right.set(xlabel="incidence (degrees)", ylabel="tangential restitution")
right.axhline(0.0, color="0.6", linewidth=0.6)
left.legend(loc="lower left")
plt.show()

# %%
# A compliant law tells what happens in between. The friction of Mindlin's law swings, and is the spring's
# until it meets the cone, which is drawn in grey.

law = laws["Hertz, Mindlin"]
chosen = (10.0, 25.0, 60.0)
oblique = [[-np.cos(a), np.sin(a)] for a in np.deg2rad(chosen)]
history = cl.impact(law, sphere, oblique, history=200)
figure, axes = plt.subplots(1, 3, figsize=(7.0, 2.4), sharey=True, layout="constrained")
for number, panel in enumerate(axes):
    impact = history.isel(impact=number)
    time, limit = 1e6 * impact.time, 0.2 * impact.normal_force
    panel.plot(time, impact.normal_force, color="0.6", label="normal force")
    panel.fill_between(time, -limit, limit, color="0.9", linewidth=0.0, label="friction cone")
    panel.plot(time, impact.friction_force, color="C1", label="friction")
    panel.set(title=f"{chosen[number]:g} degrees", xlabel="time (us)")
axes[0].set_ylabel("force (N)")
axes[0].legend(loc="upper right")
plt.show()
