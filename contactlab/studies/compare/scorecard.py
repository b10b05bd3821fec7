"""The scorecard of a comparison: metrics, energy flow and motions of each law."""

from collections.abc import Iterator, Sequence
from math import nan
from typing import Any, Final

import numpy as np
import xarray
from yaml import safe_dump

from contactlab import metrics, variables
from contactlab.metrics import METRICS, VERDICTS, NotApplicableError, Run
from contactlab.metrics.balances import SPENT, STORED
from contactlab.results.netcdf import cf_attributes
from contactlab.settling.statistics import PERIODIC, WITHOUT_CONTACT
from contactlab.steady_state.means import LONGEST, QUANTITIES
from contactlab.studies.compare.measured import Measured
from contactlab.studies.compare.reruns import Reruns

EVERY: Final = metrics.METRICS | metrics.STEP_METRICS | metrics.SENSITIVITIES
"""Metrics of a comparison."""

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

UNSETTLED: Final = 0.01
"""Relative distance of a recorded velocity from the settled one that is reported."""

NOT_KNOWN: Final = "not known"
"""Kind of a motion that fails."""

SERIES: Final = (
    "tip_tangential_displacement", "tip_normal_displacement", "gap", "slip_velocity", "normal_force",
    "friction_force", "rotor_velocity",
)  # fmt: skip
CONTACTS: Final = ("start_time", "duration", "normal_impulse", "peak_normal_force")
"""What the figures show of a motion."""

SHOWN: Final = {each.name: each for each in (*variables.SERIES, *variables.CONTACTS)}


def scorecard(laws: Sequence[Reruns], notes: Sequence[str], measured: Sequence[Measured]) -> xarray.Dataset:
    """Return metrics, errors, verdicts and energy flow of each law.

    Returns:
        A dataset over `law`, `metric` (those with a threshold first, those of measurements last) and `term`.
    """
    own = sorted(EVERY.values(), key=lambda metric: not metric.threshold)
    every = [*own, *(metric for each in measured for metric in each.rows)]
    numbers = [_assessed(law) for law in laws]
    values, errors = (
        np.array([[part.get(metric.key, nan) for metric in own] for part in parts])
        for parts in zip(*numbers, strict=True)
    )
    values = np.column_stack([values, *(each.values.T for each in measured)])
    errors = np.column_stack([errors, *(each.errors.T for each in measured)])
    verdicts = [
        [VERDICTS.index(metric.verdict(x)) for metric, x in zip(every, row, strict=True)]
        for row in values.tolist()
    ]
    settled = any(law.means for law in laws)
    flows = [energy_flow(law.best, law.period if settled else 0.0) for law in laws]
    flags = {"flag_values": np.arange(len(VERDICTS), dtype=np.int8), "flag_meanings": FLAGS}
    both, units = ("law", "metric"), {"comment": "units differ by metric, see `units`"}
    error = {"long_name": "error of the value: Richardson's, or half of a 95 % bootstrap interval", **units}
    energy = {"units": "J", "long_name": "destination of the work of the drive"}
    work = {"units": "J", "long_name": "work of the drive on the resonator"}
    labels = [law.label for law in laws]
    return xarray.Dataset(
        {
            "value": (both, values, {"long_name": "value of the metric", **units}),
            "numerical_error": (both, errors, error),
            "verdict": (both, np.array(verdicts, dtype=np.int8), flags),
            "energy": (("law", "term"), [[flow[term] for term in ENERGY_TERMS] for flow in flows], energy),
            "drive_work": ("law", [flow["drive_work"] for flow in flows], work),
        },
        coords={
            "law": labels,
            "metric": [metric.key for metric in every],
            "term": list(ENERGY_TERMS),
            **{
                name: ("metric", [getattr(metric, name) for metric in every])
                for name in ("symbol", "units", "meaning", "threshold", "reason", "conclusion")
            },
            "metric_source": ("metric", [metric.source for metric in every]),
            "judges_law": ("metric", np.array([metric.judges_law for metric in every], dtype=np.int8)),
            "kind": ("law", [law.means[-1].kind if law.means else NOT_KNOWN for law in laws]),
            "run": ("law", [law.run.source for law in laws]),
            "refined": ("law", [_refinement(law) for law in laws]),
            **{
                name: ("law", [str(law.run.attributes.get(name, "")) for law in laws])
                for name in ("law_parameters", "contactlab_version")
            },
            "configuration": (
                "law",
                [safe_dump(dict(law.run.configuration), sort_keys=False) for law in laws],
            ),
        },
        attrs={
            "title": f"Contact law{'s' if len(laws) > 1 else ''} compared: {', '.join(labels)}",
            "notes": "\n".join([*notes, *(note for law in laws for note in law.notes)]),
        },
    )


def _assessed(law: Reruns) -> tuple[dict[str, float], dict[str, float]]:
    """Return values and numerical errors by metric."""
    means = dict(zip(QUANTITIES, law.means[-1].values.tolist(), strict=True)) if law.means else {}
    if not law.steps:
        return (metrics.assess(law.best) if law.best.columns else {}) | means, {}
    steps = [metrics.assess(run) for _, run in law.steps]
    errors = {key: float(law.error([each[key] for each in steps])) for key in steps[-1]}
    if law.means:
        errors |= dict(zip(QUANTITIES, law.mean_errors().tolist(), strict=True))
    values = steps[-1] | metrics.assess_steps(law.steps) | means
    return values | metrics.assess_variants(law.steps[0][1], **law.variants), errors


def _refinement(law: Reruns) -> str:
    """Return the steps at which the law's values were computed."""
    kind = "settled, " if law.means else ""
    if law.steps:
        return f"{kind}{law.control} {', '.join(f'{step:.3g}' for step, _ in law.steps)}"
    return f"{kind}steps as configured" if kind else "as recorded"


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
    if law.steps and not law.means and run.holds("rotor_velocity"):
        error = law.error([step.columns["rotor_velocity"] for _, step in law.steps])
        columns["rotor_velocity_error"] = "time", error, {"units": "rad s-1", "long_name": "numerical error"}
    data = xarray.Dataset(columns, attrs={"law": law.label})
    # A rotor that a preload presses on the tip is not at rest there.
    pressed = run.settings.get("contact.preload")
    if isinstance(clearance := run.settings.get("contact.clearance"), float) and pressed is None:
        data.attrs["clearance"] = clearance
    if not run.columns:
        return data
    return data.assign_coords(time=("time", run.time, cf_attributes(variables.TIME))).assign_attrs(
        period=law.period
    )


def listed(names: Sequence[str]) -> str:
    """Return a list as in a sentence."""
    if not names:
        return ""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def limits_of(laws: Sequence[Reruns]) -> Iterator[str]:
    """Yield what must be known of the laws before their values, at most a sentence of a kind."""
    moved = {law.label: speed for law in laws if (speed := _unsettled(law)) is not None}
    if moved:
        speeds = listed([f"{speed:.3g} rad/s with {label}" for label, speed in moved.items()])
        yield (
            f"The recorded motor had not settled: in the last quarter of the run it turns at {speeds}. The "
            "settled motor is compared."
        )
    kinds = {law.label: law.means[-1].kind if law.means else NOT_KNOWN for law in laws}
    without = {law.label: law.without for law in laws if law.without and not law.means}
    if without:
        yield (
            f"{listed([*without])}: no steady state; the numbers are those of the recorded run. "
            f"{next(iter(without.values()))}"
        )
    if recorded := [label for label, kind in kinds.items() if kind == NOT_KNOWN and label not in without]:
        yield f"Taken as recorded, so that it is not known whether the motor has settled: {listed(recorded)}."
    if free := [label for label, kind in kinds.items() if kind == WITHOUT_CONTACT]:
        yield f"Settled without contact, so that nothing turns the rotor: {listed(free)}."
    if other := [
        f"{label} ({kind})"
        for label, kind in kinds.items()
        if kind not in (NOT_KNOWN, WITHOUT_CONTACT, PERIODIC)
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
            several.append(f"{law.label} ({', '.join(each)})")
    if several:
        yield f"Several motions, depending on the start: {listed(several)}."


def _unsettled(law: Reruns) -> float | None:
    """Return the velocity of a recorded run where it is not the settled one [rad/s]."""
    if not law.means or not law.run.columns:
        return None
    try:
        recorded = float(METRICS["rotor_velocity"].measure(law.run))
    except NotApplicableError:
        return None
    velocity = float(law.means[-1].values[0])
    return recorded if abs(recorded - velocity) > UNSETTLED * abs(velocity) else None
