"""Sweeps from Python: over keys of the configuration, or over arguments of a function that makes motors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np
import pandas
import xarray

from contactlab.checks import check_kind
from contactlab.config import ConfigurationError, Setup
from contactlab.config.composition import compose, options_of
from contactlab.config.nesting import Value
from contactlab.engine.arguments import default_contact_step
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.results.netcdf import cf_attributes
from contactlab.sweeps.answers import Answers
from contactlab.sweeps.batch import Batch, Report, SetupAt
from contactlab.sweeps.dataset import SERIES, Axis, dataset_of
from contactlab.sweeps.plan import USUAL, Configuration, Outputs, Plan, Setups, with_key
from contactlab.sweeps.planning import NOTHING, full_keys, planned, setups_of
from contactlab.sweeps.store import Store
from contactlab.sweeps.values import listed

Over: TypeAlias = Mapping[str, Any] | pandas.DataFrame | Sequence[Mapping[str, Any]]


def sweep(
    over: Over,
    *,
    motor: Callable[..., Motor] | None = None,
    law: ContactLaw | Callable[..., ContactLaw] | str | None = None,
    base: Sequence[str] | Configuration | Setup = (),
    duration: float | None = None,
    record_interval: float | None = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    metrics: Sequence[str] | str = USUAL,
    series: Sequence[str] = (),
    folder: str | Path | None = None,
    workers: int | None = None,
    report: Report | None = None,
) -> xarray.Dataset:
    """Run every combination of values, or every row of a table, and give the metrics of each.

        sweep({"law": ["newton", "hertz_penalty"], "clearance": "linspace(0, 2 um, 50)"}, duration=2e-3)
        sweep({"gap": gaps}, motor=lambda gap: Motor(..., ContactGeometry(clearance=gap)), law=law, ...)

    Every number is that of the run alone to the last bit, whatever the number of workers.

    Args:
        over: values by name. Names are keys of the configuration, 'contact.clearance' or 'clearance', or
            groups of it, 'law'; with `motor` they are the arguments of functions. Values are a list, an
            array (a DataArray brings its unit), or a text as on the command line. A table, a DataFrame
            or a list of mappings, has a run in each row.
        motor: makes the motor; what it raises makes the run a failed one.
        law: what acts between tip and rotor, or with `motor` a function that makes it; the name of one
            without.
        base: what all runs have, as overrides, as a configuration or as a setup.
        duration, record_interval: [s]; without `motor` that of `base` where they are not given, with it
            None keeps but the last record, which `USUAL` and all of `AT_ANY_INTERVAL` are content with.
        contact_step, tolerance: as for `contactlab.engine.simulate`.
        metrics: keys of `contactlab.metrics.METRICS`, or 'all'.
        series: names of `contactlab.variables.SERIES` that are kept whole, each as NAME_series.
        folder: where chunks are kept as they are finished, so that the same sweep goes on where it was
            stopped; not with `motor`, since of a function nobody can tell whether it is the same.
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
    solver = {
        "solver.duration": duration,
        "record.interval": record_interval,
        "solver.contact_step": contact_step,
        "solver.tolerance": tolerance,
    }
    if motor is None:
        if law is not None and not isinstance(law, str):
            raise TypeError(
                "The law is an object and there is no function that makes motors; it must be a name then, "
                "and its parameters keys: base=['law.restitution=0.4']. Or give motor=."
            )
        given = {key: value for key, value in solver.items() if value is not None}
        composer = ScriptComposer(base, law, given)
        plan = planned(composer, full_keys(columns, composer), outputs, samples=samples)
        if samples:
            for _ in setups_of(plan):
                pass
        if folder is not None:
            return _stored(Store(Path(folder), plan), workers, report)
        axes, shape = plan.axes, plan.shape
        setup_at: SetupAt = Setups(plan)
    else:
        if folder is not None or not isinstance(base, tuple) or duration is None or law is None:
            raise ValueError(
                "A function makes the motors; there must be a law and a duration beside it, and neither a "
                "base nor a folder, which are for sweeps over keys of the configuration."
            )
        axes = tuple(Axis(name, tuple(columns[name]), units[name]) for name in columns)
        shape, setup_at = _made(axes, samples, motor, law, solver, outputs)
    with Batch(setup_at, outputs, workers, report) as batch:
        answers = batch.answers(range(int(np.prod(shape))))
    return _dataset(axes, shape, samples, outputs, answers)


def _values(given: Any) -> list[Value]:
    """Give the values of one parameter: as listed, or as a text spells them."""
    if isinstance(given, str):
        return [*listed(given)]
    if np.ndim(given) > 1:
        raise ValueError("The values of a parameter are a table; they must be a list. Give a row.")
    return list(np.atleast_1d(given).tolist())


def _stored(store: Store, workers: int | None, report: Report | None) -> xarray.Dataset:
    """Run what is missing of a sweep in a folder."""
    store.begin()
    store.run_missing(workers, report)
    return store.merge()


def _made(
    axes: Sequence[Axis],
    samples: bool,
    motor: Callable[..., Motor],
    law: ContactLaw | Callable[..., ContactLaw] | str,
    solver: Mapping[str, float | None],
    outputs: Outputs,
) -> tuple[tuple[int, ...], SetupAt]:
    """Give the shape of a sweep over the arguments of functions, and what runs in each cell."""
    empty = [axis.key for axis in axes if not axis.values]
    if empty:
        raise ValueError(
            f"{', '.join(empty)} has no values; there must be one at least of every parameter. Give a list "
            "or an array of numbers."
        )
    if not callable(law):
        check_kind("The law", law, ContactLaw)
    duration, interval = solver["solver.duration"], solver["record.interval"]
    assert duration is not None
    if outputs.sampled and interval is None:
        raise ValueError(
            "The record interval is None; series, and metrics beyond "
            "contactlab.sweeps.plan.AT_ANY_INTERVAL, need records. Give a record_interval in seconds."
        )
    plan = Plan(tuple(axes), (), ((),), ({},), samples, outputs, 1, "")

    def setup_at(cell: int) -> Setup:
        point = plan.point(cell)
        acting = law if isinstance(law, ContactLaw) else law(**point)  # type: ignore[operator]
        made = motor(**point)
        step = solver["solver.contact_step"]
        return Setup(
            motor=made,
            law=acting,
            duration=duration,
            record_interval=interval or duration,
            contact_step=default_contact_step(made.modes, acting) if step is None else step,
            tolerance=solver["solver.tolerance"],
            configuration=_facts(made, acting),
        )

    return plan.shape, setup_at


def _facts(motor: Motor, law: ContactLaw) -> dict[str, Any]:
    """Give what the metrics ask of the configuration, where there is none but the motor itself."""
    facts: dict[str, Any] = {
        "law": {"name": law.name, **law.describe()},
        "rotor": {"radius": motor.geometry.rotor_radius, **asdict(motor.rotor)},
        "contact": {"clearance": motor.geometry.clearance},
    }
    if motor.drive.frequency.size:
        facts["drive"] = {"frequency": float(motor.drive.frequency[0])}
    if (friction := law.describe().get("friction_coefficient")) is not None:
        facts["contact"]["friction_coefficient"] = friction
    return facts


def _dataset(
    axes: Sequence[Axis],
    shape: tuple[int, ...],
    samples: bool,
    outputs: Outputs,
    answers: Answers,
) -> xarray.Dataset:
    dataset = dataset_of(
        axes,
        dict(zip(outputs.metrics, answers.metrics.T.reshape(-1, *shape), strict=True)),
        answers.status.reshape(shape),
        np.array(answers.reason, dtype=object).reshape(shape),
        {},
        grid=not samples,
    )
    dims = dataset["status"].dims
    for name, rows in answers.series.items():
        shaped = rows.reshape(*shape, answers.time.size)
        dataset[f"{name}_series"] = ((*dims, "time"), shaped, cf_attributes(SERIES[name]))
    return dataset.assign_coords(time=answers.time) if outputs.series else dataset


@final
class ScriptComposer:
    """Composes configurations from what a script gives; see `planning.Composer`.

    Args:
        base: overrides, a configuration or a setup.
        law: a name; None for that of the base.
        given: values by key that all runs have.
    """

    def __init__(
        self,
        base: Sequence[str] | Configuration | Setup,
        law: str | None = None,
        given: Mapping[str, float] | None = None,
    ) -> None:
        self._base = base.configuration if isinstance(base, Setup) else base
        self._law = law
        self._given = given or {}
        if isinstance(self._base, str):
            raise TypeError(
                f"The base is the text {self._base!r}; it must be a list of overrides or a mapping. Write "
                f"[{self._base!r}]."
            )

    def options(self, key: str) -> list[str]:
        """Give the options of a group; none for what is no group."""
        return options_of(key)

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set.

        Raises:
            ConfigurationError: it cannot be composed.
        """
        options = {"law": self._law} if self._law else {}
        lines = [f"{group}={option}" for group, option in {**options, **chosen}.items()]
        if isinstance(self._base, Mapping):
            found: Configuration = dict(self._base)
            if lines:
                composed = compose(lines)
                for group in {**options, **chosen}:
                    top = group.partition("/")[0]
                    found = {**found, top: composed[top]}
        else:
            found = compose([*self._base, *lines])
        for key, value in self._given.items():
            found = with_key(found, key.split("."), value)
        return {name: section for name, section in found.items() if name != "sweep"}

    def resolve(self, configuration: Configuration) -> Configuration:
        """Give the configuration itself: `compose` leaves no references.

        Raises:
            ConfigurationError: there are some.
        """
        if "${" in str(configuration):
            raise ConfigurationError(
                ["The configuration has references in ${...}. Write the values."]
            )
        return configuration
