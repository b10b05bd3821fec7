"""Published results of every law and part as claims, and which law each of them is of.

The first claim of the first proof of a law stands in docs/law_table.md. A result of another law is one more
function, and one more entry of `PUBLISHED`.
"""

from collections.abc import Callable, Mapping
from math import atanh, exp, gamma, log, log1p, pi, sqrt, tanh
from typing import Any, Final

import numpy as np
from scipy.optimize import brentq
from scipy.special import lambertw
from support import closed_forms as closed
from support.closed_forms import SPRING, WEIGHT, resting, restitution

from contactlab.laws import (
    Brach,
    ChatterjeeRuina,
    Composed,
    ContactLaw,
    Coulomb,
    ElastoPlastic,
    HertzElliptic,
    HertzPoint,
    Johnson,
    KuwabaraKono,
    LagrangeAgeing,
    Line,
    Linear,
)
from contactlab.laws.archard import Archard
from contactlab.laws.base import Friction
from contactlab.laws.friction import (
    AgeingStick,
    BoucWen,
    Cohesive,
    Dahl,
    Iwan,
    Microslip,
    Nagata,
    PerrinRiceZheng,
    RateAndState,
    Ruina,
    Stribeck,
    TwoState,
)
from contactlab.laws.normal import Dmt, Jkr, Maugis, Prony, Thornton, WaltonBraun
from contactlab.testing.claim import Claim, Claims, Proof, close
from contactlab.testing.plants import HEAVY, block, first, impulses_of, last, run, way_of

SLOWEST_LOSS: Final = gamma(0.6) * sqrt(pi) / (2.0**0.2 * 5.0**0.4 * gamma(2.1))
"""Loss 1 - e of slow viscoelastic impacts, over y."""


def ageing_breakaway(mu: float = 0.3, delta: float = 0.05, onset: float = 1e-3, belt: float = 0.1) -> Claims:
    """On a belt it breaks away where k v_b t = N (mu + delta ln(1 + t/t_0)) (Dieterich 1972)."""
    law = Composed(Linear(SPRING), friction=AgeingStick(mu, delta, onset))
    expected, result = _first_stick(law, lambda t: mu + delta * log1p(t / onset), belt, -WEIGHT / SPRING)
    yield close("time of the first stick on a belt", result, expected, 1e-6, "s")


def _first_stick(
    law: ContactLaw, static: Callable[[float], float], belt: float, height: float, step: float = 1e-3
) -> tuple[float, float]:
    """Return when static friction of the time of stick lets a block on a spring go, and when it goes [s]."""
    stiffness = 100.0
    expected = float(brentq(lambda t: stiffness * belt * t - WEIGHT * static(t), 0.1, 1e3, xtol=1e-14))
    motor = resting(height=height, stiffness=stiffness, velocity=belt, belt_velocity=belt)
    return expected, first(run(motor, law, expected + 0.05, step), "stick_duration")


def archard_wear(depth: float = 1e-6, speed: float = 0.5, time: float = 2e-3) -> Claims:
    """A body held at a depth d wears off w, (d - w)^-0.5 = d^-0.5 + k K v t/(2 H A) (Archard 1953)."""
    law = Archard(wear_coefficient=1e-3)
    pace = law.wear_coefficient * law.stiffness * speed / (law.hardness * law.apparent_area)
    expected = depth - (depth**-0.5 + 0.5 * pace * time) ** -2.0
    # So heavy that neither load nor friction moves it.
    made = run(block(HEAVY, height=-depth, velocity=speed), law, time, 1e-5)
    yield close("depth worn off", last(made, "internal_wear"), expected, 1e-6, "m")


def bouc_wen_loop(mu: float = 0.3, yields: float = 3e-6, swing: float = 5.0) -> Claims:
    """With n = 1, beta = gamma a cycle loses 2 mu N (2 X - 2 Y Z - Y Z^2/2), Z = 1 - W(e^(1 - 2 X/Y)).

    Wen (1976).
    """
    top = 1.0 - lambertw(exp(1.0 - 2.0 * swing)).real
    result = loss_of_cycle(BoucWen(mu, yields, 0.5, 1.0), swing * yields, 10, 1e-10)
    expected = 2.0 * mu * WEIGHT * yields * (2.0 * swing - 2.0 * top - 0.5 * top**2)
    yield close("loss in a cycle", result, expected, 1e-6, "J")


def brach_critical_ratio(mass: float = 0.1, e: float = 0.6, speed: float = 0.2, slip: float = 0.15) -> Claims:
    """A solid ball ends its slip at p_t/p_n = 2/7 r/(1 + e) and loses what is published (Brach 1989)."""
    share = 3.5
    ratio = slip / speed / (share * (1.0 + e))
    law = Brach(3.0 * ratio, e)
    d = (1.0 / mass, 0.0, share / mass)
    p_n, p_t = impulses_of(law, -speed, slip, d)
    yield close("critical ratio of the impulses", -p_t / p_n, ratio, 1e-12)
    r = slip / speed
    lost = 0.5 * mass * speed**2 * (1 + e) * (1 - e + 2 * ratio * r - (1 + e) * share * ratio**2)
    result = -0.5 * (p_n * (-speed + (-speed + p_n / mass)) + p_t * (slip + slip + d[2] * p_t))
    yield close("loss of the impact", result, lost, 1e-12, "J")


def two_plastic_impacts(v: np.ndarray, d: np.ndarray, mu: float, e: float, e_t: float) -> np.ndarray:
    """Return the impulse of Chatterjee and Ruina (1998) in vectors, with n' = (1, 0) and M^-1 = d."""
    n = np.array([1.0, 0.0])
    free, stuck = -(n @ v) / (n @ d @ n) * n, -np.linalg.solve(d, v)
    impulse = (1.0 + e) * free + (1.0 + e_t) * (stuck - free)
    if abs(impulse[1]) > mu * impulse[0]:
        down = abs(stuck[1]) - mu * (n @ (stuck - free))
        impulse = (1.0 + e) * free + mu * (1.0 + e) * (n @ free) / down * (stuck - free)
    return np.asarray(impulse)


def chatterjee_ruina_impulse(mu: float = 0.3, e: float = 0.6, e_t: float = 0.4) -> Claims:
    """Their impulse in vectors, inside of the cone and on it (1998, J. Appl. Mech. 65, 939)."""
    d, law = np.array([[600.0, 150.0], [150.0, 800.0]]), ChatterjeeRuina(mu, e, e_t)
    for text, slip in (("in the cone", 0.01), ("on the cone", 0.5)):
        expected = two_plastic_impacts(np.array([-0.1, slip]), d, mu, e, e_t)
        result = impulses_of(law, -0.1, slip, (600.0, 150.0, 800.0))
        yield close(f"friction impulse {text}", result[1], float(expected[1]), 1e-9, "N s")
        yield close(f"normal impulse {text}", result[0], float(expected[0]), 1e-9, "N s")


def cohesive_stop(mu: float = 0.3, cohesion: float = 4.0, start: float = 0.2) -> Claims:
    """A block of 1 kg slows by mu (g + C/m) and stops after v_0 over that (Derjaguin 1934)."""
    time = start / (mu * (WEIGHT + cohesion))
    law = Composed(Linear(SPRING), friction=Cohesive(mu, 1.4, cohesion))
    made = run(resting(velocity=start), law, 1.25 * time, 1e-3)
    result = first(made, "duration") - first(made, "stick_duration")
    yield close("time until it stops", result, time, 1e-6, "s")


def dahl_loop(mu: float = 0.3, sigma: float = 1e5, swing: float = 4.0) -> Claims:
    """A cycle loses 4 F_c (X - (F_c/sigma) tanh(sigma X/F_c)) at any frequency (Dahl 1976)."""
    way = mu / sigma
    result = loss_of_cycle(Dahl(mu, sigma), swing * way, 6, 1e-10)
    yield close("loss in a cycle", result, 4.0 * mu * WEIGHT * way * (swing - tanh(swing)), 1e-6, "J")


def dmt_pull_off(work: float = 0.1, radius: float = 4.2e-3) -> Claims:
    """The pull-off force is 2 pi w R (Derjaguin, Muller and Toporov 1975)."""
    normal = Dmt(radius, work_of_adhesion=work)
    result = -normal.evaluate("elastic", depth=0.0)[0]
    yield close("pull-off force", result, 2.0 * pi * work * radius, 1e-12, "N")


def elasto_plastic_deflection(mu: float = 0.3, share: float = 0.3) -> Claims:
    """Under a load P it comes to rest at P / (sigma_0 N), where `lugre` goes on (Dupont et al. 2002)."""
    sigma = 1e5
    law = Composed(Linear(SPRING), friction=ElastoPlastic(mu, bristle_stiffness=sigma, bristle_damping=1e2))
    way = way_of(run(resting(push=share * mu * WEIGHT), law, 0.1, 1e-4, 0.05).series["tip_slope"])
    expected = share * mu / sigma
    yield close("bristles that do not drag: deflection", way[-1], expected, 1e-6, "m")
    yield close("bristles that do not drag: drift", way[-1] - way[-2], 0.0, 1e-6, "m", expected)


def circular_limit(radius: float = 4e-3, modulus: float = 1e11, depth: float = 1e-6) -> Claims:
    """With equal radii it is N = 4/3 E* R^0.5 d^1.5 (Johnson 1985, eq. 4.23)."""
    normal = HertzElliptic(radius, radius, modulus)
    result = normal.evaluate("elastic", depth=depth)[0]
    expected = 4.0 / 3.0 * modulus * radius**0.5 * depth**1.5
    yield close("elliptic contact of equal radii: force", result, expected, 1e-12, "N")


def spheres_friction(share: Any) -> Any:
    """Return F/(mu N) of a first slip of a share of x_s between spheres (Mindlin and Deresiewicz 1953)."""
    return 1.0 - np.maximum(1.0 - share, 0.0) ** 1.5


def spheres_loss(share: Any) -> Any:
    """Return the loss over mu N x_s of a cycle of spheres of a share of x_s (Johnson 1985, sec. 7.4).

    By Masing's rule it is 8 int_0^A F dx - 4 A F(A), which with t = T/(mu N) at the amplitude is
    24/5 {1 - (1 - t)^(5/3) - 5/6 t [1 + (1 - t)^(2/3)]}.
    """
    t = spheres_friction(share)
    return 4.8 * (1.0 - (1.0 - t) ** (5 / 3) - 5 / 6 * t * (1.0 + (1.0 - t) ** (2 / 3)))


def loss_of_cycle(friction: Friction, swing: float, cycles: int, tolerance: float | None = None) -> float:
    """Return the loss [J] of the last of some cycles at 50 Hz of a body that friction does not move."""
    rate = 2.0 * pi * 50.0
    heavy = resting(HEAVY, velocity=rate * swing, stiffness=HEAVY * rate**2)
    law = Composed(Linear(SPRING), friction=friction)
    loss = run(heavy, law, 0.02 * cycles, 1e-4, 0.02, tolerance=tolerance).series["friction_loss"]
    return float(loss[cycles] - loss[cycles - 1])


def _cycle_of_spheres(friction: Friction, whole: float, share: float, error: float) -> Claims:
    expected = friction.friction_coefficient * WEIGHT * whole * spheres_loss(share)
    yield close("loss in a cycle", loss_of_cycle(friction, share * whole, 3), expected, error, "J")


def iwan_microslip(mu: float = 0.3, whole: float = 4e-7, share: float = 0.6, elements: int = 20) -> Claims:
    """A cycle loses 24/5 mu N x_s {1 - (1 - t)^(5/3) - 5/6 t [1 + (1 - t)^(2/3)]} (Johnson 1985, 7.4)."""
    # What is between the elements goes with 1/n^2.
    friction = Iwan(mu, elements=elements, full_slip=whole)
    yield from _cycle_of_spheres(friction, whole, share, 4.0 / elements**2)


def patch_microslip(mu: float = 0.3, kappa: float = 0.8, share: float = 0.6, rings: int = 20) -> Claims:
    """A cycle loses 24/5 mu N x_s {1 - (1 - t)^(5/3) - 5/6 t [1 + (1 - t)^(2/3)]} (Johnson 1985, 7.4)."""
    # What is between the rings goes with 1/n^2; they begin to slide over a part of x_s.
    whole = 1.5 * mu * WEIGHT / (kappa * SPRING)
    yield from _cycle_of_spheres(Microslip(mu, kappa, rings), whole, share, 4.0 / rings**2 + 0.01)


def jkr_pull_off(work: float = 0.1, radius: float = 4.2e-3, modulus: float = 115e9) -> Claims:
    """The largest pull is 3/2 pi w R, whatever the modulus (Johnson, Kendall and Roberts 1971)."""
    normal = Jkr(radius, modulus, work)
    _, ends = normal.evaluate("limits")
    depths = np.linspace(-ends, ends, 4001)
    result = -min(normal.evaluate("elastic", depth=float(d))[0] for d in depths)
    yield close("pull-off force", result, 1.5 * pi * work * radius, 1e-6, "N")


def jkr_lost(work: float = 0.1, radius: float = 4.2e-3, modulus: float = 115e9) -> Claims:
    """An impact loses 7.09 (w^5 R^4/E*^2)^(1/3), at any speed (Thornton and Ning 1998)."""
    expected = 7.09 * (work**5 * radius**4 / modulus**2) ** (1.0 / 3.0)
    # It brings a few times what it loses.
    mass = 2e-3
    speed = (8.0 * expected / mass) ** 0.5
    law = Composed(Jkr(radius, modulus, work), friction=Coulomb(0.0))
    made = run(block(mass, height=1e-9, gap_rate=-speed), law, 5e-9 / speed + 5e-3, 1e-6)
    # Half a unit of the printed digit.
    yield close("loss of an impact", first(made, "energy_loss"), expected, 0.005 / 7.09, "J")


def maugis_pull_off(work: float = 0.1, radius: float = 4.2e-3, number: float = 1.0) -> Claims:
    """The largest pull is pi w R [7/4 - 1/4 (x - 1)/(x + 1)], x = 4.04 lambda^1.4 (Carpick et al. 1999)."""
    normal = Maugis(radius, work_of_adhesion=work, tabor_number=number)
    _, ends = normal.evaluate("limits")
    depths = np.linspace(-ends, ends, 4001)
    result = -min(normal.evaluate("elastic", depth=float(d))[0] for d in depths)
    x = 4.04 * (1.157 * number) ** 1.4
    expected = pi * work * radius * (1.75 - 0.25 * (x - 1.0) / (x + 1.0))
    # What the fit claims of itself.
    yield close("pull-off force between both limits", result, expected, 0.01, "N")


def johnson_restitution(modulus: float = 115e9, strength: float = 3e8, radius: float = 4.5e-3) -> Claims:
    """Johnson's e over (Y/E*)^(1/2) (m V^2/(2 Y R^3))^(-1/8), printed as 3.8; derived it is 3.743.

    Johnson (1985), eqs. 11.46 and 11.47.
    """
    law, mass, speed = Johnson(0.3, modulus, strength, radius), 2e-3, 3.0
    p_n, _ = impulses_of(law, -speed, 0.0, (1.0 / mass, 0.0, 1.0 / mass))
    shape = sqrt(strength / modulus) * (0.5 * mass * speed**2 / (strength * radius**3)) ** -0.125
    yield close("factor of eq. 11.47", (p_n / (mass * speed) - 1.0) / shape, 3.8, 0.016)


def kuwabara_kono_restitution(mass: float = 2e-3, stiffness: float = 1e10, speed: float = 0.1) -> Claims:
    """e = 1 - 1.153 y + 0.798 y^2 + 4/15 y^2.5, y = 1.5 A (K/m)^0.4 v^0.2 (Schwager, Poeschel 1998)."""
    y = 0.01
    viscous = y / (1.5 * (stiffness / mass) ** 0.4 * speed**0.2)
    law = Composed(HertzPoint(stiffness), KuwabaraKono(viscous), Coulomb(0.0))
    result = restitution(run(block(mass, height=1e-6, gap_rate=-speed), law, 1e-6 / speed + 1e-3))
    expected = 1.0 - SLOWEST_LOSS * y + 0.6 * (SLOWEST_LOSS * y) ** 2 + 4.0 / 15.0 * y**2.5
    yield close("restitution of viscoelastic spheres", result, expected, y**3)


def lagrange_ageing_breakaway(
    mu: float = 0.3, static: float = 0.4, delta: float = 0.02, step: float = 1e-4
) -> Claims:
    """On a belt it breaks away where k v_b t = N (mu_s + delta ln(1 + t/t_0)) (Dieterich 1972)."""
    onset = 1e-3
    law = LagrangeAgeing(mu, static / mu, delta, onset)
    expected, result = _first_stick(law, lambda t: static + delta * log1p(t / onset), 0.1, 0.0, step)
    yield Claim("time of the first stick on a belt", expected, result, 2.0 * step, units="s")


def palmgren(length: float = 10e-3, force: float = 500.0) -> Claims:
    """With steel it is d = 3.84e-5 N^0.9 / L^0.8 in newtons and millimetres (Palmgren 1959)."""
    depth = 3.84e-5 * force**0.9 / (1e3 * length) ** 0.8 * 1e-3
    normal = Line(length)
    result = normal.evaluate("elastic", depth=depth)[0]
    # His coefficient is one of measurements; that of the law follows from a modulus.
    yield close("line: force at the approach of Palmgren's rule", result, force, 0.03, "N")


def prony_creep(weight: float = 5.0, relaxed: float = 5e6, arm: float = 5e6, time: float = 1e-3) -> Claims:
    """Under a weight W it creeps as W/k_inf [1 - k_1/k exp(-t k_inf/(k tau))], k = k_inf + k_1.

    The standard solid: Christensen, Theory of Viscoelasticity (1982), sec. 1.6.
    """
    whole = relaxed + arm
    slow = whole * time / relaxed
    law = Composed(Prony(relaxed, arm, time), friction=Coulomb(0.0))
    # It begins where the weight presses at once, with the rate of the creep.
    begin = weight / whole
    motor = block(1e-4, height=-begin, gap_rate=-begin * arm / (whole * time), weight=weight)
    result = -last(run(motor, law, slow), "gap")
    expected = weight / relaxed * (1.0 - arm / whole * exp(-1.0))
    yield close("depth after a retardation time", result, expected, 1e-5, "m")


def steady_slip(mu: float = 0.4, a: float = 0.01, b: float = 0.015, speed: float = 1e-3) -> Claims:
    """Steady slip is dragged at N (mu + (a - b) ln(v/v_0)) (Dieterich 1979; Ruina 1983)."""
    distance = reference = 1e-6
    law = Composed(Linear(SPRING), friction=RateAndState(mu, a, b, distance, reference))
    made = run(resting(HEAVY, velocity=speed), law, 60.0 * distance / speed, 1e-4, 10.0 * distance / speed)
    expected = WEIGHT * (mu + (a - b) * log(speed / reference))
    yield close("drag in steady slip", -last(made, "friction_force"), expected, 1e-6, "N")


def _evolved(friction: Friction, variable: str, speed: float = 1e-3) -> float:
    """Return an internal variable after a slip of 1 um at a velocity."""
    law, time = Composed(Linear(SPRING), friction=friction), 1e-6 / speed
    return last(run(resting(HEAVY, velocity=speed), law, time, 0.1 * time, time), f"internal_{variable}")


def slip_law_evolution(fresh: float = 1e-6, leap: float = log(1e3)) -> Claims:
    """By slip z = ln(v_0 theta/D) nears -ln(v/v_0) as exp(-x/D) (Ruina 1983)."""
    expected = -leap + (log(fresh) + leap) * exp(-1.0)
    yield close("ln(v_0 theta/D) at x = D", _evolved(Ruina(fresh_age=fresh), "age"), expected, 1e-6)


def perrin_evolution(fresh: float = 1e-4) -> Claims:
    """v theta/(2 D) = tanh(x/(2 D) + artanh(v theta_0/(2 D))) at a velocity v (Perrin et al. 1995)."""
    expected = log(1e-3 * tanh(0.5 + atanh(500.0 * fresh)))
    result = _evolved(PerrinRiceZheng(fresh_age=fresh), "age")
    yield close("ln(v_0 theta/(2 D)) at x = D", result, expected, 1e-6)


def nagata_evolution(a: float = 0.03, b: float = 0.035, c: float = 2.0, leap: float = log(1e3)) -> Claims:
    """v theta/D nears 1 as exp(-x/((1 + c) D)) at a velocity v (Nagata et al. 2012)."""
    friction = Nagata(0.3, a, b, stress_weakening=c)
    # w = (1 + c) z + (c/b) (mu + a ln(v/v_0)), at touch-down with the age under mu.
    risen = c / b * (0.3 + a * leap)
    begun = (friction.internal_variables[0].initial - risen) / (1.0 + c)
    z = log1p((exp(begun + leap) - 1.0) * exp(-1.0 / (1.0 + c))) - leap
    yield close("w at x = D", _evolved(friction, "state"), (1.0 + c) * z + risen, 1e-6)


def two_state_evolution(fresh: float = 1e-6, leap: float = log(1e3)) -> Claims:
    """Two states near -ln(v/v_0) as exp(-x/D) and exp(-x/D_2) (Ruina 1983)."""
    friction = TwoState(fresh_age=fresh, second_distance=2e-6)
    for variable, ratio in (("second_age", 2.0), ("age", 1.0)):
        expected = -leap + (log(fresh / ratio) + leap) * exp(-1.0 / ratio)
        yield close(f"{variable} at x = D", _evolved(friction, variable), expected, 1e-6)


def stribeck_stop(mu: float = 0.3, ratio: float = 1.5, slow: float = 0.05, start: float = 0.12) -> Claims:
    """A block of 1 kg stops after (v_s/(mu g)) ln[(mu e^(v_0/v_s) + dmu)/(mu + dmu)], for p = 1.

    Tustin (1947); Armstrong-Helouvry et al. (1994).
    """
    more = mu * (ratio - 1.0)
    time = slow / (mu * WEIGHT) * log((mu * exp(start / slow) + more) / (mu + more))
    law = Composed(Linear(SPRING), friction=Stribeck(mu, ratio, slow, 1.0))
    made = run(resting(velocity=start), law, 1.5 * time, 1e-3)
    result = first(made, "duration") - first(made, "stick_duration")
    yield close("time until it stops", result, time, 1e-6, "s")


def thornton_rebound(mass: float = 2e-3, ratio: float = 4.0) -> Claims:
    """e^2 = 6 sqrt(3)/5 (1 - s^2/6) [s/(s + 2 sqrt(6/5 - s^2/5))]^(1/2), s = V_y/V (1997, eq. 35).

    Thornton (1997): an elastic, perfectly plastic sphere.
    """
    normal = Thornton(yield_pressure=5e8)
    stiffness, depth = normal.parameters()
    first_yield = sqrt(0.8 * stiffness * depth**2.5 / mass)
    speed, s = ratio * first_yield, 1.0 / ratio
    square = 1.2 * sqrt(3.0) * (1.0 - s * s / 6.0) * sqrt(s / (s + 2.0 * sqrt(1.2 - 0.2 * s * s)))
    law = Composed(normal, friction=Coulomb(0.0))
    motor = block(mass, height=1e-7, gap_rate=-speed)
    result = restitution(run(motor, law, 1e-7 / speed + 20.0 * depth / first_yield))
    yield close(f"restitution at {ratio:g} times the speed of yield", result, sqrt(square), 1e-6)


def walton_braun_rebound(mass: float = 2e-3, loading: float = 1e7, unloading: float = 2.5e7) -> Claims:
    """A rebound of sqrt(k_1/k_2) at any speed, less with hardening, S (Walton and Braun 1986)."""
    for speed, hardening in ((0.1, 0.0), (0.4, 0.0), (0.1, 1e6)):
        law = Composed(WaltonBraun(loading, unloading, hardening), friction=Coulomb(0.0))
        result = restitution(run(block(mass, height=1e-6, gap_rate=-speed), law, 1e-6 / speed + 1e-3))
        expected = sqrt(loading / (unloading + hardening * speed * sqrt(mass * loading)))
        yield close(f"restitution at {speed:g} m/s, S = {hardening:g}/m", result, expected, 1e-6)


PUBLISHED: Final[Mapping[str, tuple[Proof, ...]]] = {
    "ageing_stick": (ageing_breakaway,),
    "archard": (archard_wear,),
    "bouc_wen": (bouc_wen_loop,),
    "brach": (brach_critical_ratio,),
    "chatterjee_ruina": (chatterjee_ruina_impulse,),
    "cohesive": (cohesive_stop,),
    "dahl": (dahl_loop,),
    "dmt": (dmt_pull_off,),
    "elasto_plastic": (elasto_plastic_deflection,),
    "hertz_elliptic": (circular_limit,),
    "iwan": (iwan_microslip,),
    "jkr": (jkr_pull_off, jkr_lost),
    "johnson": (johnson_restitution,),
    "kuwabara_kono": (kuwabara_kono_restitution,),
    "lagrange_ageing": (lagrange_ageing_breakaway,),
    "line": (palmgren,),
    "maugis": (maugis_pull_off,),
    "microslip": (patch_microslip,),
    "nagata": (nagata_evolution,),
    "perrin_rice_zheng": (perrin_evolution,),
    "prony": (prony_creep,),
    "rate_and_state": (steady_slip,),
    "ruina": (slip_law_evolution,),
    "stribeck": (stribeck_stop,),
    "thornton": (thornton_rebound,),
    "two_state": (two_state_evolution,),
    "walton_braun": (walton_braun_rebound,),
    "hertz_penalty": (closed.hertz_impact, closed.oblique_impacts),
    "lagrange_stick": (closed.oblique_impacts, closed.modal_impacts, closed.stops),
    "lagrange_slip": (closed.oblique_impacts, closed.modal_impacts),
    **dict.fromkeys(
        ("newton", "poisson", "stronge", "moreau_jean"),
        (closed.modal_impacts, closed.oblique_impacts, closed.bouncing_ball),
    ),
    "hertz_point": (closed.hertz_impact, closed.achieved_restitution),
    "normal_linear": (closed.bilinear_oscillator, closed.achieved_restitution),
    "damping_linear": (closed.dashpot_impacts, closed.achieved_restitution),
    **dict.fromkeys(
        ("hunt_crossley", "lankarani_nikravesh", "flores", "tsuji"), (closed.achieved_restitution,)
    ),
    "coulomb": (closed.belt_stick_slip, closed.stops, closed.friction_oscillator),
    "regularised": (closed.regularised_creep,),
    "mindlin": (closed.spring_and_slider,),
    "lugre": (closed.bristles,),
}
"""Proofs by law or part; where parts of two families have one name, the family's stands before it."""


def published_of(name: str, family: str = "") -> tuple[Proof, ...]:
    """Return the proofs of a law, or of a part of a family; none where there is none."""
    return (*PUBLISHED.get(f"{family}_{name}", ()), *PUBLISHED.get(name, ()))


def headline(name: str, family: str = "") -> Claim | None:
    """Return the first claim that names a law, or else the first of its first proof; None without any."""
    proofs = published_of(name, family)
    claims = list(proofs[0]()) if proofs else []
    return next((claim for claim in claims if name in claim.statement), claims[0] if claims else None)
