"""How long and how finely a motor is simulated, and what is recorded: what is no physics of a run."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.checks import check_fields
from contactlab.parameter import Parameter


@final
@dataclass(frozen=True)
class Solver:
    """How long and how finely to integrate."""

    duration: Annotated[float, Parameter("T", "s", "simulated time", above=0.0)] = 0.02
    contact_step: Annotated[
        float | None,
        Parameter(
            *("h", "s", "largest step while in contact"),
            above=0.0,
            hint="Leave it out for the law's own default.",
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

    def __post_init__(self) -> None:
        check_fields(self)


@final
@dataclass(frozen=True)
class Record:
    """What is kept; it does not change the motion."""

    interval: Annotated[float, Parameter("", "s", "time between records", above=0.0)] = 1e-6
    picture: Annotated[
        bool, Parameter("", "1", "whether run.png is drawn; it takes longer than a usual run")
    ] = True

    def __post_init__(self) -> None:
        check_fields(self)
