"""Attractors of a motor that more than one belongs to: which there are, and how many starts come to each."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.laws import ContactLaw
from contactlab.motor import ModalState, Motor
from contactlab.steady_state.arrival import NotSettledError, UnboundedError
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.search import LONGEST, Steady, steady, steady_setup

SAME: Final = 1e-5
"""Relative distance of the states of two orbits at one section below which they are one: an orbit is closed
to 1e-10, which a multiplier of 0.9999 makes 1e-6."""

SIGMA: Final = 3.0
"""Statistical errors by which the means of two motions without an orbit differ at least if they are two."""


@final
@dataclass(frozen=True)
class Attractor:
    """A steady state and the share of the starts that came to it.

    >>> import contactlab as cl
    >>> found = cl.attractors(cl.build(), count=2)[0]
    >>> found.share, round(found.steady.orbit.settling_time, 4)
    (1.0, 0.0175)
    """

    steady: Steady
    share: float


def attractors(
    motor: Motor | Setup,
    count: int = 8,
    seed: int = 0,
    *,
    law: ContactLaw | None = None,
    velocity: float | None = None,
    excitation: float = 2.0,
    longest: int = LONGEST,
) -> tuple[Attractor, ...]:
    """Find the steady states that a motor comes to from its own start and from others drawn at random.

    Drawn are the velocity of the rotor, evenly within +-`velocity`, and that of every mode, evenly within
    +-`excitation` times the amplitude that it has without contact. The modes start where they start in the
    setup, so that no start lies inside the rotor.

        >>> import contactlab as cl
        >>> setup = cl.build(["law=newton", "contact.clearance=3.895e-6"])
        >>> for each in cl.attractors(setup, count=4):
        ...     print(f"{each.share:.0%} {each.steady.kind}, {each.steady.velocity[0]:.4f} rad/s")
        ...
        75% without contact, 0.0000 rad/s
        25% periodic, 1.9566 rad/s

    Args:
        motor: what moves, or a whole setup; its own start is the first of those that are tried.
        count: of the starts in all.
        seed: of the random numbers.
        law: what acts between tip and rotor; a setup has its own.
        velocity: [rad/s]; None is the largest with which the tip moves along the rotor without contact.
        excitation: [1].
        longest: as of `contactlab.steady`.

    Returns:
        What was reached, by falling share. The shares sum to less than 1 where runs broke off or came to no
        steady state.

    Raises:
        NoPeriodError: the drive does not repeat itself.
        UnboundedError: an internal variable of the law comes to no steady value.
    """
    setup = steady_setup(motor, law)
    result: list[tuple[Steady, int]] = []
    for start in _starts(setup, count, seed, velocity, excitation):
        try:
            reached = steady(start, longest=longest)
        except UnboundedError:
            raise
        except (BrokenOffError, NotSettledError):
            continue
        known = next((i for i, (other, _) in enumerate(result) if same(other, reached)), None)
        if known is None:
            result.append((replace(reached, setup=setup), 1))
        else:
            result[known] = (result[known][0], result[known][1] + 1)
    result.sort(key=lambda pair: -pair[1])
    return tuple(Attractor(reached, times / count) for reached, times in result)


def same(one: Steady, other: Steady) -> bool:
    """Return whether two steady states of a motor are one: orbits by their states, others by their means."""
    if one.periods and other.periods and not (touches(one) or touches(other)):
        # A rotor that nothing touches keeps whatever velocity it has.
        return True
    if (one.kind, one.periods) != (other.kind, other.periods):
        return False
    if one.orbit is None or other.orbit is None:
        (a, error_a), (b, error_b) = one.velocity, other.velocity
        return bool(abs(a - b) <= SIGMA * np.hypot(error_a, error_b))
    target = other.orbit
    weighed = replace(one.orbit.map, weights=target.map.weights)
    z = at_phase(weighed, weighed.state_of(*one.orbit.map.parts_of(one.orbit.state)), target.map.phase)
    once = replace(target.map, periods=1)
    for _ in range(one.periods):
        if np.linalg.norm(z - target.state) <= SAME * np.linalg.norm(target.state):
            return True
        z = once(z)
    return False


def touches(one: Steady) -> bool:
    """Return whether tip and rotor meet in a steady state."""
    return bool(one.motion.contacts["start_time"].size)


def at_phase(section: PeriodMap, z: Array, phase: float) -> Array:
    """Return the state that follows one of a section when the drive next has another phase."""
    part = (phase - section.phase) % 1.0
    return section.end_of(section.run(z, part / section.periods)) if part else z


def amplitudes(setup: Setup) -> Array:
    """Return the amplitude of every mode's velocity without contact, tones added up [m/s kg^1/2]."""
    modes, drive = setup.motor.modes, setup.motor.drive
    rate = drive.angular_frequency
    stiffness, damping = modes.stiffness[:, None], modes.damping[:, None]
    result = np.abs(modes.coupling @ drive.phasors * rate / (stiffness - rate**2 + 1j * damping * rate))
    return np.asarray(result.sum(axis=1))


def reach(setup: Setup) -> float:
    """Return a bound of the free tip's velocity along the rotor, over the rotor's radius [rad/s]."""
    motor = setup.motor
    along = motor.geometry.tip_length * np.abs(motor.modes.tip_slope) @ amplitudes(setup)
    return float(along / motor.geometry.rotor_radius)


def _starts(
    setup: Setup, count: int, seed: int, velocity: float | None, excitation: float
) -> Iterator[Setup]:
    """Yield the setup itself, and then with other starts."""
    rng, motor = np.random.default_rng(seed), setup.motor
    fastest = reach(setup) if velocity is None else velocity
    modal = excitation * amplitudes(setup)
    at = np.zeros(modal.size) if motor.start is None else motor.start.displacement
    yield setup
    for _ in range(count - 1):
        rotor = replace(motor.rotor, initial_velocity=float(rng.uniform(-fastest, fastest)))
        start = ModalState(at, rng.uniform(-modal, modal))
        yield replace(setup, motor=replace(motor, rotor=rotor, start=start))
