"""Random motors under every law with internal variables, settled twice: by shooting, and by a run of 1 s."""

from typing import Final

import numpy as np

import contactlab as cl
from contactlab.motor.drive import period_of
from contactlab.refinement import richardson
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state.arrival import _grows

SEED: Final = 26
DURATION: Final = 1.0
"""Simulated time of a run [s]."""

COMPOSED: Final = ("law=composed",)
LAWS: Final[tuple[tuple[str, ...], ...]] = (
    (*COMPOSED, "law/normal=prony"),
    ("law=archard",),
    (*COMPOSED, "law/normal=prony", "law/friction=mindlin"),
    ("law=lagrange_ageing",),
    (*COMPOSED, "law/normal=thornton"),
    (*COMPOSED, "law/normal=prony"),
    (*COMPOSED, "law/normal=walton_braun"),
    *((*COMPOSED, f"law/friction={name}") for name in ("mindlin", "lugre", "dahl", "bouc_wen")),
    *((*COMPOSED, f"law/friction={name}") for name in ("iwan", "rate_and_state", "ageing_stick")),
)
"""A law of each kind; those whose variables live for the run come more often."""


def drawn(number: int) -> cl.Setup:
    """The motor with this number: clearance, friction, drive and rotor drawn, and the law's memory."""
    rng = np.random.default_rng([SEED, number])
    law = LAWS[number % len(LAWS)]
    keys: dict[str, float] = {
        "contact.clearance": rng.uniform(0.5e-6, 2.5e-6),
        "drive.phase": rng.uniform(-np.pi, np.pi),
        "contact.friction_coefficient": rng.uniform(0.15, 0.5),
        "drive.voltage_1": rng.uniform(70.0, 130.0),
        "drive.voltage_2": rng.uniform(70.0, 130.0),
        "rotor.inertia": 4.8e-5 * rng.uniform(0.3, 1.0),
    }
    frequency = rng.uniform(0.95, 1.05) * 3210.121
    keys["drive.frequency"] = frequency
    if "law/normal=prony" in law:
        keys["law.normal.first_time"] = 10.0 ** rng.uniform(-5.0, -1.5)
        keys["law.normal.first_stiffness"] = 10.0 ** rng.uniform(6.0, 7.5)
        if rng.random() < 0.5:
            keys["law.normal.second_stiffness"] = 10.0 ** rng.uniform(6.0, 7.0)
            keys["law.normal.second_time"] = 10.0 ** rng.uniform(-4.5, -2.0)
    if law == ("law=archard",):
        keys["law.wear_coefficient"] = 10.0 ** rng.uniform(-5.0, -2.0)
    return cl.build([*law, *(f"{key}={float(value)!r}" for key, value in keys.items())])


def by_run(setup: cl.Setup) -> tuple[float, float, bool]:
    """Velocity at the end of a run, what it may be off by, and whether an internal variable still grows."""
    period = period_of(setup.motor.drive)
    count = round(DURATION / period)
    made = setup.run(duration=count * period, record_interval=period)
    assert made.ending.reached_end, made.message
    velocity, tenth = np.diff(made.series["rotor_angle"]) / period, count // 10
    tenths = velocity[-(velocity.size // tenth) * tenth :].reshape(-1, tenth)
    mean, scatter = mean_with_error(velocity[-3 * tenth :])
    # The rest of a geometric series of what is left after each tenth, or the scatter of the mean.
    left = float(richardson(velocity[[-1 - 2 * tenth, -1 - tenth, -1]], 1.0, 0.0))
    shakes = float(np.ptp(tenths[-1])) > 1e-3 * abs(mean)
    grows = any(_grows(made.series[name][-tenth:]) for name in made.lasting)
    return (mean, scatter, grows) if shakes else (float(velocity[-1]), left, grows)
