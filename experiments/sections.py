"""Sections of docs/results: what makes each, and its short form, which has the same laws and keys."""

from collections.abc import Callable
from pathlib import Path
from shutil import copyfile
from typing import Any, Final, NamedTuple

from all import BEYOND, PAPER, numbers_of
from dependencies import ROOT, Recorder
from experiment import class_of, setup_of

from contactlab.studies.study import Result, finish, run

PICTURES: Final = {
    **{name: "docs/paper" for name in PAPER if name.startswith("fig")},
    **dict.fromkeys(("published_motor", "law_contrasts", "law_practice"), "docs/measurements"),
}
"""Folders of the experiments' pictures that pages show."""


class Section(NamedTuple):
    """A section of a file of results.

    Args:
        make: returns the results, from a file of measurements or the folder of a run, and with a folder to
            write to.
        short: returns those of the short form, from a file of measurements.
    """

    make: Callable[[Path, Path], Any]
    short: Callable[[Path], Any]


# A script is imported where its sections are made: what runs meanwhile is recorded.


def of_motor(name: str) -> Section:
    """Return a section of the motor."""
    from motor_findings import SECTIONS

    make, short = SECTIONS[name]
    return Section(lambda *_: make(), lambda *_: short())


def of_accuracy(name: str) -> Section:
    """Return a section on the accuracy of runs and fits."""
    from accuracy import SECTIONS

    make, short = SECTIONS[name]
    return Section(lambda *_: make(), lambda *_: short())


LONG: Final = ("law_contrasts", "law_practice")
"""Experiments of many hours, whose sections are made from the folders of their runs."""


def of_run(name: str, folder: Path) -> Result:
    """Return the result of an experiment of `LONG` from the folder of its run."""
    class_of(name)
    from contrast_run import RUNS, result_of

    return result_of(folder, RUNS[name], setup_of(name))


def of_experiment(name: str) -> Section:
    """Return the section of an experiment."""

    def make(source: Path, folder: Path) -> dict[str, Any]:
        result = of_run(name, source) if name in LONG else run(class_of(name)(), {"": setup_of(name)})
        numbers = numbers_of(result)
        # What draws decides no number.
        Recorder.stop()
        finish(result, folder)
        if name in PICTURES:
            for picture in folder.glob(f"{name}*.png"):
                copyfile(picture, ROOT / PICTURES[name] / picture.name)
        return numbers

    def short(source: Path) -> dict[str, Any]:
        del source
        return numbers_of(run(class_of(name)(short=True), {"": setup_of(name)}))

    return Section(make, short)


def of_measurements(name: str) -> Section:
    """Return a section of the measurements."""
    from measurement_results import SECTIONS

    return Section(*SECTIONS[name])


def keys() -> list[tuple[str, str]]:
    """Return file and name of every section."""
    from accuracy import SECTIONS as OF_ACCURACY
    from measurement_results import SECTIONS as MEASURED
    from motor_findings import SECTIONS

    named = {
        "accuracy": OF_ACCURACY,
        "motor": SECTIONS,
        "experiments": (*PAPER, *BEYOND),
        "measurements": MEASURED,
    }
    return [(file, name) for file, names in named.items() for name in names]


FILES: Final = {
    "accuracy": of_accuracy,
    "motor": of_motor,
    "experiments": of_experiment,
    "measurements": of_measurements,
}
"""Files of docs/results, and what returns a section of each."""
