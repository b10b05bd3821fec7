"""Normal forces and dampings of a composed law, written from their publications: plain numbers.

A normal force has a mode (a number, `LOADS` or `ELASTIC` where it has two) and internal variables z. It gives

    spring(mode, d, rate, z)   force N [N], stiffness dN/dd [N/m] and its slope [N/m^2] at constant z
    rates(d, z)                dz/dt, where the variables flow
    left(mode, d, z)           falls through zero where the contact ends: the depth over that of the end [m]
    switches(mode)             functions of (d, rate, z) that fall through zero where the mode ends
    switched(mode, d, z)       mode and z after that
    begins(z)                  depth at which a contact begins [m]
    touch(z, rate)             mode of a contact that begins
"""

# ruff: noqa: ARG005 - parts of one family have one signature
from __future__ import annotations

from collections.abc import Callable
from math import exp, log, pi, sqrt

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

Spring = tuple[float, float, float]
ELASTIC, LOADS = 0, 1


class Normal:
    """A normal force without variables, of one mode; N = 0 at d = 0."""

    sizes: tuple[float, ...] = ()
    """Sizes of the internal variables, for the tolerances."""
    lasts = False
    """Whether they are of the whole run."""

    def fresh(self) -> list[float]:
        return []

    def spring(self, mode: int, d: float, rate: float, z: list[float]) -> Spring:
        return self.elastic(max(d, 0.0))

    def elastic(self, d: float) -> Spring:
        raise NotImplementedError

    def rates(self, d: float, z: list[float]) -> list[float]:
        return [0.0] * len(z)

    def pace(self, d: float, rate: float, z: list[float]) -> float:
        return rate

    def left(self, mode: int, d: float, z: list[float]) -> float:
        return d

    def switches(self, mode: int) -> list[Callable[[float, float, list[float]], float]]:
        return []

    def switched(self, mode: int, d: float, z: list[float]) -> tuple[int, list[float]]:
        return mode, z

    def begins(self, z: list[float]) -> float:
        return 0.0

    def touch(self, z: list[float]) -> int:
        return ELASTIC

    def in_flight(self, z: list[float], time: float) -> list[float]:
        return z


class Power(Normal):
    """N = K d^n."""

    def __init__(self, stiffness: float, exponent: float) -> None:
        self.stiffness, self.exponent = stiffness, exponent

    def elastic(self, d: float) -> Spring:
        n = self.exponent
        if d <= 0.0:
            return 0.0, self.stiffness if n == 1.0 else 0.0, 0.0
        force = self.stiffness * d**n
        return force, n * force / d, n * (n - 1.0) * force / (d * d)


def elliptic_stiffness(first: float, second: float, modulus: float) -> float:
    """K [N/m^1.5] of relative radii (Johnson 1985, eqs. 4.26 to 4.28), by the eccentricity."""
    ratio = max(first, second) / min(first, second)
    mean = sqrt(first * second)
    if ratio < 1.0 + 1e-5:
        return 4.0 / 3.0 * modulus * sqrt(mean)

    def parts(b_over_a: float) -> tuple[float, float, float]:
        squared = 1.0 - b_over_a**2
        k, e = float(ellipk(squared)), float(ellipe(squared))
        return e / b_over_a**2 - k, k - e, k

    b = brentq(lambda b: parts(b)[0] / parts(b)[1] - ratio, 1e-4, 1.0 - 1e-7, xtol=1e-15, rtol=1e-14)
    over, under, k = parts(b)
    f1 = (4.0 / (pi * (1.0 - b * b)) * b**1.5 * sqrt(over * under)) ** (1.0 / 3.0)
    f2 = 2.0 / pi * sqrt(b) / f1 * k
    return 4.0 / 3.0 * modulus * sqrt(mean) * f2**-1.5


class Lining(Normal):
    """Stiffness k_1 up to d_1, k_2 from d_1 + w on, linear in between."""

    def __init__(self, soft: float, hard: float, depth: float, width: float) -> None:
        self.numbers = soft, hard, depth, width

    def elastic(self, d: float) -> Spring:
        soft, hard, first, width = self.numbers
        slope = (hard - soft) / width
        x = d - first
        if x <= 0.0:
            return soft * d, soft, 0.0
        if x < width:
            return soft * d + 0.5 * slope * x * x, soft + slope * x, slope
        return soft * first + 0.5 * (soft + hard) * width + hard * (x - width), hard, 0.0


class Dmt(Normal):
    """Hertz less 2 pi w R."""

    def __init__(self, radius: float, modulus: float, work: float) -> None:
        self.hertz = Power(4.0 / 3.0 * modulus * sqrt(radius), 1.5)
        self.pull = 2.0 * pi * work * radius

    def elastic(self, d: float) -> Spring:
        force, stiffness, slope = self.hertz.elastic(d)
        return force - self.pull, stiffness, slope


class Jkr(Normal):
    """Force and depth over the contact radius a, solved for a by Newton's method from above.

    d = a^2/R - sqrt(2 pi w a/E*),  N = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3); it breaks at dd/da = 0.
    """

    def __init__(self, radius: float, modulus: float, work: float) -> None:
        self.radius, self.modulus, self.work = radius, modulus, work
        self.least = (pi * work * radius**2 / (8.0 * modulus)) ** (1.0 / 3.0)
        self.break_depth = self.depth(self.least)

    def depth(self, a: float) -> float:
        """Depth [m] at a contact radius [m]."""
        return a * a / self.radius - sqrt(2.0 * pi * self.work * a / self.modulus)

    def spring(self, mode: int, d: float, rate: float, z: list[float]) -> Spring:
        r, modulus, w = self.radius, self.modulus, self.work
        pull = sqrt(2.0 * pi * w / modulus)
        if d <= self.break_depth:
            a = self.least
        else:
            a = max(sqrt(r * max(d, 0.0)), self.least) + 4.0 * self.least
            for _ in range(60):
                value, growth = a * a / r - pull * sqrt(a) - d, 2.0 * a / r - 0.5 * pull / sqrt(a)
                new = a - value / growth
                done = abs(new - a) <= 4e-16 * a
                a = max(new, self.least)
                if done:
                    break
        force = 4.0 * modulus * a**3 / (3.0 * r) - sqrt(8.0 * pi * w * modulus * a**3)
        # dN/dd = N'(a)/d'(a); its slope by the same rule.
        n1 = 4.0 * modulus * a * a / r - 1.5 * sqrt(8.0 * pi * w * modulus * a)
        n2 = 8.0 * modulus * a / r - 0.75 * sqrt(8.0 * pi * w * modulus / a)
        d1 = max(2.0 * a / r - 0.5 * pull / sqrt(a), 1e-12 * a / r)
        d2 = 2.0 / r + 0.25 * pull * a**-1.5
        return force, n1 / d1, (n2 - n1 * d2 / d1) / (d1 * d1)

    def left(self, mode: int, d: float, z: list[float]) -> float:
        return d - self.break_depth


class Dented(Normal):
    """Loads along one curve and comes back to a dent along another; z = (largest depth,)."""

    def back(self, peak: float) -> tuple[float, float]:
        """A number of the way back, and the dent [m]."""
        raise NotImplementedError

    def left(self, mode: int, d: float, z: list[float]) -> float:
        return d - (0.0 if mode == LOADS else self.back(z[0])[1])

    def switches(self, mode: int) -> list[Callable[[float, float, list[float]], float]]:
        if mode == LOADS:
            return [lambda d, rate, z: rate]
        return [lambda d, rate, z: z[0] - d]

    def switched(self, mode: int, d: float, z: list[float]) -> tuple[int, list[float]]:
        return (ELASTIC, [max(d, z[0])]) if mode == LOADS else (LOADS, z)

    def begins(self, z: list[float]) -> float:
        return self.back(z[0])[1]


class Thornton(Dented):
    """Hertz to d_y, a straight line, and Hertz of the radius R_p back; z = (largest depth,)."""

    def __init__(self, radius: float, modulus: float, pressure: float) -> None:
        self.radius, self.modulus, self.pressure = radius, modulus, pressure
        self.yield_depth = radius * (pi * pressure / (2.0 * modulus)) ** 2
        self.sizes = (self.yield_depth,)

    def fresh(self) -> list[float]:
        return [self.yield_depth]

    def line(self, d: float) -> float:
        """Force [N] as it yields: N_y + pi p_y R (d - d_y)."""
        first = 4.0 / 3.0 * self.modulus * sqrt(self.radius) * self.yield_depth**1.5
        return first + pi * self.pressure * self.radius * (d - self.yield_depth)

    def back(self, peak: float) -> tuple[float, float]:
        """Radius R_p [m] of the flattened sphere and dent d_p [m]: same force over the same circle."""
        if peak <= self.yield_depth:
            return self.radius, 0.0
        a, force = sqrt(self.radius * peak), self.line(peak)
        return 4.0 * self.modulus * a**3 / (3.0 * force), peak - 3.0 * force / (4.0 * self.modulus * a)

    def spring(self, mode: int, d: float, rate: float, z: list[float]) -> Spring:
        if mode == LOADS:
            return self.line(d), pi * self.pressure * self.radius, 0.0
        radius, dent = self.back(z[0])
        return Power(4.0 / 3.0 * self.modulus * sqrt(radius), 1.5).elastic(max(d - dent, 0.0))


class WaltonBraun(Dented):
    """Along k_1 as it loads, k_2 + S N* below the largest force; z = (largest depth,)."""

    def __init__(self, loading: float, unloading: float, hardening: float) -> None:
        self.numbers = loading, unloading, hardening
        self.sizes = (1e-7,)

    def fresh(self) -> list[float]:
        return [0.0]

    def back(self, peak: float) -> tuple[float, float]:
        """Stiffness [N/m] and dent [m]."""
        loading, unloading, hardening = self.numbers
        stiffness = unloading + hardening * loading * peak
        return stiffness, peak - loading * peak / stiffness

    def spring(self, mode: int, d: float, rate: float, z: list[float]) -> Spring:
        if mode == LOADS:
            return self.numbers[0] * d, self.numbers[0], 0.0
        stiffness, dent = self.back(z[0])
        return stiffness * max(d - dent, 0.0), stiffness, 0.0

    def touch(self, z: list[float]) -> int:
        return LOADS if z[0] == 0.0 else ELASTIC


class Prony(Normal):
    """A spring and Maxwell arms; z_i are the ways of the dashpots. It does not pull."""

    lasts = True

    def __init__(self, relaxed: float, arms: list[tuple[float, float]]) -> None:
        self.relaxed, self.arms = relaxed, arms
        self.whole = relaxed + sum(k for k, _ in arms)
        self.sizes = (1e-7,) * len(arms)
        shares = np.array([k for k, _ in arms]) / self.whole
        times = np.array([time for _, time in arms])
        # Free of load d = sum k_i z_i/k, and dz_i/dt = (d - z_i)/tau_i.
        self.recovery = (np.tile(shares, (len(arms), 1)) - np.eye(len(arms))) / times[:, None]

    def fresh(self) -> list[float]:
        return [0.0] * len(self.arms)

    def surface(self, z: list[float]) -> float:
        """Depth of the surface that nothing presses [m]."""
        return sum(k * way for (k, _), way in zip(self.arms, z, strict=True)) / self.whole

    def spring(self, mode: int, d: float, rate: float, z: list[float]) -> Spring:
        return max(self.whole * (d - self.surface(z)), 0.0), self.whole, 0.0

    def pace(self, d: float, rate: float, z: list[float]) -> float:
        flows = self.rates(d, z)
        return rate - sum(k * flow for (k, _), flow in zip(self.arms, flows, strict=True)) / self.whole

    def rates(self, d: float, z: list[float]) -> list[float]:
        return [(d - way) / time for (_, time), way in zip(self.arms, z, strict=True)]

    def left(self, mode: int, d: float, z: list[float]) -> float:
        return d - self.surface(z)

    def begins(self, z: list[float]) -> float:
        return self.surface(z)

    def in_flight(self, z: list[float], time: float) -> list[float]:
        return (expm(self.recovery * time) @ z).tolist()


Damping = Callable[[float, float, float], float]
"""Gives N [N] from elastic force, rate of the depth and speed of the impact."""


def loss_number(e: float) -> float:
    """D with (1 + e) D = ln((1 + D)/(1 - e D)), the loss of a free impact of restitution e."""
    if e == 1.0:
        return 0.0

    def excess(d: float) -> float:
        return (1.0 + e) * d - log((1.0 + d) / (1.0 - e * d))

    # Zero at D = 0 too: positive in between, down to minus infinity at D = 1/e.
    return float(brentq(excess, 0.5 * (1.0 - e), (1.0 - 1e-14) / e, xtol=1e-16, rtol=1e-14))


def dashpot_coefficient(normal: Normal, e: float, mass: float, speed: float) -> float:
    """c [N s/m] at which a free impact of a mass at a speed has the restitution e."""
    depth = brentq(
        lambda x: normal.elastic(exp(x))[0] * exp(x) - mass * speed**2, log(1e-12), log(1.0), xtol=1e-12
    )
    scale = exp(depth)

    def rebound(c: float) -> float:
        def force(t: float, y: np.ndarray) -> float:
            return (normal.elastic(max(y[0], 0.0) * scale)[0] + c * y[1] * speed) * scale / (mass * speed**2)

        force.terminal, force.direction = True, -1  # type: ignore[attr-defined]
        done = solve_ivp(
            lambda t, y: [y[1], -force(t, y)],
            (0, 1e6),
            [0.0, 1.0],
            "DOP853",
            events=force,
            rtol=1e-12,
            atol=1e-12,
        )
        return -float(done.y[1, -1])

    unit = mass * speed / scale
    return unit * float(brentq(lambda x: rebound(x * unit) - e, 0.0, 20.0, xtol=1e-12))


def dashpot(c: float) -> Damping:
    """f + c dd/dt, no pull."""
    return lambda f, rate, speed: max(f + c * rate, 0.0)


def hysteretic(d: float, fixed: float | None = None, least: float = 0.0) -> Damping:
    """f (1 + D rate/v), no pull; v a constant, or that of the impact, at least `least`."""
    return lambda f, rate, speed: f * max(1.0 + d * rate / (fixed or max(speed, least)), 0.0)


def undamped(f: float, rate: float, speed: float) -> float:
    """The elastic force."""
    return f
