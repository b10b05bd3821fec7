"""Attractors of a motor: from starts drawn at random, and basins over two coordinates of the start."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Final, final

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_lyapunov

from contactlab.arrays import Array
from contactlab.checks import checked_arguments
from contactlab.config import Setup
from contactlab.laws import ContactLaw
from contactlab.motor import ModalState, Motor
from contactlab.parameter import Parameter, not_negative
from contactlab.progress import tell_progress
from contactlab.steady_state.arrival import NotSettledError, UnboundedError, settled
from contactlab.steady_state.continuation import SMOOTH
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.search import LONGEST, Steady, steady, steady_setup
from contactlab.steady_state.shooting import Orbit
from contactlab.steady_state.state import attributes_of, flags

SAME: Final = 1e-5
"""Relative distance of the states of two orbits at one section below which they are one: an orbit is closed
to 1e-10, which a multiplier of 0.9999 makes 1e-6."""

SIGMA: Final = 3.0
"""Statistical errors by which the means of two motions without an orbit differ at least if they are two."""

COORDINATES: Final = {
    "rotor_velocity": ("rad s-1", "rotor velocity at the start"),
    "drive_phase": ("1", "phase of the drive at the start, in its periods"),
    "tip_displacement": ("m", "displacement of the tip at the start, in the first mode"),
    "tip_velocity": ("m s-1", "velocity of the tip at the start, in the first mode"),
}
"""Coordinates of a start, each with unit and meaning."""

LOOKS: Final = (30, 90, 270)
"""Periods after which a motion is tested for membership in a ball."""

LARGEST: Final = 0.5
"""Radius of the first ball that is tried, in parts of |z|."""

SMALLER: Final = 0.25
"""Ratio of the radii that are tried one after another."""

SMALLEST: Final = 1e-2
"""Radius below which there is no ball, and a motion must run into its orbit."""

CONTRACTED: Final = 0.8
"""Largest ratio of the distances from an orbit after and before one settling time in the ball."""

CANNOT_TELL: Final = -1


@final
@dataclass(frozen=True)
class Attractor:
    """A steady state and the share of the starts that reach it.

    >>> import contactlab as cl
    >>> found = cl.attractors(cl.build(), count=2)[0]
    >>> found.share, round(found.steady.orbit.settling_time, 4)
    (1.0, 0.0175)
    """

    steady: Steady
    share: float


@checked_arguments(velocity="rad/s")
def attractors(
    motor: Motor | Setup,
    count: Annotated[int, Parameter("", "1", "number of starts", at_least=1)] = 8,
    seed: Annotated[int, Parameter("", "1", "seed of the random numbers", at_least=0)] = 0,
    *,
    law: ContactLaw | None = None,
    velocity: float | None = None,
    excitation: Annotated[float, not_negative("", "1", "largest amplitude of a mode")] = 2.0,
    longest: int = LONGEST,
    own: Steady | None = None,
) -> tuple[Attractor, ...]:
    """Compute the steady states that a motor reaches from its own start and from others drawn at random.

    Drawn are the velocity of the rotor, evenly within +-`velocity`, and that of every mode, evenly within
    +-`excitation` times the amplitude that it has without contact. The modes start where they start in the
    setup, so that no start lies inside the rotor.

        >>> import contactlab as cl
        >>> setup = cl.build(["law=newton", "contact.clearance=3.895e-6"])
        >>> for each in cl.attractors(setup, count=4):
        ...     print(f"{each.share:.0%} {each.steady.kind}, {each.steady.velocity[0]:.4f} rad/s")
        ...
        75% without contact, 0.0000 rad/s
        25% periodic, 1.9487 rad/s

    Args:
        motor: what moves, or a whole setup; its own start is the first of those that are tried.
        count: of the starts in all.
        seed: of the random numbers.
        law: what acts between tip and rotor; a setup has its own.
        velocity: [rad/s]; None is the largest with which the tip moves along the rotor without contact.
        excitation: [1].
        longest: as of `contactlab.steady`.
        own: the steady state that the motor reaches from its own start; None computes it.

    Returns:
        What was reached, by falling share. The shares sum to less than 1 where runs broke off or came to no
        steady state.

    Raises:
        NoPeriodError: the drive does not repeat itself.
        UnboundedError: an internal variable of the law comes to no steady value.
    """
    setup = steady_setup(motor, law)
    states: list[tuple[Steady, int]] = []
    for number, start in enumerate(_starts(setup, count, seed, velocity, excitation)):
        try:
            # The motor's own start is the first, and may be known.
            reached = own if own is not None and number == 0 else steady(start, longest=longest)
        except UnboundedError:
            raise
        except (BrokenOffError, NotSettledError):
            continue
        known = next((i for i, (other, _) in enumerate(states) if same(other, reached)), None)
        if known is None:
            states.append((replace(reached, setup=setup), 1))
        else:
            states[known] = (states[known][0], states[known][1] + 1)
    states.sort(key=lambda pair: -pair[1])
    return tuple(Attractor(reached, times / count) for reached, times in states)


def same(first: Steady, second: Steady) -> bool:
    """Return whether two steady states of a motor are equal, orbits by states and others by means."""
    if first.periods and second.periods and not (touches(first) or touches(second)):
        # A rotor that nothing touches keeps whatever velocity it has.
        return True
    if (first.kind, first.periods) != (second.kind, second.periods):
        return False
    # Means without an orbit are equal within their statistical errors.
    if first.orbit is None or second.orbit is None:
        (a, error_a), (b, error_b) = first.velocity, second.velocity
        return bool(abs(a - b) <= SIGMA * np.hypot(error_a, error_b))
    # Follow the first orbit to the section of the second in each of its periods: if they are one orbit, one
    # of these states is that of the second.
    section, target = first.orbit.map, second.orbit
    part = (target.map.phase - section.phase) % 1.0 or 1.0
    for passed in range(first.periods):
        run = section.run(first.orbit.state, (passed + part) / section.periods)
        if target.map.ends_at(run) and target.is_near(target.map.end_of(run), SAME):
            return True
    return False


def touches(state: Steady) -> bool:
    """Return whether tip and rotor meet in a steady state."""
    return bool(state.motion.contacts["start_time"].size)


def amplitudes(setup: Setup) -> Array:
    """Return the amplitude of every mode's velocity without contact, tones added up [m/s kg^1/2]."""
    modes, drive = setup.motor.modes, setup.motor.drive
    # |i omega f / (omega_j^2 - omega^2 + i d_j omega)|, tone by tone.
    rate = drive.angular_frequency
    stiffness, damping = modes.stiffness[:, None], modes.damping[:, None]
    tones = np.abs(setup.motor.force_phasors * rate / (stiffness - rate**2 + 1j * damping * rate))
    return np.asarray(tones.sum(axis=1))


def reach(setup: Setup) -> float:
    """Return a bound of the free tip's velocity along the rotor, over the rotor's radius [rad/s]."""
    motor = setup.motor
    # All modes at once and in phase: no tip moves faster.
    along = np.abs(motor.rows_at_rest[1]) @ amplitudes(setup)
    return float(along / motor.geometry.rotor_radius)


def _starts(
    setup: Setup, count: int, seed: int, velocity: float | None, excitation: float
) -> Iterator[Setup]:
    """Yield the setup itself, and then with other starts."""
    rng, motor = np.random.default_rng(seed), setup.motor
    # The seed gives the same starts for every law of a motor.
    fastest = reach(setup) if velocity is None else velocity
    modal = excitation * amplitudes(setup)
    at = np.zeros(modal.size) if motor.start is None else motor.start.displacement
    yield setup
    for _ in range(count - 1):
        rotor = replace(motor.rotor, initial_velocity=float(rng.uniform(-fastest, fastest)))
        start = ModalState(at, rng.uniform(-modal, modal))
        yield replace(setup, motor=replace(motor, rotor=rotor, start=start))


@final
@dataclass(frozen=True)
class Ball:
    """A neighbourhood of an orbit that motions do not leave: |x|_M <= radius, |x|_M^2 = x^T M x.

    M solves A^T M A / rho^2 - M + 1 = 0 for the derivative A of the map, with rho between its largest
    multiplier and 1, so that in this norm a small deviation falls in every period. The radius is determined
    by runs of a settling time from both ends of each axis of the ball and of the one half as large, which
    must come nearer: a check at points, not a proof.
    """

    orbit: Orbit
    norm: Array
    radius: float

    @classmethod
    def around(cls, orbit: Orbit) -> "Ball":
        """Find the largest of some balls about an orbit; radius 0 where there is none.

        Motions beside an orbit do not come back to it along a neutral direction.
        """
        times = max(1.0, np.ceil(orbit.settling_time / orbit.map.period))
        if times > LONGEST or orbit.roughness > SMOOTH or orbit.neutral.any():
            return cls(orbit, np.eye(orbit.state.size), 0.0)
        # (7.10): A^T M A / rho^2 - M + 1 = 0, which has a solution for rho above the largest multiplier.
        rho = 0.5 * (1.0 + abs(orbit.multipliers[0]))
        norm = solve_discrete_lyapunov(orbit.jacobian.T / rho, np.eye(orbit.state.size))
        # The longest axis of an ellipsoid is that of the smallest eigenvalue, which comes first.
        size, axes = np.linalg.eigh(norm)
        # The ends of the axes of |x|_M = 1, either side.
        ends = [side * axis for axis in (axes / np.sqrt(size)).T for side in (-1.0, 1.0)]
        ball = cls(orbit, norm, 0.0)
        # Begin where the longest axis has half the length of the orbit's state, and try smaller balls in
        # turn.
        radius = LARGEST * float(np.linalg.norm(orbit.state) * np.sqrt(size[0]))
        least = radius * SMALLEST / LARGEST
        while radius > least:
            # From the ends of its axes, and of the axes of the ball half as large, motions must come nearer.
            if all(ball._comes_nearer(part * radius * end, times) for end in ends for part in (1.0, 0.5)):
                return replace(ball, radius=radius)
            radius *= SMALLER
        return ball

    def distance(self, z: Array) -> float:
        """Return |z - z_orbit|_M."""
        x = z - self.orbit.state
        return float(np.sqrt(x @ self.norm @ x))

    def holds(self, z: Array) -> bool:
        """Return whether a state at the section of the orbit lies in the ball."""
        return self.distance(z) <= self.radius

    def _comes_nearer(self, x: Array, times: float) -> bool:
        z = self.orbit.state + x
        try:
            run = self.orbit.map.run(z, times)
        # A rigid law refuses a start inside the rotor.
        except (BrokenOffError, ValueError):
            return False
        if not self.orbit.map.ends_at(run):
            return False
        return self.distance(self.orbit.map.end_of(run)) <= CONTRACTED * self.distance(z)


@final
@dataclass(frozen=True)
class Basins:
    """A map of starts to attractors.

    Args:
        setup: of the motor; its own start is changed in two coordinates.
        axes: values of two of `COORDINATES`, in SI.
        labels: place in `attractors` of each start, -1 where it is unresolved, shape (first, second).
        attractors: the steady states that were reached.
    """

    setup: Setup
    axes: dict[str, Array]
    labels: NDArray[np.int8]
    attractors: tuple[Steady, ...]

    def __repr__(self) -> str:
        over = " and ".join(self.axes)
        return f"<Basins: {self.labels.size} starts over {over}, {len(self.attractors)} attractors>"

    @cached_property
    def shares(self) -> tuple[float, ...]:
        """The share of the starts that comes to each attractor."""
        return tuple(float(np.mean(self.labels == i)) for i in range(len(self.attractors)))

    @property
    def unresolved(self) -> int:
        """Number of starts that are assigned to no attractor."""
        return int(np.sum(self.labels == CANNOT_TELL))

    def to_xarray(self) -> xarray.Dataset:
        """Return the labels over both coordinates, and what is known of each attractor."""
        names = ["not_known", *(f"attractor_{i}" for i in range(len(self.attractors)))]
        of_labels = flags("attractor to which the motor comes", names, first=CANNOT_TELL)
        velocity = np.array([each.velocity for each in self.attractors]).reshape(-1, 2)
        largest = [
            np.nan if each.orbit is None else abs(each.orbit.multipliers[0]) for each in self.attractors
        ]
        columns: dict[str, tuple[object, str, str]] = {
            "share": (list(self.shares), "1", "share of the starts that come to it"),
            "velocity": (velocity[:, 0], "rad s-1", "mean rotor velocity"),
            "velocity_error": (velocity[:, 1], "rad s-1", "statistical error of the mean"),
            "largest_multiplier": (largest, "1", "largest modulus of a multiplier; NaN without an orbit"),
            "periods": ([each.periods for each in self.attractors], "1", "drive periods; 0 without an orbit"),
        }
        data = xarray.Dataset(
            {n: ("attractor", v, {"units": u, "long_name": w}) for n, (v, u, w) in columns.items()}
        )
        kinds = [each.kind for each in self.attractors]
        data["kind"] = ("attractor", kinds, {"long_name": "kind of motion"})
        neutral = np.array([is_neutral(each) for each in self.attractors], dtype=np.int8)
        meaning = "whether the motion repeats itself at any velocity, in a range at least"
        data["neutral"] = ("attractor", neutral, flags(meaning, ("single", "neutral")))
        for name, values in self.axes.items():
            unit, meaning = COORDINATES[name]
            data[name] = (name, values, {"units": unit, "long_name": meaning})
        data["label"] = (tuple(self.axes), self.labels, of_labels)
        data.attrs = {
            "title": f"Basins of attraction, {self.setup.law.title}",
            "unresolved": self.unresolved,
            **attributes_of(self.setup),
        }
        return data


def default_axes(setup: Setup, count: int = 24) -> dict[str, Array]:
    """Return rotor velocities, up to the largest of the free tip either way, and phases of the drive."""
    fastest = reach(setup)
    return {"rotor_velocity": np.linspace(-fastest, fastest, count), "drive_phase": np.arange(count) / count}


def basins(
    motor: Motor | Setup,
    axes: Mapping[str, Array] | None = None,
    *,
    law: ContactLaw | None = None,
    longest: int = LONGEST,
    report: Callable[[int], None] | None = None,
) -> Basins:
    """Map which of its steady states a motor reaches, over two coordinates of its start.

    A motion that enters a `Ball` about a known orbit belongs to it; one that enters none within some hundred
    periods continues as in `contactlab.steady` and adds the attractor that it reaches.

    Args:
        motor, axes, law: as of `contactlab.basins`.
        longest: as of `contactlab.steady`.
        report: called with the number of starts that are done.

    Raises:
        ValueError: there are not two coordinates, or an unknown one.
        NoPeriodError: the drive does not repeat itself.
        UnboundedError: an internal variable of the law has no steady value.
    """
    setup = steady_setup(motor, law)
    coordinates = {name: np.asarray(v, dtype=np.float64) for name, v in (axes or default_axes(setup)).items()}
    if len(coordinates) != 2 or not coordinates.keys() <= COORDINATES.keys():
        raise ValueError(
            f"The coordinates of the start are {', '.join(coordinates) or 'none'}; they must be two of "
            f"{', '.join(COORDINATES)}."
        )
    shape = tuple(values.size for values in coordinates.values())
    labels = np.full(shape, CANNOT_TELL, dtype=np.int8)
    states: list[Steady] = []
    balls: list[Ball | None] = []
    # Start by start: the ball that the motion enters decides. Where there is none the motor runs until it has
    # settled; an attractor that is not known yet joins the others, with a ball of its own.
    for done, place in enumerate(np.ndindex(*shape)):
        start = {name: float(values[i]) for (name, values), i in zip(coordinates.items(), place, strict=True)}
        try:
            section, z = started(setup, start)
            label = _ball_reached(balls, section, z)
            if label is None:
                reached = settled(setup, None, (section.phase, *section.parts_of(z), None), longest)
                assert reached is not None
                # Neutral states of one family are one attractor.
                equal = (
                    (is_neutral(other) and is_neutral(reached) and touches(other) == touches(reached))
                    or same(other, reached)
                    for other in states
                )
                label = next((i for i, is_equal in enumerate(equal) if is_equal), len(states))
                if label == len(states):
                    states.append(reached)
                    orbit = reached.orbit
                    balls.append(Ball.around(orbit) if orbit is not None and touches(reached) else None)
            labels[place] = label
        except UnboundedError:
            raise
        # A rigid law refuses a start inside the rotor.
        except (BrokenOffError, NotSettledError, ValueError):
            labels[place] = CANNOT_TELL
        tell_progress(f"{done + 1} of {labels.size} starts", (done + 1) / labels.size)
        if report is not None:
            report(done + 1)
    return Basins(setup, coordinates, labels, tuple(states))


def started(setup: Setup, start: Mapping[str, float]) -> tuple[PeriodMap, Array]:
    """Return the section and the state in which a motor starts that has these coordinates."""
    motor = setup.motor
    modes = motor.modes
    # The tip moves in the first mode alone: q_1 = u / phi_1, on top of the motor's own start.
    zero = np.zeros(modes.stiffness.size)
    own = motor.start or ModalState(zero, zero)
    displacement, velocity = own.displacement.copy(), own.velocity.copy()
    if "tip_displacement" in start:
        displacement[0] = start["tip_displacement"] / modes.tip_displacement[0]
    if "tip_velocity" in start:
        velocity[0] = start["tip_velocity"] / modes.tip_displacement[0]
    section = PeriodMap(setup, phase=start.get("drive_phase", 0.0) % 1.0)
    turning = start.get("rotor_velocity", motor.rotor.initial_velocity)
    return section, section.state_of(ModalState(displacement, velocity), turning)


def is_neutral(state: Steady) -> bool:
    """Return whether a motion repeats itself at any rotor velocity, within a range at least.

    That is so where nothing touches the rotor, and where contacts of opposite slip take and give the same
    impulse.
    """
    if state.orbit is None:
        return bool(state.periods and not touches(state))
    return bool(state.orbit.neutral.any())


def _ball_reached(balls: list[Ball | None], section: PeriodMap, z: Array) -> int | None:
    """Return the ball that a motion enters first."""
    known = [(i, ball) for i, ball in enumerate(balls) if ball is not None and ball.radius > 0.0]
    for periods in LOOKS if known else ():
        # Run until the section of each orbit, where its ball lies.
        for i, ball in known:
            target = ball.orbit.map
            # From the start each time: a run continued within a contact is another one.
            run = section.run(z, periods + (target.phase - section.phase) % 1.0)
            if target.ends_at(run) and ball.holds(target.end_of(run)):
                return i
    return None
