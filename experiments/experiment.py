"""Experiments: studies of this project, each a claim with the data, table, figure and finding that test it.

An experiment is a subclass of `Experiment` in a file NAME.py, and `conf/experiment/NAME.yaml` is its
difference from the default configuration. The first line of the file's docstring is its title.

    python experiments/NAME.py [output=DIR] [OPTION=VALUE ...] [KEY=VALUE ...]

is the command of a study (`--help` lists the options). Exit status 1 means that the finding does not hold.
"""

import sys
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, NoReturn

import matplotlib.pyplot as plt
import pandas
import xarray
import yaml
from matplotlib.figure import Figure

import contactlab as cl
from contactlab.cli.main import main as command
from contactlab.processes import processors
from contactlab.results.provenance import versions
from contactlab.studies.registry import register
from contactlab.studies.study import Part, Result, Setups, Study, Task, finish, option, run
from contactlab.studies.tables import table

CONF: Final = Path(__file__).resolve().parents[1] / "conf" / "experiment"
OUTPUTS: Final = Path("outputs") / "experiments"

DONE, CONTRADICTED, REFUSED = 0, 1, 2
"""Exit statuses."""


@dataclass(frozen=True, kw_only=True)
class Experiment(Study):
    """Base class of experiments; the name of one is that of its module."""

    says: ClassVar[str]
    """The claim that is tested, in our own words."""

    ignored: ClassVar[tuple[str, ...]] = ()

    short: Annotated[bool, option("whether the short form, which the tests run, is computed")] = False

    def __init_subclass__(cls) -> None:
        cls.name = cls.__module__

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task; experiments that take long return several."""
        (setup,) = setups.values()
        return [Task(self.name, computed, (self, setup))]

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Return the data of an experiment of one task."""
        raise NotImplementedError

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return the data from those of the tasks."""
        del setup
        (data,) = parts
        return data

    @abstractmethod
    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return the rows of the table."""

    @abstractmethod
    def draw(self, data: xarray.Dataset) -> Figure:
        """Return the figure."""

    @abstractmethod
    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """Return a sentence made from the numbers, and whether the claim holds."""

    @property
    def title(self) -> str:
        """The first line of the module's docstring."""
        return (sys.modules[type(self).__module__].__doc__ or "").partition("\n")[0]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the data with title, claim, finding, configuration and versions."""
        (setup,) = setups.values()
        data = self.join(setup, [part.to_dataset() for part in parts.values()])
        sentence, holds = self.finding(data)
        configuration = yaml.safe_dump(setup.configuration, sort_keys=False)
        data.attrs |= {"title": self.title, "says": self.says, "finding": sentence, "holds": int(holds)}
        data.attrs |= {"configuration": configuration, **versions()}
        return xarray.DataTree(data)

    def numbers(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return no numbers: an experiment is not swept."""
        del data
        return {}

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return the claim and the finding."""
        verdict = "agrees with" if data.attrs["holds"] else "CONTRADICTS"
        both = f"Claim: {data.attrs['says']}", f"Finding: {data.attrs['finding']}"
        return [*both, f"The finding {verdict} the claim."]

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return the table."""
        return {"table": table(self.rows(data.to_dataset()))}

    def figures(self, data: xarray.DataTree) -> dict[str, Figure]:
        """Return the figure."""
        figure = self.draw(data.to_dataset())
        plt.close(figure)
        return {self.name: figure}


def computed(experiment: Experiment, setup: cl.Setup) -> Part:
    """Compute an experiment of one task."""
    return part_of(experiment.compute(setup))


def part_of(data: xarray.Dataset) -> Part:
    """Return a dataset as the result of a task."""
    return Part(xarray.DataTree(data))


def class_of(name: str) -> type[Experiment]:
    """Return the experiment of a module and add it to the studies of this process."""
    module = import_module(name)
    (experiment,) = (
        item
        for item in vars(module).values()
        if isinstance(item, type) and issubclass(item, Experiment) and item.__module__ == name
    )
    register(name, f"{name}:{experiment.__name__}")
    return experiment


def setup_of(name: str, overrides: Sequence[str] = ()) -> cl.Setup:
    """Return the checked configuration of an experiment.

    Raises:
        ConfigurationError: with every fault.
    """
    own = [f"experiment={name}"] if (CONF / f"{name}.yaml").is_file() else []
    return cl.build([*own, *overrides])


def perform(name: str, folder: Path, **options: Any) -> Result:
    """Run an experiment and write its files."""
    result = run(class_of(name)(**options), {"": setup_of(name)}, folder)
    finish(result, folder)
    return result


def main(file: str) -> NoReturn:
    """Run the experiment of a file with the arguments of the command line, and exit with the status."""
    name = Path(file).stem
    class_of(name)
    arguments, folder = [f"workers={processors()}", *sys.argv[1:]], OUTPUTS / name
    for word in [word for word in arguments if word.startswith("output=")]:
        folder = Path(word.removeprefix("output="))
        arguments.remove(word)
    own = [f"experiment={name}"] if (CONF / f"{name}.yaml").is_file() else []
    sys.argv[1:] = [name, *own, *arguments, f"output={folder}"]
    status = command()
    data = folder / f"{name}.nc"
    if status == DONE and data.is_file() and not {"--help", "-h"} & {*arguments}:
        with xarray.open_dataset(data, engine="netcdf4") as collected:
            status = DONE if collected.attrs["holds"] else CONTRADICTED
    sys.exit(status)
