"""
Classics of contact laws
========================

The loops and curves by which laws of friction and adhesion are known, each on its own prescribed path and
beside its closed form (dots) where it has one.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactlab as cl

normal, mu = 10.0, 0.3
turn = np.linspace(0.0, 1.0, 801)
swing = 2e-6 * np.sin(2.0 * np.pi * turn)


def friction_over_way(run):
    """Mean displacement (um) and friction against it (N) of every record interval."""
    way = 1e6 * run["tip_tangential_displacement"].values
    return 0.5 * (way[1:] + way[:-1]), -run["friction_force"].values[1:]


# %%
# **Dahl and LuGre.** Bristles of one stiffness. Dahl's loop depends on the displacement alone: up the branch
# it is F_c - (F_c + F_0) exp(-(x + X)/l), with F_0 = F_c tanh(X/l) and l = F_c/k. LuGre's bristles are damped
# and drag less the faster they slide, so that a slow loop breaks away at a peak.

length = 2e-7
dahl = cl.Composed(friction=cl.Dahl(mu, rest_stiffness=mu / length))
lugre = cl.Composed(friction=cl.LuGre(mu, 1.4, mu / length, bristle_damping=0.1, stribeck_velocity=1e-4))

figure, (left, right) = plt.subplots(1, 2, figsize=(6.6, 3.0), sharey=True, layout="constrained")
run = cl.drive(dahl, turn[:-1], normal=normal, slip=swing[:-1], degree=7, period=1.0, duration=3.0)
left.plot(*friction_over_way(run))
x, most = np.linspace(-2e-6, 2e-6, 24), mu * normal
branch = most - most * (1.0 + np.tanh(2e-6 / length)) * np.exp(-(x + 2e-6) / length)
left.plot(1e6 * x, branch, "k.", markersize=4)
left.plot(-1e6 * x, -branch, "k.", markersize=4)
left.set(title="Dahl", xlabel="displacement (um)", ylabel="friction (N)")
x = np.linspace(-0.8e-6, 1e-6, 13)
for period in (1.0, 0.1):
    time = period * turn[:-1]
    run = cl.drive(lugre, time, normal=normal, slip=swing[:-1], degree=7, period=period, duration=2 * period)
    speed = 2.0 * np.pi / period * np.sqrt(4e-12 - x**2)
    right.plot(*friction_over_way(run), label=f"up to {4.0 * np.pi / period:.0f} um/s")
    steady = most * (1.0 + 0.4 * np.exp(-((speed / 1e-4) ** 2)))
    right.plot(1e6 * x, steady, "k.", markersize=4)
    right.plot(-1e6 * x, -steady, "k.", markersize=4)
right.set(title="LuGre", xlabel="displacement (um)")
right.legend(loc="lower center", bbox_to_anchor=(0.5, 0.22), frameon=False)
plt.show()

# %%
# **Mindlin's spring under a falling normal force.** It is stretched, then held while the normal force falls.
# The contact that is lost takes its share of the force along, F ~ k_t ~ N^(1/3), until the cone, grey, is
# met, along which it slides. **Iwan's elements** load along mu N (1 - (1 - x/x_s)^(3/2)), the backbone. By
# Masing's rule all other branches are that curve, twice as large.

figure, (left, right) = plt.subplots(1, 2, figsize=(6.6, 3.0), layout="constrained")
time = np.linspace(0.0, 2.0, 801)
law = cl.Composed(cl.HertzPoint(1e10), friction=cl.Mindlin(mu))
pressed = normal * np.where(time < 1.0, 1.0, 1.0 - 0.99 * (time - 1.0))
run = cl.drive(law, time, normal=pressed, slip=1e-7 * np.minimum(time, 1.0), degree=1)
resting = run["time"].values[1:] > 1.0
under = run["normal_force"].values[1:]
left.fill_between([0.0, normal], [0.0, mu * normal], color="0.9", linewidth=0.0, label="cone")
left.plot(under[resting], -run["friction_force"].values[1:][resting])
load = np.linspace(2.6, normal, 12)
stiffness = 0.82 * 1.5 * 1e10 ** (2.0 / 3.0) * load ** (1.0 / 3.0)
left.plot(load, stiffness * 1e-7, "k.", markersize=4)
left.set(title="Mindlin, held", xlabel="normal force (N)", ylabel="friction (N)")
left.set(xlim=(0.0, normal), ylim=(0.0, 2.0))
left.legend(loc="upper left", frameon=False)

whole = 2e-6
law = cl.Composed(friction=cl.Iwan(mu, elements=40, full_slip=whole))
run = cl.drive(law, turn, normal=normal, slip=1.5e-6 * np.sin(2.5 * np.pi * turn), degree=7)
right.plot(*friction_over_way(run))


def backbone(x):
    """First loading (N)."""
    return mu * normal * (1.0 - (1.0 - x / whole) ** 1.5)


x = np.linspace(0.0, 1.5e-6, 12)
right.plot(1e6 * x, backbone(x), "k.", markersize=4, label="backbone")
back = 1.5e-6 - 2.0 * x
right.plot(1e6 * back, backbone(1.5e-6) - 2.0 * backbone(x), "k.", markersize=4)
right.plot(-1e6 * back, -backbone(1.5e-6) + 2.0 * backbone(x), "k.", markersize=4)
right.set(title="Iwan", xlabel="displacement (um)")
plt.show()

# %%
# **Rate and state.** A step to ten times the velocity raises friction at once by a ln 10, and then lets it
# fall by b ln 10 over a few D. Held at rest, the contact ages as t; when it slides on, friction begins above
# the steady value by b ln(1 + v t/D), of a rigid machine.

a, b, distance, slow = 0.01, 0.015, 1e-5, 1e-6
rate_and_state = cl.RateAndState(
    0.6, a, b, distance, reference_velocity=slow, fresh_age=distance / slow, creep_velocity=1e-12
)
law = cl.Composed(friction=rate_and_state)


def coefficient(run):
    """Mean coefficient of friction of every record interval."""
    return -run["friction_force"].values[1:] / normal


figure, (left, right) = plt.subplots(1, 2, figsize=(6.6, 3.0), layout="constrained")
times = np.array([0.0, 20.0, 30.0, 90.0])
way = np.cumsum([0.0, 20.0 * slow, 100.0 * slow, 60.0 * slow])
run = cl.drive(law, times, normal=normal, slip=way, degree=1, record_interval=0.05)
left.plot(1e6 * run["tip_tangential_displacement"].values[1:], coefficient(run))
x = np.linspace(0.0, 100.0, 16)[1:]
age = 0.1 + 0.9 * np.exp(-x / 10.0)
left.plot(20.0 + x, 0.6 + a * np.log(10.0) + b * np.log(age), "k.", markersize=4)
left.set(title="velocity steps", xlabel="displacement (um)", ylabel="friction / normal force")

peaks, holds = [], np.array([1.0, 10.0, 100.0, 1000.0])
for hold in holds:
    times = np.cumsum([0.0, 20.0, hold, 20.0])
    way = np.cumsum([0.0, 20.0 * slow, 0.0, 20.0 * slow])
    run = cl.drive(law, times, normal=normal, slip=way, degree=1, record_interval=0.02)
    peaks.append(coefficient(run)[run["time"].values[1:] > 20.0 + hold].max())
hold = np.geomspace(1.0, 1000.0, 16)
right.semilogx(holds, peaks, "o", label="peak after the hold")
right.semilogx(hold, 0.6 + b * np.log1p(slow * hold / distance), "k.", markersize=4, label="closed form")
right.set(title="slide, hold, slide", xlabel="hold (s)")
right.legend(loc="upper left", frameon=False)
plt.show()

# %%
# **JKR.** A sphere comes near, jumps into contact at a pull of 8/9 F_c, is pressed, and pulled off: a neck
# holds it beyond the touch, up to a pull of F_c = 3/2 pi w R, and breaks at 5/9 F_c. The dots are the
# published force over the contact radius.

sphere = cl.Jkr(work_of_adhesion=1.0)
radius, modulus, work = sphere.radius, sphere.effective_modulus, sphere.work_of_adhesion
begins, ends = sphere.evaluate("limits")
time = np.linspace(0.0, 1.0, 2001)
gap = 1.5 * ends - 3.0 * ends * np.sin(np.pi * time) ** 2
run = cl.drive(cl.Composed(sphere), time, gap=gap, degree=7)
figure, axes = plt.subplots(figsize=(6.2, 3.2), layout="constrained")
place = 1e9 * 0.5 * (run["gap"].values[1:] + run["gap"].values[:-1])
force = 1e3 * run["normal_force"].values[1:]
middle = force.size // 2
axes.plot(place[:middle], force[:middle], label="approach")
axes.plot(place[middle:], force[middle:], label="pull-off")
unit = (2.0 * np.pi * work * radius**2 / modulus) ** (1.0 / 3.0)
a = unit * np.linspace(0.25 ** (2.0 / 3.0), 1.37, 27)
depth = a**2 / radius - np.sqrt(2.0 * np.pi * work * a / modulus)
published = 4.0 * modulus * a**3 / (3.0 * radius) - np.sqrt(8.0 * np.pi * work * modulus * a**3)
axes.plot(-1e9 * depth, 1e3 * published, "k.", markersize=4, label="published")
axes.axhline(0.0, color="0.6", linewidth=0.6)
axes.set(xlabel="gap (nm)", ylabel="normal force (mN)")
axes.legend(loc="lower left", frameon=False)
plt.show()
