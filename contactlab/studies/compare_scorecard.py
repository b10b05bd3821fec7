"""The dataset of a comparison: metrics, energy flow, effects of causes, shares of the variance, motions."""

from collections.abc import Collection, Iterator, Sequence
from math import nan
from typing import Any, Final

import numpy as np
import xarray
from yaml import safe_dump

from contactlab import metrics, variables
from contactlab.arrays import Array
from contactlab.metrics import METRICS, VERDICTS, NotApplicableError, Run
from contactlab.metrics.balances import SPENT, STORED
from contactlab.results.netcdf import cf_attributes
from contactlab.steady_state.means import LONGEST, QUANTITIES
from contactlab.studies.compare_draws import BASIS, Factor, is_scalable, left_fixed, shares
from contactlab.studies.compare_measured import Measured
from contactlab.studies.compare_reruns import Reruns

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

NUMERICAL, PARAMETERS, START = "numerical error", "parameters", "start"
CAUSES: Final = (NUMERICAL, BASIS, PARAMETERS, START)
"""What else than the law could make settled motors differ."""

UNSETTLED: Final = 0.01
"""Relative distance of a recorded velocity from the settled one that is reported."""

FEWEST_DRAWN: Final = 8
"""Motors of a law; another would exceed their range in a ninth of all cases."""

WITHOUT_CONTACT: Final = "without contact"
NOT_KNOWN: Final = "not known"
"""Kinds of motion."""

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
                for name in ("symbol", "units", "meaning", "threshold", "reason")
            },
            "metric_source": ("metric", [metric.source for metric in every]),
            "judges_law": ("metric", np.array([metric.judges_law for metric in every], dtype=np.int8)),
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
    if isinstance(clearance := run.settings.get("contact.clearance"), float):
        data.attrs["clearance"] = clearance
    if not run.columns:
        return data
    return data.assign_coords(time=("time", run.time, cf_attributes(variables.TIME))).assign_attrs(
        period=law.period
    )


def with_causes(
    data: xarray.Dataset,
    laws: Sequence[Reruns],
    factors: Sequence[Factor],
    draws: Array,
    drawn_values: Array,
    ranges: Collection[str],
) -> xarray.Dataset:
    """Add the effect of each cause on settled motors.

    Args:
        data: the scorecard.
        laws: in its order.
        factors: what can be drawn; none where nothing was refined.
        draws: shape (draw, factor); without rows where nothing was drawn.
        drawn_values: shape (law, draw, quantity), NaN where a draw is of another law or has no steady state.
        ranges: keys whose range is an option.

    Returns:
        With `least` and `greatest` over (law, cause, quantity), the range of values due to a cause, NaN where
        it is not known. Of draws `first_order` and `total_order` over (quantity, factor, estimate), the
        table `drawn` over (draw, factor), which all laws share, and `drawn_value` over (law, draw, quantity).
    """
    least = np.full((len(laws), len(CAUSES), len(QUANTITIES)), np.nan)
    greatest = least.copy()
    for number, law in enumerate(laws):
        for cause, change in _changes(law, factors, draws, drawn_values[number]).items():
            # A law without contact has no stick share, and nothing changes it.
            known = np.isfinite(change).any(axis=0)
            value, at = law.means[-1].values[known], CAUSES.index(cause)
            least[number, at, known] = value + np.minimum(np.nanmin(change[:, known], axis=0), 0.0)
            greatest[number, at, known] = value + np.maximum(np.nanmax(change[:, known], axis=0), 0.0)
    three, units = ("law", "cause", "quantity"), {"comment": "units differ by quantity, see `quantity_units`"}
    varied = [
        listed_ranges([f for f in factors if any(is_scalable(law.run, key) for key in f.keys)])
        for law in laws
    ]
    fixed = [listed(left_fixed(law.run, factors, ranges)) if factors else "" for law in laws]
    data = data.assign(
        least=(three, least, {"long_name": "smallest value due to a cause", **units}),
        greatest=(three, greatest, {"long_name": "largest value due to a cause", **units}),
    ).assign_coords(
        cause=list(CAUSES),
        quantity=list(QUANTITIES),
        quantity_units=("quantity", [METRICS[key].units for key in QUANTITIES]),
        kind=("law", [law.means[-1].kind if law.means else NOT_KNOWN for law in laws]),
        varied=("law", varied),
        not_varied=("law", fixed),
    )
    data.attrs["first"] = "\n".join(_first_sentences(laws))
    data.attrs["parameters"] = listed_ranges([f for f in factors if f.keys]) or "nothing"
    if not draws.size:
        return data
    order = ("quantity", "factor", "estimate")
    name = "share of the variance of a quantity, with its 95 % interval: the factor "
    # Each draw is of one law.
    missing = np.isnan(drawn_values).all(axis=0)
    first, total = shares(np.where(missing, np.nan, np.nansum(drawn_values, axis=0)), len(factors))
    return data.assign(
        first_order=(order, first, {"units": "1", "long_name": f"{name}alone"}),
        total_order=(order, total, {"units": "1", "long_name": f"{name}and its interactions"}),
        drawn=(("draw", "factor"), draws, {"comment": "scales of parameters, levels of law, basis and step"}),
        drawn_value=(
            ("law", "draw", "quantity"),
            drawn_values,
            {"long_name": "settled values of draws", **units},
        ),
    ).assign_coords(
        factor=[factor.name for factor in factors],
        spread=("factor", [factor.spread for factor in factors]),
        estimate=["share", "lower", "upper"],
    )


def _changes(law: Reruns, factors: Sequence[Factor], draws: Array, values: Array) -> dict[str, Array]:
    """Return changes of the quantities by cause, shape (change, quantity); a cause may be unknown."""
    if not law.steps or not law.means:
        return {}
    as_configured = law.means[0].values
    error = law.mean_errors()
    changes = {NUMERICAL: np.array([-error, error])}
    elsewhere = [each.values for each in law.states.get(BASIS, ())]
    reached = [each.values for each in law.states.get("starts", ())]
    for cause, values_there in ((BASIS, elsewhere), (START, reached)):
        if values_there:
            changes[cause] = np.array(values_there) - as_configured
    if factors and not any(factor.keys for factor in factors):
        # All parameters are known exactly.
        changes[PARAMETERS] = np.zeros((1, len(QUANTITIES)))
    if draws.size:
        basis = draws[:, [factor.name for factor in factors].index(BASIS)]
        known = ~np.isnan(values).all(axis=1)
        # On each basis, relative to the value there.
        drawn = [
            np.unique(values[(basis == i) & known], axis=0) - nominal
            for i, nominal in enumerate([as_configured, *elsewhere])
        ]
        if sum(map(len, drawn)) >= FEWEST_DRAWN:
            changes[PARAMETERS] = np.concatenate(drawn)
    return changes


def listed_ranges(factors: Sequence[Factor]) -> str:
    """Return factors with their ranges."""
    return ", ".join(f"{factor.name} +-{100.0 * factor.spread:.3g} %" for factor in factors)


def listed(names: Sequence[str]) -> str:
    """Return a list as in a sentence."""
    if not names:
        return ""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def _first_sentences(laws: Sequence[Reruns]) -> Iterator[str]:
    """Yield what must be known of the laws before their values."""
    moved = {law.label: speed for law in laws if (speed := _unsettled(law)) is not None}
    if moved:
        speeds = listed([f"{speed:.3g} rad/s with {label}" for label, speed in moved.items()])
        yield (
            f"The recorded motor had not settled: in the last quarter of the run it turns at {speeds}. The "
            "settled motor is compared."
        )
    for law in laws:
        label, reached = law.label, law.states.get("starts", ())
        kind = law.means[-1].kind if law.means else NOT_KNOWN
        if law.without and not law.means:
            yield f"{label} has no steady state: its numbers are those of the recorded run. {law.without}"
        elif kind == NOT_KNOWN:
            yield f"{label} is taken as recorded: whether its motor has settled is not known."
        elif kind == WITHOUT_CONTACT:
            yield f"{label} settles without contact: nothing turns the rotor."
        elif kind != "periodic":
            yield (
                f"{label} has no periodic motion ({kind}): its values are means over {LONGEST // 2} periods, "
                "with statistical errors."
            )
        if len(reached) > 1 and law.means:
            # Without contact the rotor keeps its initial velocity.
            speeds = listed(
                [x.kind if x.kind == WITHOUT_CONTACT else f"{x.values[0]:.3g} rad/s" for x in reached]
            )
            yield f"{label} settles to several motions, depending on the start: {speeds}."


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
