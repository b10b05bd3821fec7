"""Oscillators whose period is known in closed form."""

from collections.abc import Iterator
from math import pi, sqrt

from contactlab.testing.claim import Claim, close
from contactlab.testing.laws import SpringDashpot
from contactlab.testing.plants import block
from contactlab.testing.runs import run


def bilinear_oscillator(
    mass: float = 0.5, spring: float = 2e3, contact: float = 3e5
) -> Iterator[Claim]:
    """A spring on both sides and a contact on one, without gap: period pi/w1 + pi/w2."""
    period = pi / sqrt(spring / mass) + pi / sqrt((spring + contact) / mass)
    motor = block(mass, height=1e-3, normal_stiffness=spring)
    trajectory = run(motor, SpringDashpot(contact), 3.0 * period)
    starts = trajectory.contacts["start_time"]
    yield close(
        "bilinear oscillator: period", float(starts[1] - starts[0]), period, 1e-6, units="s"
    )
    yield close(
        "bilinear oscillator: time in contact",
        float(trajectory.contacts["duration"][0]),
        pi / sqrt((spring + contact) / mass),
        1e-6,
        units="s",
    )


CLAIMS = (bilinear_oscillator,)
