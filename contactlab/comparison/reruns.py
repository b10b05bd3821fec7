"""A recorded run again: at finer steps, with a little more friction, on a larger basis.

The configuration that a run recorded builds the same motor and law again, so that every law can be
brought to its own convergence before it is set beside the others.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, build
from contactlab.engine import simulate
from contactlab.laws.base import MultiplierLaw
from contactlab.metrics import Run

FINER: Final = {"contact_step": (1.0, 2.0, 4.0), "tolerance": (1.0, 10.0, 100.0)}
"""Divisors of the contact step of a rigid law, of the tolerance of a compliant one."""

FRICTION_CHANGE: Final = 0.01
"""Relative change of the friction coefficient that shows the sensitivity to it."""

MORE_SHAPES: Final = 4
"""Functions that are added to the resonator's basis to show the sensitivity to it."""

RECORDS_PER_PERIOD: Final = 300.0
"""Records in a drive period at least, so that a contact can be drawn."""

MOST_RECORDS: Final = 1_000_000
"""Beyond this a rerun records as the run did."""

RERUNS: Final = 5
"""Of one run."""

SLOWEST: Final = 0.9
"""Ratio of successive differences beyond which a sequence is not said to converge any faster."""


@final
@dataclass
class Refined:
    """A run with its reruns.

    Args:
        run: as recorded.
        control: what is refined, `contact_step` or `tolerance`; empty without reruns.
        order: at which the law declares its error to fall with it.
        steps: value of it and what ran, coarsest first; empty without reruns.
        friction: relative change of the friction coefficient and what ran.
        basis: what ran on a larger basis.
        notes: what could not be done, a sentence each.
    """

    run: Run
    control: str = ""
    order: float = 1.0
    steps: list[tuple[float, Run]] = field(default_factory=list)
    friction: tuple[float, Run] | None = None
    basis: Run | None = None
    notes: list[str] = field(default_factory=list)

    @property
    def best(self) -> Run:
        """The finest of the reruns, the run itself without any."""
        return self.steps[-1][1] if self.steps else self.run

    @property
    def base(self) -> Run:
        """The rerun as recorded, which the changed ones are set against; else the run itself."""
        return self.steps[0][1] if self.steps else self.run

    @property
    def period(self) -> float:
        """Period of the drive's first tone [s]; a tenth of the run where it is not known."""
        return self.run.period or 0.1 * float(np.ptp(self.run.time))

    def error(self, of: Callable[[Run], Any]) -> Any:
        """Give the numerical error of a number or a series of the finest rerun; NaN without reruns."""
        if not self.steps:
            return np.full_like(np.asarray(of(self.best), dtype=float), np.nan)
        factor = self.steps[0][0] / self.steps[1][0]
        return richardson([np.asarray(of(run)) for _, run in self.steps], factor, self.order)


def richardson(values: Sequence[Array], factor: float, order: float) -> Array:
    """Give the error of the last of three values from steps that fall by a factor.

    With differences that fall by the ratio q the rest of the series is q / (1 - q) times the last of
    them. The ratio is what is seen, but no better than the declared order promises; a sequence that does
    not converge is given `SLOWEST`, which makes its error nine times its last change.
    """
    coarse, middle, fine = values
    last, before = np.abs(fine - middle), np.abs(middle - coarse)
    # One ratio for a whole series: where the difference passes through zero there is none to see. The sums
    # take little notice of a record that an impact passes as it moves with the step.
    whole = float(np.sum(before))
    seen = float(np.sum(last)) / whole if whole > 0.0 else 0.0
    ratio = float(np.clip(seen, factor**-order, SLOWEST))
    return np.asarray(last * ratio / (1.0 - ratio))


def refined(run: Run, advance: Callable[[], object] = lambda: None) -> Refined:
    """Run a law again at finer steps, with more friction and on a larger basis.

    Args:
        run: as recorded. One that cannot be run again comes back with a note.
        advance: called after every rerun.
    """
    law = Refined(run)
    try:
        setup = build(run.configuration)
    except ConfigurationError as error:
        first = error.faults[0].rstrip(".")
        law.notes.append(
            f"{run.label} is taken as recorded, its configuration does not build: {first}."
        )
        return law
    control = "contact_step" if isinstance(setup.law, MultiplierLaw) else "tolerance"
    steps = []
    for divisor in FINER[control]:
        finer = getattr(setup, control) / divisor
        again = _again(law, f"at {control} {finer:.3g}", solver={control: finer})
        advance()
        if again is not None:
            steps.append((finer, again))
    # Without all of them there is no convergence to speak of.
    if len(steps) < len(FINER[control]):
        return law
    law.control, law.order, law.steps = control, setup.law.convergence_order, steps
    law.notes += _unlike(run, law.base)
    law.friction = _more_friction(law)
    advance()
    law.basis = _larger_basis(law)
    advance()
    return law


def _more_friction(law: Refined) -> tuple[float, Run] | None:
    coefficient = law.run.setting("contact", "friction_coefficient")
    if coefficient == 0.0:
        law.notes.append(
            f"{law.run.label} is frictionless: no sensitivity to the friction coefficient."
        )
        return None
    more = {"friction_coefficient": coefficient * (1.0 + FRICTION_CHANGE)}
    again = _again(law, "with more friction", contact=more)
    return None if again is None else (FRICTION_CHANGE, again)


def _larger_basis(law: Refined) -> Run | None:
    """Run with more functions; a drive at the first natural frequency stays there."""
    resonator, drive = law.run.configuration["resonator"], law.run.configuration["drive"]
    key = "shapes" if resonator["basis"] == "ritz" else "kept_modes"
    larger = resonator[key] + MORE_SHAPES
    known = law.run.columns.get("natural_frequency")
    tuned = known is not None and drive["frequency"] == known[0]
    return _again(
        law,
        f"with resonator.{key} {larger}",
        resonator={key: larger},
        drive={"frequency": None} if tuned else {},
    )


def _again(law: Refined, words: str, **changes: Mapping[str, Any]) -> Run | None:
    """Make one rerun in memory, with keys changed by section; None with a note where there is none."""
    given = law.run.configuration
    changed = {section: {**given[section], **keys} for section, keys in changes.items()}
    try:
        setup = build({**given, **changed})
        interval = min(setup.record_interval, law.period / RECORDS_PER_PERIOD)
        if setup.duration / interval > MOST_RECORDS:
            interval = setup.record_interval
        trajectory = simulate(
            setup.motor,
            setup.law,
            duration=setup.duration,
            record_interval=interval,
            contact_step=setup.contact_step,
            tolerance=setup.tolerance,
        )
    except ConfigurationError as error:
        law.notes.append(f"{law.run.label} cannot be run {words}: {error.faults[0]}")
    # A law of another package may fail in ways of its own.
    except Exception as error:
        law.notes.append(f"{law.run.label} fails {words}: {error}")
    else:
        if trajectory.ending.reached_end:
            return Run.of_trajectory(trajectory, setup.configuration)
        law.notes.append(f"{law.run.label} does not reach its end {words}: {trajectory.message}")
    return None


def _unlike(run: Run, again: Run) -> Iterator[str]:
    """Say so if the rerun is not the run that was recorded."""
    if not run.holds("rotor_velocity"):
        return
    old, new = (float(which.columns["rotor_velocity"][-1]) for which in (run, again))
    if abs(old - new) > 1e-9 * max(abs(old), abs(new)):
        yield (
            f"{run.label} run again ends at {new:.9g} rad/s and not at the recorded {old:.9g} rad/s: "
            "other code has left it. The reruns are compared."
        )
