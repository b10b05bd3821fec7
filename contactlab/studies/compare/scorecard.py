"""The scorecard of a comparison: settled motions of each law at several steps, metrics, energy flow."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import nan
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab import metrics, variables
from contactlab.config import Setup, build
from contactlab.config.faults import failure_of
from contactlab.metrics import VERDICTS, NotApplicableError, Run
from contactlab.metrics.balances import SPENT, STORED
from contactlab.refinement import LEVELS, Refinement
from contactlab.results.netcdf import cf_attributes, to_datatree
from contactlab.results.yaml_text import write_yaml
from contactlab.settling.statistics import PERIODIC, WITHOUT_CONTACT
from contactlab.steady_state import NotSettledError, Steady, attractors
from contactlab.steady_state.means import LONGEST, QUANTITIES, Means, means_of, motion_of, settled_soon
from contactlab.studies.compare.motors import on_other_basis
from contactlab.studies.compare.observables import observation, quantities_of
from contactlab.studies.study import Part, Task

VARIANTS: Final = {"friction": 0.01, "basis": 1.0}
"""Reruns with another motor, and their relative changes."""

CONFIGURED: Final = "as configured"
"""Name of the only rerun of a comparison without refinement."""

FLAGS: Final = "not_applicable pass fail reported settled not_settled inconclusive"
"""`VERDICTS` as words of the CF conventions."""

ENERGY_TERMS: Final = {
    "damping_loss": "viscous damping",
    "friction_loss": "friction",
    "contact_loss": "contact losses",
    "load_work": "load work",
    "stored_energy": "change of stored energy",
    "unaccounted": "unaccounted",
}
"""Terms of the energy flow and their names, in the order of the figure."""

MOST_IN_TITLE: Final = 6
"""Laws that a title names; of more it has the number."""

NOT_KNOWN: Final = "not known"
"""Kind of a recorded motion, and of one that fails."""

SERIES: Final = (
    "tip_tangential_displacement", "tip_normal_displacement", "gap", "slip_velocity", "normal_force",
    "friction_force", "rotor_velocity",
)  # fmt: skip
CONTACTS: Final = ("start_time", "duration", "normal_impulse", "peak_normal_force")
"""What the figures show of a motion."""

SHOWN: Final = {each.name: each for each in (*variables.SERIES, *variables.CONTACTS)}

OBSERVED_IN: Final = (*(f"step {n}" for n in range(LEVELS)), "basis")
"""Reruns whose motors the paired comparison has, too."""

Rerun = tuple[str, str, Setup | dict[str, Any]]
"""Name, change in words, and the setup or its configuration."""


def reruns_of(setup: Setup, *, refine: bool) -> Iterator[Rerun]:
    """Yield the reruns of a law; a setup that was made in Python has no configuration to change."""
    configuration, refinement = setup.configuration, Refinement.of(setup)
    if not refine:
        yield CONFIGURED, CONFIGURED, setup
        return
    for number, (step, finer) in enumerate(zip(refinement.values, refinement.setups(setup), strict=True)):
        yield f"step {number}", f"at {refinement.control} {step:.3g}", finer
    if "resonator" in configuration:
        contact = configuration["contact"]
        if coefficient := contact["friction_coefficient"] * (1.0 + VARIANTS["friction"]):
            changed = configuration | {"contact": contact | {"friction_coefficient": coefficient}}
            yield "friction", "with more friction", changed
        other, change = on_other_basis(setup)
        yield "basis", f"with {change}", other


def tasks_of(
    label: str, setup: Setup, *, refine: bool, starts: int, observe: Sequence[str] = ()
) -> dict[str, Task]:
    """Return the tasks of a law by name: settled motions, the first with steady states of several starts.

    Args:
        label: of the law.
        setup: of the law.
        refine: whether there are reruns and starts.
        starts: initial conditions.
        observe: quantities of the reruns of `OBSERVED_IN`, that the paired comparison takes from them.
    """
    tasks = {}
    for name, _, rerun in reruns_of(setup, refine=refine):
        quantities = observe if name in OBSERVED_IN else ()
        work = settled_motion, rerun, quantities, starts if name == OBSERVED_IN[0] else 1
        tasks[name] = Task(task_key(label, name), attempt, work)
    return tasks


def task_key(label: str, name: str) -> str:
    """Return the key of a task of a law by its name."""
    return f"{label} {name}"


def attempt(work: Callable[..., xarray.DataTree], *arguments: Any) -> Part:
    """Do work whose failure is its result: it must not stop the tasks of other laws."""
    try:
        return Part(work(*arguments))
    except Exception as error:
        settles = int(not isinstance(error, NotSettledError))
        return Part(xarray.DataTree(xarray.Dataset(attrs={"failure": failure_of(error), "settles": settles})))


def settled_motion(
    rerun: Setup | dict[str, Any], observe: Sequence[str] = (), starts: int = 1
) -> xarray.DataTree:
    """Return the settled motion with its means, quantities that are observed, and those from other starts."""
    setup = rerun if isinstance(rerun, Setup) else build(rerun)
    state, soon = settled_soon(setup)
    tree = to_datatree(motion_of(state), setup.configuration)
    tree["means"] = _tree_of([means_of(state)])
    if observe:
        tree["observed"] = xarray.DataTree(observation(observe, lambda: quantities_of(state, observe)))
    if starts > 1:
        tree["starts"] = attempt(steady_states, setup, starts, state if soon else None).data
    return tree


def steady_states(setup: Setup, starts: int, own: Steady | None) -> xarray.DataTree:
    """Return the steady states that a motor reaches from several initial conditions."""
    return _tree_of([means_of(a.steady) for a in attractors(setup, starts, longest=LONGEST, own=own)])


def _tree_of(means: Sequence[Means]) -> xarray.DataTree:
    columns = {"value": [each.values for each in means], "error": [each.errors for each in means]}
    data = {
        name: (("state", "quantity"), np.reshape(values, (-1, len(QUANTITIES))))
        for name, values in columns.items()
    }
    return xarray.DataTree(xarray.Dataset(data, attrs={"kinds": "|".join(each.kind for each in means)}))


def means_in(tree: xarray.DataTree) -> list[Means]:
    """Return the means of the steady states of a part."""
    data = tree.to_dataset()
    kinds = data.attrs["kinds"].split("|")
    return [Means(*each) for each in zip(kinds, data["value"].values, data["error"].values, strict=False)]


def observation_in(tree: xarray.DataTree, names: Sequence[str]) -> xarray.Dataset:
    """Return the quantities that a part has observed; those of one that fails are NaN."""
    if "observed" in tree.children:
        return tree.children["observed"].to_dataset(inherit=False)
    return observation(names, failure=tree.attrs["failure"])


@final
@dataclass
class Reruns:
    """The results of one law: a recorded run, or the settled motor at several steps.

    Args:
        run: as recorded; without records for a setup.
        setup: of the law; None of a recorded run.
        runs: settled motions by name of the rerun; all steps or none.
        states: steady states by name of the rerun, and those reached from all "starts".
        notes: what could not be done.
        without: why there is no steady state.
    """

    run: Run
    setup: Setup | None = None
    runs: dict[str, Run] = field(default_factory=dict)
    states: dict[str, list[Means]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    without: str = ""

    @classmethod
    def of(cls, run: Run, setup: Setup, parts: Mapping[str, xarray.DataTree], *, refine: bool) -> "Reruns":
        """Return the results of a setup; without all its steps it has no convergence and no variants.

        Args:
            run: the setup without records.
            setup: of the law.
            parts: of the tasks of `tasks_of` by name.
            refine: as there.
        """
        law = cls(run, setup)
        for name, change, _ in reruns_of(setup, refine=refine):
            tree = parts[name]
            failure = str(tree.attrs.get("failure", ""))
            note = f"{run.label} fails {change}: {failure}"
            if not failure:
                law.runs[name], law.states[name] = Run.of(tree), means_in(tree.children["means"])
            elif name in VARIANTS:
                law.notes.append(note)
            elif tree.attrs["settles"] == 0:
                return cls(run, setup, without=failure)
            else:
                return cls(run, setup, notes=[note])
        if refine and "friction" not in parts:
            law.notes.append(f"{run.label} has no friction coefficient to change.")
        first = parts.get(OBSERVED_IN[0], xarray.DataTree())
        if "starts" in first.children:
            if failure := first.children["starts"].attrs.get("failure", ""):
                law.notes.append(f"{run.label} fails from other starts: {failure}")
            else:
                law.states["starts"] = means_in(first.children["starts"])
        return law

    @property
    def refinement(self) -> Refinement:
        """The steps or tolerances of a setup."""
        assert self.setup is not None
        return Refinement.of(self.setup)

    @property
    def steps(self) -> list[tuple[float, Run]]:
        """Values of the solver's option that is refined, and the runs, coarsest first."""
        if self.setup is None or CONFIGURED in self.runs or not self.runs:
            return []
        return [(step, self.runs[f"step {n}"]) for n, step in enumerate(self.refinement.values)]

    @property
    def means(self) -> list[Means]:
        """The steady state at each step, or as configured; none of a recorded run."""
        return [x[0] for name, x in self.states.items() if name == CONFIGURED or name.startswith("step")]

    @property
    def best(self) -> Run:
        """The finest rerun, the settled motion, or the run itself."""
        return self.steps[-1][1] if self.steps else self.runs.get(CONFIGURED, self.run)

    @property
    def period(self) -> float:
        """Period of the drive's first tone [s]; a tenth of the run where it is not known."""
        return self.run.period or 0.1 * float(np.ptp(self.best.time))

    def assessed(self) -> tuple[dict[str, float], dict[str, float]]:
        """Return values and errors by metric, numerical and, of means, statistical."""
        means = dict(zip(QUANTITIES, self.means[-1].values.tolist(), strict=True)) if self.means else {}
        if not self.steps:
            return (_assessed(self.best, bool(self.means)) if self.best.columns else {}) | means, {}
        steps = [_assessed(run, True) for _, run in self.steps]
        error = self.refinement.error
        errors = {key: error([each[key] for each in steps]) for key in steps[-1]}
        columns = np.transpose([each.values for each in self.means])
        both = np.array([error(column) for column in columns]) + self.means[-1].errors
        errors |= dict(zip(QUANTITIES, both.tolist(), strict=True))
        variants = {name: (size, self.runs[name]) for name, size in VARIANTS.items() if name in self.runs}
        values = steps[-1] | metrics.assess_steps(self.steps) | means
        return values | metrics.assess_variants(self.steps[0][1], **variants), errors

    @property
    def refined(self) -> str:
        """The steps at which the values were computed."""
        if self.steps:
            steps = ", ".join(f"{step:.3g}" for step, _ in self.steps)
            return f"settled, {self.refinement.control} {steps}"
        return "settled, steps as configured" if self.means else "as recorded"


def _assessed(run: Run, settled: bool) -> dict[str, float]:
    """Return the metrics of a run; sums of a settled motion, which may last several periods, are of one."""
    values = metrics.assess(run)
    if not settled:
        return values
    return {key: x / run.periods if metrics.METRICS[key].sums else x for key, x in values.items()}


def scorecard(laws: Sequence[Reruns], notes: Sequence[str]) -> xarray.Dataset:
    """Return metrics, errors, verdicts and energy flow of each law.

    Returns:
        A dataset over `law`, `metric` (those with a threshold first) and `term`.
    """
    catalogue = metrics.METRICS | metrics.STEP_METRICS | metrics.SENSITIVITIES
    settled = any(law.means for law in laws)
    every = [
        replace(metric, meaning=f"{metric.meaning}, in a drive period") if settled and metric.sums else metric
        for metric in sorted(catalogue.values(), key=lambda metric: not metric.threshold)
    ]
    values, errors = (
        [[part.get(metric.key, nan) for metric in every] for part in parts]
        for parts in zip(*(law.assessed() for law in laws), strict=True)
    )
    verdicts = [
        [VERDICTS.index(metric.verdict(x)) for metric, x in zip(every, row, strict=True)] for row in values
    ]
    flows = [energy_flow(law.best, law.period if settled else 0.0) for law in laws]
    flags = {"flag_values": np.arange(len(VERDICTS), dtype=np.int8), "flag_meanings": FLAGS}
    both, units = ("law", "metric"), {"comment": "units differ by metric, see `units`"}
    error = {"long_name": "error of the value: Richardson's, and statistical", **units}
    energy = {"units": "J", "long_name": "destination of the work of the drive"}
    work = {"units": "J", "long_name": "work of the drive on the resonator"}
    labels = [law.run.label for law in laws]
    of_metrics = ("symbol", "units", "meaning", "threshold", "reason", "conclusion")
    of_laws = {
        "kind": [law.means[-1].kind if law.means else NOT_KNOWN for law in laws],
        "run": [law.run.source for law in laws],
        "refined": [law.refined for law in laws],
        "configuration": [write_yaml(dict(law.run.configuration)) for law in laws],
        "law_parameters": [str(law.run.attributes.get("law_parameters", "")) for law in laws],
        "contactlab_version": [str(law.run.attributes.get("contactlab_version", "")) for law in laws],
    }
    return xarray.Dataset(
        {
            "value": (both, values, {"long_name": "value of the metric", **units}),
            "numerical_error": (both, errors, error),
            "verdict": (both, np.array(verdicts, dtype=np.int8), flags),
            "energy": (("law", "term"), [[flow[term] for term in ENERGY_TERMS] for flow in flows], energy),
            "drive_work": ("law", [flow["drive_work"] for flow in flows], work),
        },
        {
            "law": labels,
            "metric": [metric.key for metric in every],
            "term": list(ENERGY_TERMS),
            **{name: ("metric", [getattr(metric, name) for metric in every]) for name in of_metrics},
            "metric_source": ("metric", [metric.source for metric in every]),
            "judges_law": ("metric", np.array([metric.judges_law for metric in every], dtype=np.int8)),
            **{name: ("law", texts) for name, texts in of_laws.items()},
        },
        {
            "title": f"{len(labels)} contact laws compared"
            if len(labels) > MOST_IN_TITLE
            else f"Contact law{'s' if len(labels) > 1 else ''} compared: {', '.join(labels)}",
            "notes": "\n".join([*notes, *(note for law in laws for note in law.notes)]),
        },
    )


def energy_flow(run: Run, period: float = 0.0) -> dict[str, float]:
    """Return the work of the drive and its destinations by the end of a run [J]; the terms add up to it.

    The ledger is E(t) - E(0) = drive_work - losses - load_work + energy_residual: the residual is unaccounted
    energy with its sign changed.

    Args:
        run: NaN where it lacks a series of the ledger.
        period: time [s] to which the flow is scaled; 0 for the whole run.
    """
    names = ("drive_work", "energy_residual", *STORED, *SPENT)
    try:
        share = period / run.gain("time") if period else 1.0
        gain = {name: share * run.gain(name) for name in names}
    except NotApplicableError:
        return dict.fromkeys(("drive_work", *ENERGY_TERMS), nan)
    flow = {name: gain[name] for name in ("drive_work", *SPENT)}
    stored = sum(gain[name] for name in STORED)
    return flow | {"stored_energy": stored, "unaccounted": -gain["energy_residual"]}


def motion(law: Reruns) -> xarray.Dataset:
    """Return the motion that the figures show: the finest rerun, or the run as recorded."""
    run = law.best
    shown = [("time", run.columns, SERIES, run.holds), ("contact", run.rows, CONTACTS, run.touches)]
    columns: dict[str, Any] = {
        name: (dim, values[name], cf_attributes(SHOWN[name]))
        for dim, values, names, has in shown
        for name in names
        if has(name)
    }
    data = xarray.Dataset(columns, attrs={"law": law.run.label})
    # A rotor that a preload presses on the tip is not at rest there.
    pressed = run.settings.get("contact.preload")
    if isinstance(clearance := run.settings.get("contact.clearance"), float) and pressed is None:
        data.attrs["clearance"] = clearance
    if run.columns:
        data = data.assign_coords(time=("time", run.time, cf_attributes(variables.TIME)))
        data.attrs["period"] = law.period
    return data


def listed(names: Sequence[str]) -> str:
    """Return a list as in a sentence."""
    *first, last = names or [""]
    return f"{', '.join(first)} and {last}" if first else last


def limits_of(laws: Sequence[Reruns]) -> Iterator[str]:
    """Yield what must be known of settled laws beside their values."""
    kinds = {law.run.label: law.means[-1].kind for law in laws if law.means}
    without = {law.run.label: law.without for law in laws if law.without}
    for reason in dict.fromkeys(without.values()):
        yield f"{listed([label for label in without if without[label] == reason])}: no steady state. {reason}"
    if free := [label for label, kind in kinds.items() if kind == WITHOUT_CONTACT]:
        yield f"Settled without contact, so that nothing turns the rotor: {listed(free)}."
    if other := [
        f"{label} ({kind})" for label, kind in kinds.items() if kind not in (WITHOUT_CONTACT, PERIODIC)
    ]:
        yield (
            f"No periodic motion: {listed(other)}; values are means over {LONGEST // 2} periods, with "
            "statistical errors."
        )
    several: list[str] = []
    for law in laws:
        reached = law.states.get("starts", ())
        if len(reached) > 1 and law.means:
            # Without contact the rotor keeps its initial velocity.
            each = [x.kind if x.kind == WITHOUT_CONTACT else f"{x.values[0]:.3g} rad/s" for x in reached]
            several.append(f"{law.run.label} ({', '.join(each)})")
    if several:
        yield f"Several motions, depending on the start: {listed(several)}."
