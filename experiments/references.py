"""Numbers that others state of the paper's motor: its printed table, and case A of independent solvers.

Case A: placement 2, clearance 1 um, 100 V at 3210 and 6420 Hz, phase -pi/5, no load, from rest, at 5 ms.
Its numbers are those of two event-driven solvers that share no code with this package (DOP853 at a
relative tolerance of 1e-10, every switch an event); validation/test_oracle.py runs one of them again.
"""

PLACEMENTS = {"placement 1": (15.968e-3, 25.065e-3), "placement 2": (0.914e-3, 10.146e-3)}
"""Start and end of the first patch set [m]."""

TABLE_1 = {
    "placement 1": ((-0.016, -0.057, 0.006), (2.02e3, 5.38e3)),
    "placement 2": ((0.021, 0.027, 0.005), (3.21e3, 5.46e3)),
}
"""Couplings Gamma_11, Gamma_21, Gamma_31 [N/V] and frequencies f_1, f_2 [Hz] as printed in Table 1."""

HERTZ_CASE_A = {
    0.3: (-0.4468048, -2.3727588e-6, 1.0026338e-4, 4.534830e-3, 9.908710e-4, 2.483e-4),
    0.0: (0.0, -2.3728353e-6, 1.0207838e-4, 4.534537e-3, 9.908446e-4, 0.0),
}
"""Hertz contact, K = 1e10 N m^-3/2, by friction coefficient: rotor velocity [rad/s], the tip's normal
displacement [m] and slope [rad] at the end; sums of normal impulses [N s], of durations and of stick [s]."""

RIGID_CASE_A = {
    "rotor_velocity": (-0.448569, 5e-7, "rad s-1"),
    "normal_impulse": (3.380450e-3, 5e-10, "N s"),
    "duration": (5.198480e-4, 5e-11, "s"),
}
"""Rigid contact with tangentially rigid stick, mu = 0.3: value, half a unit of its last digit, unit."""
