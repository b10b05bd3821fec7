"""All laws against the published impacts of an ellipse, over several seeds: does their order hold?

    python docs/tools/measured_impacts.py PATH [--output DIR] [--seeds N] [--docs]

PATH is `ellipse_impacts.mat`; docs/measurements.md says where it is from. Every seed deals the impacts into
other folds, starts the fits elsewhere and draws other resamples. Leaves a study for each seed and a table;
with --docs the tables and figures of docs/measurements.md as well. Takes a quarter of an hour on one core;
what was stopped goes on.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from shutil import copyfile
from typing import NamedTuple

import numpy as np
import xarray
from tqdm import tqdm

from contactlab.inference.cross_validation_data import laws_in
from contactlab.inference.residuals import abscissas, binned, residuals_of
from contactlab.inference.study import study
from contactlab.measured.files import read_impacts
from contactlab.results.files import whole_file
from contactlab.studies import validate_tables as tables
from contactlab.studies.validate_page import write

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "measurements.md"
BEGIN = "<!-- Made by docs/tools/measured_impacts.py: begin. Do not edit. -->"
END = "<!-- Made by docs/tools/measured_impacts.py: end. -->"
FIGURES = ("prediction_error", "paired_differences", "residuals", "impacts")
PREFIX = "ellipses_"


class Weighed(NamedTuple):
    """What the seeds say of two laws: in how many the first beats the second, and the other way round."""

    first: str
    second: str
    wins: int
    losses: int
    seeds: int

    @property
    def contradicts(self) -> bool:
        """Whether both beat each other, by their intervals, in different seeds."""
        return self.wins > 0 and self.losses > 0

    @property
    def settled(self) -> bool:
        """Whether one beats the other in every seed."""
        return max(self.wins, self.losses) == self.seeds


def weighed(studies: Sequence[xarray.Dataset]) -> list[Weighed]:
    """Count over the seeds who beats whom, for every two laws in the order of their mean errors."""
    result = []
    for first, second in combinations(ordered(studies), 2):
        ends = [item["difference_interval"].sel(law=first, other=second).values for item in studies]
        wins, losses = (sum(bool(test) for test in tests) for tests in _signs(ends))
        result.append(Weighed(first, second, wins, losses, len(studies)))
    return result


def _signs(ends: Sequence[np.ndarray]) -> tuple[list[bool], list[bool]]:
    return [high < 0.0 for _, high in ends], [low > 0.0 for low, _ in ends]


def ordered(studies: Sequence[xarray.Dataset]) -> list[str]:
    """Return the laws in the order of their errors' means over the seeds."""
    labels = [str(label) for label in laws_in(studies[0])["law"].values]
    return sorted(labels, key=lambda label: mean_of(studies, label))


def mean_of(studies: Sequence[xarray.Dataset], label: str) -> float:
    """Return the mean over the seeds of an error."""
    return float(np.mean([item["prediction_error"].sel(law=label) for item in studies]))


def table(studies: Sequence[xarray.Dataset]) -> Iterator[str]:
    """Return the table of all laws, baselines and floors, in Markdown."""
    heads = (
        "law",
        "",
        "held-out error",
        "95 % interval",
        "over the seeds",
        "not distinguishable from the above",
    )
    yield f"| {' | '.join(heads)} |"
    yield "|---|---|---|---|---|---|"
    laws, first = ordered(studies), studies[0]
    others = [str(label) for label in first["law"].values if label not in laws]
    pairs = {(item.first, item.second): item for item in weighed(studies)}
    for place, label in enumerate([*laws, *others]):
        errors = [float(item["prediction_error"].sel(law=label)) for item in studies]
        low, high = first["prediction_error_interval"].sel(law=label).values
        above = pairs.get((laws[place - 1], label)) if 0 < place < len(laws) else None
        doubt = f"in {above.seeds - above.wins} of {above.seeds} seeds" if above and not above.settled else ""
        yield (
            f"| `{label}` | {first['kind'].sel(law=label).item()} | {np.mean(errors):.4f} | "
            f"{low:.4f} to {high:.4f} | {min(errors):.4f} to {max(errors):.4f} | {doubt} |"
        )


def parameter_table(first: xarray.Dataset) -> Iterator[str]:
    """Return what was fitted under the first seed, in Markdown."""
    yield "| law | parameter | median of the folds | least to greatest | |"
    yield "|---|---|---|---|---|"
    for item in tables.parameters(first):
        unit = "" if item.units == "1" else f" {item.units}"
        yield (
            f"| `{item.law}` | {item.name} | {item.middle:.4g}{unit} | {item.low:.4g} to {item.high:.4g} | "
            f"{item.doubt} |"
        )


def restitution_table(first: xarray.Dataset) -> Iterator[str]:
    """Return the measured ratio of the gap rates over the slip, and what the best law misses, in Markdown."""
    yield "| slip before (m/s) | gap rate after over before | quartiles | missed by the best law (m/s) |"
    yield "|---|---|---|---|"
    best = str(first["law"].values[0])
    ratio = -first["velocity_after"].values[:, 0] / first["velocity_before"].values[:, 0]
    slip = abscissas(first)["slip (m/s)"]
    seen = binned(slip, ratio)
    missed = binned(slip, residuals_of(first, best)["gap rate missed (m/s)"])
    for at, middle, low, high, left in zip(*seen[:4], missed.median, strict=True):
        yield f"| {at:.2f} | {middle:.3f} | {low:.2f} to {high:.2f} | {left:+.3f} |"


def finding(studies: Sequence[xarray.Dataset]) -> list[str]:
    """Return whether the order of the laws is the same under every seed, where intervals part them."""
    every = weighed(studies)
    settled = [item for item in every if item.settled]
    against = [item for item in every if item.contradicts]
    never = [item for item in every if item.wins == item.losses == 0]
    stated = [
        f"Of {len(every)} pairs of laws {len(settled)} are parted by their intervals in the same order under "
        f"all {len(studies)} seeds, {len(never)} under none, the others under some; {len(against)} in "
        "opposite orders under two of them."
    ]
    stated += [f"{item.first} and {item.second} beat each other under different seeds." for item in against]
    odd = [set(item["impact"].values[item["unexplained"].values != 0].tolist()) for item in studies]
    stated.append(
        f"No law explains {len(set.intersection(*odd))} impacts under any seed, and "
        f"{len(set.union(*odd))} under one at least."
    )
    return stated


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the studies and write what they say; returns the exit status, 1 where the order does not hold."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("path", type=Path)
    parser.add_argument("--output", type=Path, default=Path("outputs") / "measured_impacts")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument(
        "--docs", action="store_true", help="write tables and figures of docs/measurements.md"
    )
    options = parser.parse_args(arguments)
    impacts = read_impacts(options.path)
    studies = []
    for seed in range(options.seeds):
        folder = options.output / f"seed_{seed}"
        with tqdm(total=100.0, desc=f"seed {seed}", unit=" %", disable=None) as bar:
            data = study(
                impacts,
                seed=seed,
                workers=options.workers,
                keep=folder,
                progress=lambda share, bar=bar: bar.update(100.0 * share - bar.n),
                announce=tqdm.write,
            )
        write(data, folder)
        studies.append(data)
    stated = finding(studies)
    lines = [
        *stated,
        "",
        *table(studies),
        "",
        *parameter_table(studies[0]),
        "",
        *restitution_table(studies[0]),
    ]
    with whole_file(options.output / "table.md") as partial:
        partial.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))
    if options.docs:
        _into_docs(studies, stated, options.output / "seed_0")
    return int(any(item.contradicts for item in weighed(studies)))


def _into_docs(studies: Sequence[xarray.Dataset], stated: Sequence[str], folder: Path) -> None:
    """Put tables and figures into the page, whose text is written by hand."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(BEGIN)
    _, _, after = rest.partition(END)
    first = studies[0]
    texts = tables.unexplained(first)
    odd = f"Under seed 0 {texts[0].lower()}{texts[1:]}"
    block = [BEGIN, ""]
    for part in (table(studies), stated, [odd], parameter_table(first), restitution_table(first)):
        block += [*part, ""]
    with whole_file(PAGE) as partial:
        partial.write_text(before + "\n".join(block) + END + after, encoding="utf-8")
    pictures = PAGE.with_suffix("")
    pictures.mkdir(exist_ok=True)
    for name in FIGURES:
        copyfile(folder / f"{name}.png", pictures / f"{PREFIX}{name}.png")


if __name__ == "__main__":
    sys.exit(main())
