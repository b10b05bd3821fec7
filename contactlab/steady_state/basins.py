"""Basins of attraction: to which of its steady states a motor comes from where it starts."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, final

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.linalg import solve_discrete_lyapunov

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.laws import ContactLaw
from contactlab.motor import ModalState, Motor
from contactlab.steady_state.arrival import NotSettledError, UnboundedError, settled
from contactlab.steady_state.bifurcations import SMOOTH
from contactlab.steady_state.coexisting import at_phase, reach, same, touches
from contactlab.steady_state.dataset import attributes_of, flags
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.search import LONGEST, Steady, steady_setup
from contactlab.steady_state.shooting import Orbit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COORDINATES: Final = {
    "rotor_velocity": ("rad s-1", "rotor velocity at the start"),
    "drive_phase": ("1", "phase of the drive at the start, in its periods"),
    "tip_displacement": ("m", "displacement of the tip at the start, in the first mode"),
    "tip_velocity": ("m s-1", "velocity of the tip at the start, in the first mode"),
}
"""Of a start, with unit and meaning."""

LOOKS: Final = (30, 90, 270)
"""Periods after which it is looked whether a motion has come into a ball."""

LARGEST: Final = 0.5
"""Radius of the first ball that is tried, in parts of |z|."""

SMALLER: Final = 0.25
"""Ratio of the radii that are tried one after another."""

SMALLEST: Final = 1e-2
"""Radius below which there is no ball, and a motion must run into its orbit."""

CONTRACTED: Final = 0.8
"""Share of its distance from an orbit that a motion may have left after a settling time in the ball."""

NEUTRAL: Final = 1e-6
"""Distance of a multiplier from 1, of which the differences are no longer sure."""

CANNOT_TELL: Final = -1


@final
@dataclass(frozen=True)
class Ball:
    """A neighbourhood of an orbit that motions do not leave: |x|_M <= radius, |x|_M^2 = x^T M x.

    M solves A^T M A / rho^2 - M + 1 = 0 for the derivative A of the map, with rho between its largest
    multiplier and 1, so that in this norm a small deviation falls in every period. How far the law of the
    small holds is found by trial: from both ends of each axis of the ball and of the one half as large the
    motor runs for a settling time, and must come nearer. That is a check at points, not a proof.
    """

    orbit: Orbit
    norm: Array
    radius: float

    @classmethod
    def around(cls, orbit: Orbit) -> "Ball":
        """Find the largest of some balls about an orbit; radius 0 where there is none."""
        times = max(1.0, np.ceil(orbit.settling_time / orbit.map.period))
        if times > LONGEST or orbit.roughness > SMOOTH:
            return cls(orbit, np.eye(orbit.state.size), 0.0)
        rho = 0.5 * (1.0 + abs(orbit.multipliers[0]))
        norm = solve_discrete_lyapunov(orbit.jacobian.T / rho, np.eye(orbit.state.size))
        # The longest axis of an ellipsoid is that of the smallest eigenvalue, which comes first.
        size, axes = np.linalg.eigh(norm)
        ends = [side * axis for axis in (axes / np.sqrt(size)).T for side in (-1.0, 1.0)]
        ball = cls(orbit, norm, 0.0)
        radius = LARGEST * float(np.linalg.norm(orbit.state) * np.sqrt(size[0]))
        least = radius * SMALLEST / LARGEST
        while radius > least:
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
            later = self.orbit.map.end_of(self.orbit.map.run(z, times))
        # A rigid law refuses a start inside the rotor.
        except (BrokenOffError, ValueError):
            return False
        return self.distance(later) <= CONTRACTED * self.distance(z)


@final
@dataclass(frozen=True)
class Basins:
    """Where starts go.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> axes = {"rotor_velocity": np.array([-2.0, 2.0]), "drive_phase": np.array([0.0])}
        >>> found = cl.basins(cl.build(), axes).details
        >>> found
        <Basins: 2 starts over rotor_velocity and drive_phase, 1 attractors>
        >>> found.to_xarray()["label"].dims, found.unresolved
        (('rotor_velocity', 'drive_phase'), 0)

    Args:
        setup: of the motor; its own start is changed in two coordinates.
        axes: values of two of `COORDINATES`, in SI.
        labels: place in `attractors` of each start, -1 where it cannot be told, shape (first, second).
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
        """The starts of which it cannot be told where they go."""
        return int(np.sum(self.labels == CANNOT_TELL))

    def to_xarray(self) -> xarray.Dataset:
        """Return the labels over both coordinates, and what is known of each attractor."""
        names = ["cannot_tell", *(f"attractor_{i}" for i in range(len(self.attractors)))]
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
        kinds = ["neutral" if is_neutral(each) and touches(each) else each.kind for each in self.attractors]
        text = "kind of motion; the rotor of a neutral one keeps any velocity in a range"
        data["kind"] = ("attractor", kinds, {"long_name": text})
        for name, values in self.axes.items():
            unit, text = COORDINATES[name]
            data[name] = (name, values, {"units": unit, "long_name": text})
        data["label"] = (tuple(self.axes), self.labels, of_labels)
        data.attrs = {
            "title": f"Basins of attraction, {self.setup.law.title}",
            "unresolved": self.unresolved,
            **attributes_of(self.setup),
        }
        return data

    def plot(self) -> "Figure":
        """Draw the map of the labels, the attractors' velocities in its legend."""
        # It brings matplotlib.
        from contactlab.plot.orbits import draw_basins

        return draw_basins(self.to_xarray())


def default_axes(setup: Setup, count: int = 24) -> dict[str, Array]:
    """Return the rotor's velocity and the drive's phase, which nobody chooses who switches a motor on.

    The velocity goes up to the largest of the tip along the rotor without contact, either way.
    """
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
    """Map which of its steady states a motor comes to, over two coordinates of its start.

    A motion that comes into a `Ball` about a known orbit belongs to it; one that comes into none within
    some hundred periods goes on as `contactlab.steady` does, and adds what it finds.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> axes = {"rotor_velocity": np.linspace(-2.0, 2.0, 3), "drive_phase": np.array([0.0, 0.5])}
        >>> found = cl.basins(cl.build(), axes).details
        >>> found.labels.tolist(), found.shares, f"{found.attractors[0].velocity[0]:.4f} rad/s"
        ([[0, 0], [0, 0], [0, 0]], (1.0,), '-2.1911 rad/s')

    Args:
        motor: what moves, or a whole setup.
        axes: values of two of `COORDINATES`; by default those of `default_axes`.
        law: what acts between tip and rotor; a setup has its own.
        longest: as of `contactlab.steady`.
        report: called with the number of starts that are done.

    Raises:
        ValueError: there are not two coordinates, or one that there is none of.
        NoPeriodError: the drive does not repeat itself.
        UnboundedError: an internal variable of the law comes to no steady value.
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
    result: list[Steady] = []
    balls: list[Ball | None] = []
    for done, place in enumerate(np.ndindex(*shape)):
        start = {name: float(values[i]) for (name, values), i in zip(coordinates.items(), place, strict=True)}
        try:
            section, z = started(setup, start)
            label = _fallen_into(balls, section, z)
            if label is None:
                there, memory = _setup_at(section, z)
                begins = 0.0, there.motor.start, there.motor.rotor.initial_velocity, memory
                reached = settled(there, None, begins, longest)
                assert reached is not None
                label = next(
                    (i for i, other in enumerate(result) if _of_one_basin(other, reached)), len(result)
                )
                if label == len(result):
                    result.append(reached)
                    orbit = reached.orbit
                    balls.append(Ball.around(orbit) if orbit is not None and touches(reached) else None)
            labels[place] = label
        except UnboundedError:
            raise
        # A rigid law refuses a start inside the rotor.
        except (BrokenOffError, NotSettledError, ValueError):
            labels[place] = CANNOT_TELL
        if report is not None:
            report(done + 1)
    return Basins(setup, coordinates, labels, tuple(result))


def started(setup: Setup, start: Mapping[str, float]) -> tuple[PeriodMap, Array]:
    """Return the section and the state in which a motor starts that has these coordinates."""
    motor = setup.motor
    modes = motor.modes
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


def is_neutral(one: Steady) -> bool:
    """Return whether a rotor keeps whatever velocity it has, within a range at least.

    That is so where nothing touches it, and where contacts of opposite slip take and give the same impulse.
    """
    largest = 1.0 if one.orbit is None else abs(one.orbit.multipliers[0])
    return bool(one.periods and largest > 1.0 - NEUTRAL)


def _of_one_basin(one: Steady, other: Steady) -> bool:
    """Return whether two steady states are one, or of one family that nothing holds in its place."""
    return (is_neutral(one) and is_neutral(other) and touches(one) == touches(other)) or same(one, other)


def _fallen_into(balls: list[Ball | None], section: PeriodMap, z: Array) -> int | None:
    """Return the ball that a motion comes into first."""
    known = [(i, ball) for i, ball in enumerate(balls) if ball is not None and ball.radius > 0.0]
    for periods in LOOKS if known else ():
        for i, ball in known:
            target = ball.orbit.map
            # From the start each time: a run that goes on in the middle of a contact is another one.
            if ball.holds(target.end_of(section.run(z, periods + (target.phase - section.phase) % 1.0))):
                return i
    return None


def _setup_at(section: PeriodMap, z: Array) -> tuple[Setup, Array]:
    """Return a setup that starts where a motor is when the drive next has phase 0, and its memory there."""
    start, velocity, memory = section.parts_of(at_phase(section, z, 0.0))
    motor = section.setup.motor
    rotor = replace(motor.rotor, initial_velocity=velocity)
    return replace(section.setup, motor=replace(motor, start=start, rotor=rotor)), memory
