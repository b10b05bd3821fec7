"""A motor: normal modes of a resonator, a drive, a contact geometry and a rotor."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from typing import Annotated, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import Checked, check_number, check_shape
from contactlab.immutable import Immutable
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.plant import Plant
from contactlab.parameter import Parameter, not_negative, positive

ROUND_OFF: Final = 1e-9
"""Share of the largest capacitance by which others may miss symmetry or a positive energy."""

FLAT: Final = 1e15
"""Tip length and rotor radius [m] of a flat contact: a way x along it changes the gap by x^2 / FLAT."""

STILL: Final = 1e-36
"""Mobility of a rotor along its surface [1/kg] below which no force changes its velocity."""

BELT: Final = 1e9
"""Mass of a belt over that of the body on it [1]: friction hardly brakes it."""


@final
@dataclass(frozen=True, eq=False)
class NormalModes(Immutable):
    """A resonator as everything after it sees it: mass-orthonormal, decoupled oscillators.

        qdd_j + c_j qd_j + k_j q_j = sum_e coupling[j, e] U_e(t) + tip force terms

        >>> import contactlab as cl
        >>> modes = cl.RitzResonator(shapes=2).modes
        >>> modes.natural_frequency.round(1), modes.coupling.shape
        (array([3438. , 6400.5]), (2, 2))

    Args:
        stiffness: k_j = omega_j^2 [1/s^2], shape (mode,).
        damping: c_j = 2 zeta_j omega_j [1/s], shape (mode,).
        coupling: modal force per voltage [N/V kg^-1/2], shape (mode, electrode).
        tip_displacement: u = tip_displacement . q [kg^-1/2], shape (mode,).
        tip_slope: theta = tip_slope . q [kg^-1/2 m^-1], shape (mode,).
        rotor_displacement: w = rotor_displacement . q, of the rotor's centre along u [kg^-1/2], shape
            (mode,); None where its axle is fixed. The gap follows from u - w.
        prescribed: modes whose coordinate is what the voltages say, q_j = sum_e coupling[j, e] U_e(t),
            whatever force acts; truth values, shape (mode,), without stiffness and damping. None is none.
        points: displacement of other points, x = row . q [kg^-1/2], shape (mode,) each, by name; a run
            records them.
        shape_coupling: Gamma [N/V], shape (shape, electrode), force per voltage on shapes psi of
            int psi^2 dx = L: those of the basis before the modes, or the modes themselves, so scaled; None
            where the modes are not those of a beam.
        capacitance: C_p with the modes at rest [F], shape (electrode, electrode); None where it is not
            known, as of a resonator measured by its motion alone.
        loss_tangent: tan delta of that capacitance [1]; a tone of amplitude U heats it by
            omega C_p tan(delta) U^2 / 2.
    """

    stiffness: Array
    damping: Array
    coupling: Array
    tip_displacement: Array
    tip_slope: Array
    shape_coupling: Array | None = None
    capacitance: Array | None = None
    loss_tangent: float = 0.0
    rotor_displacement: Array | None = None
    prescribed: NDArray[np.bool_] | None = None
    points: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.freeze()
        check_shape("stiffness", self.stiffness, (-1,), "one number a mode")
        if not self.stiffness.size:
            raise ValueError("There are no modes; there must be one at least.")
        count = self.stiffness.size
        for name in ("damping", "tip_displacement", "tip_slope", "rotor_displacement"):
            if getattr(self, name) is not None:
                check_shape(name, getattr(self, name), (count,), "one number a mode")
        if self.prescribed is not None:
            check_shape("prescribed", self.prescribed, (count,), "a truth value a mode", "b")
            if self.stiffness[self.prescribed].any() or self.damping[self.prescribed].any():
                raise ValueError("A prescribed mode has stiffness or damping; it must have neither.")
        _check_points(self.points, count)
        check_shape("coupling", self.coupling, (count, -1), "a row a mode and a column an electrode")
        electrodes = self.coupling.shape[1]
        if self.shape_coupling is not None:
            meaning = "a row a shape and a column an electrode"
            check_shape("shape_coupling", self.shape_coupling, (-1, electrodes), meaning)
        if self.capacitance is not None:
            meaning = "a row and a column an electrode"
            check_shape("capacitance", self.capacitance, (electrodes, electrodes), meaning)
            _check_capacitance(self.capacitance)
        check_number("loss_tangent", self.loss_tangent)
        if not 0.0 <= self.loss_tangent < np.inf:
            raise ValueError(f"loss_tangent is {self.loss_tangent}; it must be at least 0 and finite.")
        if not self.approach.any():
            raise ValueError(
                "The modes do not move the tip towards the rotor: uy, the tip_displacement, is zero in each "
                "mode; it must be another number in one at least."
            )

    @property
    def approach(self) -> Array:
        """Tip towards rotor, u - w = approach . q [kg^-1/2], shape (mode,)."""
        if self.rotor_displacement is None:
            return self.tip_displacement
        return self.tip_displacement - self.rotor_displacement

    @property
    def is_prescribed(self) -> NDArray[np.bool_]:
        """Whether the voltages are a mode's coordinate, shape (mode,)."""
        return np.zeros(self.stiffness.size, np.bool_) if self.prescribed is None else self.prescribed

    @property
    def natural_frequency(self) -> Array:
        """Undamped natural frequencies f_j [Hz], shape (mode,)."""
        return np.sqrt(self.stiffness) / (2.0 * np.pi)

    @property
    def damping_ratio(self) -> Array:
        """zeta_j [1], shape (mode,); 1 is critical, more is overdamped."""
        return 0.5 * self.damping / np.sqrt(self.stiffness)

    @cached_property
    def persisting_rate(self) -> float:
        """Fastest rate that persists [rad/s], see `persisting_rates`."""
        return float(persisting_rates(self.stiffness, self.damping).max())


def persisting_rates(stiffness: Array, damping: Array) -> Array:
    """Return the rate of each mode [rad/s] from k_j and c_j, an overdamped one by its slow root k/c."""
    # An overdamped mode has a fast root, c, which is over at once, and a slow one, k/c, which lasts.
    slow = np.full(stiffness.shape, np.inf)
    np.divide(stiffness, damping, out=slow, where=damping > 0.0)
    return np.asarray(np.minimum(np.sqrt(stiffness), slow), dtype=np.float64)


def _check_points(points: Mapping[str, Array], count: int) -> None:
    for name, row in points.items():
        if not name.isidentifier():
            raise ValueError(f"A point is called {name!r}; it must be a name of letters, digits and _.")
        check_shape(f"points[{name!r}]", row, (count,), "one number a mode")


def _check_capacitance(matrix: Array) -> None:
    """Refuse a capacitance that is not symmetric, or that stores a negative energy, but for round-off."""
    scale = float(np.abs(matrix).max(initial=0.0))
    odd = np.abs(matrix - matrix.T)
    if odd.max(initial=0.0) > ROUND_OFF * scale:
        i, j = np.unravel_index(odd.argmax(), odd.shape)
        raise ValueError(
            f"capacitance_{i + 1}_{j + 1} is {matrix[i, j]:g} F and capacitance_{j + 1}_{i + 1} is "
            f"{matrix[j, i]:g} F; both must be the same number: the capacitance is symmetric."
        )
    if (least := float(np.linalg.eigvalsh(matrix).min(initial=0.0))) < -ROUND_OFF * scale:
        raise ValueError(
            f"The capacitance has the eigenvalue {least:g} F; none may be negative: voltages would store a "
            "negative energy."
        )


_LOAD = Parameter(
    "tau",
    "N m",
    "load torque towards negative rotation: it brakes positive, drives negative",
    usual=(-2e-3, 2e-3),
)
_ROTOR_DAMPING = not_negative("C_r", "N m s rad-1", "viscous damping", usual=(0.0, 1e-3))
_START = Parameter("Omega(0)", "rad s-1", "velocity at the start", usual=(-5.0, 5.0))


@final
@dataclass(frozen=True)
class Rotor(Checked):
    """A rigid rotor, J Omegadot = -R F - C_r Omega - tau.

    >>> import contactlab as cl
    >>> rotor = cl.Rotor(inertia=5e-5, load_torque=-1e-3)
    >>> rotor
    Rotor(inertia=5e-05, damping=0.0, load_torque=-0.001, initial_velocity=0.0)
    """

    inertia: Annotated[float, positive("J", "kg m2", "moment of inertia")] = 4.8e-5
    damping: Annotated[float, _ROTOR_DAMPING] = 0.0
    load_torque: Annotated[float, _LOAD] = 0.0
    initial_velocity: Annotated[float, _START] = 0.0


def lever_of(radius: float) -> float:
    """Return the lever of friction on a rotor of a radius [m], not a number where the contact is flat.

    `FLAT` stands for the radius of what only moves along: it is no lever, and R F no torque.
    """
    return radius if radius < FLAT else nan


@final
@dataclass(frozen=True, eq=False)
class ModalState(Immutable):
    """Normal coordinates at t = 0: q [m kg^1/2] and qd [m s^-1 kg^1/2], shape (mode,).

    Where the gap is positive there is no contact, unless `touching`: then an adhesive contact begins in its
    neck, as if it had been pulled apart so far. Where that gap has broken it, there is none.

    >>> import contactlab as cl
    >>> import numpy as np
    >>> modes = cl.RitzResonator(shapes=2).modes
    >>> bent = cl.ModalState(displacement=np.array([0.0, 1e-9]), velocity=np.zeros(2))
    >>> motor = cl.Motor(modes, start=bent)
    >>> f"{0.5 * modes.stiffness @ bent.displacement**2:.2e} J"
    '8.09e-10 J'
    """

    displacement: Array
    velocity: Array
    touching: bool = False

    def __post_init__(self) -> None:
        self.freeze()


@final
@dataclass(frozen=True, eq=False)
class Motor(Checked, Immutable):
    """Everything that moves; which contact law acts between tip and rotor is not part of it.

    A mode may be a rigid body's (no stiffness), the drive may have no tone, and a rotor of huge inertia
    is a belt: `contactlab.motor.bodies` makes balls, oscillators, masses on belts and cantilevers so.

        >>> import contactlab as cl
        >>> drive = cl.Drive.two_mode(100.0, 100.0, frequency=3210.0)
        >>> motor = cl.Motor(cl.RitzResonator().modes, drive, rotor=cl.Rotor(inertia=1e-5))
        >>> run = cl.simulate(motor, cl.Newton(restitution=0.4), duration=2e-3)
        >>> f"{run['rotor_velocity'][-1]:.3f} rad/s"
        '-0.041 rad/s'

    Args:
        modes, drive, geometry, rotor: the resonator in any basis, and what acts on it; without a drive there
            is no tone.
        preload: constant modal forces [N kg^-1/2], shape (mode,); None is none. `on_bearing` presses the
            rotor on the tip.
        start: state at t = 0; None is at rest without displacement. A prescribed mode begins where its
            voltages say.

    Attributes:
        plant: how `contactlab.motor.bodies` made it; None of another, and of one with something replaced.
    """

    modes: NormalModes
    drive: Drive = field(default_factory=Drive)
    geometry: ContactGeometry = field(default_factory=ContactGeometry)
    rotor: Rotor = field(default_factory=Rotor)
    preload: Array | None = None
    start: ModalState | None = None
    plant: Plant | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.freeze()
        super().__post_init__()
        if not np.all(self.modes.stiffness >= 0.0):
            raise ValueError(
                f"The modes have stiffnesses {self.modes.stiffness} 1/s^2; none may be negative: a "
                "buckled mode runs away."
            )
        electrodes, driven = self.modes.coupling.shape[1], len(self.drive.phasors)
        if self.drive.voltages and driven != electrodes:
            raise ValueError(f"The drive has {driven} electrodes; it must have {electrodes}, as the modes.")
        arrays = {"preload": self.preload}
        if start := self.start:
            arrays |= {"start.displacement": start.displacement, "start.velocity": start.velocity}
        for name, values in arrays.items():
            if values is not None:
                check_shape(name, values, self.modes.stiffness.shape, "one number a mode")

    @property
    def belt_velocity(self) -> float | None:
        """Velocity of a rotor that is a belt [rad/s]; None of one that contacts, damping or load change.

        A belt has neither damping nor load, and `BELT` times the mass that the tip has along it.
        """
        rotor, geometry = self.rotor, self.geometry
        mobility = float(np.sum(self.rows_at_rest[1] ** 2))
        light = rotor.inertia * mobility < BELT * (1.0 - 1e-9) * geometry.rotor_radius**2
        return None if light or rotor.damping or rotor.load_torque else rotor.initial_velocity

    @property
    def slides_freely(self) -> NDArray[np.bool_]:
        """Coordinates whose displacement no force depends on, shape (mode,).

        They have no stiffness, and move the tip along a flat contact alone, or not at all.
        """
        flat = min(self.geometry.tip_length, self.geometry.rotor_radius) >= FLAT
        normal, tangential = self.rows_at_rest
        return np.asarray((self.modes.stiffness == 0.0) & (normal == 0.0) & (flat | (tangential == 0.0)))

    @property
    def slip_is_prescribed(self) -> bool:
        """Whether prescribed modes alone move the tip along a rotor that no force turns."""
        prescribed, rotor = self.modes.is_prescribed, self.rotor
        free = self.rows_at_rest[1][~prescribed]
        still = self.geometry.rotor_radius**2 <= STILL * rotor.inertia
        return bool(prescribed.any() and still and not free.any())

    @cached_property
    def persisting_rate(self) -> float:
        """Fastest rate that persists [rad/s] of tones and modes; zero where nothing vibrates."""
        return max(self.modes.persisting_rate, float(self.drive.angular_frequency.max(initial=0.0)))

    @cached_property
    def rows_at_rest(self) -> tuple[Array, Array]:
        """G at rest: gap rate and slip less the rotor's of unit rates [kg^-1/2], shape (mode,) each."""
        _, n_u, n_th, t_u, t_th = self.geometry.frame(0.0, 0.0)
        approach, slope = self.modes.approach, self.modes.tip_slope
        return n_u * approach + n_th * slope, t_u * approach + t_th * slope

    @property
    def force_phasors(self) -> NDArray[np.complex128]:
        """Modal forces of the tones [N kg^-1/2], shape (mode, tone); accelerations of a prescribed mode."""
        modes, drive = self.modes, self.drive
        if not drive.voltages:
            return np.zeros((modes.stiffness.size, 0), np.complex128)
        rate = np.where(modes.is_prescribed[:, None], -(drive.angular_frequency**2), 1.0)
        return np.asarray(rate * (modes.coupling @ drive.phasors))

    @property
    def first_motion(self) -> tuple[Array, Array]:
        """Normal coordinates and their rates at t = 0, shape (mode,) each."""
        modes, drive, start = self.modes, self.drive, self.start
        motion = np.zeros((2, modes.stiffness.size))
        if start is not None:
            motion[:] = start.displacement, start.velocity
        if modes.prescribed is None:
            return motion[0], motion[1]
        for order, values in enumerate(motion):
            path = modes.coupling @ drive.voltage(0.0, order) if drive.voltages else 0.0
            np.copyto(values, path, where=modes.is_prescribed)
        return motion[0], motion[1]


PERIODS, SAMPLES = 20, 20_000
"""Of the slowest tone that are looked through; tones that do not repeat themselves have met in most ways."""


def free_reach(motor: Motor) -> float:
    """Return what the tip bridges of the clearance in the steady state of free vibration [m].

    That is the largest of clearance less gap, with u and th of the sum of all modes' answers
    Q_j = f_j / (k_j - omega^2 + i c_j omega) to all tones, and of the preload's; zero without either. It is
    sampled, to a thousandth of itself. Not a number where there is no such state: a rigid body under a
    constant force, a mode without damping driven at its own frequency.
    """
    modes, geometry = motor.modes, motor.geometry
    omega, force = motor.drive.angular_frequency, motor.force_phasors
    loud = np.any(force != 0.0, axis=0)
    omega, force = omega[loud], force[:, loud]
    q = np.zeros((modes.stiffness.size, 1))
    if omega.size:
        dynamic = modes.stiffness[:, None] - omega**2 + 1j * modes.damping[:, None] * omega
        time = np.linspace(0.0, PERIODS * 2.0 * np.pi / omega.min(), SAMPLES)
        with np.errstate(all="ignore"):
            q = np.real(force / dynamic @ np.exp(1j * np.multiply.outer(omega, time)))
    if motor.preload is not None:
        with np.errstate(all="ignore"):
            still = np.where(motor.preload == 0.0, 0.0, motor.preload / modes.stiffness)
        q = q + still[:, None]
    if not np.isfinite(q).all():
        return float("nan")
    seen = zip((modes.approach @ q).tolist(), (modes.tip_slope @ q).tolist(), strict=True)
    least = min(geometry.frame(u, th)[0] for u, th in seen)
    return float(geometry.clearance - least)
