"""Sweeps from Python: over keys of the configuration, or over arguments of a function that makes motors."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
import pandas
import xarray

from contactlab.checks import check_kind
from contactlab.config import ConfigurationError, Setup, build
from contactlab.config.composition import compose, options_of
from contactlab.config.groups import NOT_OF_A_RUN
from contactlab.config.nesting import Value
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.simulation import KEYS, setup_of, variable_numbers, with_number
from contactlab.sweeps.batch import Batch, Outputs, Report, SetupAt
from contactlab.sweeps.dataset import Axis, dataset_of
from contactlab.sweeps.plan import NOTHING, Columns, Configuration, Plan, full_keys, planned, with_key
from contactlab.sweeps.store import Store
from contactlab.sweeps.values import in_si, listed, spread

Over: TypeAlias = Mapping[str, Any] | pandas.DataFrame | Sequence[Mapping[str, Any]]


def sweep(
    over: Over,
    *,
    motor: Callable[..., Motor] | None = None,
    law: ContactLaw | Callable[..., ContactLaw] | str | None = None,
    base: Sequence[str] | Configuration | Setup | Motor = (),
    duration: float | None = None,
    record_interval: float | None = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    metrics: Sequence[str] | str | None = None,
    series: Sequence[str] = (),
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Report | None = None,
) -> xarray.Dataset:
    """Run every combination of values, or every row of a table, and give the metrics of each.

        >>> values = {"law": ["newton", "hertz_penalty"], "clearance": "linspace(0, 2 um, 3)"}
        >>> dict(sweep(values, duration=1e-3, workers=1).sizes)
        {'law': 2, 'clearance': 3}

    A motor and a law made in Python have numbers of their own that vary, those of contact, rotor and law:

        >>> import contactlab as cl
        >>> ball, law = cl.ball(1e-3, height=1e-4), cl.Newton(restitution=0.5)
        >>> found = sweep({"law.restitution": [0.4, 0.6]}, base=ball, law=law, duration=0.02, workers=1)
        >>> found["law_restitution"].values
        array([0.4, 0.6])

    With a function that makes the motor anything may vary:

        sweep({"gap": gaps}, motor=lambda gap: Motor(..., ContactGeometry(clearance=gap)), law=law, ...)

    Every number is that of the run alone to the last bit, whatever the number of workers.

    Args:
        over: values by name: a key of the configuration, 'contact.clearance' or 'clearance', or a group
            of it, 'law'; with `motor` an argument of functions. Values are a list, an array (a DataArray
            brings its unit), or a text as on the command line. A table, a DataFrame or a list of mappings,
            has a run in each row.
        motor: makes the motor; what it raises makes the run a failed one.
        law: its name; with `motor` what acts between tip and rotor, or a function that makes it; with a motor
            as base what acts.
        base: what all runs have, as overrides, as a configuration, as a setup or as a motor made in Python.
        duration, record_interval: [s]; those of `base` where they are not given. With `motor` no interval
            keeps but the last record, with which all metrics are content that need no records.
        contact_step, tolerance: as for `contactlab.engine.simulate`.
        metrics: keys of `contactlab.metrics.METRICS`, or 'all'; None is those that cost next to nothing.
        series: names of `contactlab.variables.SERIES` that are kept whole, each as NAME_series; and
            internal_NAME of what a law remembers, NaN under laws that do not.
        folder: where chunks are kept as they are finished, so that the same sweep goes on where it was
            stopped; for sweeps over keys of the configuration alone, as of a function or a motor made in
            Python nobody can tell whether it is the same.
        workers: processes at work; None is one a processor.
        report: told now and then how many runs have ended.

    Returns:
        The metrics over the parameters, or over `run` for a table, with `status` (see `Status`) and
        `reason` of every run; one that did not reach its end has NaN.

    Raises:
        ConfigurationError: values, with every fault that was found.
        TypeError, ValueError: arguments that do not fit, in a sentence.
        SweepError: the folder holds another sweep.
        WorkerError: a worker process died.
    """
    samples = not isinstance(over, Mapping)
    table: Any = pandas.DataFrame(over) if samples else over
    columns = {str(name): _values(table[name]) for name in table}
    units = {name: str(getattr(table[name], "attrs", {}).get("units", "")) for name in columns}
    if not columns:
        raise ValueError(NOTHING)
    outputs = Outputs.named(metrics, series)
    numbers = (duration, record_interval, contact_step, tolerance)
    solver = {name: x for name, x in zip(KEYS, numbers, strict=True) if x is not None}
    if isinstance(base, Motor):
        if folder is not None or motor is not None or duration is None:
            raise ValueError(
                "The base is a motor made in Python; there must be a law and a duration beside it, and "
                "neither a folder nor a function that makes motors."
            )
        made = setup_of(base, law, solver)
        plan = Plan(axes=_axes_of_numbers(made, columns, samples), samples=samples, outputs=outputs)
        outputs = outputs.of_laws([made.law])
        setup_at: SetupAt = partial(_with_numbers, plan, made)
        # Every value is checked before the first run.
        for cell in range(plan.cells):
            setup_at(cell)
    elif motor is None:
        composer = ScriptComposer(base, law, solver)
        plan = planned(composer, full_keys(columns, composer), outputs, samples=samples)
        outputs = plan.outputs
        setup_at = plan.setup_at
    else:
        if folder is not None or not isinstance(base, tuple) or duration is None or law is None:
            raise ValueError(
                "A function makes the motors; there must be a law and a duration beside it, and neither a "
                "base nor a folder, which are for sweeps over keys of the configuration."
            )
        axes = tuple(Axis(name, tuple(columns[name]), units[name]) for name in columns)
        plan = Plan(axes=axes, samples=samples, outputs=outputs)
        _refuse(plan, law, record_interval)
        outputs = outputs.of_laws(_laws(plan, law))
        setup_at = partial(_setup, plan, motor, law, solver)
    if folder is not None:
        store = Store(Path(folder), plan)
        store.begin()
        store.run_missing(workers, report)
        return store.merge()
    with Batch(setup_at, outputs, workers, report) as batch:
        answers = batch.answers(range(plan.cells))
    return dataset_of(plan.axes, answers, samples=samples, series=outputs.kept)


def _refuse(plan: Plan, law: object, record_interval: float | None) -> None:
    """Refuse what no function can make runs of."""
    if empty := [axis.key for axis in plan.axes if not axis.values]:
        raise ValueError(
            f"{', '.join(empty)} has no values; there must be one at least of every parameter. Give a list "
            "or an array of numbers."
        )
    if not callable(law):
        check_kind("The law", law, ContactLaw)
    if plan.outputs.sampled and record_interval is None:
        raise ValueError(
            "The record interval is None; series, and metrics that are of more than the contacts and the "
            "end, need records. Give a record_interval in seconds."
        )


def _laws(plan: Plan, law: Any) -> Iterator[ContactLaw]:
    """Give the laws at both ends of a sweep; what a function raises there its runs tell."""
    for cell in (0, plan.cells - 1):
        with suppress(Exception):
            yield law(**plan.point(cell)) if callable(law) else law


def _setup(plan: Plan, motor: Callable[..., Motor], law: Any, solver: dict[str, Any], cell: int) -> Setup:
    """Make what runs in a cell by functions of its values."""
    point = plan.point(cell)
    return setup_of(motor(**point), law(**point) if callable(law) else law, solver)


def _axes_of_numbers(setup: Setup, columns: Columns, samples: bool) -> tuple[Axis, ...]:
    """Return the axes of a sweep over numbers of a motor made in Python, by full key or its last part.

    Raises:
        ConfigurationError: a last part that several numbers have, or a number that is swept twice.
    """
    numbers, axes = variable_numbers(setup), list[Axis]()
    keys: dict[tuple[str, ...], str] = {}
    for name, column in columns.items():
        ends = [name] if name in numbers else [key for key in numbers if key.rpartition(".")[2] == name]
        # The friction coefficient that laws share has a key of the contact beside that of its law.
        different = {numbers[key][0]: key for key in reversed(ends)}
        if len(different) > 1:
            raise ConfigurationError([f"{name} may be {' or '.join(ends)}. Name one of them."])
        path, key = next(iter(different.items()), ((name,), name))
        if path in keys:
            raise ConfigurationError([f"{key} is swept by two names, {name} one of them. Leave one out."])
        keys[path] = key
        said = numbers[key][1].parameter if key in numbers else None
        units, meaning = (said.units, said.meaning) if said else ("", "")
        values = column if samples else [x for value in column for x in spread(key, value, units)]
        axes.append(Axis(key, tuple(in_si(value, units) for value in values), units, meaning))
    return tuple(axes)


def _with_numbers(plan: Plan, setup: Setup, cell: int) -> Setup:
    """Return what runs in a cell over numbers of a motor made in Python."""
    for key, value in plan.point(cell).items():
        setup = with_number(setup, key, value)
    return setup


def _values(given: Any) -> list[Value]:
    """Give the values of one parameter: as listed, or as a text spells them."""
    if isinstance(given, str):
        return [*listed(given)]
    if np.ndim(given) > 1:
        raise ValueError("The values of a parameter are a table; they must be a list. Give a row.")
    return list(np.atleast_1d(given).tolist())


@final
class ScriptComposer:
    """Composes configurations over a base, with a law by its name and values by `contactlab.simulation.KEYS`.

    See `plan.Composer`.
    """

    options = staticmethod(options_of)
    build = staticmethod(build)

    def __init__(
        self,
        base: Sequence[str] | Configuration | Setup,
        law: object = None,
        solver: Mapping[str, float] | None = None,
    ) -> None:
        self._base = base.configuration if isinstance(base, Setup) else base
        self._chosen = {} if law is None else {"law": law}
        self._solver = solver or {}
        if isinstance(self._base, str):
            raise TypeError(
                f"The base is the text {self._base!r}; it must be a list of overrides or a mapping. Write "
                f"[{self._base!r}]."
            )
        if not isinstance(law, str | None):
            raise TypeError(
                "The law is an object and there is no function that makes motors; it must be a name then, "
                "and its parameters keys: base=['law.restitution=0.4']. Or give motor=."
            )

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set."""
        options = {**self._chosen, **chosen}
        lines = [f"{group}={option}" for group, option in options.items()]
        if isinstance(self._base, Mapping):
            composed, tops = compose(lines), {group.partition("/")[0] for group in options}
            found: Configuration = {**self._base, **{top: composed[top] for top in tops}}
        else:
            found = compose([*self._base, *lines])
        for name, value in self._solver.items():
            found = with_key(found, ".".join(KEYS[name]), value)
        return {name: section for name, section in found.items() if name not in NOT_OF_A_RUN}
