"""The laws of a comparison: recorded runs or setups of one motor with one drive, and their labels."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, final

import xarray

from contactlab.config import Setup
from contactlab.config.nesting import flat
from contactlab.metrics import Run, read_run
from contactlab.results.files import DATASET
from contactlab.results.netcdf import reached_end
from contactlab.simulation import Solution

Source = str | Path | Solution | xarray.DataTree
"""A run's folder, its dataset, a folder of such folders, or a run in memory."""

FREE: Final = ("law", "solver", "record", "hydra")
"""Sections of a configuration in which compared laws may differ."""


@final
class ComparisonError(ValueError):
    """Runs that cannot be compared, a sentence for each fault."""

    def __init__(self, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(self.faults))


def read_runs(sources: Sequence[Source]) -> list[Run]:
    """Read runs, each once, in the order of their sources.

    Raises:
        ComparisonError: a source is missing, damaged or incomplete.
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
    return runs


def run_of_setup(label: str, setup: Setup) -> Run:
    """Return a setup as a run without records."""
    law = setup.law
    return Run({}, {}, setup.configuration, law.name, law.describe(), 0.0, source=label, label=law.name)


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


def grid_of(setups: Iterable[Setup], *, transient: bool) -> Grid:
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
    shown_keys = [key for key in differing if not (basis and key == "drive.frequency")][:3]
    points: dict[tuple[str, ...], list[Setup]] = {}
    for setup, settings in every:
        points.setdefault(tuple(shown(settings.get(key)) for key in differing), []).append(setup)
    result: dict[tuple[str, str], Setup] = {}
    laws: list[tuple[str, ...]] = []
    cells = []
    for values, members in points.items():
        point = dict(zip(differing, values, strict=True))
        cells.append(", ".join(f"{key}={point[key]}" for key in shown_keys))
        runs = labelled(
            [run_of_setup(f"law {n}", each) for n, each in enumerate(members, 1)], transient=transient
        )
        laws.append(tuple(run.label for run in runs))
        result |= {(run.label, cells[-1]): each for run, each in zip(runs, members, strict=True)}
    if len({frozenset(each) for each in laws}) > 1 or len(set(cells)) < len(cells):
        raise ComparisonError(
            ["Setups differ in more than their laws; then every law must be at every operating point, once."]
        )
    return Grid(laws[0], tuple(cells), result)


def labelled(runs: Sequence[Run], *, transient: bool) -> list[Run]:
    """Return runs with distinct labels.

    Args:
        runs: recorded, or of setups.
        transient: whether they must last equally long.

    Raises:
        ComparisonError: they differ in more than their laws, or one law occurs twice.
    """
    result = [replace(run, label=_label(run, runs)) for run in runs]
    if faults := [*_differences(runs, transient=transient)] or [*_repeated(result)]:
        raise ComparisonError(faults)
    return result


def _datasets(source: Path) -> list[Path]:
    """Return the datasets at a place, which is a run or a folder of runs."""
    if source.is_file():
        return [source]
    if (source / DATASET).exists():
        return [source / DATASET]
    # 10_... follows 9_..., as the jobs of a sweep are named.
    return sorted(source.rglob(DATASET), key=lambda path: re.sub(r"\d+", lambda x: x[0].zfill(20), str(path)))


def _differences(runs: Sequence[Run], *, transient: bool) -> Iterator[str]:
    """Yield the differences of runs other than their laws."""
    keys = dict.fromkeys(key for run in runs for key in run.settings)
    for key in keys:
        section = key.partition(".")[0]
        if section not in FREE:
            values = [(run, run.settings.get(key)) for run in runs if section in run.configuration]
            yield from _unequal(key, values)
    if transient:
        lengths = [
            (run, float(run.time[-1]) if run.columns else run.setting("solver.duration")) for run in runs
        ]
        yield from _unequal("solver.duration [s]", lengths)


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
    return "not given" if value is None else f"{value:.9g}" if isinstance(value, float) else str(value)


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


def _repeated(runs: Sequence[Run]) -> Iterator[str]:
    for label, count in Counter(run.label for run in runs).items():
        if count > 1:
            names = ", ".join(f"'{run.source}'" for run in runs if run.label == label)
            yield f"{label} occurs {count} times with equal parameters, in {names}; it must occur once."
