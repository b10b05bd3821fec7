"""Plants of benches and tests, runs of them, and bound kernels; `block` is of `contactlab.motor.bodies`."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import pi
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.engine.binding import functions_of, row_of
from contactlab.engine.state import HEAD, SPEED
from contactlab.laws import ContactLaw, MultiplierLaw
from contactlab.laws.base import PenaltyLaw, is_stepped
from contactlab.laws.consistency import CANARIES, guarded
from contactlab.motor import RitzResonator
from contactlab.motor.bodies import FLAT as FLAT, HEAVY as HEAVY, block as block, way_of as way_of
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.trajectory import Trajectory


def paper_motor() -> Motor:
    """Return the paper's motor: placement 2, 1 um clearance, 100 V at 3210 and 6420 Hz, phase -pi/5."""
    return Motor(RitzResonator().modes, Drive.two_mode(100.0, 100.0, 3210.0, 2.0, -pi / 5.0))


def attempt(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
) -> Trajectory:
    """Make a run, whatever becomes of it; without a record interval it is recorded at its ends only."""
    steps: dict[str, Any] = {"contact_step": contact_step, "tolerance": tolerance}
    interval = record_interval or duration
    return simulate(motor, law, duration=duration, record_interval=interval, **steps)


def completed(trajectory: Trajectory) -> Trajectory:
    """Return a run back that has reached its end, or raise a RuntimeError with the reason why it has not."""
    if not trajectory.ending.reached_end:
        raise RuntimeError(f"{trajectory.law.name}: {trajectory.message}")
    return trajectory


def run(*of_attempt: Any, **named: Any) -> Trajectory:
    """Make a run as `attempt` does that must reach its end, or raise a RuntimeError."""
    return completed(attempt(*of_attempt, **named))


def first(trajectory: Trajectory, name: str) -> float:
    """Return a column of the first contact."""
    return float(trajectory.contacts[name][0])


def last(trajectory: Trajectory, name: str) -> float:
    """Return the last record of a series."""
    return float(trajectory.series[name][-1])


def free_motion(motor: Motor) -> tuple[NDArray[np.complex128], ...]:
    """Return exponents r [1/s] and the terms of u [m] and th [rad] of a motor from rest that never touches.

    u(t) = Re sum_k u_k exp(r_k t), and th alike: of every tone the steady answer, then of every mode two
    terms that cancel it at t = 0, r^2 + c r + k = 0. A mode that is exactly critical has no such terms.
    """
    modes = motor.modes
    tones = 1j * motor.drive.angular_frequency
    k, c = modes.stiffness[:, None], modes.damping[:, None]
    steady = (modes.coupling @ motor.drive.phasors) / (k + c * tones + tones**2)
    root = np.sqrt((0.25 * modes.damping**2 - modes.stiffness).astype(np.complex128))
    first, second = -0.5 * modes.damping + root, -0.5 * modes.damping - root
    # A + B = -q(0) and A r1 + B r2 = -v(0) of the steady part.
    q, v = -steady.real.sum(axis=1), -(steady * tones).real.sum(axis=1)
    from_first = (v - second * q) / (first - second)
    u, th = (
        np.concatenate([row @ steady, row * from_first, row * (q - from_first)])
        for row in (modes.tip_displacement, modes.tip_slope)
    )
    return np.concatenate([tones, first, second]), u, th


MOTOR_DURATION = 1.5e-3
"""Of the run of a bench's motor [s]: five contacts of the paper's."""

MASS, BELT_MASS, WEIGHT = 2e-3, 1e-2, 5.0
"""Of the skipping block [kg], [kg], [N]: about a motor's tip, and a rotor as light as to answer."""


@final
@dataclass(frozen=True, eq=False)
class Bench:
    """Hold a law and the runs that its contract is checked on, each made once, even where it fails.

    The motor is one that the law can drive at its default contact step.
    """

    law: ContactLaw
    make_motor: Callable[[], Motor] = paper_motor

    @property
    def rigid(self) -> bool:
        """Whether the law is a `MultiplierLaw`."""
        return isinstance(self.law, MultiplierLaw)

    @property
    def balance(self) -> float:
        """What energy and momentum may miss by default, as a share: time stepping more."""
        return 1e-3 if is_stepped(self.law, self.step) else 1e-6

    @property
    def step(self) -> float | None:
        """Contact step of the runs in the motor [s]; None of a rigid law in its limit of no step."""
        return None if self.rigid else self.law.default_contact_step

    @cached_property
    def motor(self) -> Motor:
        """The motor that the law drives."""
        return self.make_motor()

    def attempt_motor(self, motor: Motor) -> Trajectory:
        """Make a finely recorded run of a motor with the law, whatever becomes of it."""
        # Finer than the steps of time stepping, fine against a contact.
        interval = 0.4 * self.law.default_contact_step if self.rigid else 1e-7
        return attempt(motor, self.law, MOTOR_DURATION, self.step, interval)

    @cached_property
    def motor_run(self) -> Trajectory:
        """The law in the motor."""
        return self.attempt_motor(self.motor)

    @cached_property
    def skipping(self) -> Trajectory:
        """A block that is thrown onto a moving belt at a slant and pressed on by its weight."""
        motor = block(
            MASS,
            height=1e-6,
            gap_rate=-0.1,
            velocity=0.05,
            weight=WEIGHT,
            belt_mass=BELT_MASS,
            belt_velocity=-0.02,
        )
        return attempt(motor, self.law, 1e-3, record_interval=1e-6)

    @property
    def runs(self) -> dict[str, Trajectory]:
        """Both, once they have reached their ends."""
        return {"motor": completed(self.motor_run), "block": completed(self.skipping)}


def impulses_of(law: MultiplierLaw, gap_rate: float, slip: float, delassus: tuple[float, ...]) -> Any:
    """Return normal and friction impulse [N s] of an impact at a gap rate and a slip [m/s].

    The Delassus matrix is given by D_nn, D_nt, D_tt [1/kg].
    """
    d_nn, d_nt, d_tt = delassus
    return law.evaluate("impact", approach=gap_rate, slip=slip, d_nn=d_nn, d_nt=d_nt, d_tt=d_tt)


def viscous_friction(law: ContactLaw) -> float:
    """Return the viscous friction beside that of a law's parts [N s/m]."""
    return float(getattr(law, "viscous_friction", None) or 0.0)


@final
class Evaluator:
    """Evaluate the kernels of a law; internal variables are `kept`, shape (variable,), in the order declared.

    First in it is the variable of the friction's own kernel, where there is one. On either side of the law's
    row stands a canary, by default no number.
    """

    def __init__(self, law: ContactLaw, canary: float = np.nan) -> None:
        self.law, self.variables = law, law.internal_variables
        self.own = law.coupled if isinstance(law, PenaltyLaw) else 0
        self.initial = np.array([each.initial for each in self.variables], dtype=np.float64)
        row = row_of(law)
        # Behind the internal variables, too.
        row[HEAD + len(self.variables)] = canary
        self._kernels, self._row = functions_of(law), guarded(row, canary)
        # What kernels may only read is written here.
        self._written: Any = np.asarray(self._row.base)[CANARIES:]
        self._count = len(self.variables)

    @property
    def has_friction(self) -> bool:
        """Whether there is a kernel of friction beside that of the force."""
        return isinstance(self.law, PenaltyLaw) and self.law.friction_force is not None

    def _seen(self, kept: Array) -> Array:
        self._written[HEAD : HEAD + self._count] = kept
        return self._row

    def force(self, gap: float, rate: float, slip: float, speed: float, kept: Array) -> tuple[float, ...]:
        """Return what `PenaltyLaw.force` does; viscous friction is beside the bound."""
        self._written[SPEED] = speed
        normal, _, most, stored, loss = self._kernels["force"](gap, rate, slip, speed, self._seen(kept))
        return normal, most + viscous_friction(self.law) * slip, stored, loss

    def friction(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Any:
        """Return friction [N], the rate of the friction's own variable, energy [J] and stiffness [N/m]."""
        return self._kernels["friction_force"](gap, rate, slip, normal, self._seen(kept))

    def rates(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Return the rates of all internal variables."""
        result, row = np.zeros(self._count), self._seen(kept)
        if self.own:
            result[0] = self.friction(gap, rate, slip, normal, kept)[1]
        for k in range(self.own, self._count):
            result[k] = self._kernels["rate"](k, gap, rate, slip, normal, row)
        return result

    def guards(self, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Return all guards."""
        row, guard = self._seen(kept), self._kernels["guard"]
        return np.array([guard(k, gap, rate, slip, normal, row) for k in range(self.law.guards)])

    def jumped(self, event: int, gap: float, rate: float, slip: float, normal: float, kept: Array) -> Array:
        """Return the internal variables after an event."""
        after, row = kept.copy(), self._seen(kept)
        for k in range(self.own, self._count):
            after[k] = self._kernels["jump"](k, event, gap, rate, slip, normal, row)
        return after

    def limits(self, kept: Array) -> tuple[float, float]:
        """Return the gaps at which a contact begins and ends [m]."""
        begin, end = self._kernels["limits"](0.0, self._seen(kept))
        return float(begin), float(end)

    def impact(self, impact: tuple[float, ...], kept: Array) -> Any:
        """Return the impulses [N s] of a rigid law for one of `drawn_impacts`."""
        return self._kernels["impact"](*impact, self._seen(kept))

    def bound(self, normal: float, slip: float, kept: Array) -> float:
        """Return the friction bound of a rigid law [N]."""
        return float(self._kernels["bound"](normal, slip, self._seen(kept)))
