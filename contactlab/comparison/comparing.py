"""Runs of several laws in one motor -> scorecard, tables, figures and a report."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import xarray

from contactlab.comparison.report import write_page
from contactlab.comparison.reruns import RERUNS, Refined, refined
from contactlab.comparison.runs import Run, Source, collect
from contactlab.comparison.scorecard import scorecard
from contactlab.comparison.tables import as_csv, as_latex
from contactlab.results.files import whole_file, whole_netcdf

TEXT: Final = {"scorecard.csv": as_csv, "scorecard.tex": as_latex}
DATASET: Final = "metrics.nc"
REPORT: Final = "report.html"


def compare(
    sources: Sequence[Source], output: str | Path | None = None, *, refine: bool = True
) -> xarray.Dataset:
    """Compare contact laws in one motor.

    Args:
        sources: run folders, their datasets, folders of such folders, or runs in memory; all of one
            motor with one drive.
        output: folder for tables, figures and the report, made where it is missing; None writes
            nothing.
        refine: whether every law is run again at finer steps, with more friction and on a larger basis;
            what follows from these is not applicable without.

    Returns:
        Values, verdicts and numerical errors over the dimensions `law` and `metric`, the energy flow over
        `law` and `term`.

    Raises:
        ComparisonError: the runs cannot be compared; a sentence each.
        OSError: the folder cannot be written to.
    """
    runs, notes = collect(sources)
    laws = _refined(runs) if refine else [Refined(run) for run in runs]
    data = scorecard(laws, notes)
    if output is not None:
        _write(data, laws, Path(output))
    return data


def _refined(runs: list[Run]) -> list[Refined]:
    """Every run with its reruns; a bar on a terminal."""
    from tqdm import tqdm

    laws = []
    with tqdm(total=RERUNS * len(runs), unit=" runs", disable=None, delay=1.0, leave=False) as bar:
        for number, run in enumerate(runs, 1):
            bar.set_description(run.label)
            laws.append(refined(run, bar.update))
            # One that could not be run again has not advanced the bar.
            bar.update(RERUNS * number - bar.n)
    return laws


def _write(data: xarray.Dataset, laws: list[Refined], folder: Path) -> None:
    # They bring the plotting.
    from contactlab.comparison.figures import draw_all, write_all

    folder.mkdir(parents=True, exist_ok=True)
    for name, of in TEXT.items():
        _write_text(of(data), folder / name)
    with whole_netcdf(folder / DATASET) as partial:
        data.to_netcdf(partial, engine="netcdf4")
    figures = draw_all(laws, data)
    write_all(figures, folder)
    _write_text(write_page(data, folder, figures), folder / REPORT)


def _write_text(text: str, path: Path) -> None:
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8")
