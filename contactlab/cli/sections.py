"""The study of a command, and how the runs of -m are made: its configuration beside that of a run."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Final, Literal, final

from omegaconf import DictConfig

from contactlab.checks import Checked
from contactlab.config.composition import resolved
from contactlab.config.faults import faults_added, raise_faults
from contactlab.config.groups import Section, keys_of
from contactlab.config.schema import Examination
from contactlab.parameter import Parameter
from contactlab.studies.keys import STUDIES, study_in
from contactlab.studies.study import Study

_declared = partial(Parameter, "", "1")
_Names = list[str] | str | None


@final
@dataclass(frozen=True)
class Sweep(Checked):
    """How the runs of a sweep are made, and what is kept of them."""

    keep: Annotated[Literal["runs", "metrics"], _declared("a folder a run, or numbers alone")] = "runs"
    metrics: Annotated[_Names, _declared("names of metrics that are kept, or all")] = None
    series: Annotated[_Names, _declared("names of time series that are kept as well")] = None
    samples: Annotated[str | None, _declared("table whose columns are keys and whose rows are runs")] = None
    over: Annotated[_Names, _declared("values by which the setups of one study differ, as law=A,B")] = None
    chunk: Annotated[int | None, _declared("runs of a task, which one process does", at_least=1)] = None
    workers: Annotated[int | None, _declared("processes at work", at_least=1, at_most=1000)] = None


SECTIONS: Final[dict[str, Section]] = {"sweep": Section({"default": keys_of(Sweep)}), "study": STUDIES}


def of_run(config: DictConfig) -> dict[str, Any]:
    """Return the configuration of the run that a command composes, not yet checked.

    Raises:
        ConfigurationError: a reference has no value.
    """
    return {group: keys for group, keys in resolved(config).items() if group not in SECTIONS}


def sweep_in(section: Mapping[str, Any]) -> Sweep:
    """Return how the runs of a command are made.

    Raises:
        ConfigurationError: with every fault.
    """
    examined = Examination({"sweep": section}, {"sweep": SECTIONS["sweep"]}, ())
    raise_faults(examined.faults)
    return Sweep(**examined.values["sweep"])


def of_command(config: DictConfig) -> tuple[Study, Sweep]:
    """Return the study of a command, and how its runs are made.

    Raises:
        ConfigurationError: with every fault.
    """
    sections, faults = resolved(config), list[str]()
    with faults_added(faults):
        study = study_in(sections["study"])
    with faults_added(faults):
        sweep = sweep_in(sections["sweep"])
    raise_faults(faults)
    return study, sweep
