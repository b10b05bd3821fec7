"""Closed forms that the engine is held to on small plants: impacts, oscillations and friction."""

from dataclasses import replace
from functools import partial
from math import atan, atan2, cos, exp, pi, sin, sqrt

import numpy as np
from scipy.special import gamma

from contactlab.laws import LAWS, ContactLaw, HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.laws.composed import Composed
from contactlab.laws.damping import (
    Flores,
    HuntCrossley,
    LankaraniNikravesh,
    LinearDamping,
    Tsuji,
    damping_coefficient,
)
from contactlab.laws.friction import Coulomb, LuGre, Mindlin, Regularised
from contactlab.laws.normal import NORMAL_FORCES, Linear
from contactlab.motor import RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.testing.claim import Claims, at_most, close
from contactlab.testing.plants import FLAT, HEAVY, block, first, last, run, way_of
from contactlab.trajectory import Trajectory

INSTANT = 1e-12  # Contact step [s] at which a rigid impact is one.

RESTITUTIONS = [LAWS[name] for name in ("newton", "poisson", "stronge", "moreau_jean")]
"""Laws with friction and restitution; collinear impacts do not tell one from the other."""

WEIGHT, SPRING = 9.81, 1e7
"""Weight of a block of 1 kg [N], and stiffness of the linear contact that it rests on [N/m]."""

resting = partial(block, height=-WEIGHT / SPRING, weight=WEIGHT)
"""The block in balance."""


def rigid_laws(mu: float, e: float) -> list[tuple[ContactLaw, float]]:
    """Return the rigid laws with their restitution."""
    plastic = [(LagrangeStick(mu), 0.0), (LagrangeSlip(mu), 0.0)]
    return [*plastic, *((law(mu, e), e) for law in RESTITUTIONS)]


def restitution(made: Trajectory) -> float:
    """Return separation over approach of the first contact."""
    return -first(made, "separation_velocity") / first(made, "approach_velocity")


def hertz_impact(mass: float = 2e-3, speed: float = 0.4, stiffness: float = 1e10) -> Claims:
    """A ball against a Hertz contact (Johnson 1985, sec. 11.4).

    d_max = (5 m v^2 / 4 K)^(2/5), duration 2 (d_max/v) int_0^1 dx / sqrt(1 - x^(5/2))
    """
    depth = (1.25 * mass * speed**2 / stiffness) ** 0.4
    # The integral is sqrt(pi) Gamma(7/5) / Gamma(9/10) = 1.471640...
    duration = 2.0 * depth / speed * sqrt(pi) * gamma(1.4) / gamma(0.9)
    ball = block(mass, height=1e-6, gap_rate=-speed)
    made = run(ball, HertzPenalty(stiffness, 0.0), 1e-6 / speed + 2.0 * duration)
    for name, expected, units in (
        ("max_penetration", depth, "m"),
        ("peak_normal_force", stiffness * depth**1.5, "N"),
        ("duration", duration, "s"),
        ("normal_impulse", 2.0 * mass * speed, "N s"),
    ):
        yield close(f"Hertz impact: {name}", first(made, name), expected, 1e-6, units)
    yield close("Hertz impact: restitution", restitution(made), 1.0, 1e-9)


def dashpot_impacts(mass: float = 1e-2, speed: float = 0.5, ratio: float = 0.3) -> Claims:
    """A ball against a spring and dashpot of damping ratio z, released at N = 0.

    e = exp[-(b/w)(pi - atan2(2 b w, w^2 - b^2))],  b = z w0, w = w0 sqrt(1 - z^2)
    """
    rate, spring = sqrt(SPRING / mass), Linear(SPRING)
    b, w = ratio * rate, rate * sqrt(1.0 - ratio**2)
    expected = exp(-b / w * (pi - atan2(2.0 * b * w, w * w - b * b)))
    tuned, ball = LinearDamping(expected, mass, speed), block(mass, height=1e-6, gap_rate=-speed)
    result = run(ball, Composed(spring, tuned), 1e-6 / speed + 2.0 * pi / w)
    solved = damping_coefficient(tuned, spring)
    yield close("dashpot: damping solved for", solved, 2.0 * b * mass, 1e-6, "N s m-1")
    yield close("dashpot: restitution", restitution(result), expected, 1e-6, scale=1.0)


def oblique_impacts(mass: float = 0.1, speed: float = 0.2, mu: float = 0.3) -> Claims:
    """A ball at a slant: dv_t = -sign(v_t) min(|v_t|, mu (1 + e) v_n); slip-only takes no min."""
    for law, e in [(HertzPenalty(1e10, mu), 1.0), *rigid_laws(mu, 0.5)]:
        kick, step = mu * (1.0 + e) * speed, INSTANT if e < 1.0 else None
        for sideways, word in ((5.0 * kick, "slips"), (-0.4 * kick, "ends the slip")):
            ball = block(mass, height=1e-6, gap_rate=-speed, velocity=sideways)
            made = run(ball, law, 1e-6 / speed + (10.0 * step if step else 2e-3), step)
            taken = kick if isinstance(law, LagrangeSlip) else min(abs(sideways), kick)
            left = sideways - np.sign(sideways) * taken
            text = f"oblique impact that {word}, {law.name}: slip after it"
            yield close(text, last(made, "slip_velocity"), left, 1e-9, "m s-1", abs(sideways))


def coupled_body(seed: int, approach: float = 0.3) -> Motor:
    """Draw a body whose modes couple both directions, about to touch a rotor at a gap rate [m/s]."""
    rng, modes = np.random.default_rng(seed), RitzResonator().modes
    tip, slope, velocity = rng.normal(size=(3, modes.stiffness.size)) * [[20.0], [1e3], [1e-3]]
    # Along u the tip approaches as wanted, and the modes keep the rest of what was drawn.
    along = tip / (tip @ tip)
    start = ModalState(-1e-12 * along, velocity + (approach - tip @ velocity) * along)
    body = replace(modes, tip_displacement=tip, tip_slope=slope)
    rotor = Rotor(float(rng.uniform(1e-6, 1e-4)), initial_velocity=2.0)
    return Motor(body, Drive(), ContactGeometry(clearance=0.0), rotor, start=start)


def modal_impacts(seed: int = 1) -> Claims:
    """A body of coupled modes against a rotor: p_n = (1 + e) m_eff v, loss (1 - e^2) m_eff v^2 / 2.

    m_eff = 1/(G M^-1 G'), frictionless; with stick, loss = v' D^-1 v / 2 with v = (gdot, slip).
    """
    motor = coupled_body(seed)
    rotor, radius = motor.rotor, motor.geometry.rotor_radius
    g_n, g_t = motor.rows_at_rest
    d_nn, d_nt = float(g_n @ g_n), float(g_n @ g_t)
    d_tt = float(g_t @ g_t) + radius**2 / rotor.inertia
    touch = first(run(motor, LagrangeStick(0.0), 1e-8, INSTANT), "start_time")
    for law, e in rigid_laws(0.0, 0.6):
        made, text = (run(motor, law, touch + INSTANT, INSTANT), f"modal impact, e = {e:g}, {law.name}")
        speed = first(made, "approach_velocity")
        impulse, loss = -(1.0 + e) * speed / d_nn, 0.5 * (1.0 - e * e) * speed**2 / d_nn
        yield close(f"{text}: impulse", first(made, "normal_impulse"), impulse, 1e-6, "N s")
        yield close(f"{text}: energy loss", first(made, "energy_loss"), loss, 1e-6, "J")
    made = run(motor, LagrangeStick(100.0), touch + INSTANT, INSTANT)
    velocity = first(made, "approach_velocity"), float(made.series["slip_velocity"][0])
    lost = 0.5 * np.dot(velocity, np.linalg.solve([[d_nn, d_nt], [d_nt, d_tt]], velocity))
    text = "modal impact that sticks, lagrange_stick: energy loss"
    yield close(text, first(made, "energy_loss"), lost, 1e-6, "J")


def bouncing_ball(height: float = 0.05, e: float = 0.5, gravity: float = 9.81) -> Claims:
    """A ball that is dropped comes to rest at sqrt(2 h/g) (1 + e)/(1 - e), after any number of bounces."""
    fall = sqrt(2.0 * height / gravity)
    rest = fall * (1.0 + e) / (1.0 - e)
    ball = block(1.0, height=height, weight=gravity)
    for law in RESTITUTIONS:
        made, text = run(ball, law(0.0, e), rest + 1e-5, 1e-9), f"bouncing ball, {law.name}"
        starts = made.contacts["start_time"]
        yield close(f"{text}: time of the first bounce", starts[0], fall, 1e-12, "s")
        yield close(f"{text}: time at which it rests", starts[-1], rest, 1e-6, "s")
        yield close(f"{text}: height at rest", last(made, "gap"), 0.0, 1e-12, scale=height)


def bilinear_oscillator(mass: float = 0.5, spring: float = 2e3, contact: float = 3e5) -> Claims:
    """A spring on both sides and a contact on one, without gap: period pi/w1 + pi/w2."""
    touching = pi / sqrt((spring + contact) / mass)
    period = pi / sqrt(spring / mass) + touching
    motor = block(mass, height=1e-3, normal_stiffness=spring)
    made, text = run(motor, Composed(Linear(contact)), 3.0 * period), "bilinear oscillator"
    result = np.diff(made.contacts["start_time"])[0]
    yield close(f"{text}: period", result, period, 1e-6, "s")
    yield close(f"{text}: time in contact", first(made, "duration"), touching, 1e-6, "s")


def stops(mu: float = 0.2, velocity: float = 0.5, stiffness: float = 400.0) -> Claims:
    """A sliding block stops after v0/(mu g), having gone v0^2/(2 mu g), and stays where it is.

    With a spring it loses 4 mu N / k a cycle and comes to rest inside mu N / k.
    """
    stop, far = velocity / (mu * WEIGHT), velocity**2 / (2.0 * mu * WEIGHT)
    dead, half = mu * WEIGHT / stiffness, pi / sqrt(stiffness)
    # 9.5, -7.5, 5.5, -3.5, 1.5, 0.5 of mu N / k: five half cycles.
    start = 9.5 * dead
    compliant = Composed(Linear(SPRING), friction=Coulomb(mu))
    for law, height, error in ((compliant, -WEIGHT / SPRING, 1e-8), (LagrangeStick(mu), 0.0, 1e-4)):
        motor, text = resting(height=height, velocity=velocity), f"sliding block, {law.name}"
        made = run(motor, law, 2.0 * stop, 1e-6, stop / 50.0)
        gone, after = way_of(made.series["tip_slope"]), made.time > 1.05 * stop
        # The belt takes the block's momentum, so heavy that it is.
        crept = np.ptp((gone - FLAT * made.series["rotor_angle"])[after])
        slid = first(made, "duration") - first(made, "stick_duration")
        yield close(f"{text}: time until it stops", slid, stop, error, "s")
        yield close(f"{text}: way until it stops", gone[-1], far, error, "m")
        slip = np.abs(made.series["slip_velocity"][after]).max()
        yield at_most(f"{text}: slip after it", slip, 1e-15 * velocity, "m s-1")
        yield at_most(f"{text}: creep after it", crept, 1e-15 * far, "m")

        motor, text = (resting(height=height, way=start, stiffness=stiffness), f"oscillator, {law.name}")
        cycle, made = (run(motor, law, halves * half, 1e-5) for halves in (2.0, 6.0))
        passed, left = (way_of(each.series["tip_slope"])[-1] for each in (cycle, made))
        yield close(f"{text}: decay in a cycle", start - passed, 4.0 * dead, error, "m")
        yield close(f"{text}: where it rests", left, 0.5 * dead, 10.0 * error, "m")
        slid = first(made, "duration") - first(made, "stick_duration")
        yield close(f"{text}: time until it rests", slid, 5.0 * half, error, "s")
        slip = abs(last(made, "slip_velocity"))
        yield at_most(f"{text}: slip at rest", slip, 1e-15 * start * sqrt(stiffness), "m s-1")


def belt_stick_slip(static: float = 0.5, kinetic: float = 0.3, belt: float = 0.1) -> Claims:
    """A block on a belt: t_stick = 2 dF/(k v_b), t_slip = (2/w)[pi - atan(dF w/(k v_b))].

    dF = (mu_s - mu_k) N. From x = 0 it sticks until k x = mu_s N; every later cycle is the same.
    """
    stiffness, drop = 100.0, (static - kinetic) * WEIGHT
    w, pull = sqrt(stiffness), stiffness * belt
    stick, slip = 2.0 * drop / pull, 2.0 / w * (pi - atan(drop * w / pull))
    law = Composed(Linear(SPRING), friction=Coulomb(kinetic, static / kinetic))
    motor = resting(stiffness=stiffness, velocity=belt, belt_velocity=belt)
    away = static * WEIGHT / pull

    def stuck(until: float) -> float:
        return first(run(motor, law, until, 1e-3), "stick_duration")

    # From the middle of one slip to the middle of the next there is one whole stick.
    middle = away + 0.5 * slip
    once, twice = stuck(middle), stuck(middle + stick + slip)
    yield close("block on a belt: time that it sticks", twice - once, stick, 1e-6, "s")
    # In the middle of the second stick the slip has taken what stick has not.
    now = away + slip + 0.5 * stick
    slipped = now - (stuck(now) - once) - away
    yield close("block on a belt: time that it slips", slipped, slip, 1e-6, "s")


def friction_oscillator(ratio: float = 0.8, share: float = 0.3) -> Claims:
    """Forced vibration with Coulomb friction and no stop (Den Hartog 1931).

    X/(P/k) = sqrt(V^2 - (F/P)^2 U^2),  V = 1/(1 - r^2),  U = sin(pi/r)/(r (1 + cos(pi/r)))
    """
    stiffness, amplitude = 100.0, 20.0
    mu, frequency = share * amplitude / WEIGHT, ratio * sqrt(stiffness) / (2.0 * pi)
    v, u = 1.0 / (1.0 - ratio**2), sin(pi / ratio) / (ratio * (1.0 + cos(pi / ratio)))
    expected = amplitude / stiffness * sqrt(v * v - (share * u) ** 2)
    motor = resting(stiffness=stiffness, push_amplitude=amplitude, push_frequency=frequency)
    law = Composed(Linear(SPRING), friction=Coulomb(mu))
    made = run(motor, law, 100.0 / frequency, 1e-2, 1.0 / frequency)
    # In a cycle the friction works along 4 X: no need to catch the turning points.
    result = np.diff(made.series["friction_loss"])[-1] / (4.0 * mu * WEIGHT)
    yield close("oscillator with friction: amplitude", result, expected, 1e-6, "m")


def achieved_restitution(mass: float = 2e-3, speed: float = 0.1) -> Claims:
    """A ball rebounds with the restitution of the damping, whatever the elastic force.

    (1 + e) D = ln[(1 + D)/(1 - e D)] with D = a v where the loss is in proportion to the force.
    """
    ball = block(mass, height=1e-6, gap_rate=-speed)
    tuned = LinearDamping(0.6, mass, speed), HuntCrossley(0.55, speed), Tsuji(0.5, mass)
    for spring in (part() for part in NORMAL_FORCES.values()):
        if spring.elastic is None or spring.allows_tension:
            continue
        for damping in (*tuned, LankaraniNikravesh(0.7), Flores(0.25)):
            made = run(ball, Composed(spring, damping, Coulomb(0.0)), 1e-6 / speed + 1e-3)
            text, rebound = f"restitution of {damping.name} in {spring.name}", restitution(made)
            yield close(text, rebound, damping.restitution, 1e-6, scale=1.0)


def regularised_creep(share: float = 0.6, mu: float = 0.3, creep: float = 1e-3) -> Claims:
    """A block under the share p of the friction that could hold it creeps at v_0 p / sqrt(1 - p^2)."""
    law = Composed(Linear(SPRING), friction=Regularised(mu, creep))
    result = last(run(resting(push=share * mu * WEIGHT), law, 0.02, 1e-4), "slip_velocity")
    expected = creep * share / sqrt(1.0 - share**2)
    yield close("regularised friction: velocity of creep", result, expected, 1e-6, "m s-1")


def spring_and_slider(mu: float = 0.3, ratio: float = 0.5) -> Claims:
    """Mindlin's spring holds as an oscillator; moved to and fro it loses 4 mu N (X - mu N / k_t) a cycle."""
    tangential = ratio * SPRING
    law = Composed(Linear(SPRING), friction=Mindlin(mu, ratio))
    push, half = 0.4 * mu * WEIGHT, pi * sqrt(1.0 / tangential)
    way = way_of(run(resting(push=push), law, half).series["tip_slope"])[-1]
    yield close("spring of Mindlin: swing", way, 2.0 * push / tangential, 1e-6, "m")

    # A body so heavy that the contact does not disturb it, swinging by three times the elastic range.
    limit, frequency = mu * WEIGHT / tangential, 50.0
    swing, rate = 3.0 * limit, 2.0 * pi * frequency
    driven = resting(HEAVY, velocity=rate * swing, stiffness=HEAVY * rate**2)
    loss = run(driven, law, 2.0 / frequency, 1e-4, 1.0 / frequency).series["friction_loss"]
    expected = 4.0 * mu * WEIGHT * (swing - limit)
    yield close("slider of Mindlin: loss in a cycle", loss[2] - loss[1], expected, 1e-6, "J")


def bristles(mu: float = 0.3, static: float = 1.4, stribeck: float = 1e-2) -> Claims:
    """LuGre drags at g(v) N in steady slip, and bends by P / (sigma_0 N) under a load P that it holds."""
    law = Composed(Linear(SPRING), friction=LuGre(mu, static, 1e5, 10.0, stribeck))
    for speed in (0.3 * stribeck, 3.0 * stribeck):
        sliding = resting(HEAVY, velocity=speed)
        drag = -last(run(sliding, law, 0.1, 1e-4, 0.05), "friction_force")
        expected = WEIGHT * mu * (1.0 + (static - 1.0) * exp(-((speed / stribeck) ** 2)))
        yield close(f"bristles: drag at {speed:g} m/s", drag, expected, 1e-6, "N")
    motor = resting(push=1e-5 * mu * WEIGHT)
    way = way_of(run(motor, law, 1.0, 1e-3, 0.5).series["tip_slope"])[-1]
    # While it bends, it drifts by what slip has dragged: a part of the load over the limit.
    yield close("bristles: deflection under a small load", way, 1e-5 * mu / 1e5, 1e-3, "m")
