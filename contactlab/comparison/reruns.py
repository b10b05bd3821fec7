"""A recorded run again: at finer steps, with a little more friction, on a larger basis.

The configuration that a run recorded builds the same motor and law again, so that every law can be
brought to its own convergence before it is set beside the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, build
from contactlab.laws.base import MultiplierLaw
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, richardson
from contactlab.simulation import simulate

FRICTION_CHANGE: Final = 0.01  # of the friction coefficient, to show the sensitivity to it, relative
MORE_SHAPES: Final = 4  # functions that are added to the resonator's basis, to show that to it

RECORDS_PER_PERIOD: Final = 300.0  # at least, so that a contact can be drawn
MOST_RECORDS: Final = 1_000_000  # beyond which a rerun records as the run did


@final
@dataclass
class Refined:
    """A run as recorded and its reruns: at `steps`, coarsest first, and with one thing changed by a share."""

    run: Run
    control: str = ""  # what is refined, `contact_step` or `tolerance`
    order: float = 1.0  # of the error in it
    steps: list[tuple[float, Run]] = field(default_factory=list)
    variants: dict[str, tuple[float, Run]] = field(default_factory=dict)  # `friction` and `basis`
    notes: list[str] = field(default_factory=list)  # what could not be done, a sentence each

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

    def error(self, values: Sequence[Any]) -> Array:
        """Give the numerical error of the last of the values, numbers or series, one a step."""
        return richardson(values, self.steps[0][0] / self.steps[1][0], self.order)


def refined(run: Run) -> Refined:
    """Run a law again at finer steps, with more friction and on a larger basis; what cannot is noted."""
    law = Refined(run)
    try:
        setup = build(run.configuration)
    except ConfigurationError as error:
        law.notes.append(f"{run.label} is taken as recorded; it does not build: {error.faults[0]}")
        return law
    law.control = "contact_step" if isinstance(setup.law, MultiplierLaw) else "tolerance"
    law.order = setup.law.convergence_order
    for divisor in FINER[law.control]:
        finer = getattr(setup, law.control) / divisor
        again = _again(law, f"at {law.control} {finer:.3g}", solver={law.control: finer})
        # Without all of them there is no convergence to speak of.
        if again is None:
            law.steps.clear()
            return law
        law.steps.append((finer, again))
    old, new = (float(r.columns.get("rotor_velocity", [0.0])[-1]) for r in (run, law.base))
    if run.holds("rotor_velocity") and abs(old - new) > 1e-9 * max(abs(old), abs(new)):
        law.notes.append(
            f"{run.label} run again ends at {new:.9g} rad/s and not at the recorded {old:.9g} rad/s: "
            "other code has left it. The reruns are compared."
        )
    coefficient = run.setting("contact.friction_coefficient") * (1.0 + FRICTION_CHANGE)
    resonator, drive = run.configuration["resonator"], run.configuration["drive"]
    key = "shapes" if resonator["basis"] == "ritz" else "kept_modes"
    larger = resonator[key] + MORE_SHAPES
    # A drive at the first natural frequency stays there.
    known = run.columns.get("natural_frequency")
    tuned = {"frequency": None} if known is not None and drive["frequency"] == known[0] else {}
    if coefficient == 0.0:
        law.notes.append(f"{run.label} is frictionless: no sensitivity to the coefficient.")
    elif more := _again(law, "with more friction", contact={"friction_coefficient": coefficient}):
        law.variants["friction"] = FRICTION_CHANGE, more
    words = f"with resonator.{key} {larger}"
    if more := _again(law, words, resonator={key: larger}, drive=tuned):
        law.variants["basis"] = 1.0, more
    return law


def _again(law: Refined, words: str, **changes: dict[str, Any]) -> Run | None:
    """Make one rerun in memory, with keys changed by section; None with a note where there is none."""
    given = law.run.configuration
    changed = {section: given[section] | keys for section, keys in changes.items()}
    try:
        setup = build({**given, **changed})
        interval = min(setup.record_interval, law.period / RECORDS_PER_PERIOD)
        if setup.duration / interval > MOST_RECORDS:
            interval = setup.record_interval
        solution = simulate(setup, record_interval=interval)
    # A law of another package may fail in ways of its own.
    except Exception as error:
        law.notes.append(f"{law.run.label} fails {words}: {error}")
        return None
    if solution.ending.reached_end:
        return Run.of(solution.tree)
    law.notes.append(f"{law.run.label} does not reach its end {words}: {solution.message}")
    return None
