"""How long and how finely a motor is simulated, what is recorded, and how sweeps are made."""

from dataclasses import dataclass
from typing import Annotated, Literal, final

from contactlab.checks import Checked
from contactlab.parameter import Parameter, positive


@final
@dataclass(frozen=True)
class Solver(Checked):
    """How long and how finely to integrate."""

    duration: Annotated[float, positive("T", "s", "simulated time")] = 0.02
    contact_step: Annotated[
        float | None,
        positive(
            "h", "s", "largest step in contact", hint="Leave it out for the law's own default."
        ),
    ] = None
    tolerance: Annotated[
        float | None,
        Parameter(
            *("", "1", "relative tolerance in contact, compliant laws only"),
            at_least=1e-14,
            at_most=1e-2,
            hint="Leave it out for the solver's own default.",
        ),
    ] = None


@final
@dataclass(frozen=True)
class Record(Checked):
    """What is kept; it does not change the motion."""

    interval: Annotated[float, positive("", "s", "time between records")] = 1e-6
    picture: Annotated[bool, Parameter("", "1", "whether run.png is drawn; it takes long")] = True


@final
@dataclass(frozen=True)
class Sweep:
    """How the runs of a sweep are made, and what is kept of them: no part of a run's own configuration."""

    keep: Annotated[
        Literal["runs", "metrics"], Parameter("", "1", "a folder a run, or numbers alone")
    ] = "runs"
    metrics: Annotated[
        list[str] | str | None, Parameter("", "1", "names of metrics that are kept, or all")
    ] = None
    series: Annotated[
        list[str] | str | None, Parameter("", "1", "names of time series that are kept as well")
    ] = None
    samples: Annotated[
        str | None, Parameter("", "1", "table whose columns are keys and whose rows are runs")
    ] = None
    chunk: Annotated[
        int | None,
        Parameter("", "1", "runs that are kept together as they are finished", at_least=1),
    ] = None
    workers: Annotated[int | None, Parameter("", "1", "processes at work", at_least=1)] = None
