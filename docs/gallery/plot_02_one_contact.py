"""
One contact under three laws
============================

The first touch-down of the same motor, under a Hertzian contact, one with a Hunt-Crossley damping, and a
linear spring that a dashpot damps. A compliant law has a force; a rigid one has an impulse and no force of
its own.
"""

import matplotlib.pyplot as plt

import contactlab as cl

laws = {
    "Hertz": cl.Composed(),
    "Hertz, Hunt-Crossley": cl.Composed(damping=cl.HuntCrossley()),
    "spring and dashpot": cl.Composed(cl.Linear(stiffness=2e7), cl.LinearDamping()),
}
motor = cl.build().motor
figure, (above, below) = plt.subplots(2, sharex=True, figsize=(6.2, 4.2), layout="constrained")
for name, law in laws.items():
    run = cl.simulate(motor, law, duration=2.4e-4, record_interval=2e-7)
    time = 1e6 * run["time"]
    above.plot(time, run["normal_force"], label=name)
    below.plot(time, run["friction_force"])
above.set(ylabel="normal force (N)", xlim=(125, 200))
below.set(ylabel="friction (N)", xlabel="time (us)")
above.legend()
plt.show()
