"""Tasks of a comparison, reruns of each law and draws, and the results of one law."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import Setup, build
from contactlab.config.faults import failure_of
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, control_of, richardson
from contactlab.results.netcdf import reached_end, to_datatree
from contactlab.simulation import simulate
from contactlab.steady_state import NotSettledError, attractors
from contactlab.steady_state.means import LONGEST, QUANTITIES, Means, means_of, motion_of, settled
from contactlab.studies.compare.draws import on_other_basis
from contactlab.studies.study import Part
from contactlab.trajectory import Ending

FRICTION_CHANGE: Final = 0.01
"""Relative change of the friction coefficient for the sensitivity to it."""

RECORDS_PER_PERIOD: Final = 300.0
"""Smallest number of records in a period of the drive, which resolves a contact in a figure."""

MOST_RECORDS: Final = 1_000_000
"""Number of records beyond which a rerun has the record interval of its run."""

VARIANTS: Final = {"friction": FRICTION_CHANGE, "basis": 1.0}
"""Reruns with another motor, and their relative changes."""

CONFIGURED: Final = "as configured"
"""Name of the only rerun of a comparison without refinement."""

Rerun = tuple[str, str, "Setup | dict[str, Any]"]
"""Name, change in words, and the setup or its configuration."""


def reruns_of(setup: Setup, *, refine: bool) -> Iterator[Rerun]:
    """Yield the reruns of a law; a setup that was made in Python has no configuration to change."""
    configuration = setup.configuration
    if not refine:
        yield CONFIGURED, CONFIGURED, setup
        return
    control = control_of(setup)
    whole = "resonator" in configuration
    for number, divisor in enumerate(FINER[control]):
        step = getattr(setup, control) / divisor
        finer: Setup | dict[str, Any] = replace(setup, **{control: step})
        if whole:
            finer = configuration | {"solver": configuration["solver"] | {control: step}}
        yield f"step {number}", f"at {control} {step:.3g}", finer
    if whole:
        contact = configuration["contact"]
        if coefficient := contact["friction_coefficient"] * (1.0 + FRICTION_CHANGE):
            changed = configuration | {"contact": contact | {"friction_coefficient": coefficient}}
            yield "friction", "with more friction", changed
        other, change = on_other_basis(setup)
        yield "basis", f"with {change}", other


def _failing_alone(task: Callable[..., xarray.DataTree]) -> Callable[..., Part]:
    """Decorate a task whose failure is its result: it must not stop the tasks of other laws."""

    @wraps(task)
    def do(*arguments: Any) -> Part:
        try:
            return Part(task(*arguments))
        except Exception as error:
            settles = int(not isinstance(error, NotSettledError))
            failure = failure_of(error)
            return Part(xarray.DataTree(xarray.Dataset(attrs={"failure": failure, "settles": settles})))

    return do


@_failing_alone
def do_rerun(rerun: "Setup | dict[str, Any]", transient: bool, period: float) -> xarray.DataTree:
    """Return the run of a transient, or the settled motion with its means."""
    setup = rerun if isinstance(rerun, Setup) else build(rerun)
    if transient:
        interval = min(setup.record_interval, period / RECORDS_PER_PERIOD)
        if setup.duration / interval > MOST_RECORDS:
            interval = setup.record_interval
        run = simulate(setup, record_interval=interval)
        if run.ending is Ending.INTERRUPTED:
            raise KeyboardInterrupt
        return run.tree
    state = settled(setup)
    tree = to_datatree(motion_of(state), setup.configuration)
    tree["means"] = _tree_of([means_of(state)])
    return tree


@_failing_alone
def do_starts(setup: Setup, starts: int) -> xarray.DataTree:
    """Return the steady states that a motor reaches from several initial conditions."""
    return _tree_of([means_of(a.steady) for a in attractors(setup, starts, longest=LONGEST)])


def _tree_of(means: Sequence[Means]) -> xarray.DataTree:
    columns = {"value": [each.values for each in means], "error": [each.errors for each in means]}
    return xarray.DataTree(
        xarray.Dataset(
            {
                name: (("state", "quantity"), np.reshape(values, (-1, len(QUANTITIES))))
                for name, values in columns.items()
            },
            attrs={"kinds": "|".join(each.kind for each in means)},
        )
    )


def means_in(tree: xarray.DataTree) -> list[Means]:
    """Return the means of the steady states of a part."""
    data = tree.to_dataset()
    kinds = data.attrs["kinds"].split("|")
    return [Means(*each) for each in zip(kinds, data["value"].values, data["error"].values, strict=False)]


def _failure_of(tree: xarray.DataTree, transient: bool) -> str:
    """Return why a part has no numbers; empty where it has."""
    if transient and "failure" not in tree.attrs and not reached_end(tree.attrs):
        return f"it does not reach its end: {tree.attrs.get('message', '')}"
    return str(tree.attrs.get("failure", ""))


@final
@dataclass
class Reruns:
    """The results of one law.

    Args:
        run: as recorded; without records for a setup.
        setup: of the law; None if its configuration does not build.
        runs: by name of the rerun; all steps or none.
        states: steady states by name of the rerun, and those reached from all "starts"; none of a transient.
        notes: what could not be done.
        without: why there is no steady state.
    """

    run: Run
    setup: Setup | None = None
    runs: dict[str, Run] = field(default_factory=dict)
    states: dict[str, list[Means]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    without: str = ""

    @property
    def label(self) -> str:
        """Label of the law."""
        return self.run.label

    @property
    def steps(self) -> list[tuple[float, Run]]:
        """Values of the solver's option that is refined, and the runs, coarsest first."""
        if self.setup is None:
            return []
        value, divisors = getattr(self.setup, self.control), FINER[self.control]
        names = [name for name in self.runs if name.startswith("step")]
        return [(value / divisor, self.runs[name]) for name, divisor in zip(names, divisors, strict=False)]

    @property
    def control(self) -> str:
        """Option of the solver that is refined."""
        return control_of(self.setup) if self.setup else ""

    @property
    def means(self) -> list[Means]:
        """The steady state at each step, or as configured; none of a transient."""
        return [x[0] for name, x in self.states.items() if name == CONFIGURED or name.startswith("step")]

    @property
    def variants(self) -> dict[str, tuple[float, Run]]:
        """Relative change and run of the reruns with another motor."""
        return {name: (size, self.runs[name]) for name, size in VARIANTS.items() if name in self.runs}

    @property
    def best(self) -> Run:
        """The finest rerun, the settled motion, or the run itself."""
        return self.steps[-1][1] if self.steps else self.runs.get(CONFIGURED, self.run)

    @property
    def period(self) -> float:
        """Period of the drive's first tone [s]; a tenth of the run where it is not known."""
        return self.run.period or 0.1 * float(np.ptp(self.best.time))

    def error(self, values: Sequence[Any]) -> Array:
        """Return the numerical error of the last of the values, numbers or one series, one for each step."""
        assert self.setup is not None
        (coarse, _), (fine, _), *_ = self.steps
        return richardson(values, coarse / fine, self.setup.law.convergence_order)

    def mean_errors(self) -> Array:
        """Return the errors of the means, numerical and statistical."""
        columns = np.transpose([each.values for each in self.means])
        return np.array([self.error(column) for column in columns]) + self.means[-1].errors

    def add(
        self, setup: Setup, parts: Mapping[str, xarray.DataTree], *, transient: bool, refine: bool
    ) -> None:
        """Add the reruns of a setup; without all its steps a law has no convergence and no variants.

        Args:
            setup: of the law.
            parts: by name of the rerun, and "starts".
            transient, refine: options of the study.
        """
        self.setup = setup
        for name, change, _ in reruns_of(setup, refine=refine):
            if name not in parts or (name in VARIANTS and not self.runs):
                continue
            tree = parts[name]
            if not (failure := _failure_of(tree, transient)):
                self.runs[name] = Run.of(tree)
                if not transient:
                    self.states[name] = means_in(tree.children["means"])
                continue
            self.notes.append(f"{self.label} fails {change}: {failure}")
            if name not in VARIANTS:
                self.without = failure if tree.attrs.get("settles") == 0 else ""
                self.runs, self.states = {}, {}
                return
        if refine and "friction" not in parts:
            self.notes.append(f"{self.label} has no friction coefficient to change.")
        if "starts" in parts:
            if failure := _failure_of(parts["starts"], False):
                self.notes.append(f"{self.label} fails from other starts: {failure}")
            else:
                self.states["starts"] = means_in(parts["starts"])
