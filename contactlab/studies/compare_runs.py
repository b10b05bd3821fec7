"""The runs that are compared: found, read, held to be of one motor with one drive, and named."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, final

import xarray

from contactlab.metrics import Run, read_run
from contactlab.results.files import DATASET
from contactlab.results.netcdf import reached_end
from contactlab.simulation import Solution

Source = str | Path | Solution | xarray.DataTree
"""A run folder, a dataset, a folder of such folders, or a run in memory."""

FREE: Final = ("law", "solver", "record", "hydra")  # sections in which compared runs may differ
MOST_NAMES: Final = 2  # runs that a sentence names for one value


@final
class ComparisonError(ValueError):
    """Runs that cannot be compared, a sentence for each fault."""

    def __init__(self, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(self.faults))


def collect(sources: Sequence[Source], *, transient: bool = False) -> tuple[list[Run], list[str]]:
    """Read the runs, each once, and check that they can be compared.

    Args:
        sources: where they are.
        transient: whether they must have lasted as long; settled motors do not know how long they took.

    Returns:
        The runs, in the order given, and notes on what could not be checked.

    Raises:
        ComparisonError: with every fault that was found.
    """
    faults = [] if sources else ["There is nothing to compare; give one run folder or more."]
    places: dict[Path | str, Path | xarray.DataTree] = {}
    for number, source in enumerate(sources, 1):
        if isinstance(source, Solution | xarray.DataTree):
            places[f"run {number}"] = source.tree if isinstance(source, Solution) else source
        elif paths := _datasets(Path(source)):
            places |= {path.resolve(): path for path in paths}
        else:
            faults.append(
                f"'{source}' {'holds no run' if Path(source).is_dir() else 'does not exist'}; it must be a "
                f"run's folder, its {DATASET}, or a folder of such folders. "
                "`contactlab -m law=A,B hydra.sweep.dir=DIR` leaves one."
            )
    runs = []
    for key, place in places.items():
        try:
            runs.append(_read(str(key), place))
        except ValueError as error:
            faults.append(str(error))
    labels = [_label(run, runs) for run in runs]
    labelled = [replace(run, label=label) for run, label in zip(runs, labels, strict=True)]
    if faults := faults or [*_differences(runs, transient=transient)] or [*_repeated(labelled)]:
        raise ComparisonError(faults)
    return labelled, [*_untold(runs)]


def _datasets(source: Path) -> list[Path]:
    """Find the datasets at a place; a folder is one run or a folder of runs."""
    if source.is_file():
        return [source]
    if (source / DATASET).exists():
        return [source / DATASET]
    return sorted(source.rglob(DATASET), key=_in_order)


def _in_order(path: Path) -> str:
    """Sort 10_... after 9_..., as the jobs of a sweep are named."""
    return re.sub(r"\d+", lambda digits: digits[0].zfill(20), str(path))


def _read(name: str, source: Path | xarray.DataTree) -> Run:
    """Read a run that has reached its end; a ValueError says what is wrong with another."""
    if isinstance(source, Path):
        name = str(source.parent if source.name == DATASET else source)
    try:
        run = Run.of(read_run(source))
    except ValueError as error:
        raise ValueError(f"'{name}' cannot be compared. {error}") from error
    if not reached_end(run.attributes):
        reason = run.attributes.get("message") or run.attributes.get("ending", "no reason")
        raise ValueError(
            f"The run '{name}' of {run.law or 'some law'} is incomplete: it ended at {run.time[-1]:.6g} s "
            f"({reason}); a run that is compared must have reached its end. Run it again or leave it out."
        )
    return replace(run, source=name, label=run.law or Path(name).stem)


def _differences(runs: Sequence[Run], *, transient: bool) -> Iterator[str]:
    """Say what sets runs apart other than their laws."""
    said = []
    for key in dict.fromkeys(key for run in runs for key in run.settings):
        section = key.partition(".")[0]
        if section not in FREE:
            told = [run for run in runs if section in run.configuration]
            said.append(_unlike(key, [(run, run.settings.get(key)) for run in told]))
    if transient:
        said.append(_unlike("solver.duration [s]", [(run, float(run.time[-1])) for run in runs]))
    return filter(None, said)


def _unlike(key: str, values: Iterable[tuple[Run, Any]]) -> str:
    """Say which runs have which value, if they differ by more than another machine rounds otherwise."""
    groups: dict[str, list[str]] = {}
    for run, value in values:
        groups.setdefault(shown(value), []).append(f"'{run.source}'")
    if len(groups) < 2:
        return ""
    said = " and ".join(
        f"{value} in {', '.join(names[:MOST_NAMES])}"
        + (f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else "")
        for value, names in groups.items()
    )
    return (
        f"{key} is {said}; laws are compared in one motor with one drive, so it must be the same in all "
        "runs. Leave runs out, or run one of them again."
    )


def shown(value: Any) -> str:
    """Write a value in a sentence or a label, to nine digits."""
    if isinstance(value, list):
        return " ".join(map(shown, value))
    return "not given" if value is None else f"{value:.9g}" if isinstance(value, float) else str(value)


def _untold(runs: Sequence[Run]) -> Iterator[str]:
    """Say what could not be checked."""
    told = dict.fromkeys(key for run in runs for key in run.configuration if key not in FREE)
    for run in runs:
        if missing := [section for section in told if section not in run.configuration]:
            yield (
                f"'{run.source}' does not say its {', '.join(missing)}; that they are those of the other "
                "runs is taken on trust."
            )


def _label(run: Run, runs: Sequence[Run]) -> str:
    """Name a run by its law and the keys that set it apart; keys of a part, from others with that part."""
    laws = [_law_keys(other) for other in runs if other.label == run.label]
    said = []
    for key, value in _law_keys(run).items():
        part = key.rpartition(".")[0]
        kinds = {(law.get(part), law[key]) for law in laws if key in law}
        if value is not None and len(kinds) > len({kind for kind, _ in kinds}):
            said.append(f"{key} {value}")
    return f"{run.label} ({', '.join(said)})" if said else run.label


def _law_keys(run: Run) -> Mapping[str, str | None]:
    """Give the law's parameters by key; from its own record where the configuration has none."""
    law = {k.removeprefix("law."): x for k, x in run.settings.items() if k.startswith("law.")}
    values = (law or run.law_parameters).items()
    return {k.removesuffix(".name"): None if x is None else shown(x) for k, x in values}


def _repeated(runs: Sequence[Run]) -> Iterator[str]:
    for label, count in Counter(run.label for run in runs).items():
        if count > 1:
            names = ", ".join(f"'{run.source}'" for run in runs if run.label == label)
            yield (
                f"{label} stands in {count} runs with the same parameters, {names}; a law is compared once. "
                "Leave all but one out."
            )
