"""How long and how finely a motor is simulated, and what is recorded: what is no physics of a run."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.checks import check_fields
from contactlab.parameter import Parameter, positive


@final
@dataclass(frozen=True)
class Solver:
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

    def __post_init__(self) -> None:
        check_fields(self)


@final
@dataclass(frozen=True)
class Record:
    """What is kept; it does not change the motion."""

    interval: Annotated[float, positive("", "s", "time between records")] = 1e-6
    picture: Annotated[bool, Parameter("", "1", "whether run.png is drawn; it takes long")] = True

    def __post_init__(self) -> None:
        check_fields(self)
