"""A recorded run again, settled or as it was: at finer steps, with more friction, on another basis.

The configuration that a run recorded builds the same motor and law again, so that every law can be
brought to its own convergence before it is set beside the others.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.comparison.settled import LONGEST, Means, means_of, motion_of, settled
from contactlab.config import ConfigurationError, Setup, build
from contactlab.laws.base import MultiplierLaw
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, richardson
from contactlab.simulation import simulate
from contactlab.steady_state import NotSettledError, attractors

FRICTION_CHANGE: Final = 0.01  # of the friction coefficient, to show the sensitivity to it, relative
MORE_SHAPES: Final = 4  # functions that are added to the resonator's basis, to show that to it

RECORDS_PER_PERIOD: Final = 300.0  # at least, so that a contact can be drawn
MOST_RECORDS: Final = 1_000_000  # beyond which a rerun records as the run did

Configuration = Mapping[str, Any]


@final
@dataclass
class Refined:
    """A run as recorded and its reruns: at `steps`, coarsest first, and with one thing changed by a share.

    Of a settled law `means` has the steady state of every step, or that as recorded alone.
    """

    run: Run
    control: str = ""  # what is refined, `contact_step` or `tolerance`
    order: float = 1.0  # of the error in it
    steps: list[tuple[float, Run]] = field(default_factory=list)
    variants: dict[str, tuple[float, Run]] = field(default_factory=dict)  # `friction` and `basis`
    notes: list[str] = field(default_factory=list)  # what could not be done, a sentence each
    motion: Run | None = None  # the settled one as recorded
    means: list[Means] = field(default_factory=list)
    elsewhere: Means | None = None  # settled, on the other basis
    reached: list[Means] = field(default_factory=list)  # from all starts; empty if none was tried
    without: str = ""  # why there is no steady state
    seconds: list[float] = field(default_factory=list)  # that a steady state takes on either basis

    @property
    def best(self) -> Run:
        """The finest of the reruns, the settled motion or the run itself without any."""
        return self.steps[-1][1] if self.steps else self.motion or self.run

    @property
    def base(self) -> Run:
        """The rerun as recorded, which the changed ones are set against; else the run itself."""
        return self.steps[0][1] if self.steps else self.motion or self.run

    @property
    def period(self) -> float:
        """Period of the drive's first tone [s]; a tenth of the run where it is not known."""
        return self.run.period or 0.1 * float(np.ptp(self.run.time))

    def error(self, values: Sequence[Any], *, each: bool = False) -> Array:
        """Give the numerical error of the last of the values, one a step: of numbers, or of one series.

        Args:
            each: whether they are rows of numbers that converge each by itself.
        """
        factor = self.steps[0][0] / self.steps[1][0]
        if each:
            return np.array([richardson(one, factor, self.order) for one in np.transpose(values)])
        return richardson(values, factor, self.order)


def refined(run: Run, *, transient: bool = False, refine: bool = True, starts: int = 0) -> Refined:
    """Run a law again; what cannot is noted.

    Args:
        run: as recorded.
        transient: the run itself again, and not the motion that its motor settles to.
        refine: at finer steps, with more friction and on another basis.
        starts: from which steady states are looked for, the run's own included.
    """
    law = Refined(run)
    if transient and not refine:
        return law
    try:
        setup = build(run.configuration)
    except ConfigurationError as error:
        law.notes.append(f"{run.label} is taken as recorded; it does not build: {error.faults[0]}")
        return law
    if not refine:
        if found := _again(law, setup.configuration, "", transient=False):
            law.motion = found[0]
            law.means.append(found[1])
        return law
    law.control = control_of(setup)
    law.order = setup.law.convergence_order
    _refine(law, setup, transient)
    if not law.steps:
        return law
    if transient:
        _tell_other_code(law)
    _vary(law, setup, transient)
    if starts > 1 and not transient:
        _start_elsewhere(law, setup, starts)
    return law


def control_of(setup: Setup) -> str:
    """Name what makes a law finer."""
    return "contact_step" if isinstance(setup.law, MultiplierLaw) else "tolerance"


def with_keys(configuration: Configuration, **changes: Mapping[str, Any]) -> dict[str, Any]:
    """Give a configuration with keys changed by section."""
    return {**configuration, **{name: configuration[name] | keys for name, keys in changes.items()}}


def on_other_basis(setup: Setup) -> tuple[dict[str, Any], str]:
    """Give the same motor on the converged basis, and what differs; a converged one keeps more modes.

    A drive at the first natural frequency stays there.
    """
    configuration = setup.configuration
    resonator, drive = configuration["resonator"], configuration["drive"]
    if resonator["basis"] == "ritz":
        kept = {key: value for key, value in resonator.items() if key not in ("basis", "shapes")}
        other = {**build([f"resonator={CONVERGED}"]).configuration["resonator"], **kept}
        words = f"with resonator={CONVERGED}"
    else:
        more = resonator["kept_modes"] + MORE_SHAPES
        other, words = resonator | {"kept_modes": more}, f"with resonator.kept_modes {more}"
    tuned = drive["frequency"] == setup.motor.modes.natural_frequency[0]
    frequency = {"frequency": None} if tuned else {}
    return {**configuration, "resonator": other, "drive": drive | frequency}, words


CONVERGED: Final = "finite_element"


def _refine(law: Refined, setup: Setup, transient: bool) -> None:
    """Run at three steps; without all of them there is no convergence to speak of."""
    coarsest = getattr(setup, law.control)
    for divisor in FINER[law.control]:
        finer, began = coarsest / divisor, perf_counter()
        changed = with_keys(setup.configuration, solver={law.control: finer})
        found = _again(law, changed, f"at {law.control} {finer:.3g}", transient=transient)
        if found is None:
            law.steps.clear()
            law.means.clear()
            return
        law.steps.append((finer, found[0]))
        law.means += found[1:]
        # The first run of all may wait for the compiler.
        law.seconds = [perf_counter() - began]


def _tell_other_code(law: Refined) -> None:
    run = law.run
    old, new = (float(r.columns.get("rotor_velocity", [0.0])[-1]) for r in (run, law.base))
    if run.holds("rotor_velocity") and abs(old - new) > 1e-9 * max(abs(old), abs(new)):
        law.notes.append(
            f"{run.label} run again ends at {new:.9g} rad/s and not at the recorded {old:.9g} rad/s: "
            "other code has left it. The reruns are compared."
        )


def _vary(law: Refined, setup: Setup, transient: bool) -> None:
    """Run with more friction and on another basis."""
    coefficient = law.run.setting("contact.friction_coefficient") * (1.0 + FRICTION_CHANGE)
    if coefficient == 0.0:
        law.notes.append(f"{law.run.label} is frictionless: no sensitivity to the coefficient.")
    else:
        changed = with_keys(setup.configuration, contact={"friction_coefficient": coefficient})
        if found := _again(law, changed, "with more friction", transient=transient):
            law.variants["friction"] = FRICTION_CHANGE, found[0]
    began = perf_counter()
    if found := _again(law, *on_other_basis(setup), transient=transient):
        law.variants["basis"] = 1.0, found[0]
        law.elsewhere = found[1] if not transient else None
    law.seconds.append(perf_counter() - began)


def _start_elsewhere(law: Refined, setup: Setup, starts: int) -> None:
    try:
        law.reached = [means_of(a.steady) for a in attractors(setup, starts, longest=LONGEST)]
    # A law of another package may fail in ways of its own.
    except Exception as error:
        law.notes.append(f"{law.run.label} fails from other starts: {error}")


def _again(
    law: Refined, configuration: Configuration, words: str, *, transient: bool
) -> tuple[Any, ...] | None:
    """Make one rerun: the run, and the means of a settled one; None with a note if there is none."""
    try:
        setup = build(configuration)
        if not transient:
            state = settled(setup)
            return motion_of(state), means_of(state)
        interval = min(setup.record_interval, law.period / RECORDS_PER_PERIOD)
        if setup.duration / interval > MOST_RECORDS:
            interval = setup.record_interval
        solution = simulate(setup, record_interval=interval)
    # A law of another package may fail in ways of its own.
    except Exception as error:
        law.notes.append(f"{law.run.label} fails {words}: {error}".replace(" :", ":"))
        law.without = str(error) if isinstance(error, NotSettledError) else ""
        return None
    if solution.ending.reached_end:
        return (Run.of(solution.tree),)
    law.notes.append(f"{law.run.label} does not reach its end {words}: {solution.message}")
    return None
