"""The study `compare`: contact laws in one motor, in pairs."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final

import pandas
import xarray

from contactlab.config import ConfigurationError, Setup, build
from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.metrics import Run
from contactlab.motor import Motor
from contactlab.processes import processors
from contactlab.simulation import Solution
from contactlab.studies.compare.factors import as_configured, left_fixed
from contactlab.studies.compare.hypercube import SEED
from contactlab.studies.compare.laws import (
    ComparisonError as ComparisonError,
    Grid,
    Source,
    grid_of,
    read_runs,
    run_of_setup,
    unchecked,
)
from contactlab.studies.compare.motors import CONVERGED
from contactlab.studies.compare.observables import OBSERVABLES, OBSERVED
from contactlab.studies.compare.page import few_draws, findings, tables
from contactlab.studies.compare.pairs import Design, population_of, undecided, with_pairs
from contactlab.studies.compare.posteriors import Posteriors
from contactlab.studies.compare.priors import Distribution, Prior
from contactlab.studies.compare.repeats import MARGIN
from contactlab.studies.compare.scorecard import Reruns, limits_of, listed, motion, scorecard, tasks_of
from contactlab.studies.function import Put, function_of, of_motors, of_setups
from contactlab.studies.study import Setups, Study, Task, option

MOST_LISTED: Final = 3
"""Laws that are named beside a number that they share; of more the sentence has how many."""

SAMPLES: Final = 64
"""Draws at most, which take a minute or two for three laws."""

STARTS: Final = 6
"""Initial conditions of each law."""


@dataclass(frozen=True, kw_only=True)
class Compare(Study):
    """Does the difference of contact laws survive where the motor is not exactly known?

    Laws are chosen by law=A,B; other listed values, drive.phase=-1,0,1, are operating points. The motors are
    compared once they have settled, in pairs: a draw of all that is uncertain serves every law. Drawn are
    friction, contact stiffness, clearance or preload, damping, frequency, phase and amplitude of the
    voltages, and the start; KEY=LOW..HIGH, KEY=log(LOW..HIGH), KEY=MEAN+-DEVIATION and KEY=+-SHARE state
    these or others. Draws continue until the order of each pair in this population is known, or `samples`
    are spent. Recorded runs of one motor with one drive, DIR..., folders of runs, their run.nc, or folders
    of such folders, are compared from their start on, by the scorecard.

        >>> import contactlab as cl
        >>> setups = [cl.build([f"law={law}"]) for law in ("newton", "hertz_penalty")]
        >>> runs = [cl.simulate(setup, duration=5e-4) for setup in setups]
        >>> result = cl.compare(runs, refine=False)
        >>> result["value"].sel(metric="contact_count").to_series().to_dict()
        {'newton': 2.0, 'hertz_penalty': 2.0}

    Returns:
        Values, verdicts and numerical errors over the dimensions `law` and `metric`, the energy flow over
        `law` and `term`, and of setups the paired comparison.

    Raises:
        ComparisonError: the laws cannot be compared.
        OSError: the folder cannot be written to.
    """

    name: ClassVar[str] = "compare"
    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = ("record.picture", "solver.changes")
    presets: ClassVar[tuple[str, ...]] = (f"resonator={CONVERGED}",)
    delay: ClassVar[float] = 10.0
    files: ClassVar[str] = "runs"

    runs: Annotated[list[str] | list[Source] | None, option("folders or files of recorded runs")] = None
    refine: Annotated[bool, option("whether numerical errors, draws and starts are computed")] = True
    samples: Annotated[
        int, option("draws at most, a power of two; 0 draws nothing", at_least=0, at_most=100_000)
    ] = SAMPLES
    seed: Annotated[int, option("seed of the draws", at_least=0)] = SEED
    starts: Annotated[int, option("initial conditions of each law", at_least=1, at_most=1000)] = STARTS
    vary: Annotated[
        Mapping[str, Distribution] | list[Prior] | None,
        option("what is uncertain: KEY=LOW..HIGH, log(LOW..HIGH), MEAN+-DEVIATION, +-SHARE; +-0 is exact"),
    ] = None
    margin: Annotated[
        float, option("relative difference within which laws are practically equal", at_least=0.0, below=1.0)
    ] = MARGIN
    posterior: Annotated[
        str | Path | None, option("file of a fit, whose posteriors the laws' numbers are drawn from")
    ] = None
    observe: Annotated[list[str], option(f"quantities that are compared, of {', '.join(OBSERVABLES)}")] = (
        field(default_factory=lambda: [*OBSERVED])
    )
    workers: Annotated[int, option("processes at work", at_least=1)] = processors()

    @property
    def options(self) -> dict[str, Any]:
        """The options on which the result depends; runs in memory have numbers."""
        in_memory = Solution | xarray.DataTree
        names = [f"run {n}" if isinstance(x, in_memory) else str(x) for n, x in enumerate(self.runs or (), 1)]
        vary = [str(Prior(name, value)) for name, value in self.priors.items()]
        return super().options | {"runs": names or None, "vary": vary or None}

    @property
    def priors(self) -> Mapping[str, Distribution]:
        """What is uncertain beside the usual, by full key."""
        if isinstance(self.vary, list):
            return {prior.name: prior.value for prior in self.vary}
        return self.vary or {}

    @cached_property
    def recorded(self) -> list[Run]:
        """The recorded runs."""
        return read_runs(self.runs or ())

    def put_to(self, setups: Setups) -> Setups:
        """Return the setups of the laws by label; recorded runs are compared without any.

        Raises:
            ComparisonError: runs or setups cannot be compared.
            ConfigurationError: there are setups beside recorded runs.
        """
        faults = []
        if self.samples & (self.samples - 1):
            faults.append(f"study.samples is {self.samples}; it must be a power of two, or 0.")
        first, *others = OBSERVABLES
        if self.observe[:1] != [first] or {*self.observe} - {*OBSERVABLES}:
            faults.append(
                f"study.observe is {', '.join(self.observe)}; it must be {first}, then any of "
                f"{', '.join(others)}."
            )
        names = [prior.name for prior in self.vary or () if isinstance(prior, Prior)]
        if twice := next((name for name in names if names.count(name) > 1), ""):
            faults.append(f"vary has {twice} twice; it must occur once.")
        if not (self.runs or setups):
            faults.append("There is nothing to compare; there must be a run or a setup.")
        if faults:
            raise ComparisonError(faults)
        # Read here: nothing is written where one cannot be.
        if self.recorded:
            plain = [build().configuration, build(list(self.presets)).configuration]
            if any(setup.configuration not in plain for setup in setups.values()):
                raise ConfigurationError(
                    "Recorded runs have configurations of their own; there must be no other keys."
                )
            return {}
        grid = grid_of(setups.values())
        if len(grid.cells) > 1 and not self.refine:
            raise ComparisonError(
                "Operating points are compared with refine=true; without it every key must have one value."
            )
        return {", ".join(filter(None, place)): setup for place, setup in grid.setups.items()}

    def _design(self, grid: Grid) -> Design | None:
        """Return the motors that are compared in pairs; None without any."""
        if not self.refine:
            return None
        return Design.of(grid, self.priors, self.samples, self.observe, self._posteriors, self.seed)

    def notice(self, setups: Setups) -> str:
        """Return that the draws are too few to show any order."""
        if self.runs or not (self.refine and self.samples):
            return ""
        grid = grid_of(self.put_to(setups).values())
        laws, points = len(grid.laws), len(grid.cells)
        claims = laws * (laws - 1) * points * len(self.observe)
        return few_draws(self.samples, claims) if claims else ""

    def _scored(self, grid: Grid) -> dict[str, dict[str, Task]]:
        """Return the tasks for the scorecard by law and name."""
        return {
            law: tasks_of(law, setup, refine=self.refine, starts=self.starts, observe=self.observe)
            for law, setup in grid.first.items()
        }

    @cached_property
    def _posteriors(self) -> Posteriors | None:
        return None if self.posterior is None else Posteriors.read(self.posterior)

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return reruns and other starts of each law, and the first draws.

        Raises:
            ComparisonError, ConfigurationError: files or options cannot be used.
        """
        if self.runs:
            return ()
        grid = grid_of(setups.values())
        every = [task for tasks in self._scored(grid).values() for task in tasks.values()]
        if design := self._design(grid):
            every += design.tasks(design.nominal() | design.drawn(0, design.looks[0]))
        return every

    def further_tasks(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> Iterable[Task]:
        """Return twice as many draws while two laws have no order in the settled velocity."""
        design = None if self.runs else self._design(grid_of(setups.values()))
        if not design or not (spent := design.spent(parts)) or spent == design.looks[-1]:
            return ()
        settled = design.settled(parts, spent)
        pairs = population_of(settled, design.names, self.margin, len(design.looks))
        if not undecided(settled, pairs, self.margin):
            return ()
        return design.tasks(design.drawn(spent, 2 * spent))

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return scorecard and paired comparison; the group motion_N is that of the N-th law."""
        if self.runs:
            laws = [Reruns(run) for run in self.recorded]
            data = scorecard(laws, [*unchecked(self.recorded)])
        else:
            grid = grid_of(setups.values())
            runs = {law: run_of_setup(law, setup, law) for law, setup in grid.first.items()}
            laws = []
            for law, tasks in self._scored(grid).items():
                own = {name: parts[task.key] for name, task in tasks.items()}
                laws.append(Reruns.of(runs[law], grid.first[law], own, refine=self.refine))
            data = scorecard(laws, [*self._left_alone(grid)])
            data.attrs["limits"] = "\n".join(limits_of(laws))
            if design := self._design(grid):
                data = with_pairs(data, design, parts, self.margin)
                fixed = {law: left_fixed(run, design.factors, self.priors) for law, run in runs.items()}
                data.attrs["not_varied"] = "; ".join(_of_laws(fixed))
                data.attrs["held"] = listed(as_configured([*runs.values()], design.factors))
        motions = {f"motion_{n}": xarray.DataTree(motion(law)) for n, law in enumerate(laws, 1)}
        return xarray.DataTree(data, motions)

    def _left_alone(self, grid: Grid) -> Iterator[str]:
        """Yield the laws that an option does not reach."""
        laws = grid.first
        if self._posteriors:
            known = self._posteriors.samples
            if missing := [law for law, setup in laws.items() if setup.law.name not in known]:
                yield f"'{self.posterior}' has no posterior of {listed(missing)}, which keep their values."

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the rotor velocity of each law with its error."""
        key = "rotor_velocity" if "limits" in data.attrs else "final_rotor_velocity"
        every = data.to_dataset().sel(metric=key)
        values, errors = every["value"].values.tolist(), every["numerical_error"].values.tolist()
        return dict(zip(map(str, every["law"].values), map(Estimate, values, errors), strict=True))

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return classes and orders of the laws, what limits the comparison, and failed thresholds."""
        return findings(data.to_dataset())

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return scorecard, pairs of laws, where to measure, and the metrics."""
        return tables(data.to_dataset())

    def figures(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return laws, pairs and operating points, or transients; forces, paths, energy, phases."""
        # Imported here: it brings matplotlib.
        from contactlab.studies.compare.figures import draw_all

        return draw_all(data)


def _of_laws(names: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """Yield the names that laws have, those of the same laws together; of many laws their number."""
    having: dict[tuple[str, ...], list[str]] = {}
    for name in dict.fromkeys(name for each in names.values() for name in each):
        having.setdefault(tuple(law for law in names if name in names[law]), []).append(name)
    for laws, own in having.items():
        yield f"{listed(own)} of {listed(laws) if len(laws) <= MOST_LISTED else f'{len(laws)} laws'}"


def _sources(
    sources: Source | Setup | Motor | Sequence[Source | Setup],
    law: ContactLaw | Sequence[ContactLaw] | None = None,
) -> Put:
    """Put the comparison to setups or recorded runs.

    Args:
        sources: setups; or recorded runs: folders, their datasets, folders of such folders, runs in memory;
            or a motor made in Python.
        law: one or several, of that motor.
    """
    if isinstance(sources, Motor):
        return of_motors(sources, law or [])
    if law is not None:
        raise TypeError("A law is given with a motor only; runs and setups have their own.")
    single = str | Path | Solution | xarray.DataTree | Setup
    every: list[Any] = [sources] if isinstance(sources, single) else list(sources)
    setups = [each for each in every if isinstance(each, Setup)]
    if setups and len(setups) < len(every):
        raise ComparisonError("There are setups and recorded runs; there must be one kind.")
    return of_setups(setups) if setups else ({}, {"runs": every})


compare = function_of(Compare, _sources, without=["runs"])
