"""The numbers of a configuration as a person sets them: value, default, unit, meaning and ranges by key."""

from collections.abc import Mapping
from dataclasses import MISSING, dataclass
from typing import Any, Final, Literal, final

from contactlab.config.made_in_python import MotorUnderLaw, variable_numbers
from contactlab.config.nesting import flat
from contactlab.config.schema import numbers_in
from contactlab.parameter import Parameter

LOGARITHMIC: Final = 20.0
"""Ratio of two positive ends from which a scale between them is logarithmic."""


@final
@dataclass(frozen=True)
class Number:
    """A number of a setup, with all that its class declares of it.

        >>> import contactlab as cl
        >>> number = cl.build(["law=newton"]).numbers()["law.restitution"]
        >>> number.value, number.symbol, number.unit, number.usual
        (0.5, 'e', '1', (0.0, 1.0))

    Args:
        key: as `contactlab.build` takes it.
        value: that runs [SI]; None, or the text of a choice, where it is no number.
        default: of the class; None where it has none.
        parameter: the declaration.
        choices: what is admitted in place of a number: None, or texts.
        whole: whether it must be a whole number.
    """

    key: str
    value: float | str | None
    default: float | str | None
    parameter: Parameter
    choices: tuple[Any, ...]
    whole: bool

    @property
    def symbol(self) -> str:
        """Symbol of the equations; empty without one."""
        return self.parameter.symbol

    @property
    def unit(self) -> str:
        """Unit of value, default and ranges, "1" for a pure number."""
        return self.parameter.unit

    @property
    def meaning(self) -> str:
        """What it is, in a few words."""
        return self.parameter.meaning

    @property
    def range(self) -> str:
        """The admitted range in words, empty where every finite number is."""
        return self.parameter.range

    @property
    def usual(self) -> tuple[float, float] | None:
        """Ends of the usual values, both admitted, of which the value may be outside; None without.

        Those that the class declares, or that follow from the default, or without one from the value; see
        `contactlab.Parameter.usual_range`.
        """
        numbers = (x for x in (self.default, self.value) if x and not isinstance(x, str))
        ends = self.parameter.usual_range(next(numbers, None))
        if ends is None or not self.whole:
            return ends
        return float(round(ends[0])), float(round(ends[1]))

    @property
    def scale(self) -> Literal["linear", "log"]:
        """Scale of the usual values, 'log' where positive ends are far apart and no number need be whole."""
        ends = self.usual
        far = ends is not None and not self.whole and 0.0 < LOGARITHMIC * ends[0] <= ends[1]
        return "log" if far else "linear"


def numbers_of(setup: MotorUnderLaw, configuration: Mapping[str, Any], made: bool) -> dict[str, Number]:
    """Return the numbers of what is selected by full key.

    Args:
        setup: motor and law.
        configuration: that of the setup.
        made: whether the setup was made in Python and has the keys of `with_number` alone.
    """
    values = flat(configuration)
    if made:
        fields = {key: field for key, (_, field) in variable_numbers(setup).items()}
    else:
        fields = numbers_in(configuration)
    numbers = {}
    for key, field in fields.items():
        assert field.parameter is not None
        default = None if field.default is MISSING else field.default
        whole = int in field.kinds
        numbers[key] = Number(key, values.get(key), default, field.parameter, field.choices, whole)
    return numbers
