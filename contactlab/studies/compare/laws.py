"""The laws of a comparison: recorded runs, or setups at operating points, of one motor with one drive."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.config.nesting import flat
from contactlab.metrics import Run, read_run
from contactlab.motor import Motor
from contactlab.results.files import DATASET
from contactlab.results.netcdf import reached_end
from contactlab.simulation import Solution

Source = str | Path | Solution | xarray.DataTree
"""A run's folder, its dataset, a folder of such folders, or a run in memory."""

FREE: Final = ("law", "solver", "record", "hydra")
"""Sections of a configuration in which compared laws may differ."""

POINT_KEYS: Final = 3
"""Keys that the label of an operating point shows at most."""


@final
class ComparisonError(ValueError):
    """Runs that cannot be compared, a sentence for each fault, or one."""

    def __init__(self, faults: Iterable[str] | str) -> None:
        self.faults = (faults,) if isinstance(faults, str) else tuple(faults)
        super().__init__("\n".join(self.faults))


def read_runs(sources: Sequence[Source]) -> list[Run]:
    """Read runs, each once, in the order of their sources, and label them.

    Raises:
        ComparisonError: a source is missing, damaged or incomplete, or runs cannot be compared.
    """
    faults: list[str] = []
    places: dict[Path | str, Path | xarray.DataTree] = {}
    for number, source in enumerate(sources, 1):
        if isinstance(source, Solution | xarray.DataTree):
            places[f"run {number}"] = source.tree if isinstance(source, Solution) else source
        elif paths := _datasets(Path(source)):
            places |= {path.resolve(): path for path in paths}
        else:
            faults.append(
                f"'{source}' {'contains no run' if Path(source).is_dir() else 'does not exist'}; it must be "
                f"a run's folder, its {DATASET}, or a folder of such folders."
            )
    runs = []
    for key, place in places.items():
        name = str(key)
        if isinstance(place, Path):
            name = str(place.parent if place.name == DATASET else place)
        try:
            run = Run.of(read_run(place))
        except ValueError as error:
            faults.append(f"'{name}' cannot be compared. {error}")
            continue
        runs.append(replace(run, source=name, label=run.law or Path(name).stem))
        if not reached_end(run.attributes):
            reason = run.attributes.get("message") or run.attributes.get("ending", "no reason")
            faults.append(
                f"The run '{name}' of {run.law or 'some law'} is incomplete: it ended at {run.time[-1]:.6g} "
                f"s ({reason}); a run that is compared must have reached its end."
            )
    if faults:
        raise ComparisonError(faults)
    return labelled(runs)


def _datasets(source: Path) -> list[Path]:
    """Return the datasets at a place, which is a run or a folder of runs."""
    if source.is_file():
        return [source]
    if (source / DATASET).exists():
        return [source / DATASET]
    # 10_... follows 9_..., as the jobs of a sweep are named.
    return sorted(source.rglob(DATASET), key=lambda path: re.sub(r"\d+", lambda x: x[0].zfill(20), str(path)))


def run_of_setup(source: str, setup: Setup, label: str = "") -> Run:
    """Return a setup as a run without records."""
    name, numbers = setup.law.name, setup.law.describe()
    return Run({}, {}, setup.configuration, name, numbers, 0.0, source=source, label=label or name)


@final
@dataclass(frozen=True)
class Grid:
    """The setups of laws at operating points.

    Args:
        laws: labels.
        cells: operating points, 'drive.phase=0'; one without a label where there is a single one.
        setups: of each law at each operating point.
    """

    laws: tuple[str, ...]
    cells: tuple[str, ...]
    setups: Mapping[tuple[str, str], Setup]

    @property
    def first(self) -> dict[str, Setup]:
        """The setups at the first operating point by law."""
        return {law: self.setups[law, self.cells[0]] for law in self.laws}

    @property
    def whole(self) -> bool:
        """Whether the setups have configurations: those of a motor that was made in Python have not."""
        return all("resonator" in setup.configuration for setup in self.setups.values())


def grid_of(setups: Iterable[Setup]) -> Grid:
    """Return laws and operating points: setups that differ in more than the law are other points.

    Raises:
        ComparisonError: a law is missing at a point, or occurs twice.
    """
    every = [
        (setup, flat({k: x for k, x in setup.configuration.items() if k not in FREE})) for setup in setups
    ]
    keys = dict.fromkeys(key for _, settings in every for key in settings)
    differing = [key for key in keys if len({shown(settings.get(key)) for _, settings in every}) > 1]
    basis = any(key.startswith("resonator.") for key in differing)
    # What follows from another resonator is no choice.
    shown_keys = [key for key in differing if not (basis and key == "drive.frequency")][:POINT_KEYS]
    points: dict[tuple[str, ...], list[Setup]] = {}
    for setup, settings in every:
        points.setdefault(tuple(shown(settings.get(key)) for key in differing), []).append(setup)
    result: dict[tuple[str, str], Setup] = {}
    laws: list[tuple[str, ...]] = []
    cells = []
    for values, members in points.items():
        point = dict(zip(differing, values, strict=True))
        cells.append(", ".join(f"{key}={point[key]}" for key in shown_keys))
        runs = labelled([run_of_setup(f"law {n}", each) for n, each in enumerate(members, 1)])
        laws.append(tuple(run.label for run in runs))
        result |= {(run.label, cells[-1]): each for run, each in zip(runs, members, strict=True)}
    if len({frozenset(each) for each in laws}) > 1 or len(set(cells)) < len(cells):
        raise ComparisonError(
            "Setups differ in more than their laws; then every law must be at every operating point, once."
        )
    return Grid(laws[0], tuple(cells), result)


def delassus_at_rest(motor: Motor) -> Array:
    """Return D = G M^-1 G' at rest, normal and tangential [1/kg], shape (2, 2)."""
    rows = np.stack(motor.rows_at_rest)
    return rows @ rows.T + np.diag([0.0, motor.geometry.rotor_radius**2 / motor.rotor.inertia])


def labelled(runs: Sequence[Run]) -> list[Run]:
    """Return runs, or setups as runs, with distinct labels.

    Raises:
        ComparisonError: they differ in more than their laws, recorded ones in their length, or one law
            occurs twice.
    """
    faults = list[str]()
    for key in dict.fromkeys(key for run in runs for key in run.settings):
        section = key.partition(".")[0]
        if section not in FREE:
            values = [(run, run.settings.get(key)) for run in runs if section in run.configuration]
            faults += _unequal(key, values)
    faults += _unequal("solver.duration [s]", [(run, float(run.time[-1])) for run in runs if run.columns])
    result = [replace(run, label=_label(run, runs)) for run in runs]
    if not faults:
        for label, count in Counter(run.label for run in result).items():
            if count > 1:
                names = ", ".join(f"'{run.source}'" for run in result if run.label == label)
                faults.append(
                    f"{label} occurs {count} times with equal parameters, in {names}; it must occur once."
                )
    if faults:
        raise ComparisonError(faults)
    return result


def _unequal(key: str, values: Iterable[tuple[Run, Any]]) -> Iterator[str]:
    """Yield a sentence on a key that differs by more than the round-off of another machine."""
    groups: dict[str, list[str]] = {}
    for run, value in values:
        groups.setdefault(shown(value), []).append(f"'{run.source}'")
    if len(groups) > 1:
        more = {n: f" and {n - 1} more" if n > 1 else "" for n in map(len, groups.values())}
        texts = [f"{value} in {names[0]}{more[len(names)]}" for value, names in groups.items()]
        yield (
            f"{key} is {' and '.join(texts)}; it must be the same: laws are compared in one motor with one "
            "drive."
        )


def shown(value: Any) -> str:
    """Return a value as a text of nine digits."""
    if isinstance(value, list | tuple):
        return " ".join(map(shown, value))
    if isinstance(value, float):
        return f"{value:.9g}"
    return "not given" if value is None else str(value)


def unchecked(runs: Sequence[Run]) -> Iterator[str]:
    """Yield the sections of a motor that runs lack, so that they could not be checked."""
    sections = dict.fromkeys(key for run in runs for key in run.configuration if key not in FREE)
    for run in runs:
        if missing := [section for section in sections if section not in run.configuration]:
            yield (
                f"'{run.source}' lacks its {', '.join(missing)}; they are assumed to be those of the other "
                "runs."
            )


def _label(run: Run, runs: Sequence[Run]) -> str:
    """Return the law with the keys that differ; keys of a part only among laws with that part."""
    laws = [_law_keys(other) for other in runs if other.label == run.label]
    differing = []
    for key, value in _law_keys(run).items():
        part = key.rpartition(".")[0]
        kinds = {(law.get(part), law[key]) for law in laws if key in law}
        if value is not None and len(kinds) > len({kind for kind, _ in kinds}):
            differing.append(f"{key} {value}")
    return f"{run.label} ({', '.join(differing)})" if differing else run.label


def _law_keys(run: Run) -> Mapping[str, str | None]:
    """Return the law's parameters by key; from its own record where the configuration has none."""
    law = {k.removeprefix("law."): x for k, x in run.settings.items() if k.startswith("law.")}
    values = (law or run.law_parameters).items()
    return {k.removesuffix(".name"): None if x is None else shown(x) for k, x in values}
