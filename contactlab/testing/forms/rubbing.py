"""Friction whose course is known in closed form: stopping, decay, stick-slip, a rubbing oscillator."""

from collections.abc import Iterator
from math import atan, cos, pi, sin, sqrt

import numpy as np

from contactlab.laws import ContactLaw, HertzPenalty, LagrangeStick
from contactlab.testing.claim import Claim, at_most, close
from contactlab.testing.laws import SpringDashpot
from contactlab.testing.plants import FLAT, block, way_of
from contactlab.testing.runs import first, last, run

WEIGHT = 9.81
"""Of the block of 1 kg [N]."""

STIFFNESS = 1e9
"""Of the contacts [N/m^1.5]; a block in balance rests at a depth of (W/K)^(2/3)."""

BALANCE = -((WEIGHT / STIFFNESS) ** (2.0 / 3.0))


def laws_with_stick(mu: float) -> tuple[tuple[ContactLaw, float, float], ...]:
    """Laws, the height at which their block is in balance [m], and their relative error."""
    return ((HertzPenalty(STIFFNESS, mu), BALANCE, 1e-8), (LagrangeStick(mu), 0.0, 1e-4))


def stopping_block(velocity: float = 0.5, mu: float = 0.3) -> Iterator[Claim]:
    """A sliding block stops after v0/(mu g), having gone v0^2/(2 mu g), and then stays where it is."""
    stop, way = velocity / (mu * WEIGHT), velocity**2 / (2.0 * mu * WEIGHT)
    for law, height, error in laws_with_stick(mu):
        motor = block(1.0, height=height, velocity=velocity, weight=WEIGHT)
        trajectory = run(motor, law, 2.0 * stop, 1e-6, stop / 50.0)
        slid = first(trajectory, "duration") - first(trajectory, "stick_duration")
        gone = way_of(trajectory.series["tip_slope"])
        after = trajectory.time > 1.05 * stop
        slip = np.abs(trajectory.series["slip_velocity"][after]).max()
        # The belt takes the block's momentum, so heavy that it is.
        crept = np.ptp((gone - FLAT * trajectory.series["rotor_angle"])[after])
        words = f"sliding block, {law.name}"
        yield close(f"{words}: time until it stops", slid, stop, error, units="s")
        yield close(f"{words}: way until it stops", gone[-1], way, error, units="m")
        yield at_most(f"{words}: slip after it", slip, 1e-15 * velocity, "m s-1")
        yield at_most(f"{words}: creep after it", crept, 1e-15 * way, "m")


def coulomb_decay(mu: float = 0.2, stiffness: float = 400.0) -> Iterator[Claim]:
    """An oscillator loses 4 mu N / k a cycle and comes to rest inside mu N / k."""
    dead = mu * WEIGHT / stiffness
    half = pi / sqrt(stiffness)
    start = 9.5 * dead
    for law, height, error in laws_with_stick(mu):
        motor = block(1.0, height=height, way=start, weight=WEIGHT, stiffness=stiffness)
        words = f"Coulomb oscillator, {law.name}"
        cycle = way_of(run(motor, law, 2.0 * half, 1e-5).series["tip_slope"])[-1]
        loss = start - cycle
        yield close(f"{words}: decay in a cycle", loss, 4.0 * dead, error, units="m")
        # 9.5, -7.5, 5.5, -3.5, 1.5, 0.5 of mu N / k: five half cycles.
        rest = run(motor, law, 6.0 * half, 1e-5)
        way = way_of(rest.series["tip_slope"])[-1]
        yield close(f"{words}: where it rests", way, 0.5 * dead, 10.0 * error, units="m")
        slid = first(rest, "duration") - first(rest, "stick_duration")
        yield close(f"{words}: time until it rests", slid, 5.0 * half, error, units="s")
        slip = abs(last(rest, "slip_velocity"))
        yield at_most(f"{words}: slip at rest", slip, 1e-15 * start * sqrt(stiffness), "m s-1")


def belt_stick_slip(
    static: float = 0.5, kinetic: float = 0.3, stiffness: float = 100.0, belt: float = 0.1
) -> Iterator[Claim]:
    """A block on a belt: t_stick = 2 dF/(k v_b), t_slip = (2/w)[pi - atan(dF w/(k v_b))].

    dF = (mu_s - mu_k) N. From x = 0 it sticks until k x = mu_s N; every later cycle is the same.
    """
    w = sqrt(stiffness)
    drop = (static - kinetic) * WEIGHT
    stick = 2.0 * drop / (stiffness * belt)
    slip = 2.0 / w * (pi - atan(drop * w / (stiffness * belt)))
    law = SpringDashpot(1e7, static_friction=static, kinetic_friction=kinetic)
    height = -WEIGHT / 1e7
    motor = block(
        1.0,
        height=height,
        velocity=belt,
        weight=WEIGHT,
        stiffness=stiffness,
        belt_velocity=belt,
    )
    away = static * WEIGHT / (stiffness * belt)

    def stuck(until: float) -> float:
        return first(run(motor, law, until, 1e-3), "stick_duration")

    # From the middle of one slip to the middle of the next there is one whole stick.
    middle = away + 0.5 * slip
    first_slip, second_slip = stuck(middle), stuck(middle + stick + slip)
    yield close(
        "block on a belt: time that it sticks", second_slip - first_slip, stick, 1e-6, units="s"
    )
    # In the middle of the second stick the slip has taken what stick has not.
    now = away + slip + 0.5 * stick
    began = now - (stuck(now) - first_slip)
    yield close("block on a belt: time that it slips", began - away, slip, 1e-6, units="s")


def rubbing_oscillator(ratio: float = 0.8, share: float = 0.3) -> Iterator[Claim]:
    """Forced vibration with Coulomb friction and no stop (Den Hartog 1931).

    X/(P/k) = sqrt(V^2 - (F/P)^2 U^2),  V = 1/(1 - r^2),  U = sin(pi/r)/(r (1 + cos(pi/r)))
    """
    stiffness, amplitude = 100.0, 20.0
    mu = share * amplitude / WEIGHT
    v = 1.0 / (1.0 - ratio**2)
    u = sin(pi / ratio) / (ratio * (1.0 + cos(pi / ratio)))
    expected = amplitude / stiffness * sqrt(v * v - (share * u) ** 2)
    frequency = ratio * sqrt(stiffness) / (2.0 * pi)
    motor = block(
        1.0,
        height=BALANCE,
        weight=WEIGHT,
        stiffness=stiffness,
        push_amplitude=amplitude,
        push_frequency=frequency,
    )
    law = HertzPenalty(STIFFNESS, mu)
    # In a cycle the friction works along 4 X: no need to catch the turning points.
    loss = run(motor, law, 100.0 / frequency, 1e-2, 1.0 / frequency).series["friction_loss"]
    found = float(loss[-1] - loss[-2]) / (4.0 * mu * WEIGHT)
    yield close("rubbing oscillator: amplitude", found, expected, 1e-6, units="m")


CLAIMS = (stopping_block, coulomb_decay, belt_stick_slip, rubbing_oscillator)
