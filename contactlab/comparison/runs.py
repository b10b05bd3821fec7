"""The runs that are compared: found, read, checked and named."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import xarray

from contactlab.comparison.arrays import series
from contactlab.comparison.faults import ComparisonError
from contactlab.comparison.sameness import differences, law_keys, shown
from contactlab.metrics import configuration_of, read_run
from contactlab.results.files import DATASET
from contactlab.results.netcdf import reached_end

Source = str | Path | xarray.DataTree
"""A run folder, a dataset, a folder of such folders, or a run in memory."""


@final
@dataclass(frozen=True)
class Run:
    """A run.

    Args:
        label: its law in a word, with what sets it apart where a law has several runs.
        source: where it is from.
        tree: what it recorded.
        configuration: as recorded, nested; empty where the run has none.
    """

    label: str
    source: str
    tree: xarray.DataTree
    configuration: Mapping[str, Any]

    @property
    def law(self) -> str:
        """The law's name."""
        return _law(self.source, self.tree)

    @property
    def period(self) -> float:
        """Period of the drive's first tone [s]; a tenth of the run where it is not known."""
        frequency = dict(self.configuration.get("drive") or {}).get("frequency")
        time = series(self.tree, "time")
        return 1.0 / float(frequency) if frequency else 0.1 * float(time[-1] - time[0])


def collect(sources: Sequence[Source]) -> tuple[list[Run], list[str]]:
    """Read the runs and check that they can be compared.

    Returns:
        The runs, in the order given, and notes on what could not be checked.

    Raises:
        ComparisonError: with every fault that was found.
    """
    faults: list[str] = []
    read: list[tuple[str, xarray.DataTree]] = []
    for name, found in _found(sources, faults):
        tree = _read(name, found, faults)
        if tree is not None:
            read.append((name, tree))
    if not read and not faults:
        faults.append("There is nothing to compare; give one run folder or more.")
    if faults:
        raise ComparisonError(faults)
    configurations = {name: configuration_of(tree) for name, tree in read}
    faults, notes = differences(dict(read), configurations)
    if faults:
        raise ComparisonError(faults)
    labels = _labels(dict(read), configurations, faults)
    if faults:
        raise ComparisonError(faults)
    return [Run(labels[name], name, tree, configurations[name]) for name, tree in read], notes


def _found(
    sources: Sequence[Source], faults: list[str]
) -> list[tuple[str, Path | xarray.DataTree]]:
    """Names and places of all runs, each once."""
    found: dict[str, Path | xarray.DataTree] = {}
    seen: set[Path] = set()
    for number, source in enumerate(sources, 1):
        if isinstance(source, xarray.DataTree):
            found[f"run {number}"] = source
            continue
        for path in _datasets(Path(source), faults):
            if path.resolve() not in seen:
                seen.add(path.resolve())
                found[str(path.parent if path.name == DATASET else path)] = path
    return list(found.items())


def _datasets(source: Path, faults: list[str]) -> list[Path]:
    """The datasets at a place; a folder is one run or a folder of runs."""
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
    """Sorts 10_... after 9_..., as the jobs of a sweep are named."""
    words = re.split(r"(\d+)", str(path))
    return [(int(word), "") if word.isdigit() else (-1, word) for word in words]


def _read(name: str, found: Path | xarray.DataTree, faults: list[str]) -> xarray.DataTree | None:
    try:
        tree = read_run(found)
    # A file may be anything.
    except (OSError, ValueError, KeyError, RuntimeError, AttributeError) as error:
        faults.append(
            f"'{name}' cannot be read ({str(error).strip() or type(error).__name__}); it must be a "
            f"{DATASET} that contactlab has left. Run it again."
        )
        return None
    # A dataset of one's own need not say so.
    if not reached_end(tree.attrs):
        time = float(series(tree, "time")[-1])
        faults.append(
            f"The run '{name}' of {tree.attrs.get('law', 'some law')} is incomplete: it ended at "
            f"{time:.6g} s ({tree.attrs.get('message') or tree.attrs.get('ending', 'no reason')}); a "
            "run that is compared must have reached its end. Run it again or leave it out."
        )
        return None
    return tree


def _law(name: str, tree: xarray.DataTree) -> str:
    return str(tree.attrs.get("law") or Path(name).stem)


def _labels(
    trees: Mapping[str, xarray.DataTree],
    configurations: Mapping[str, Mapping[str, Any]],
    faults: list[str],
) -> dict[str, str]:
    """A word for every run."""
    laws = {name: _law(name, tree) for name, tree in trees.items()}
    labels = dict(laws)
    for law, count in Counter(laws.values()).items():
        if count == 1:
            continue
        names = [name for name in trees if laws[name] == law]
        keys = {name: law_keys(trees[name], configurations[name]) for name in names}
        labels |= {name: f"{law} ({said})" if said else law for name, said in _apart(keys).items()}
    for label, count in Counter(labels.values()).items():
        if count > 1:
            names = [name for name, mine in labels.items() if mine == label]
            listed = ", ".join(f"'{name}'" for name in names)
            faults.append(
                f"{label} stands in {count} runs with the same parameters, {listed}; a law is "
                "compared once. Leave all but one out."
            )
    return labels


def _apart(keys: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """What sets runs of one law apart: its own keys, those of its parts only as far as is needed."""
    every = dict.fromkeys(key for mine in keys.values() for key in mine)
    differing = [key for key in every if len({shown(k.get(key)) for k in keys.values()}) > 1]
    chosen = [key for key in differing if "." not in key]
    said = _said(keys, chosen)
    for key in (key for key in differing if "." in key):
        if len(set(said.values())) == len(keys):
            break
        longer = _said(keys, [*chosen, key])
        if len(set(longer.values())) > len(set(said.values())):
            chosen.append(key)
            said = longer
    return said


def _said(keys: Mapping[str, Mapping[str, Any]], chosen: Sequence[str]) -> dict[str, str]:
    return {
        name: ", ".join(f"{key} {shown(mine[key])}" for key in chosen if key in mine)
        for name, mine in keys.items()
    }
