"""Reruns of one law, each a task: at finer steps, with more friction, on another basis, from other starts."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import Setup, build
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, richardson
from contactlab.results.netcdf import reached_end, to_datatree
from contactlab.simulation import simulate
from contactlab.steady_state import NotSettledError, attractors
from contactlab.steady_state.means import LONGEST, QUANTITIES, Means, means_of, motion_of, settled
from contactlab.studies.compare_draws import control_of, on_other_basis
from contactlab.studies.study import Part

FRICTION_CHANGE: Final = 0.01
"""Relative change of the friction coefficient for the sensitivity to it."""

RECORDS_PER_PERIOD: Final = 300.0
"""Smallest number of records in a period of the drive, which resolves a contact in a figure."""

MOST_RECORDS: Final = 1_000_000
"""Number of records beyond which a rerun has the record interval of its run."""

VARIANTS: Final = ("friction", "basis")
"""Names of the reruns with another motor."""

Rerun = tuple[str, str, "Setup | dict[str, Any]"]
"""Name, change in words, and the setup or its configuration."""


def reruns_of(setup: Setup, *, refine: bool) -> Iterator[Rerun]:
    """Yield the reruns of a law; a setup that was made in Python has no configuration to change."""
    whole, configuration = "resonator" in setup.configuration, setup.configuration
    if not refine:
        yield "as configured", "as configured", setup
        return
    control = control_of(setup)
    for number, divisor in enumerate(FINER[control]):
        step = getattr(setup, control) / divisor
        finer: Setup | dict[str, Any] = replace(setup, **{control: step})
        if whole:
            finer = configuration | {"solver": configuration["solver"] | {control: step}}
        yield f"step {number}", f"at {control} {step:.3g}", finer
    if not whole:
        return
    contact = configuration["contact"]
    if coefficient := contact["friction_coefficient"] * (1.0 + FRICTION_CHANGE):
        changed = configuration | {"contact": contact | {"friction_coefficient": coefficient}}
        yield "friction", "with more friction", changed
    other, change = on_other_basis(setup)
    yield "basis", f"with {change}", other


def do_rerun(rerun: "Setup | dict[str, Any]", transient: bool, period: float) -> Part:
    """Do one rerun: the run with its means, or the message of its failure."""
    try:
        setup = rerun if isinstance(rerun, Setup) else build(rerun)
        if transient:
            interval = min(setup.record_interval, period / RECORDS_PER_PERIOD)
            if setup.duration / interval > MOST_RECORDS:
                interval = setup.record_interval
            return Part(simulate(setup, record_interval=interval).tree)
        state = settled(setup)
        tree = to_datatree(motion_of(state), setup.configuration)
        tree["means"] = xarray.DataTree(_dataset_of([means_of(state)]))
        return Part(tree)
    # A law of another package may fail in any way.
    except Exception as error:
        return _failure(error)


def do_starts(setup: Setup, starts: int) -> Part:
    """Compute the steady states that a motor reaches from several starts."""
    try:
        return Part(
            xarray.DataTree(
                _dataset_of([means_of(a.steady) for a in attractors(setup, starts, longest=LONGEST)])
            )
        )
    # As above.
    except Exception as error:
        return _failure(error)


def do_draw(configuration: Mapping[str, Any]) -> Part:
    """Compute the steady state of one draw."""
    try:
        return Part(xarray.DataTree(_dataset_of([means_of(settled(build(configuration)))])))
    # As above: one motor of a thousand must not stop the others.
    except Exception as error:
        return _failure(error)


def _failure(error: Exception) -> Part:
    settles = int(not isinstance(error, NotSettledError))
    failure = str(error) or type(error).__name__
    return Part(xarray.DataTree(xarray.Dataset(attrs={"failure": failure, "settles": settles})))


def _dataset_of(means: Sequence[Means]) -> xarray.Dataset:
    dims = ("state", "quantity")
    return xarray.Dataset(
        {
            "value": (dims, np.reshape([each.values for each in means], (-1, len(QUANTITIES)))),
            "error": (dims, np.reshape([each.errors for each in means], (-1, len(QUANTITIES)))),
        },
        attrs={"kinds": "|".join(each.kind for each in means)},
    )


def means_in(tree: xarray.DataTree) -> list[Means]:
    """Return the means of the steady states of a part."""
    data = tree.to_dataset()
    kinds = data.attrs["kinds"].split("|")
    return [Means(*each) for each in zip(kinds, data["value"].values, data["error"].values, strict=False)]


@final
@dataclass
class Reruns:
    """The results of one law.

    Args:
        run: as recorded; without records for a setup.
        control, order: option of the solver that is refined, and the order of the error in it.
        steps: its values and the runs, coarsest first.
        variants: relative change and run, of `friction` and `basis`.
        notes: what could not be done.
        motion: the settled motion, or the run, as configured, where nothing was refined.
        means: the steady state at each step, or as configured; none of a transient.
        elsewhere: the steady state on the other basis.
        reached: the steady states from all starts; none if not computed.
        without: why there is no steady state.
    """

    run: Run
    control: str = ""
    order: float = 1.0
    steps: list[tuple[float, Run]] = field(default_factory=list)
    variants: dict[str, tuple[float, Run]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    motion: Run | None = None
    means: list[Means] = field(default_factory=list)
    elsewhere: Means | None = None
    reached: list[Means] = field(default_factory=list)
    without: str = ""

    @property
    def label(self) -> str:
        """Label of the law."""
        return self.run.label

    @property
    def best(self) -> Run:
        """The finest rerun, the settled motion, or the run itself."""
        return self.steps[-1][1] if self.steps else self.motion or self.run

    @property
    def period(self) -> float:
        """Period of the drive's first tone [s]; a tenth of the run where it is not known."""
        return self.run.period or 0.1 * float(np.ptp(self.best.time))

    def error(self, values: Sequence[Any], *, each: bool = False) -> Array:
        """Return the numerical error of the last of the values, one for each step.

        Args:
            values: numbers, or one series.
            each: whether they are rows of numbers that converge separately.
        """
        factor = self.steps[0][0] / self.steps[1][0]
        if each:
            return np.array([richardson(column, factor, self.order) for column in np.transpose(values)])
        return richardson(values, factor, self.order)

    def mean_errors(self) -> Array:
        """Return the errors of the means, numerical and statistical."""
        return self.error([each.values for each in self.means], each=True) + self.means[-1].errors

    def add(
        self, setup: Setup, parts: Mapping[str, xarray.DataTree], *, transient: bool, refine: bool
    ) -> None:
        """Add the reruns of a setup; without all its steps a law has no convergence and no variants.

        Args:
            setup: of the law.
            parts: by name of the rerun, and "starts".
            transient, refine: options of the study.
        """
        self.control, self.order = control_of(setup), setup.law.convergence_order
        for name, change, _ in reruns_of(setup, refine=refine):
            if name not in parts or (name in VARIANTS and not self.steps):
                continue
            tree = parts[name]
            failure = tree.attrs.get("failure", "")
            if transient and not failure and not reached_end(tree.attrs):
                failure = f"it does not reach its end: {tree.attrs.get('message', '')}"
            if not failure:
                self._put(name, setup, Run.of(tree), [] if transient else means_in(tree.children["means"]))
                continue
            self.notes.append(f"{self.label} fails {change}: {failure}")
            if name not in VARIANTS:
                self.without = failure if tree.attrs.get("settles") == 0 else ""
                self.steps, self.means = [], []
                return
        if refine and "friction" not in parts:
            self.notes.append(f"{self.label} has no friction coefficient to change.")
        if transient:
            self._compare_with_record()
        if "starts" in parts:
            if failure := parts["starts"].attrs.get("failure"):
                self.notes.append(f"{self.label} fails from other starts: {failure}")
            else:
                self.reached = means_in(parts["starts"])

    def _put(self, name: str, setup: Setup, run: Run, means: list[Means]) -> None:
        """Put a rerun in its place."""
        match name:
            case "as configured":
                self.motion, self.means = run, means
            case "friction":
                self.variants[name] = FRICTION_CHANGE, run
            case "basis":
                self.variants[name] = 1.0, run
                self.elsewhere = means[0] if means else None
            case _:
                divisor = FINER[self.control][len(self.steps)]
                self.steps.append((getattr(setup, self.control) / divisor, run))
                self.means += means

    def _compare_with_record(self) -> None:
        """Note a rerun at the recorded step that differs from the record."""
        if not self.steps or not self.run.holds("rotor_velocity"):
            return
        old, new = (float(run.columns["rotor_velocity"][-1]) for run in (self.run, self.steps[0][1]))
        if abs(old - new) > 1e-9 * max(abs(old), abs(new)):
            self.notes.append(
                f"{self.label}: a rerun ends at {new:.9g} rad/s, its record at {old:.9g} rad/s: another "
                "version of the code made it. The reruns are compared."
            )
