"""A recorded run again: at finer steps, with a little more friction, on a larger basis.

The configuration that a run recorded builds the same motor and law again, so that every law can be
brought to its own convergence before it is set beside the others.
"""

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.comparison.arrays import Array, holds, series
from contactlab.comparison.runs import Run
from contactlab.config import ConfigurationError, Setup, build
from contactlab.engine import simulate
from contactlab.laws.base import MultiplierLaw
from contactlab.results.netcdf import to_datatree

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
@dataclass(frozen=True)
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
    steps: list[tuple[float, xarray.DataTree]] = field(default_factory=list)
    friction: tuple[float, xarray.DataTree] | None = None
    basis: xarray.DataTree | None = None
    notes: list[str] = field(default_factory=list)

    @property
    def best(self) -> xarray.DataTree:
        """The finest of the reruns, the run itself without any."""
        return self.steps[-1][1] if self.steps else self.run.tree

    @property
    def base(self) -> xarray.DataTree:
        """The rerun as recorded, which the changed ones are set against; else the run itself."""
        return self.steps[0][1] if self.steps else self.run.tree

    def error(self, of: Callable[[xarray.DataTree], Any]) -> Any:
        """Numerical error of a number or of a series of the finest rerun; NaN without reruns."""
        if not self.steps:
            return np.full_like(np.asarray(of(self.best), dtype=float), np.nan)
        factor = self.steps[0][0] / self.steps[1][0]
        return richardson([np.asarray(of(tree)) for _, tree in self.steps], factor, self.order)


def richardson(values: list[Array], factor: float, order: float) -> Array:
    """Error of the last of three values from steps that fall by a factor.

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
        run: as recorded. One that cannot be built again comes back with a note.
        advance: called after every rerun.
    """
    try:
        setup = build(run.configuration)
    except ConfigurationError as error:
        first = error.faults[0].rstrip(".")
        return Refined(
            run,
            notes=[f"{run.label} is taken as recorded, its configuration does not build: {first}."],
        )
    control = "contact_step" if isinstance(setup.law, MultiplierLaw) else "tolerance"
    recorded = {"contact_step": setup.contact_step, "tolerance": setup.tolerance}[control]
    assert recorded is not None, "a compliant setup has a tolerance"
    notes: list[str] = []
    steps = []
    for divisor in FINER[control]:
        tree = _run(
            setup,
            run,
            f"at {control} {recorded / divisor:.3g}",
            notes,
            **{control: recorded / divisor},
        )
        advance()
        if tree is not None:
            steps.append((recorded / divisor, tree))
    if len(steps) < len(FINER[control]):
        # Without all of them there is no convergence to speak of.
        return Refined(run, notes=notes)
    notes += _repeated(run, steps[0][1])
    friction, basis = _more_friction(run, notes), _larger_basis(run, notes)
    advance()
    advance()
    changed_by = None if friction is None else (FRICTION_CHANGE, friction)
    return Refined(run, control, setup.law.convergence_order, steps, changed_by, basis, notes)


def _run(
    setup: Setup, run: Run, words: str, notes: list[str], **finer: float
) -> xarray.DataTree | None:
    """One rerun in memory; None with a note if it does not reach its end."""
    interval = min(setup.record_interval, run.period / RECORDS_PER_PERIOD)
    if setup.duration / interval > MOST_RECORDS:
        interval = setup.record_interval
    given = {"contact_step": setup.contact_step, "tolerance": setup.tolerance} | finer
    try:
        trajectory = simulate(
            setup.motor,
            setup.law,
            duration=setup.duration,
            record_interval=interval,
            contact_step=given["contact_step"],
            tolerance=given["tolerance"],
        )
    # A law of another package may fail in ways of its own.
    except Exception as error:
        notes.append(f"{run.label} fails {words}: {error}")
        return None
    if not trajectory.ending.reached_end:
        notes.append(f"{run.label} does not reach its end {words}: {trajectory.message}")
        return None
    return to_datatree(trajectory, setup.configuration)


def _repeated(run: Run, again: xarray.DataTree) -> Iterator[str]:
    """A word if the rerun is not the run that was recorded."""
    if not holds(run.tree, "rotor_velocity"):
        return
    old, new = (float(series(tree, "rotor_velocity")[-1]) for tree in (run.tree, again))
    if abs(old - new) > 1e-9 * max(abs(old), abs(new)):
        yield (
            f"{run.label} run again ends at {new:.9g} rad/s and not at the recorded {old:.9g} rad/s: "
            "other code has left it. The reruns are compared."
        )


def _more_friction(run: Run, notes: list[str]) -> xarray.DataTree | None:
    changed = copy.deepcopy(dict(run.configuration))
    changed["contact"]["friction_coefficient"] *= 1.0 + FRICTION_CHANGE
    if changed["contact"]["friction_coefficient"] == 0.0:
        notes.append(f"{run.label} is frictionless: no sensitivity to the friction coefficient.")
        return None
    return _changed(changed, run, "with more friction", notes)


def _larger_basis(run: Run, notes: list[str]) -> xarray.DataTree | None:
    """More functions; a drive at the first natural frequency stays there."""
    changed = copy.deepcopy(dict(run.configuration))
    key = "shapes" if changed["resonator"]["basis"] == "ritz" else "kept_modes"
    changed["resonator"][key] += MORE_SHAPES
    known = holds(run.tree, "natural_frequency")
    if known and changed["drive"]["frequency"] == series(run.tree, "natural_frequency")[0]:
        changed["drive"]["frequency"] = None
    return _changed(changed, run, f"with resonator.{key} {changed['resonator'][key]}", notes)


def _changed(
    configuration: dict[str, Any], run: Run, words: str, notes: list[str]
) -> xarray.DataTree | None:
    try:
        setup = build(configuration)
    except ConfigurationError as error:
        notes.append(f"{run.label} cannot be run {words}: {error.faults[0]}")
        return None
    return _run(setup, run, words, notes)
