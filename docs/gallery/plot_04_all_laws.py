"""
Every law at one contact
========================

The first touch-down of the same motor, from the same start, under every law that is installed. A compliant
law pushes with a force over some tens of microseconds, a rigid one with an impulse in no time, which no force
shows; what both have is the impulse that they have given so far.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

# %%
# Each law has its usual values. The times of rigid contacts differ from those of compliant ones because a
# rigid one is over at once, and the tip may come back.

names = cl.law_names()
figure, panels = plt.subplots(
    -(-len(names) // 4), 4, figsize=(7.2, 5.6), sharex=True, sharey=True, layout="constrained"
)
for axes, name in zip(panels.flat, names, strict=False):
    run = cl.simulate(cl.build([f"law={name}"]), duration=2.2e-4, record_interval=2e-7)
    time, step = 1e6 * run["time"], np.diff(run["time"], prepend=0.0)
    for force, colour in (("normal_force", "C0"), ("friction_force", "C1")):
        impulse = 1e6 * np.cumsum(run[force] * step)
        axes.plot(time, impulse, color=colour, label=force.replace("_", " "))
    axes.set(title=name, xlim=(120, 220))
for axes in panels.flat[len(names) :]:
    axes.axis("off")
handles, labels = panels[0, 0].get_legend_handles_labels()
panels.flat[-1].legend(handles, ["normal", "friction"], loc="center")
figure.supxlabel("time (us)", fontsize=8)
figure.supylabel("impulse so far (uN s)", fontsize=8)
plt.show()
