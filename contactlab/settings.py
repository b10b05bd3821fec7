"""How long and how finely a motor is simulated, what is recorded, and how sweeps are made."""

from dataclasses import dataclass
from functools import partial
from typing import Annotated, Literal, final

from contactlab.checks import Checked
from contactlab.parameter import Parameter, positive

_Names = list[str] | str | None
_said = partial(Parameter, "", "1")
_STEP = positive(
    "h", "s", "largest step in contact", hint="Leave it out for the law's own default."
)
_TOLERANCE = Parameter(
    *("", "1", "relative tolerance in contact, compliant laws only"),
    at_least=1e-14,
    at_most=1e-2,
    hint="Leave it out for the solver's own default.",
)
_SAMPLES = _said("table whose columns are keys and whose rows are runs")
_CHUNK = _said("runs kept together as they are finished", at_least=1)


@final
@dataclass(frozen=True)
class Solver(Checked):
    """How long and how finely to integrate."""

    duration: Annotated[float, positive("T", "s", "simulated time")] = 0.02
    contact_step: Annotated[float | None, _STEP] = None
    tolerance: Annotated[float | None, _TOLERANCE] = None


@final
@dataclass(frozen=True)
class Record(Checked):
    """What is kept; it does not change the motion."""

    interval: Annotated[float, positive("", "s", "time between records")] = 1e-6
    picture: Annotated[bool, _said("whether run.png is drawn; it takes long")] = True


@final
@dataclass(frozen=True)
class Sweep(Checked):
    """How the runs of a sweep are made, and what is kept of them: no part of a run's own configuration."""

    keep: Annotated[Literal["runs", "metrics"], _said("a folder a run, or numbers alone")] = "runs"
    metrics: Annotated[_Names, _said("names of metrics that are kept, or all")] = None
    series: Annotated[_Names, _said("names of time series that are kept as well")] = None
    samples: Annotated[str | None, _SAMPLES] = None
    chunk: Annotated[int | None, _CHUNK] = None
    workers: Annotated[int | None, _said("processes at work", at_least=1)] = None
