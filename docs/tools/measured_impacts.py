"""All laws against the published impacts of an ellipse, under several seeds: does their order hold?

    python docs/tools/measured_impacts.py PATH [--output DIR] [--seeds N] [--docs]

PATH is `ellipse_impacts.mat`; docs/measurements.md says where it is from. Every seed deals the impacts into
other folds, starts the fits elsewhere and draws other resamples. Leaves the files of `contactlab validate`
and a table; with --docs the tables and figures of docs/measurements.md as well. Takes a quarter of an hour
on one core; an interrupted one continues.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from shutil import copyfile

import numpy as np
import xarray
from tqdm import tqdm

import contactlab as cl
from contactlab.inference.cross_validation import laws_in
from contactlab.results.files import whole_file
from contactlab.studies.runner import finish
from contactlab.studies.validate import agreement, opposite_orders, parameters, unexplained
from contactlab.studies.validate_figures import abscissas, binned, residuals_of

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "measurements.md"
BEGIN = "<!-- Made by docs/tools/measured_impacts.py: begin. Do not edit. -->"
END = "<!-- Made by docs/tools/measured_impacts.py: end. -->"
FIGURES = ("prediction_error", "paired_differences", "residuals", "impacts")
PREFIX = "ellipses_"


def ordered(seeds: Sequence[xarray.Dataset]) -> list[str]:
    """Return the laws in the order of the means of their errors over the seeds."""
    labels = [str(label) for label in laws_in(seeds[0])["law"].values]
    return sorted(
        labels, key=lambda label: np.mean([entry["prediction_error"].sel(law=label) for entry in seeds])
    )


def error_table(seeds: Sequence[xarray.Dataset]) -> Iterator[str]:
    """Yield the table of all laws, baselines and floors, in Markdown."""
    yield "| law | | held-out error | 95 % interval | over the seeds | not distinct from the one above |"
    yield "|---|---|---|---|---|---|"
    laws, first = ordered(seeds), seeds[0]
    others = [str(label) for label in first["law"].values if label not in laws]
    for place, label in enumerate([*laws, *others]):
        errors = [float(entry["prediction_error"].sel(law=label)) for entry in seeds]
        low, high = first["prediction_error_interval"].sel(law=label).values
        doubt = ""
        if 0 < place < len(laws):
            above = {"law": label, "other": laws[place - 1], "end": "low"}
            count = sum(float(entry["difference_interval"].sel(above)) <= 0.0 for entry in seeds)
            doubt = f"in {count} of {len(seeds)} seeds" if count else ""
        yield (
            f"| `{label}` | {first['kind'].sel(law=label).item()} | {np.mean(errors):.4f} | "
            f"{low:.4f} to {high:.4f} | {min(errors):.4f} to {max(errors):.4f} | {doubt} |"
        )


def parameter_table(first: xarray.Dataset) -> Iterator[str]:
    """Yield the fitted parameters under the first seed, in Markdown."""
    yield "| law | parameter | median of the folds | least to greatest | |"
    yield "|---|---|---|---|---|"
    for row in parameters(first):
        unit = "" if row["unit"] == "1" else f" {row['unit']}"
        yield (
            f"| `{row['law']}` | {row['parameter']} | {row['median']:.4g}{unit} | {row['least']:.4g} to "
            f"{row['greatest']:.4g} | {row['remark']} |"
        )


def restitution_table(first: xarray.Dataset) -> Iterator[str]:
    """Yield the measured ratio of the gap rates over the slip, and the best law's residual, in Markdown."""
    yield "| slip before (m/s) | gap rate after over before | quartiles | residual of the best law (m/s) |"
    yield "|---|---|---|---|"
    best = str(first["law"].values[0])
    ratio = -first["velocity_after"].values[:, 0] / first["velocity_before"].values[:, 0]
    slip = abscissas(first)["slip velocity (m/s)"]
    seen = binned(slip, ratio)
    missed = binned(slip, residuals_of(first, best)["gap rate residual (m/s)"])
    for at, middle, low, high, left in zip(*seen[:4], missed.median, strict=True):
        yield f"| {at:.2f} | {middle:.3f} | {low:.2f} to {high:.2f} | {left:+.3f} |"


def main(arguments: Sequence[str] | None = None) -> int:
    """Validate the laws and write tables; the exit status is 1 if the order of two laws is contradictory."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("path", type=Path)
    parser.add_argument("--output", type=Path, default=Path("outputs") / "measured_impacts")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument(
        "--docs", action="store_true", help="write tables and figures of docs/measurements.md"
    )
    options = parser.parse_args(arguments)
    with tqdm(desc="laws and seeds", disable=None) as bar:

        def show(done: int, total: int) -> None:
            bar.total = total
            bar.update(done - bar.n)

        result = cl.validate(
            options.path, repeats=options.seeds, workers=options.workers, folder=options.output, progress=show
        )
    finish(result, options.output)
    seeds = [result.data.to_dataset(), *(child.to_dataset() for child in result.data.children.values())]
    sentences = agreement(seeds)
    tables = [error_table(seeds), parameter_table(seeds[0]), restitution_table(seeds[0])]
    blocks = ["\n".join(each) for each in tables]
    text = "\n\n".join(["\n".join(sentences), *blocks])
    with whole_file(options.output / "table.md") as partial:
        partial.write_text(text + "\n", encoding="utf-8")
    print(text)
    if options.docs:
        first, *others = blocks
        _into_docs(
            "\n\n".join([first, *sentences, f"Under seed 0: {unexplained(seeds[0])}", *others]),
            options.output,
        )
    return int(bool(opposite_orders(seeds)))


def _into_docs(block: str, folder: Path) -> None:
    """Put tables and figures into the page, whose text is written by hand."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    with whole_file(PAGE) as partial:
        partial.write_text(f"{before}{BEGIN}\n\n{block}\n\n{END}{after}", encoding="utf-8")
    pictures = PAGE.with_suffix("")
    pictures.mkdir(exist_ok=True)
    for name in FIGURES:
        copyfile(folder / f"{name}.png", pictures / f"{PREFIX}{name}.png")


if __name__ == "__main__":
    sys.exit(main())
