"""The runs that are compared: found, read, held to be of one motor with one drive, and named."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, final

import xarray

from contactlab.config.nesting import flat
from contactlab.metrics import Run, read_run
from contactlab.results.files import DATASET
from contactlab.results.netcdf import reached_end
from contactlab.simulation import Solution

Source = str | Path | Solution | xarray.DataTree
"""A run folder, a dataset, a folder of such folders, or a run in memory."""

FREE = ("law", "solver", "record", "hydra")
"""Sections of the configuration in which compared runs may differ."""

MOST_NAMES = 2
"""Runs that a sentence names for one value."""


@final
class ComparisonError(ValueError):
    """Runs that cannot be compared, a sentence for each fault."""

    def __init__(self, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(self.faults))


def collect(sources: Sequence[Source]) -> tuple[list[Run], list[str]]:
    """Read the runs and check that they can be compared.

    Returns:
        The runs, in the order given, and notes on what could not be checked.

    Raises:
        ComparisonError: with every fault that was found.
    """
    faults: list[str] = []
    if not sources:
        faults.append("There is nothing to compare; give one run folder or more.")
    read = [_read(name, source, faults) for name, source in _found(sources, faults).items()]
    runs = [run for run in read if run is not None]
    labelled = _labelled(runs)
    if faults := faults or list(_differences(runs)) or list(_repeated(labelled)):
        raise ComparisonError(faults)
    return labelled, list(_untold(runs))


def _found(sources: Sequence[Source], faults: list[str]) -> dict[str, Path | xarray.DataTree]:
    """Find all runs, by name, each once."""
    found: dict[Any, tuple[str, Path | xarray.DataTree]] = {}
    for number, source in enumerate(sources, 1):
        if isinstance(source, Solution | xarray.DataTree):
            tree = source.tree if isinstance(source, Solution) else source
            found[number] = f"run {number}", tree
            continue
        for path in _datasets(Path(source), faults):
            name = str(path.parent if path.name == DATASET else path)
            found.setdefault(path.resolve(), (name, path))
    return dict(found.values())


def _datasets(source: Path, faults: list[str]) -> list[Path]:
    """Find the datasets at a place; a folder is one run or a folder of runs."""
    if source.is_file():
        return [source]
    if not source.is_dir():
        faults.append(
            f"'{source}' does not exist; it must be a run's folder, its {DATASET}, or a folder of "
            "such folders. `contactlab -m law=A,B hydra.sweep.dir=DIR` leaves one."
        )
        return []
    if (source / DATASET).exists():
        return [source / DATASET]
    below = sorted(source.rglob(DATASET), key=_in_order)
    if not below:
        faults.append(
            f"'{source}' holds no {DATASET}, nor does a folder below it; it must hold one at least. "
            f"A run leaves one: contactlab hydra.run.dir={source}"
        )
    return below


def _in_order(path: Path) -> list[tuple[int, str]]:
    """Sort 10_... after 9_..., as the jobs of a sweep are named."""
    words = re.split(r"(\d+)", str(path))
    return [(int(word), "") if word.isdigit() else (-1, word) for word in words]


def _read(name: str, source: Path | xarray.DataTree, faults: list[str]) -> Run | None:
    try:
        tree = read_run(source)
    # A file may be anything.
    except (OSError, ValueError, KeyError, RuntimeError, AttributeError) as error:
        faults.append(
            f"'{name}' cannot be read ({str(error).strip() or type(error).__name__}); it must be a "
            f"{DATASET} that contactlab has left. Run it again."
        )
        return None
    run = Run.of(tree)
    if reached_end(tree.attrs):
        return replace(run, source=name, label=run.law or Path(name).stem)
    faults.append(
        f"The run '{name}' of {run.law or 'some law'} is incomplete: it ended at "
        f"{run.time[-1]:.6g} s ({tree.attrs.get('message') or tree.attrs.get('ending', 'no reason')}); "
        "a run that is compared must have reached its end. Run it again or leave it out."
    )
    return None


def _differences(runs: Sequence[Run]) -> Iterable[str]:
    """Say what sets runs apart other than their laws."""
    values = [(run, flat(run.configuration)) for run in runs]
    sections = {key: key.partition(".")[0] for _, mine in values for key in mine}
    motor = [
        _unlike(key, [(run, v.get(key)) for run, v in values if section in run.configuration])
        for key, section in sections.items()
        if section not in FREE
    ]
    time = _unlike("solver.duration [s]", [(run, float(run.time[-1])) for run in runs])
    name = "natural_frequency"
    modes = [(run, run.columns[name].tolist()) for run in runs if run.holds(name)]
    # Where a key has told of it already, once is enough.
    tones = "" if any(motor) else _unlike("The natural frequency [Hz]", modes)
    return filter(None, (*motor, time, tones))


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
        f"{key} is {said}; laws are compared in one motor with one drive over one time, so it must be "
        "the same in all runs. Leave runs out, or run one of them again."
    )


def shown(value: Any) -> str:
    """Write a value in a sentence or a label, to nine digits."""
    if value is None:
        return "not given"
    if isinstance(value, list):
        return " ".join(shown(entry) for entry in value)
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def _untold(runs: Sequence[Run]) -> Iterable[str]:
    """Say what could not be checked."""
    told = dict.fromkeys(key for run in runs for key in run.configuration if key not in FREE)
    for run in runs:
        if missing := [section for section in told if section not in run.configuration]:
            yield (
                f"'{run.source}' does not say its {', '.join(missing)}; that they are those of the other "
                "runs is taken on trust."
            )


def _labelled(runs: Sequence[Run]) -> list[Run]:
    """Add to labels what sets the runs of one law apart: its own keys, of its parts those that are needed."""
    labelled = []
    for run in runs:
        same = [_law_keys(other) for other in runs if other.label == run.label]
        chosen: list[str] = []
        every = dict.fromkeys(key for keys in same for key in keys)
        for key in sorted(every, key=lambda key: "." in key):
            known = chosen if "." in key else []
            if _kinds(same, [*known, key]) > _kinds(same, known):
                chosen.append(key)
        said = _said(_law_keys(run), chosen)
        labelled.append(replace(run, label=f"{run.label} ({said})" if said else run.label))
    return labelled


def _law_keys(run: Run) -> dict[str, str]:
    """Give the law's parameters by key; from its own record where the configuration has none."""
    section = run.configuration.get("law")
    values = flat(section if isinstance(section, Mapping) else run.law_parameters)
    return {
        key.removesuffix(".name"): shown(value)
        for key, value in values.items()
        if value is not None and key != "name"
    }


def _said(law: Mapping[str, str], chosen: Sequence[str]) -> str:
    return ", ".join(f"{key} {law[key]}" for key in chosen if key in law)


def _kinds(laws: Sequence[Mapping[str, str]], chosen: Sequence[str]) -> int:
    return len({_said(law, chosen) for law in laws})


def _repeated(runs: Sequence[Run]) -> Iterable[str]:
    for label in dict.fromkeys(run.label for run in runs):
        names = [f"'{run.source}'" for run in runs if run.label == label]
        if len(names) > 1:
            yield (
                f"{label} stands in {len(names)} runs with the same parameters, {', '.join(names)}; a law "
                "is compared once. Leave all but one out."
            )
