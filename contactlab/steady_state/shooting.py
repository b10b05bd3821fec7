"""Periodic orbits by shooting: a state that the period map leaves where it is.

Newton's method on P(z) - z = 0, with the derivative of the period map by differences, which are good to
1e-8 where the map is smooth, and Broyden's rank-one corrections between. A step is judged by the next one
that the same derivative asks for, |(1 - A)^-1 (P(z) - z)|, which is the distance to the orbit and does not
hang on units: a slow rotor far from its orbit changes by as little in a period as one next to it. Steps are
limited to a trust region whose radius is adapted to that reduction (Deuflhard: Newton Methods for Nonlinear
Problems, 2011, ch. 3; Conn, Gould, Toint: Trust-Region Methods, 2000).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.immutable import read_only
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap

STEP: Final = 1e-6
"""Step of the differences, in parts of |z|."""

ROUGH: Final = 100.0
"""Ratio of the step of a second difference, which tests whether the map is smooth."""

CLOSED: Final = 1e-10
"""|P(z) - z| over |z| at which an orbit counts as closed, if it is `REACHED` too."""

REACHED: Final = 1e-8
"""Distance from the orbit over |z| with which shooting is content, where round-off lets it come so near."""

ROUND_OFF: Final = 2e-15
"""Of P(z) - z, over |z|."""

SLOW: Final = 1e-4
"""Distance of a multiplier from 1 below which the rotor's row of the derivative has a step `ROUGH` times as
long: what a slow rotor answers is less than the round-off of a short one."""

NEUTRAL: Final = 1e-11
"""Distance of a multiplier from 1 that those differences do not resolve."""

RESOLVED: Final = 4.0
"""Distance of a multiplier from 1, over `NEUTRAL`, from which on it is known to be another number."""

LEARNED: Final = 10.0
"""Change of P(z) - z over its round-off from which on a move tells of the slowest direction."""

MOST_ITERATIONS: Final = 40

FARTHEST: Final = 100.0
"""Length of the first step at most, in parts of |z|: a motor at its start is slow."""

WORTH: Final = 0.5
"""Share of |P(z) - z| that a step may leave without a new derivative."""


class NoOrbitError(RuntimeError):
    """There is no orbit near a state; the message continues 'no periodic orbit'."""


@final
@dataclass(frozen=True)
class Orbit:
    """A closed orbit of the period map.

    Args:
        map: whose fixed point it is.
        state: z at the section.
        jacobian: dP/dz there.
        roughness: relative change of the derivative along one direction when the step of its difference is a
            hundred times as long; large where the map is not smooth.
    """

    map: PeriodMap
    state: Array
    jacobian: Array
    roughness: float

    @classmethod
    def at(cls, section: PeriodMap, z: Array) -> "Orbit":
        """Take a closed orbit's derivative."""
        if not z.size:
            # All that moves is led.
            return cls(section, z, np.zeros((0, 0)), 0.0)
        # One step along each coordinate, and one along the diagonal that is `ROUGH` times as long.
        length, along = STEP * _size(z), np.full(z.size, z.size**-0.5)
        steps = length * np.vstack([np.eye(z.size), ROUGH * along])
        ahead, behind = np.split(_ends(section, np.vstack([z + steps, z - steps])), 2)
        # Central differences, dP/dz e_j = (P(z + h e_j) - P(z - h e_j)) / 2 h.
        every = (ahead - behind).T / (2.0 * length)
        jacobian, coarse = every[:, :-1], every[:, -1] / ROUGH
        fine = jacobian @ along
        if is_slow(section, jacobian):
            # What a slow rotor changes in a period is below the round-off of a short difference.
            steps = ROUGH * length * np.eye(z.size)
            ahead, behind = np.split(_ends(section, np.vstack([z + steps, z - steps])), 2)
            jacobian[-1] = (ahead - behind)[:, -1] / (2.0 * ROUGH * length)
        # A smooth map has the same derivative along the diagonal with the long step as with the short one.
        changed = float(np.linalg.norm(coarse - fine))
        # A map that forgets everything has no derivative, and none that changes.
        roughness = changed / max(float(np.linalg.norm(fine)), np.finfo(float).tiny)
        return cls(section, z, jacobian, roughness)

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers, eigenvalues of dP/dz, the largest first [1]."""
        result = np.linalg.eigvals(self.jacobian).astype(complex)
        return read_only(result[np.argsort(-np.abs(result), kind="stable")])

    def is_near(self, z: Array, share: float) -> bool:
        """Return whether a state lies within a share of |z| of that of the orbit."""
        return bool(np.linalg.norm(z - self.state) <= share * np.linalg.norm(self.state))

    @property
    def neutral(self) -> NDArray[np.bool_]:
        """Which multipliers are one: along their directions every motion repeats itself."""
        return np.abs(self.multipliers - 1.0) <= NEUTRAL

    @cached_property
    def largest(self) -> float:
        """Largest modulus of a multiplier, neutral ones left out [1]."""
        return float(np.abs(self.multipliers[~self.neutral]).max(initial=0.0))

    @property
    def stable(self) -> bool:
        """Whether every multiplier lies inside the unit circle, neutral ones left out."""
        return self.largest < 1.0

    @property
    def settling_time(self) -> float:
        """Time in which a small deviation falls by e [s]; infinite for an orbit that is not stable.

        Along neutral directions it never falls, and they are left out.
        """
        if not self.stable:
            return np.inf
        return float(-self.map.period / np.log(max(self.largest, np.finfo(float).tiny)))

    def closure(self, end: Array) -> float:
        """Return the distance of what was found from the orbit, |(1 - A)^-1 (P(z) - z)| over |z| [1].

        At least that of round-off, and what shooting is content with; `end` is P(z) of a run. Neutral
        directions are left out.
        """
        if not (size := float(np.linalg.norm(self.state))):
            return REACHED
        # The step that would close the orbit is the distance from it. Round-off of P(z) - z hides a distance
        # that grows with the inverse of the least singular value of 1 - A.
        away = float(np.linalg.norm(_newton_step(self.jacobian, end - self.state)))
        return max(2.0 * away / size, REACHED, ROUND_OFF / _slowest(self.jacobian))

    def velocity(self, mean: float, closure: float) -> Estimate:
        """Return a mean rotor velocity [rad/s] with what the closure leaves of it.

        The rotor's part of a state whose size is mostly the resonator's may be all of that.
        """
        size = float(np.linalg.norm(self.state)) / self.map.rotor_scale
        return Estimate(mean, closure * max(abs(mean), size))


def orbit_from(section: PeriodMap, z: Array) -> Orbit:
    """Compute the periodic orbit near a state.

    Raises:
        NoOrbitError: there is none near it.
        KeyboardInterrupt: as it comes.
    """
    if not z.size:
        return Orbit.at(section, z)
    # Begin with the gap P(z) - z and with A = dP/dz, by forward differences, at the motor's state.
    image = section(z)
    left, jacobian = image - z, _forward(section, z, image)
    fresh, radius, slowest = True, FARTHEST * _size(z), _slowest(jacobian)
    for _ in range(MOST_ITERATIONS):
        # Newton's step (7.2): (1 - A) dz = P(z) - z.
        move = _newton_step(jacobian, left)
        length, gap = float(np.linalg.norm(move)), float(np.linalg.norm(left))
        # The orbit is closed if the gap is small and the step too: beside a multiplier close to one the gap
        # is small far from the orbit. Round-off of the gap limits how small the step gets.
        if gap <= CLOSED * _size(z) and length <= max(REACHED, LEARNED * ROUND_OFF / slowest) * _size(z):
            return _resolved(Orbit.at(section, z))
        # The trust region: the derivative is believed no farther than the radius.
        move *= min(1.0, radius / length)
        try:
            after = section(z + move) - (z + move)
        # A rigid law refuses a start inside the rotor.
        except (BrokenOffError, ValueError):
            after = np.full(z.size, np.inf)
        # A step is worth what the same derivative asks for next, |(1 - A)^-1 (P(z + dz) - z - dz)|, over the
        # length of Newton's step: the share of the distance to the orbit that is left.
        runs = np.isfinite(after).all()
        share = float(np.linalg.norm(_newton_step(jacobian, after))) / length if runs else np.inf
        # It is nearer: go there. Broyden's correction (7.3) makes A foretell what the move changed, unless
        # that is round-off along the slowest direction, and the next step may be twice as long.
        if share < 1.0:
            if np.linalg.norm(move) * slowest > LEARNED * ROUND_OFF * _size(z):
                jacobian = updated(jacobian, move, np.asarray(after - left + move))
            z, left, fresh = z + move, after, False
            radius = max(radius, 2.0 * float(np.linalg.norm(move)))
        # A step that gained little with a corrected derivative gets a new one.
        if share > WORTH and not fresh:
            jacobian, fresh = _forward(section, z, left + z), True
            slowest = _slowest(jacobian)
        # With a new derivative it is the step that was too long.
        elif share > WORTH:
            radius = 0.25 * min(radius, length)
            if radius < STEP * _size(z):
                raise NoOrbitError(f"steps shrink to {radius:.1e} and lead no further")
    remains = np.linalg.norm(left) / _size(z)
    raise NoOrbitError(f"{MOST_ITERATIONS} steps leave a gap of {remains:.1e} of the state")


def continued(section: PeriodMap, z: Array, jacobian: Array) -> Orbit:
    """Compute the orbit of a map that continues an orbit of a map of other numbers in one step.

    Each move with the derivative of the other orbit, corrected by (7.3), must leave at most `WORTH` of the
    distance: within that range simplified Newton iterations follow a branch (Deuflhard 2011, sec. 5.1).
    Beyond it another orbit might be found, and nothing else is tried.

    Args:
        section: of the orbit that is looked for.
        z: state of the other orbit at this section.
        jacobian: dP/dz there.

    Raises:
        NoOrbitError: no orbit is so near.
    """
    slowest = _slowest(jacobian)
    left = section(z) - z
    for _ in range(MOST_ITERATIONS):
        move = _newton_step(jacobian, left)
        length, gap = float(np.linalg.norm(move)), float(np.linalg.norm(left))
        if gap <= CLOSED * _size(z) and length <= max(REACHED, LEARNED * ROUND_OFF / slowest) * _size(z):
            return _resolved(Orbit.at(section, z))
        after = section(z + move) - (z + move)
        share = float(np.linalg.norm(_newton_step(jacobian, after))) / length
        if not share <= WORTH:
            raise NoOrbitError(f"a step leaves {share:.2g} of the distance")
        jacobian = updated(jacobian, move, after - left + move)
        z, left = z + move, after
    raise NoOrbitError(f"{MOST_ITERATIONS} steps leave a gap of {gap / _size(z):.1e} of the state")


def _resolved(orbit: Orbit) -> Orbit:
    """Return an orbit whose multipliers are one, or known not to be."""
    away = np.abs(orbit.multipliers - 1.0)
    if np.any((away > NEUTRAL) & (away < RESOLVED * NEUTRAL)):
        raise NoOrbitError(f"a multiplier that differs from one by {away.min():.0e} is not resolved")
    return orbit


def is_slow(section: PeriodMap, jacobian: Array) -> bool:
    """Return whether the rotor settles so slowly that its row of the derivative needs long steps."""
    return section.belt is None and _slowest(jacobian) < SLOW


def _slowest(jacobian: Array) -> float:
    """Return the least singular value of 1 - dP/dz that is not neutral."""
    # The distance to an orbit is at most the gap over this value.
    values = np.linalg.svd(np.eye(len(jacobian)) - jacobian, compute_uv=False)
    return float(values[values > NEUTRAL * values.max(initial=1.0)].min(initial=1.0))


def _newton_step(jacobian: Array, left: Array) -> Array:
    """Return the step that closes a gap, the shortest where nothing brings a coordinate back."""
    # Singular values of 1 - A below `NEUTRAL` belong to neutral directions, along which nothing is moved.
    return np.asarray(np.linalg.lstsq(np.eye(left.size) - jacobian, left, NEUTRAL)[0], np.float64)


def derivative_of(function: Callable[[Array], Array], at: Array, along: Array, step: float = STEP) -> Array:
    """Return the derivative of a function along a direction, by a central difference."""
    length = step * _size(at)
    return (function(at + length * along) - function(at - length * along)) / (2.0 * length)


def updated(jacobian: Array, move: Array, change: Array) -> Array:
    """Return the derivative next to another that foretells what a move changes (Broyden 1965)."""
    return np.asarray(jacobian + np.outer(change - jacobian @ move, move) / (move @ move))


def _forward(section: PeriodMap, z: Array, image: Array) -> Array:
    """Return dP/dz by forward differences from P(z), at half the price and to half the digits."""
    length = STEP * _size(z)
    jacobian = np.asarray((_ends(section, z + length * np.eye(z.size)) - image).T / length)
    if is_slow(section, jacobian):
        # The rotor's row again, by a step that moves more than round-off.
        length *= ROUGH
        jacobian[-1] = (_ends(section, z + length * np.eye(z.size)) - image)[:, -1] / length
    return jacobian


def _ends(section: PeriodMap, starts: Array) -> Array:
    """Return the states after others that lie together, or say that there is no derivative."""
    ends = section.ends(starts)
    if not np.isfinite(ends).all():
        raise NoOrbitError("the motor breaks off or does not run from next to it")
    return ends


def _size(z: Array) -> float:
    return float(np.linalg.norm(z)) or 1.0
