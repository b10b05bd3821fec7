"""The steady state of a motor, free, on a belt, under load or a brake, and its discretisation error."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any, Final, final

import numpy as np

from contactlab.checks import check_kind, check_number, checked_arguments
from contactlab.config import Setup
from contactlab.engine.initial_state import memory_mark
from contactlab.estimate import Estimate
from contactlab.interrupts import Stop, stopped_by
from contactlab.laws import ContactLaw
from contactlab.motor import ModalState, Motor
from contactlab.progress import tell_progress
from contactlab.refinement import FACTORS, LEVELS, Refinement
from contactlab.settling.statistics import STANDING, WITHOUT_CONTACT
from contactlab.simulation import setup_of
from contactlab.steady_state.arrival import TAIL, NotSettledError, Start, settled
from contactlab.steady_state.state import Steady as Steady

LONGEST: Final = 4000
"""Periods after which a motion without an orbit has its means."""


def steady(
    motor: Motor | Setup,
    law: ContactLaw | None = None,
    *,
    belt: float | None = None,
    load: float | None = None,
    brake: float | None = None,
    start: "Steady | tuple[ModalState, float] | None" = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    longest: int = LONGEST,
) -> Steady:
    """Compute the steady state that a motor reaches from its start.

    The motor runs until the resonator's free vibration has decayed; then Newton's method computes the
    periodic orbit next to its state (`contactlab.steady_state.shooting`). The orbit is accepted if it is
    stable, and if two test runs, from the current state and from half-way to the orbit, follow the
    linearised map. Otherwise the transient is continued and the test repeated. A motion without an orbit
    after the longest run is averaged over a run of the same length, with statistical errors.

    Errors are those of the orbit, or of statistics, at one step of the solver; `converged` adds the
    discretisation error. Arguments are those of `contactlab.steady`. A brake takes the sign of the rotation
    without load; a motor that does not keep its rotation against it stands.

    Raises:
        NoPeriodError: the drive does not repeat itself.
        UnboundedError: an internal variable of the law comes to no steady value, as the depth of wear.
        NotSettledError: there is no steady state, or it is not reached.
        BrokenOffError: a run broke off.
        ValueError, TypeError: an argument is out of range, or of another kind.
    """
    setup = steady_setup(motor, law, contact_step, tolerance)
    _check(belt, load, brake, longest)
    rotor = setup.motor.rotor
    begins: Start = 0.0, setup.motor.start, rotor.initial_velocity, None, None
    cycle = 0
    if isinstance(start, Steady):
        begins, cycle = start.end, start.periods if start.orbit else 0
        # Internal variables and a contact that lasts are those of one law.
        if memory_mark(start.setup.law) != memory_mark(setup.law):
            begins = *begins[:3], None, None
    elif start is not None:
        check_kind("The modal state of the start", start[0], ModalState)
        check_number("The rotor velocity of the start", start[1])
        begins = 0.0, start[0], float(start[1]), None, None
    if brake is not None:
        return _braked(setup, float(brake), begins, longest)
    if load is not None:
        setup = _loaded(setup, float(load))
    state = settled(setup, belt, begins, longest, cycle=cycle)
    assert state is not None
    return state


@checked_arguments(belt="rad/s", load="N m", brake="N m", contact_step="s", tolerance="1")
def orbit(
    motor: Motor | Setup,
    law: ContactLaw | None = None,
    *,
    belt: float | None = None,
    load: float | None = None,
    brake: float | None = None,
    start: "Steady | tuple[ModalState, float] | None" = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    longest: int = LONGEST,
    stop: Stop | None = None,
) -> Steady:
    """Compute the steady state alone, at one step of the solver, without the study `contactlab.steady` of it.

        >>> import contactlab as cl
        >>> state = cl.orbit(cl.build(["law=newton"]))
        >>> state.kind, state.series(300)["gap"].size, state.impacts["phase"].size
        ('periodic', 301, 1)

    Args:
        motor: what moves, or a whole setup.
        law: what acts between tip and rotor; a setup has its own.
        belt, load, brake, start, contact_step, tolerance, longest: as of `contactlab.steady`.
        stop: function or event that is looked at between periods, and ends the search once it is true or set.

    Raises:
        NoPeriodError, NotSettledError, BrokenOffError: as of `contactlab.steady`.
        StoppedError: it was stopped.
        ValueError, TypeError: an argument is out of range, or of another kind.
    """
    with stopped_by(stop):
        return steady(
            motor,
            law,
            belt=belt,
            load=load,
            brake=brake,
            start=start,
            contact_step=contact_step,
            tolerance=tolerance,
            longest=longest,
        )


def steady_setup(
    motor: Motor | Setup,
    law: ContactLaw | None = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
) -> Setup:
    """Return the setup of a study of steady states, whose duration means nothing; see `steady`."""
    steps = {"contact_step": contact_step, "tolerance": tolerance}
    steps = {name: value for name, value in steps.items() if value is not None}
    return setup_of(motor, law, steps if isinstance(motor, Setup) else steps | {"duration": 1.0})


def _check(belt: float | None, load: float | None, brake: float | None, longest: int) -> None:
    """Check the arguments, each alone and together."""
    every = {"belt": belt, "load": load, "brake": brake}
    values = {name: value for name, value in every.items() if value is not None}
    for name, value in values.items():
        check_number(f"The {name}", value)
        if not isfinite(value):
            raise ValueError(f"The {name} is {value}; it must be finite.")
    if len(values) > 1:
        raise ValueError(
            f"{' and '.join(values)} are given; a rotor is held by a belt, or it carries a load, or a brake "
            "is on it. Give one of them."
        )
    if brake is not None and brake <= 0.0:
        raise ValueError(f"The brake is {brake} N m; it must be positive: it opposes either rotation.")
    check_number("The longest run", longest)
    if longest < 2 * TAIL:
        raise ValueError(f"The longest run is {longest} periods; it must be at least {2 * TAIL}.")


def _loaded(setup: Setup, torque: float) -> Setup:
    """Return a setup with another load torque."""
    rotor = replace(setup.motor.rotor, load_torque=torque)
    return replace(setup, motor=replace(setup.motor, rotor=rotor))


def _braked(setup: Setup, brake: float, begins: Start, longest: int) -> Steady:
    """Compute the steady state without load, then that with the brake against its rotation."""
    # The brake acts against the rotation that there is without load, once that is known.
    free = settled(_loaded(setup, 0.0), None, begins, longest)
    assert free is not None
    sense = float(np.sign(free.velocity[0])) if free.kind != WITHOUT_CONTACT else 0.0
    loaded = _loaded(setup, sense * brake)
    state = _turning(loaded, free, longest, sense) if sense else None
    if state is None:
        # The rotor stands: hold it there, and see what the contact would turn it with.
        still = settled(loaded, 0.0, free.end, longest)
        assert still is not None
        state = replace(still, kind=STANDING)
        # At rest the torque may be larger than in the rotation that the brake has stopped.
        if sense * still.torque[0] > brake:
            state = _turning(loaded, still, longest, sense)
    if state is None:
        raise NotSettledError(
            f"A brake of {brake:.4g} N m stops the rotor and does not hold it; it must do both, or neither. "
            "Give another one, or rotor.damping."
        )
    return replace(state, brake=brake)


def _turning(loaded: Setup, before: Steady, longest: int, sense: float) -> Steady | None:
    """Compute the rotation against a brake; None where the rotor does not keep its sense."""
    state = settled(loaded, None, before.end, longest, sense)
    return state if state is not None and sense * state.velocity[0] > 0.0 else None


@final
@dataclass(frozen=True)
class Converged:
    """A steady state at three steps or tolerances.

        >>> import contactlab as cl
        >>> found = cl.converged(cl.build(["law=hertz_penalty"])).details
        >>> found.control, len(found.steps)
        ('tolerance', 3)
        >>> f"{found.best.velocity.value:.5f} rad/s"
        '-2.19111 rad/s'

    Args:
        refinement: the steps or tolerances, coarsest first.
        steps: the steady states, in the same order.
    """

    refinement: Refinement
    steps: tuple[Steady, ...]

    def __repr__(self) -> str:
        return f"<Converged: {self.best.kind}, {self.velocity.text()} rad/s over {self.control}>"

    @property
    def control(self) -> str:
        """What is refined, 'tolerance', or 'contact_step' of time stepping."""
        return self.refinement.control

    @property
    def values(self) -> tuple[float, ...]:
        """Values of `control`, coarsest first."""
        return self.refinement.values

    @property
    def best(self) -> Steady:
        """The steady state at the finest step."""
        return self.steps[-1]

    def value(self, of: Callable[[Steady], tuple[float, float]]) -> Estimate:
        """Return a number at the finest step and its error, of discretisation and statistics together.

        Args:
            of: gives number and statistical error of a steady state, as `lambda each: each.velocity`.
        """
        return self.refinement.estimate(*np.transpose([of(each) for each in self.steps]))

    @property
    def velocity(self) -> Estimate:
        """Mean rotor velocity and its error [rad/s]."""
        return self.value(lambda each: each.velocity)

    @property
    def torque(self) -> Estimate:
        """Mean torque of the contact on the rotor and its error [N m]."""
        return self.value(lambda each: each.torque)


def converged(
    motor: Motor | Setup, law: ContactLaw | None = None, *, refine: bool = True, **arguments: Any
) -> Converged:
    """Compute a steady state at three steps, each from the one before it.

    It is a tolerance, a tenth and a hundredth of it, or of time stepping the contact steps h, h/2, h/4.

    Args:
        motor, law: as of `steady`; the contact step or tolerance is the coarsest.
        refine: False computes the coarsest alone, without a discretisation error.
        arguments: further ones of `steady`.

    Raises:
        NoPeriodError, NotSettledError, BrokenOffError: as of `contactlab.steady`.
    """
    coarsest = {name: arguments.pop(name) for name in FACTORS if name in arguments}
    setup = steady_setup(motor, law, **coarsest)
    refinement = Refinement.of(setup, LEVELS if refine else 1)
    control, values = refinement.control.replace("_", " "), refinement.values
    steps: list[Steady] = []
    for value, finer in zip(values, refinement.setups(setup), strict=True):
        tell_progress(f"{control} {value:.3g}", len(steps) / len(values))
        # Each step starts in the state of the one before, so that all are of one orbit.
        steps.append(steady(finer, **arguments))
        arguments["start"] = steps[-1]
    return Converged(refinement, tuple(steps))
