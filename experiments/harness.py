"""What every experiment shares: its configuration, its output folder, and the four files it leaves.

An experiment is a module with

    SAYS                        what the paper says, in our own words
    study(setup, short)         the numbers, an xarray dataset; `short` is the form that the tests run
    table(data)                 rows of numbers for the CSV file and the terminal
    draw(data)                  the figure
    finding(data)               a sentence made from the numbers by rule, and whether the claim holds

and `conf/experiment/NAME.yaml`, its difference from the default configuration.
"""

import copy
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib.pyplot as plt
import pandas
import xarray
import yaml
from matplotlib.figure import Figure

from contactlab.config import ConfigurationError, Setup, build
from contactlab.laws import ContactLaw, HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.motor import NormalModes
from contactlab.plot.style import STYLE
from contactlab.results.provenance import versions

STIFFNESS = 1e10
"""Of a Hertz contact where a rigid law is configured [N/m^1.5]: a 5 mm steel tip."""

NINE_DIGITS = "{:.9g}".format
"""How tables show numbers."""

DONE, CONTRADICTED, REFUSED = 0, 1, 2
"""Exit statuses; a finding that does not hold is no failure of the script, but nobody shall overlook it."""


@dataclass(frozen=True)
class Result:
    """What an experiment has left.

    Args:
        name: of the experiment.
        title: its first line.
        says: what the paper says.
        sentence: what we find.
        holds: whether the claim holds.
        rows: the table.
        folder: where figure.png, figure.pdf, data.nc and table.csv are.
    """

    name: str
    title: str
    says: str
    sentence: str
    holds: bool
    rows: pandas.DataFrame
    folder: Path


def setup_of(name: str, overrides: Sequence[str] = ()) -> Setup:
    """The checked configuration of an experiment.

    Raises:
        ConfigurationError: with every fault, a sentence each.
    """
    return build([f"experiment={name}", *overrides])


def changed(setup: Setup, changes: Mapping[str, object]) -> Setup:
    """The setup built again with some full keys set otherwise."""
    return build(with_values(setup.configuration, changes))


def with_values(configuration: Mapping[str, Any], changes: Mapping[str, object]) -> dict[str, Any]:
    """A copy of a configuration with some full keys set otherwise."""
    result = copy.deepcopy(dict(configuration))
    for key, value in changes.items():
        *groups, name = key.split(".")
        section = result
        for group in groups:
            section = section[group]
        section[name] = value
    return result


def placed(setup: Setup, start: float, end: float) -> NormalModes:
    """Modes of the configured resonator with the first patch set elsewhere [m]."""
    return changed(setup, {"placement.start": start, "placement.end": end}).motor.modes


def laws_of(setup: Setup) -> dict[str, ContactLaw]:
    """All three laws with the configured friction, and the configured stiffness if the law has one."""
    mu = setup.configuration["contact"]["friction_coefficient"]
    stiffness = setup.configuration["law"].get("stiffness") or STIFFNESS
    return {
        "lagrange_slip": LagrangeSlip(mu),
        "lagrange_stick": LagrangeStick(mu),
        "hertz_penalty": HertzPenalty(stiffness, mu),
    }


def perform(
    module: ModuleType, folder: Path, overrides: Sequence[str] = (), short: bool = False
) -> Result:
    """Run an experiment and write its figure, dataset and table."""
    name = module.__name__.rpartition(".")[2]
    setup = setup_of(name, overrides)
    data: xarray.Dataset = module.study(setup, short)
    sentence, holds = module.finding(data)
    rows = pandas.DataFrame(module.table(data))
    folder.mkdir(parents=True, exist_ok=True)
    title = (module.__doc__ or "").partition("\n")[0]
    data.attrs |= {
        "title": title,
        "finding": sentence,
        "configuration": yaml.safe_dump(setup.configuration, sort_keys=False),
        **versions(),
    }
    data.to_netcdf(folder / "data.nc", engine="netcdf4")
    rows.to_csv(folder / "table.csv", index=False, float_format="%.9g", lineterminator="\n")
    with plt.style.context(STYLE):
        figure: Figure = module.draw(data)
        figure.savefig(folder / "figure.png")
        # No date in the file: the same run gives the same bytes.
        figure.savefig(folder / "figure.pdf", metadata={"CreationDate": None})
    plt.close(figure)
    return Result(name, title, module.SAYS, sentence, holds, rows, folder)


def show(result: Result) -> None:
    """Print the table and the finding."""
    print(result.rows.to_string(index=False, float_format=NINE_DIGITS))
    print(f"\n{'Holds' if result.holds else 'DOES NOT HOLD'}: {result.sentence}")
    print(f"Written to {result.folder}: figure.png, figure.pdf, data.nc, table.csv")


def main(name: str, arguments: Sequence[str] | None = None) -> int:
    """Run one experiment from the command line; returns the exit status.

    python experiments/NAME.py [output=DIR] [KEY=VALUE ...]
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    module: Any = sys.modules[name]
    stem = Path(module.__file__).stem
    if "--help" in words or "-h" in words:
        print(f"{module.__doc__}\nusage: python experiments/{stem}.py [output=DIR] [KEY=VALUE ...]")
        return DONE
    folder = Path("outputs") / "experiments" / stem
    for word in [w for w in words if w.startswith("output=")]:
        folder = Path(word.removeprefix("output="))
        words.remove(word)
    try:
        module.__name__ = stem
        result = perform(module, folder, words)
    except ConfigurationError as error:
        print(*error.faults, sep="\n", file=sys.stderr)
        return REFUSED
    show(result)
    return DONE if result.holds else CONTRADICTED
