"""Frictions of a composed law, written from their publications: plain numbers.

A friction has a mode: the sign of the slip, or 0 where it sticks (set-valued) or its spring holds (Mindlin);
and internal variables z. Its quantities come from the instant `At`.

    force(mode, at, z)         friction [N]
    rates(mode, at, z)         dz/dt
    switches(mode, z)          functions of (at, z) that fall through zero where the mode ends
    switched(mode, k, at, z)   mode and z after switch k
    touch(at, z)               mode of a contact that begins
"""

# ruff: noqa: ARG005 - parts of one family have one signature
from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from math import asin, asinh, copysign, cos, exp, log, log1p, pi, sin, sqrt
from typing import NamedTuple


class At(NamedTuple):
    """One instant of a contact."""

    normal: float  # N, N
    stiffness: float  # dN/dd, N/m
    stiffness_rate: float  # N/(m s)
    slip: float  # m/s
    hold: float  # F that holds the slip rate at zero, N
    pace: float  # dN/dt over dN/dd, m/s


Switch = Callable[[At, list[float]], float]


class Friction:
    """Friction that slip and variables determine; its mode is the sign of the slip, for the kinks."""

    sizes: tuple[float, ...] = ()
    set_valued = False
    stiff = False
    """Whether it wants an implicit method."""

    def fresh(self) -> list[float]:
        return [0.0] * len(self.sizes)

    def force(self, mode: int, at: At, z: list[float]) -> float:
        raise NotImplementedError

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        return [0.0] * len(z)

    def switches(self, mode: int, z: list[float]) -> list[Switch]:
        return [lambda at, z: mode * at.slip]

    def switched(self, mode: int, k: int, at: At, z: list[float]) -> tuple[int, list[float]]:
        return -mode, z

    def touch(self, at: At, z: list[float]) -> int:
        return -1 if at.slip < 0.0 else 1


class SetValued(Friction):
    """|F| <= static in stick, F = -kinetic sign(v) in slip."""

    set_valued = True

    def __init__(self, mu: float, ratio: float = 1.0, cohesion: float = 0.0) -> None:
        self.mu, self.ratio, self.cohesion = mu, ratio, cohesion

    def static(self, at: At, z: list[float]) -> float:
        """Largest friction of stick [N]."""
        return self.mu * self.ratio * max(at.normal + self.cohesion, 0.0)

    def kinetic(self, at: At, z: list[float]) -> float:
        """Friction of slip [N]."""
        return self.mu * max(at.normal + self.cohesion, 0.0)

    def force(self, mode: int, at: At, z: list[float]) -> float:
        return at.hold if mode == 0 else -mode * self.kinetic(at, z)

    def switches(self, mode: int, z: list[float]) -> list[Switch]:
        if mode != 0:
            return super().switches(mode, z)
        return [lambda at, z: self.static(at, z) - at.hold, lambda at, z: self.static(at, z) + at.hold]

    def at_rest(self, at: At, z: list[float]) -> int:
        """Mode where the slip is zero: stick inside of the static cone, else slip against the friction."""
        return 0 if abs(at.hold) <= self.static(at, z) else -int(copysign(1, at.hold))

    def switched(self, mode: int, k: int, at: At, z: list[float]) -> tuple[int, list[float]]:
        if mode != 0:
            return self.at_rest(at, z), z
        return (-1 if k == 0 else 1), [0.0] * len(z)

    def touch(self, at: At, z: list[float]) -> int:
        return int(copysign(1, at.slip)) if at.slip != 0.0 else self.at_rest(at, z)


class Ageing(SetValued):
    """Static friction that grows with the time t of stick: mu + delta ln(1 + min(t, t_max)/t_0)."""

    sizes = (1e-5,)

    def __init__(self, mu: float, delta: float, first: float, longest: float) -> None:
        super().__init__(mu)
        self.delta, self.first, self.longest = delta, first, longest

    def static(self, at: At, z: list[float]) -> float:
        grown = self.mu + self.delta * log1p(min(z[0], self.longest) / self.first)
        return grown * max(at.normal, 0.0)

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        return [1.0 if mode == 0 else 0.0]


class Stribeck(SetValued):
    """mu(v) = mu + (mu_s - mu) exp(-(|v|/v_s)^p)."""

    def __init__(self, mu: float, ratio: float, speed: float, exponent: float) -> None:
        super().__init__(mu, ratio)
        self.speed, self.exponent = speed, exponent

    def kinetic(self, at: At, z: list[float]) -> float:
        fall = exp(-((abs(at.slip) / self.speed) ** self.exponent))
        return self.mu * (1.0 + (self.ratio - 1.0) * fall) * max(at.normal, 0.0)


class Regularised(Friction):
    """F = -mu N v/sqrt(v^2 + v_0^2)."""

    stiff = True

    def __init__(self, mu: float, creep: float) -> None:
        self.mu, self.creep = mu, creep

    def force(self, mode: int, at: At, z: list[float]) -> float:
        return -self.mu * max(at.normal, 0.0) * at.slip / sqrt(at.slip**2 + self.creep**2)

    def switches(self, mode: int, z: list[float]) -> list[Switch]:
        return []


class Bristles(Friction):
    """LuGre, and with a break-away ratio its elasto-plastic sister."""

    sizes = (1e-7,)

    def __init__(
        self,
        mu: float,
        ratio: float,
        stiffness: float,
        damping: float,
        speed: float,
        away: float | None = None,
    ) -> None:
        self.mu, self.ratio, self.stiffness, self.damping = mu, ratio, stiffness, damping
        self.speed, self.away = speed, away

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        v = at.slip
        steady = self.mu + self.mu * (self.ratio - 1.0) * exp(-((v / self.speed) ** 2))
        bent = self.stiffness * z[0] / steady
        if self.away is None:
            return [v - mode * v * bent]
        alpha, size = 0.0, abs(bent)
        if mode * z[0] > 0.0 and size > self.away:
            alpha = (
                1.0 if size >= 1.0 else 0.5 + 0.5 * sin(pi * (size - 0.5 * (1 + self.away)) / (1 - self.away))
            )
        return [v * (1.0 - alpha * size)]

    def force(self, mode: int, at: At, z: list[float]) -> float:
        flow = self.rates(mode, at, z)[0]
        return -max(at.normal, 0.0) * (self.stiffness * z[0] + self.damping * flow)


class Dahl(Friction):
    """F = -N sigma z, dz/dt = v |1 - s|^i sgn(1 - s), s = sigma z sgn(v)/mu."""

    sizes = (1e-7,)

    def __init__(self, mu: float, stiffness: float, exponent: float) -> None:
        self.mu, self.stiffness, self.exponent = mu, stiffness, exponent

    def force(self, mode: int, at: At, z: list[float]) -> float:
        return -max(at.normal, 0.0) * self.stiffness * z[0]

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        left = 1.0 - self.stiffness * z[0] * mode / self.mu
        return [at.slip * copysign(abs(left) ** self.exponent, left)]


class BoucWen(Friction):
    """F = -mu N z/Y, dz/dt = v - beta |v| |z/Y|^(n-1) z/Y - (1 - beta) v |z/Y|^n."""

    sizes = (1e-7,)

    def __init__(self, mu: float, displacement: float, beta: float, exponent: float) -> None:
        self.mu, self.displacement, self.beta, self.exponent = mu, displacement, beta, exponent

    def force(self, mode: int, at: At, z: list[float]) -> float:
        return -self.mu * max(at.normal, 0.0) * z[0] / self.displacement

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        y, v, n = z[0] / self.displacement, at.slip, self.exponent
        bent = abs(y) ** n
        return [v - self.beta * mode * v * copysign(bent, y) - (1.0 - self.beta) * v * bent]


class Iwan(Friction):
    """Jenkins elements of limits x_j and shares s_j; the mode is the sign times one and how many slide.

    A mode m has the sign of m and |m| - 1 elements that slide.
    """

    def __init__(self, mu: float, elements: int, whole: float) -> None:
        n = elements
        # sin^2 of the edges is the way over x_s: from a third of a hundredth on they are a geometric series.
        first, last = asin(sqrt(0.01 / 3.0)), 0.5 * pi
        edges = [1.0, *(cos(first * (last / first) ** (j / (n - 1))) for j in range(n - 1)), 0.0]
        pairs = [*pairwise(edges)]
        self.limits = [whole * (1.0 - (a * a + a * b + b * b) / 3.0) for a, b in pairs]
        self.shares = [1.5 * mu / whole * (a - b) for a, b in pairs]
        self.sizes = (1e-7,) * n
        self.near = 1e-11 * whole

    def force(self, mode: int, at: At, z: list[float]) -> float:
        return -max(at.normal, 0.0) * sum(s * x for s, x in zip(self.shares, z, strict=True))

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        slide = abs(mode) - 1
        return [0.0 if j < slide else at.slip for j in range(len(z))]

    def switches(self, mode: int, z: list[float]) -> list[Switch]:
        sign, j = int(copysign(1, mode)), abs(mode) - 1
        result: list[Switch] = [lambda at, z: sign * at.slip]
        if j < len(z):
            result.append(lambda at, z: self.limits[j] - sign * z[j])
        return result

    def switched(self, mode: int, k: int, at: At, z: list[float]) -> tuple[int, list[float]]:
        sign, j = int(copysign(1, mode)), abs(mode) - 1
        if k == 0:
            return self.sliding(-sign, 0, z), z
        return self.sliding(sign, j + 1, z), z

    def sliding(self, sign: int, j: int, z: list[float]) -> int:
        """Mode with those that have reached their limits."""
        while j < len(z) and self.limits[j] - sign * z[j] <= self.near:
            j += 1
        return sign * (j + 1)


class Mindlin(Friction):
    """A spring k_t = kappa dN/dd that slides at mu N; mode 0 holds, and z is the friction F [N] itself.

    Held, dF/dt = -k_t v + F min(dk_t/dt, 0)/k_t: what the contact gains in stiffness carries nothing, and
    what it loses takes its share of the force along. It slides as long as F, so held, would leave the
    bound mu N.
    """

    sizes = (1.0,)

    def __init__(self, mu: float, kappa: float) -> None:
        self.mu, self.kappa = mu, kappa

    def force(self, mode: int, at: At, z: list[float]) -> float:
        return z[0] if mode == 0 else -mode * self.mu * max(at.normal, 0.0)

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        if mode != 0:
            return [0.0]
        shrinks = min(at.stiffness_rate, 0.0) / at.stiffness if at.stiffness > 0.0 else 0.0
        return [-self.kappa * at.stiffness * at.slip + z[0] * shrinks]

    def slider(self, mode: int, at: At) -> float:
        """Velocity of the slider in its direction [m/s]; under a pull the bound is zero, and stays so."""
        if at.normal < 0.0:
            return mode * at.slip
        shrinks = at.normal * min(at.stiffness_rate, 0.0) / at.stiffness**2 if at.stiffness > 0.0 else 0.0
        return mode * at.slip + self.mu / self.kappa * (shrinks - at.pace)

    def switches(self, mode: int, z: list[float]) -> list[Switch]:
        if mode != 0:
            return [lambda at, z: self.slider(mode, at)]
        return [lambda at, z: self.mu * at.normal + z[0], lambda at, z: self.mu * at.normal - z[0]]

    def switched(self, mode: int, k: int, at: At, z: list[float]) -> tuple[int, list[float]]:
        if mode == 0:
            return (1 if k == 0 else -1), z
        return 0, [-mode * self.mu * max(at.normal, 0.0)]

    def touch(self, at: At, z: list[float]) -> int:
        """Slides from the first instant where the slip is faster than mu N/k_t grows."""
        sign = -1 if at.slip < 0.0 else 1
        return sign if self.slider(sign, at) > 0.0 else 0


class RateAndState(Friction):
    """Dieterich's ageing law; z = ln(v_0 theta/D)."""

    sizes = (1.0,)
    stiff = True

    def __init__(
        self, mu: float, a: float, b: float, way: float, speed: float, age: float, creep: float
    ) -> None:
        self.numbers = mu, a, b, way, speed, creep
        self.first = log(speed * age / way)

    def fresh(self) -> list[float]:
        return [self.first]

    def force(self, mode: int, at: At, z: list[float]) -> float:
        mu, a, b, _, speed, creep = self.numbers
        exponent = (mu + b * z[0]) / a - log(2.0 * speed)
        # What of the exponent makes the creep slower than v_c is taken out of the asinh.
        slower = max(exponent + log(creep), 0.0)
        v = at.slip
        risen = asinh(v * exp(exponent - slower)) + slower * v / sqrt(v * v + creep * creep)
        return -max(at.normal, 0.0) * a * risen

    def rates(self, mode: int, at: At, z: list[float]) -> list[float]:
        _, _, _, way, speed, _ = self.numbers
        return [(speed * exp(-z[0]) - mode * at.slip) / way]
