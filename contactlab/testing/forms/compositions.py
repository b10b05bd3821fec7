"""What the parts of composed laws do in closed form: restitution, creep, a spring with slider, bristles."""

from collections.abc import Iterator
from math import exp, pi, sqrt

from contactlab.laws.composed import Composed
from contactlab.laws.damping import Flores, HuntCrossley, LankaraniNikravesh, LinearDamping
from contactlab.laws.friction import Coulomb, LuGre, Mindlin, Regularised
from contactlab.laws.normal import NORMAL_FORCES, Linear
from contactlab.testing.claim import Claim, close
from contactlab.testing.plants import HEAVY, block, way_of
from contactlab.testing.runs import first, last, run

WEIGHT, STIFFNESS = 9.81, 1e7
"""Of a block of 1 kg [N] and of the linear contact it rests on [N/m]."""

BALANCE = -WEIGHT / STIFFNESS


def achieved_restitution(mass: float = 2e-3, speed: float = 0.1) -> Iterator[Claim]:
    """A ball comes back with the restitution that the damping is asked for, whatever the elastic force.

    (1 + e) D = ln[(1 + D)/(1 - e D)] with D = a v where the loss is in proportion to the force.
    """
    ball = block(mass, height=1e-6, gap_rate=-speed)
    for name, normal in NORMAL_FORCES.items():
        for damping in (
            LinearDamping(0.6, mass, speed),
            HuntCrossley(0.55, speed),
            LankaraniNikravesh(0.7),
            Flores(0.25),
        ):
            law = Composed(normal(), damping, Coulomb(0.0))
            trajectory = run(ball, law, 1e-6 / speed + 1e-3)
            rebound = first(trajectory, "separation_velocity") / speed
            yield close(
                f"restitution of {damping.name} in {name}",
                rebound,
                damping.restitution,
                1e-6,
                scale=1.0,
            )


def regularised_creep(share: float = 0.6, mu: float = 0.3, creep: float = 1e-3) -> Iterator[Claim]:
    """A block under the share p of the friction that could hold it creeps at v_0 p / sqrt(1 - p^2)."""
    law = Composed(Linear(STIFFNESS), friction=Regularised(mu, creep))
    motor = block(1.0, height=BALANCE, weight=WEIGHT, push=share * mu * WEIGHT)
    found = last(run(motor, law, 0.02, 1e-4), "slip_velocity")
    expected = creep * share / sqrt(1.0 - share**2)
    yield close("regularised friction: velocity of creep", found, expected, 1e-6, units="m s-1")


def spring_and_slider(mu: float = 0.3, ratio: float = 0.5) -> Iterator[Claim]:
    """Mindlin's spring holds as an oscillator; moved to and fro it loses 4 mu N (X - mu N / k_t) a cycle."""
    tangential = ratio * STIFFNESS
    law = Composed(Linear(STIFFNESS), friction=Mindlin(mu, ratio))
    push = 0.4 * mu * WEIGHT
    half = pi * sqrt(1.0 / tangential)
    motor = block(1.0, height=BALANCE, weight=WEIGHT, push=push)
    way = way_of(run(motor, law, half, record_interval=half).series["tip_slope"])[-1]
    yield close("spring of Mindlin: swing", way, 2.0 * push / tangential, 1e-6, units="m")

    # A body so heavy that the contact does not disturb it, swinging by three times the elastic range.
    limit = mu * WEIGHT / tangential
    swing, frequency = 3.0 * limit, 50.0
    driven = block(
        HEAVY,
        height=BALANCE,
        weight=WEIGHT,
        velocity=2.0 * pi * frequency * swing,
        stiffness=HEAVY * (2.0 * pi * frequency) ** 2,
    )
    loss = run(driven, law, 2.0 / frequency, 1e-4, 1.0 / frequency).series["friction_loss"]
    expected = 4.0 * mu * WEIGHT * (swing - limit)
    yield close("slider of Mindlin: loss in a cycle", loss[2] - loss[1], expected, 1e-6, units="J")


def bristles(mu: float = 0.3, static: float = 1.4, stribeck: float = 1e-2) -> Iterator[Claim]:
    """LuGre drags at g(v) N in steady slip, and bends by P / (sigma_0 N) under a load P that it holds."""
    law = Composed(Linear(STIFFNESS), friction=LuGre(mu, static, 1e5, 10.0, stribeck))
    for speed in (0.3 * stribeck, 3.0 * stribeck):
        sliding = block(HEAVY, height=BALANCE, weight=WEIGHT, velocity=speed)
        end = 0.1
        series = run(sliding, law, end, 1e-4, 0.5 * end).series
        drag = -float(series["friction_force"][-1])
        expected = WEIGHT * mu * (1.0 + (static - 1.0) * exp(-((speed / stribeck) ** 2)))
        words = f"bristles: drag at {speed:g} m/s"
        yield close(words, drag, expected, 1e-6, units="N")
    push = 1e-5 * mu * WEIGHT
    motor = block(1.0, height=BALANCE, weight=WEIGHT, push=push)
    way = way_of(run(motor, law, 1.0, 1e-3, 0.5).series["tip_slope"])[-1]
    # While it bends, it drifts by what slip has dragged: a part of the load over the limit.
    yield close(
        "bristles: deflection under a small load", way, push / (1e5 * WEIGHT), 1e-3, units="m"
    )


CLAIMS = (achieved_restitution, regularised_creep, spring_and_slider, bristles)
