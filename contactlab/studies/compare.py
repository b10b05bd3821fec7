"""The study `compare`: contact laws in one motor, and the causes of their differences."""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from itertools import starmap
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup, build
from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.metrics import REPORTED, VERDICTS, Run
from contactlab.motor import Motor
from contactlab.processes import processors
from contactlab.simulation import Solution
from contactlab.steady_state.means import QUANTITIES
from contactlab.steady_state.search import steady_setup
from contactlab.studies.compare_causes import findings, sample_count, unclear, written_share
from contactlab.studies.compare_draws import LAW, Factor, configurations_of, drawn, factors_of
from contactlab.studies.compare_measured import (
    Measurement,
    check_motor,
    do_prediction,
    measured_rows,
    read_all,
    with_measurements,
)
from contactlab.studies.compare_reruns import Reruns, do_draw, do_rerun, do_starts, means_in, reruns_of
from contactlab.studies.compare_runs import (
    ComparisonError as ComparisonError,
    Source,
    labelled,
    read_runs,
    run_of_setup,
    unchecked,
)
from contactlab.studies.compare_scorecard import motion, scorecard, with_causes
from contactlab.studies.runner import finish, run
from contactlab.studies.study import Result, Setups, Study, Task, option
from contactlab.studies.tables import UNIT, table

SAMPLES: Final = 32
"""Rows of the design of draws, which take a minute or two for three laws."""

STARTS: Final = 6


@dataclass(frozen=True, kw_only=True)
class Compare(Study):
    """By how much do contact laws differ in one motor, and is the law the cause?

    Laws are chosen by law=A,B, or are those of recorded runs: DIR..., folders of runs, their run.nc, or
    folders of such folders, of one motor with one drive. The motors are compared once they have settled. A
    difference is an effect of the law only if it exceeds the effects of numerical error, basis of the
    resonator, parameters within their ranges, and initial conditions.
    """

    name: ClassVar[str] = "compare"
    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = ("record.picture", "sweep")
    delay: ClassVar[float] = 10.0
    patterns: ClassVar[Mapping[str, re.Pattern[str]]] = {
        # A folder of a sweep is named by its overrides: two/law=newton.
        "runs": re.compile(r"(?!-)[^=]+|(?![-+~]|law/|hydra/)[^=]*/.*")
    }

    runs: Annotated[list[str] | None, option("folders or files of recorded runs")] = None
    refine: Annotated[bool, option("whether the effects of all other causes are computed")] = True
    transient: Annotated[
        bool, option("whether runs are compared from their start on, not settled motors")
    ] = False
    samples: Annotated[
        int, option("rows of the design of draws, a power of two; 0 draws nothing", at_least=0)
    ] = SAMPLES
    starts: Annotated[int, option("initial conditions of each law", at_least=1)] = STARTS
    range: Annotated[
        list[str] | None, option("half the range of parameters over their values: KEY=SHARE,...; 0 is exact")
    ] = None
    measured: Annotated[list[str] | None, option("files of measured impacts or series")] = None
    workers: Annotated[int, option("processes at work", at_least=1)] = processors()

    @cached_property
    def recorded(self) -> list[Run]:
        """The recorded runs; `compare` sets those in memory."""
        return labelled(read_runs(self.runs or ()), transient=self.transient)

    @cached_property
    def measurements(self) -> list[Measurement]:
        """The files of measurements."""
        return read_all(self.measured or ())

    @cached_property
    def ranges(self) -> dict[str, float]:
        """Half the range of parameters over their values, by full key."""
        pairs = [text.partition("=") for text in self.range or ()]
        try:
            return {key.strip(): float(share) for key, _, share in pairs}
        except ValueError:
            raise ComparisonError(
                [f"study.range is {self.range}; it must be KEY=SHARE, as contact.clearance=0.1."]
            ) from None

    def put_to(self, setups: Setups) -> Setups:
        """Return the setups of the laws by label: those of the recorded runs, if there are any.

        Raises:
            ComparisonError: runs or setups cannot be compared.
            ConfigurationError: overrides stand beside recorded runs.
        """
        if self.samples & (self.samples - 1):
            raise ComparisonError([f"study.samples is {self.samples}; it must be a power of two, or 0."])
        if not self.recorded:
            if not setups:
                raise ComparisonError(["There is nothing to compare; there must be a run or a setup."])
            laws = labelled([*starmap(run_of_setup, setups.items())], transient=self.transient)
            return {law.label: setup for law, setup in zip(laws, setups.values(), strict=True)}
        if any(setup.configuration != build().configuration for setup in setups.values()):
            raise ConfigurationError(
                ["Recorded runs have configurations of their own; other keys must be left out beside them."]
            )
        return {law.label: setup for law in self.recorded if (setup := _built(law))}

    def laws(self, setups: Setups) -> list[Run]:
        """Return the laws in their order: as recorded, or without records."""
        return self.recorded or [
            replace(run_of_setup(label, setup), label=label) for label, setup in setups.items()
        ]

    def factors(self, setups: Setups) -> tuple[Factor, ...]:
        """Return what can be drawn; nothing where a setup was made in Python and has no configuration."""
        whole = all("resonator" in setup.configuration for setup in setups.values())
        if not (self.refine and not self.transient and setups and whole):
            return ()
        return factors_of([*starmap(run_of_setup, setups.items())], self.ranges)

    def _plan(self, setups: Setups) -> dict[str, dict[str, Task]]:
        """Return the tasks of each law by what they do: a rerun, "starts", the digest of a measurement."""
        plan: dict[str, dict[str, Task]] = {}
        recorded = {law.label: law for law in self.laws(setups)}
        for label, setup in setups.items():
            tasks = plan[label] = {}
            if not (self.transient and not self.refine and recorded[label].columns):
                period = recorded[label].period or 0.1 * setup.duration
                for name, _, rerun in reruns_of(setup, refine=self.refine):
                    key = _key(label, f"{name} {'transient' if self.transient else ''}", rerun)
                    tasks[name] = Task(key, do_rerun, (rerun, self.transient, period))
            if self.refine and self.starts > 1 and not self.transient:
                tasks["starts"] = Task(_key(label, "starts", setup), do_starts, (setup, self.starts))
            for measurement in self.measurements:
                check_motor(measurement, setup)
                key = _key(label, measurement.digest, setup)
                tasks[measurement.digest] = Task(key, do_prediction, (setup, measurement.data))
        return plan

    def _draws(self, setups: Setups) -> tuple[Array, list[Task]]:
        """Return the table of draws and the task of each; draws of equal configurations have one task."""
        factors = self.factors(setups)
        if not (factors and self.samples):
            return np.empty((0, len(factors))), []
        draws = drawn(factors, self.samples)
        configurations = configurations_of([*setups.values()], factors, draws)
        return draws, [Task(_key("draw", "", each), do_draw, (each,)) for each in configurations]

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return reruns, other starts and predictions of measurements of each law, and the draws.

        Raises:
            ComparisonError, ConfigurationError: files or options cannot be used.
        """
        every = [task for tasks in self._plan(setups).values() for task in tasks.values()]
        return [*every, *{task.key: task for task in self._draws(setups)[1]}.values()]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the scorecard with the effects of causes; the group motion_N is that of the N-th law."""
        plan = self._plan(setups)
        laws = [Reruns(law) for law in self.laws(setups)]
        for law in laws:
            if setup := setups.get(law.label):
                own = {name: parts[task.key] for name, task in plan[law.label].items()}
                law.add(setup, own, transient=self.transient, refine=self.refine)
            else:
                law.notes.append(f"{law.label} is taken as recorded; its configuration does not build.")
        marks = [f"_{n}" if len(self.measurements) > 1 else "" for n in range(1, len(self.measurements) + 1)]
        measured = [
            measured_rows(
                measurement,
                [law.label for law in laws],
                {label: parts[tasks[measurement.digest].key] for label, tasks in plan.items()},
                mark,
            )
            for measurement, mark in zip(self.measurements, marks, strict=True)
        ]
        notes = [*unchecked(self.recorded), *(note for each in measured for note in each.notes)]
        data = scorecard(laws, notes, measured)
        if not self.transient:
            factors, (draws, tasks) = self.factors(setups), self._draws(setups)
            every = {task.key: parts[task.key] for task in tasks}
            if failures := [part.attrs["failure"] for part in every.values() if "failure" in part.attrs]:
                data.attrs["notes"] += (
                    f"\n{len(failures)} of {len(every)} draws have no steady state: {failures[0]}"
                )
            # Shape (law, draw, quantity), NaN where a draw is of another law.
            values = np.full((len(laws), len(tasks), len(QUANTITIES)), np.nan)
            names = [factor.name for factor in factors]
            places = draws[:, names.index(LAW)].astype(int) if LAW in names else np.zeros(len(tasks), int)
            order = [[law.label for law in laws].index(label) for label in setups]
            for number, (task, place) in enumerate(zip(tasks, places, strict=True)):
                if "failure" not in every[task.key].attrs:
                    values[order[place], number] = means_in(every[task.key])[0].values
            data = with_causes(data, laws, factors, draws, values, self.ranges)
        data = with_measurements(data, measured)
        return xarray.DataTree(
            data, {f"motion_{n}": xarray.DataTree(motion(law)) for n, law in enumerate(laws, 1)}
        )

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the rotor velocity of each law with its error."""
        key = "rotor_velocity" if "cause" in data.dims else "final_rotor_velocity"
        every = data.to_dataset().sel(metric=key)
        return {
            str(law): Estimate(
                float(every["value"].sel(law=law)), float(every["numerical_error"].sel(law=law))
            )
            for law in every["law"].values
        }

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the differences with their causes, and failed thresholds."""
        return findings(data.to_dataset())

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return scorecard, shares of the variance, files of measurements, and definitions of the metrics."""
        every = data.to_dataset()
        tables = {"scorecard": _scorecard_table(every)}
        if "total_order" in every:
            tables["shares"] = _shares_table(every)
        if "measured" in every.dims:
            names = {"title": "measured", "contents": "measured_contents", "source": "measured_source"}
            names |= {"file": "measured_file", "SHA-256": "measured_digest"}
            caption = "Measurements; the errors of their rows are half of a 95 % interval by resampling"
            columns = {head: every[name].values for head, name in names.items()}
            tables["measurements"] = table(columns, caption=caption)
        names = {"metric": "metric", "symbol": "symbol", "unit": "units", "meaning": "meaning"}
        names |= {"must be": "threshold", "reason": "reason", "source": "metric_source"}
        columns = {head: every[name].values for head, name in names.items() if head != "unit"}
        tables["metrics"] = table(columns, caption="Definitions of the metrics")
        tables["metrics"].attrs["reference"] = True
        return tables

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return effects of causes and shares, or velocities of transients; forces, paths, energy, phases."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.compare_figures import draw_all

        return draw_all(data)


def _built(law: Run) -> Setup | None:
    try:
        return build(law.configuration) if law.configuration else None
    except ConfigurationError:
        return None


def _key(label: str, name: str, subject: Setup | Mapping[str, Any]) -> str:
    configuration = subject.configuration if isinstance(subject, Setup) else subject
    digest = sha256(json.dumps(configuration, sort_keys=True, default=str).encode()).hexdigest()
    return f"{label} {name} {digest[:16]}"


def _scorecard_table(data: xarray.Dataset) -> pandas.DataFrame:
    """Return a row for each metric: value, error and verdict of each law."""
    rows = []
    for key in map(str, data["metric"].values):
        here = data.sel(metric=key)
        row: dict[str, Any] = {
            "metric": key,
            UNIT: str(here["units"].item()),
            "must be": str(here["threshold"].item()),
        }
        for law in map(str, data["law"].values):
            cell = here.sel(law=law)
            verdict = VERDICTS[int(cell["verdict"])]
            row[law] = Estimate(float(cell["value"]), float(cell["numerical_error"]))
            row[f"{law}: verdict"] = "" if verdict == REPORTED else verdict
        rows.append(row)
    return table(rows, caption="Scorecard")


def _shares_table(data: xarray.Dataset) -> pandas.DataFrame:
    """Return the shares of the factors in the variance of the settled velocity."""
    here = data.sel(quantity="rotor_velocity")
    inconclusive = f"{sample_count(data)} samples are inconclusive"
    columns: dict[str, Any] = {"factor": data["factor"].values}
    for head, name in (("alone", "first_order"), ("with interactions", "total_order")):
        columns[head] = [
            inconclusive if unclear(*estimate[1:]) else written_share(*estimate)
            for estimate in here[name].values
        ]
    caption = (
        f"Shares in the variance of the settled rotor velocity over {data.sizes['draw']} draws: laws, bases "
        f"and steps of equal probability, {data.attrs['parameters']}"
    )
    return table(columns, caption=caption)


def compare(
    sources: Source | Setup | Motor | Sequence[Source | Setup],
    law: ContactLaw | Sequence[ContactLaw] | None = None,
    *,
    output: str | Path | None = None,
    ranges: Mapping[str, float] | None = None,
    measured: Sequence[str | Path] = (),
    **options: Any,
) -> Result:
    """Compare contact laws in one motor: the study `Compare`.

        >>> import contactlab as cl
        >>> setups = [cl.build([f"law={law}"]) for law in ("newton", "hertz_penalty")]
        >>> runs = [cl.simulate(setup, duration=5e-4) for setup in setups]
        >>> result = cl.compare(runs, refine=False, transient=True)
        >>> result["value"].sel(metric="contact_count").to_series().to_dict()
        {'newton': 2.0, 'hertz_penalty': 2.0}

    Args:
        sources: setups; or recorded runs: folders, their datasets, folders of such folders, runs in memory;
            or a motor made in Python.
        law: one or several, of that motor.
        output: folder for the files; None writes none.
        ranges: half the range of a parameter over its value, by full key, in place of what the section
            `uncertainty` of the runs states; 0 is exact.
        measured: files of measured impacts or series, which the laws predict with their parameters.
        options: fields of `Compare`.

    Returns:
        Values, verdicts and numerical errors over the dimensions `law` and `metric`, the energy flow over
        `law` and `term`, and the effects of all causes, see `compare_scorecard.with_causes`.

    Raises:
        ComparisonError: the laws cannot be compared.
        OSError: the folder cannot be written to.
    """
    study = Compare(
        range=[f"{key}={share}" for key, share in (ranges or {}).items()] or None,
        measured=[str(path) for path in measured] or None,
        **options,
    )
    setups: dict[str, Setup] = {}
    if isinstance(sources, Motor):
        laws: Any = law if isinstance(law, Sequence) else [] if law is None else [law]
        setups = {f"law {n}": steady_setup(sources, each) for n, each in enumerate(laws, 1)}
    elif law is not None:
        raise TypeError("A law is given with a motor only; runs and setups have their own.")
    else:
        single = str | Path | Solution | xarray.DataTree | Setup
        every: list[Any] = [sources] if isinstance(sources, single) else list(sources)
        setups = {f"setup {n}": each for n, each in enumerate(every, 1) if isinstance(each, Setup)}
        if setups and len(setups) < len(every):
            raise ComparisonError(["There are setups and recorded runs; there must be one kind."])
        if not setups:
            # The cached property that reads the option `runs`.
            study.__dict__["recorded"] = labelled(read_runs(every), transient=study.transient)
    folder = None if output is None else Path(output)
    result = run(study, setups, folder)
    if folder is not None:
        finish(result, folder)
    return result
