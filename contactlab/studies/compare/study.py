"""The study `compare`: contact laws in one motor, in pairs."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from math import isclose
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, final

import numpy as np
import pandas
import xarray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup, build, rebuild
from contactlab.config.nesting import flat, nested
from contactlab.estimate import Estimate
from contactlab.inference.calibration import Datum, calibrated
from contactlab.inference.paired import INCONCLUSIVE, looks_up_to
from contactlab.laws import ContactLaw, MultiplierLaw
from contactlab.metrics import Run
from contactlab.metrics.convergence import FINER, control_of
from contactlab.motor import Motor
from contactlab.processes import processors
from contactlab.simulation import Solution
from contactlab.steady_state.search import steady_setup
from contactlab.studies.compare.draws import (
    LEVELS,
    POSTERIOR,
    Factor,
    Posteriors,
    as_configured,
    configuration_of,
    drawn,
    factors_of,
    left_fixed,
)
from contactlab.studies.compare.findings import findings
from contactlab.studies.compare.measured import (
    Measurement,
    check_motor,
    do_prediction,
    measured_rows,
    read_all,
    with_measurements,
)
from contactlab.studies.compare.observables import OBSERVABLES, USUAL, do_draw
from contactlab.studies.compare.pairs import Settled, signs_of, verdicts_of, with_pairs
from contactlab.studies.compare.reruns import Reruns, do_rerun, do_starts, reruns_of
from contactlab.studies.compare.runs import (
    ComparisonError as ComparisonError,
    Grid,
    Source,
    grid_of,
    labelled,
    read_runs,
    run_of_setup,
    unchecked,
)
from contactlab.studies.compare.scorecard import limits_of, listed, motion, scorecard
from contactlab.studies.compare.tables import tables
from contactlab.studies.study import Progress, Result, Setups, Study, Task, option

SAMPLES: Final = 64
"""Draws at most, which take a minute or two for three laws."""

STARTS: Final = 6
_WORD: Final = re.compile(r"(?!(?:law|law/\w+)=)[\w.]+=[^,\[(]*(?:\.\.|\+-).*")
"""KEY=LOW..HIGH, KEY=MEAN+-DEVIATION, KEY=+-SHARE."""


@dataclass(frozen=True, kw_only=True)
class Compare(Study):
    """Does the difference of contact laws survive where the motor is not exactly known?

    Laws are chosen by law=A,B, or are those of recorded runs: DIR..., folders of runs, their run.nc, or
    folders of such folders, of one motor with one drive. Other listed values, drive.phase=-1,0,1, are
    operating points. The motors are compared once they have settled, in pairs: a draw of all that is
    uncertain serves every law, so that a difference within it is the law's. KEY=LOW..HIGH,
    KEY=MEAN+-DEVIATION and KEY=+-SHARE state what is uncertain, beside friction, contact stiffness,
    clearance, basis and start. Draws continue until the order of each pair is known, or `samples` are spent.
    """

    name: ClassVar[str] = "compare"
    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = ("record.picture", "solver.changes")
    delay: ClassVar[float] = 10.0
    patterns: ClassVar[Mapping[str, re.Pattern[str]]] = {
        # A folder of a sweep is named by its overrides: two/law=newton.
        "vary": _WORD,
        "runs": re.compile(r"(?!-)[^=]+|(?![-+~]|law/|hydra/)[^=]*/.*"),
    }

    runs: Annotated[list[str] | None, option("folders or files of recorded runs")] = None
    refine: Annotated[bool, option("whether numerical errors, draws and starts are computed")] = True
    transient: Annotated[
        bool, option("whether runs are compared from their start on, not settled motors")
    ] = False
    samples: Annotated[
        int, option("draws at most, a power of two; 0 draws nothing", at_least=0, at_most=100_000)
    ] = SAMPLES
    starts: Annotated[int, option("initial conditions of each law", at_least=1, at_most=1000)] = STARTS
    vary: Annotated[
        list[str] | None,
        option("what is uncertain: KEY=LOW..HIGH, KEY=MEAN+-DEVIATION, KEY=+-SHARE; +-0 is exact"),
    ] = None
    posterior: Annotated[
        str | None, option("file of a fit, whose posteriors the laws' numbers are drawn from")
    ] = None
    calibrate: Annotated[
        str | None, option("datum of all laws: restitution=VALUE@SPEED or contact_time=VALUE@SPEED, in SI")
    ] = None
    observe: Annotated[list[str], option(f"quantities that are compared, of {', '.join(OBSERVABLES)}")] = (
        field(default_factory=lambda: [*USUAL])
    )
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
    def priors(self) -> dict[str, str]:
        """What is uncertain beside the usual, as texts by full key."""
        pairs = [text.partition("=") for text in self.vary or ()]
        return {key.strip(): text.strip() for key, _, text in pairs}

    @cached_property
    def posteriors(self) -> Posteriors | None:
        """Samples of the laws' numbers."""
        return None if self.posterior is None else Posteriors.read(self.posterior)

    def put_to(self, setups: Setups) -> Setups:
        """Return the setups of the laws by label: those of the recorded runs, if there are any.

        Raises:
            ComparisonError: runs or setups cannot be compared.
            ConfigurationError: overrides stand beside recorded runs.
        """
        if self.samples & (self.samples - 1):
            raise ComparisonError([f"study.samples is {self.samples}; it must be a power of two, or 0."])
        unknown = [name for name in self.observe if name not in OBSERVABLES]
        if unknown or not self.observe or self.observe[0] != next(iter(OBSERVABLES)):
            raise ComparisonError(
                [
                    f"study.observe is {', '.join(self.observe)}; it must be rotor_velocity, "
                    f"then any of {', '.join([*OBSERVABLES][1:])}."
                ]
            )
        if not self.recorded:
            if not setups:
                raise ComparisonError(["There is nothing to compare; there must be a run or a setup."])
            if self.calibrate is not None:
                setups = {label: _brought_to(self.calibrate, setup) for label, setup in setups.items()}
            grid = grid_of(setups.values(), transient=self.transient)
            if len(grid.cells) > 1 and (self.transient or not self.refine):
                raise ComparisonError(
                    [
                        "Operating points are compared once motors have settled, with refine=true; leave out "
                        "transient and refine, or give every key one value."
                    ]
                )
            return {", ".join(filter(None, place)): setup for place, setup in grid.setups.items()}
        if any(setup.configuration != build().configuration for setup in setups.values()):
            raise ConfigurationError(
                ["Recorded runs have configurations of their own; other keys must be left out beside them."]
            )
        return {law.label: setup for law in self.recorded if (setup := _built(law))}

    def grid(self, setups: Setups) -> Grid:
        """Return the laws and operating points of the setups that `put_to` returned."""
        if not self.recorded:
            return grid_of(setups.values(), transient=self.transient)
        return Grid(tuple(setups), ("",), {(label, ""): setup for label, setup in setups.items()})

    def laws(self, grid: Grid) -> list[Run]:
        """Return the laws in their order: as recorded, or without records."""
        return self.recorded or [
            replace(run_of_setup(label, grid.setups[label, grid.cells[0]]), label=label)
            for label in grid.laws
        ]

    def _plan(self, grid: Grid) -> dict[str, dict[str, Task]]:
        """Return the tasks of each law by what they do: a rerun, "starts", the digest of a measurement."""
        plan: dict[str, dict[str, Task]] = {}
        recorded = {law.label: law for law in self.laws(grid)}
        for label in grid.laws:
            setup, tasks = grid.setups[label, grid.cells[0]], plan.setdefault(label, {})
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

    def factors(self, grid: Grid) -> tuple[Factor, ...]:
        """Return what is drawn."""
        runs = [run_of_setup(law, setup) for (law, _), setup in grid.setups.items()]
        factors = factors_of(runs, self.priors)
        if not self.posteriors:
            return factors
        if not any(self.posteriors.values(setup, 0.0) for setup in grid.setups.values()):
            raise ComparisonError(
                [
                    f"posterior is '{self.posterior}', a fit of {', '.join(self.posteriors.samples)}; it "
                    "must be one of a number of the laws that are compared."
                ]
            )
        return (*factors, Factor(POSTERIOR))

    def _design(self, grid: Grid) -> "_Design | None":
        """Return the motors that are compared in pairs; None without any."""
        if self.transient or not self.refine or not grid.laws:
            return None
        whole = all("resonator" in setup.configuration for setup in grid.setups.values())
        factors = self.factors(grid) if whole else ()
        return _Design(grid, factors, self.samples if whole else 0, tuple(self.observe), self.posteriors)

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return reruns, other starts and predictions of measurements of each law, and the draws.

        Raises:
            ComparisonError, ConfigurationError: files or options cannot be used.
        """
        grid = self.grid(setups)
        design = self._design(grid)
        every = [task for tasks in self._plan(grid).values() for task in tasks.values()]
        if design:
            every += [*design.nominal_tasks, *design.drawn_tasks(design.looks[0])]
        return {task.key: task for task in every}.values()

    def further_tasks(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> Iterable[Task]:
        """Return twice as many draws while the order of two laws in the settled velocity is not known."""
        design = self._design(self.grid(setups))
        if not design or not (spent := design.spent(parts)) or spent == design.looks[-1]:
            return ()
        settled = design.settled(parts, spent)
        signs = signs_of(settled, design.factors, design.draws(spent))[:, :, :, :1]
        undecided = (verdicts_of(signs, len(design.looks)).verdict == INCONCLUSIVE) & np.isfinite(signs).any(
            -1
        )
        if not undecided.any():
            return ()
        return [task for task in design.drawn_tasks(2 * spent) if task.key not in parts]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return scorecard and paired comparison; the group motion_N is that of the N-th law."""
        grid = self.grid(setups)
        plan, laws = self._plan(grid), [Reruns(law) for law in self.laws(grid)]
        for law in laws:
            if setup := grid.setups.get((law.label, grid.cells[0])):
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
            data.attrs["limits"] = "\n".join(limits_of(laws))
        design = self._design(grid)
        if design and len(design.grid.laws) == len(laws):
            data = design.compared(data, parts)
            fixed = {law.label: left_fixed(law.run, design.factors, self.priors) for law in laws}
            names = dict.fromkeys(name for names in fixed.values() for name in names)
            data.attrs["notes"] = "\n".join([data.attrs["notes"], *self._left_alone(grid)]).strip()
            data.attrs["not_varied"] = listed(
                [
                    f"{name} of {listed([law for law in fixed if name in fixed[law]])}"
                    if not name.startswith("resonator")
                    else name
                    for name in names
                ]
            )
        data = with_measurements(data, measured)
        return xarray.DataTree(
            data, {f"motion_{n}": xarray.DataTree(motion(law)) for n, law in enumerate(laws, 1)}
        )

    def _left_alone(self, grid: Grid) -> Iterator[str]:
        """Yield the laws that an option does not reach."""
        laws = {law: grid.setups[law, grid.cells[0]] for law in grid.laws}
        if self.calibrate is not None:
            datum = Datum.of(self.calibrate)
            off = [
                name
                for name, setup in laws.items()
                if not isclose(datum.measured(setup.law, _delassus(setup.motor)), datum.value, rel_tol=1e-6)
            ]
            if off:
                yield f"No single number brings {listed(off)} to {self.calibrate}: those keep their values."
        if self.posteriors:
            known = self.posteriors.samples
            if missing := [name for name, setup in laws.items() if setup.law.name not in known]:
                yield f"'{self.posterior}' has no posterior of {listed(missing)}, which keep their values."

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the rotor velocity of each law with its error."""
        key = "rotor_velocity" if "limits" in data.attrs else "final_rotor_velocity"
        every = data.to_dataset().sel(metric=key)
        return {
            str(law): Estimate(
                float(every["value"].sel(law=law)), float(every["numerical_error"].sel(law=law))
            )
            for law in every["law"].values
        }

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return what limits the comparison, classes and orders of the laws, and failed thresholds."""
        return findings(data.to_dataset())

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return scorecard, pairs of laws, where to measure, files of measurements, and the metrics."""
        return tables(data.to_dataset())

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return laws, pairs and operating points, or transients; forces, paths, energy, phases."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.compare.figures import draw_all

        return draw_all(data)


@final
@dataclass(frozen=True)
class _Design:
    """The motors that are compared in pairs: as configured, and draws; each task is one motor, all laws.

    Args:
        grid: laws and operating points.
        factors: what is drawn; nothing for setups that were made in Python.
        samples: draws at most.
        names: of the quantities.
        posterior: samples of the laws' numbers.
    """

    grid: Grid
    factors: tuple[Factor, ...]
    samples: int
    names: tuple[str, ...]
    posterior: Posteriors | None

    @property
    def looks(self) -> list[int]:
        """Numbers of draws after which orders are tested."""
        return looks_up_to(self.samples)

    @cached_property
    def _draws(self) -> Array:
        return drawn(self.factors, self.samples)

    @cached_property
    def _drawn(self) -> list[list[Task]]:
        """The tasks of all draws by operating point."""
        return [[self._task(cell, draw) for draw in self._draws] for cell in self.grid.cells]

    def draws(self, count: int) -> Array:
        """Return the first draws, shape (draw, factor)."""
        return self._draws[:count]

    @cached_property
    def _nominal(self) -> dict[tuple[int, int, int], Task]:
        """The tasks of the motors as configured, by operating point, basis and step."""
        tasks = {}
        for number, cell in enumerate(self.grid.cells):
            for basis, step in np.ndindex(LEVELS):
                if self.factors:
                    tasks[number, basis, step] = self._task(cell, as_configured(self.factors, basis), step)
                elif not basis:
                    setups = {law: self._finer(self.grid.setups[law, cell], step) for law in self.grid.laws}
                    tasks[number, basis, step] = Task(f"step {step}", do_draw, (setups, self.names))
        return tasks

    @property
    def nominal_tasks(self) -> Iterable[Task]:
        """The tasks of the motors as configured."""
        return self._nominal.values()

    def drawn_tasks(self, count: int) -> list[Task]:
        """Return the tasks of the first draws, those of an operating point together."""
        return [task for tasks in self._drawn for task in tasks[:count]]

    def _task(self, cell: str, draw: Array, step: int = 0) -> Task:
        laws = {law: self.grid.setups[law, cell] for law in self.grid.laws}
        configurations = {
            law: configuration_of(setup, self.factors, draw, self.posterior, step)
            for law, setup in laws.items()
        }
        return Task(_key("draw", "", configurations), do_draw, (configurations, self.names))

    @staticmethod
    def _finer(setup: Setup, step: int) -> Setup:
        control = control_of(setup)
        return replace(setup, **{control: getattr(setup, control) / FINER[control][step]})

    def spent(self, parts: Mapping[str, xarray.DataTree]) -> int:
        """Return the number of draws that are finished: a look's, or none."""
        done = [count for count in self.looks if all(task.key in parts for task in self.drawn_tasks(count))]
        return max(done, default=0)

    def settled(self, parts: Mapping[str, xarray.DataTree], count: int) -> Settled:
        """Return the settled motors of a number of draws."""
        size = len(self.grid.laws), len(self.grid.cells)
        nominal = np.full((*size, *LEVELS, len(self.names)), np.nan)
        for (cell, basis, step), task in self._nominal.items():
            nominal[:, cell, basis, step] = parts[task.key].to_dataset()["value"].values
        every = [parts[task.key].to_dataset() for task in self.drawn_tasks(count)]
        # Draws of an operating point stand together.
        shape = (len(self.grid.cells), count, len(self.grid.laws), len(self.names))
        values, errors = (
            np.moveaxis(np.reshape([data[name].values for data in every], shape), 2, 0)
            for name in ("value", "error")
        )
        laws = [self.grid.setups[law, self.grid.cells[0]].law for law in self.grid.laws]
        return Settled(nominal, values, errors, [law.convergence_order for law in laws])

    def compared(self, data: xarray.Dataset, parts: Mapping[str, xarray.DataTree]) -> xarray.Dataset:
        """Return a scorecard with the paired comparison."""
        count = self.spent(parts)
        tasks = [*self.nominal_tasks, *self.drawn_tasks(count)]
        reasons = np.array([parts[task.key].to_dataset()["failure"].values for task in tasks], str)
        if (failed := reasons != "").any():
            laws = zip(self.grid.laws, failed.sum(axis=0).tolist(), strict=True)
            reason = f": {reasons[failed][0]}"
            data.attrs["notes"] += (
                f"\n{failed.sum()} of {failed.size} motors have no steady state "
                f"({', '.join(f'{law} {number}' for law, number in laws if number)})"
                f"{reason if reason not in data.attrs['notes'] else '.'}"
            )
        settled, draws = self.settled(parts, count), self.draws(count)
        setups = [self.grid.setups[law, self.grid.cells[0]] for law in self.grid.laws]
        coupling = {"units": "1", "long_name": "D_nt over sqrt(D_nn D_tt) of the motor at rest"}
        return with_pairs(
            data, settled, self.factors, draws, len(self.looks), self.grid.cells, self.names
        ).assign_coords(
            normal_tangential_coupling=("law", [_coupling(setup.motor) for setup in setups], coupling),
            rigid=("law", np.array([isinstance(each.law, MultiplierLaw) for each in setups], np.int8)),
        )


def _built(law: Run) -> Setup | None:
    try:
        return rebuild(law.configuration) if law.configuration else None
    except ConfigurationError:
        return None


def _delassus(motor: Motor) -> Array:
    """Return D = G M^-1 G' at rest, normal and tangential [1/kg], shape (2, 2)."""
    rows = np.stack([motor.modes.approach, motor.geometry.tip_length * motor.modes.tip_slope])
    return rows @ rows.T + np.diag([0.0, motor.geometry.rotor_radius**2 / motor.rotor.inertia])


def _coupling(motor: Motor) -> float:
    """Return |D_nt| / sqrt(D_nn D_tt) at rest."""
    matrix = _delassus(motor)
    return float(abs(matrix[0, 1]) / np.sqrt(matrix[0, 0] * matrix[1, 1]))


def _brought_to(text: str, setup: Setup) -> Setup:
    """Return a setup whose law has a datum; of one that no number brings there, the setup itself."""
    try:
        datum = Datum.of(text)
    except ValueError as error:
        raise ComparisonError([str(error)]) from None
    number = calibrated(setup.law, datum, _delassus(setup.motor))
    if number is None:
        return setup
    free, value = number
    return build(nested(flat(setup.configuration) | {f"law.{free.name}": value}))


def _key(label: str, name: str, subject: Setup | Mapping[str, Any]) -> str:
    configuration = subject.configuration if isinstance(subject, Setup) else subject
    digest = sha256(json.dumps(configuration, sort_keys=True, default=str).encode()).hexdigest()
    return f"{label} {name} {digest[:16]}"


def compare(
    sources: Source | Setup | Motor | Sequence[Source | Setup],
    law: ContactLaw | Sequence[ContactLaw] | None = None,
    *,
    output: str | Path | None = None,
    progress: Progress | None = None,
    vary: Mapping[str, str] | None = None,
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
        output, progress: as of every study.
        vary: what is uncertain by full key, "LOW..HIGH", "MEAN+-DEVIATION" or "+-SHARE", in place of what
            is by default; "+-0" is exact.
        measured: files of measured impacts or series, which the laws predict with their parameters.
        options: fields of `Compare`.

    Returns:
        Values, verdicts and numerical errors over the dimensions `law` and `metric`, the energy flow over
        `law` and `term`, and the paired comparison, see `pairs.with_pairs`.

    Raises:
        ComparisonError: the laws cannot be compared.
        OSError: the folder cannot be written to.
    """
    study = Compare(
        vary=[f"{key}={text}" for key, text in (vary or {}).items()] or None,
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
    return study(setups, output=output, progress=progress)
