"""Parameters that laws share, and the check of a law's values."""

from typing import Any

from contactlab.checks import check_fields
from contactlab.parameter import Parameter, parameters_of

FRICTION_COEFFICIENT = Parameter("mu", "1", "friction coefficient", at_least=0.0)
"""Shared by the laws with Coulomb friction of one coefficient."""

RESTITUTION = Parameter("e", "1", "coefficient of restitution", at_least=0.0, at_most=1.0)
"""Shared by the laws with a restitution, whichever of velocity, impulse or energy it is of."""


def check_parameters(law: Any) -> None:
    """Refuse a law or a part with a parameter that is none, or outside of its range.

    Raises:
        TypeError: with a sentence for each that is no number, or no part of the wanted family.
        ValueError: with a sentence for each that is out of range.
    """
    kind: type = type(law)
    check_fields(law, law.name)
    faults = [
        f"{law.name}: {name} is {getattr(law, name)} {declared.units}; it must be {declared.range}."
        for name, declared in parameters_of(kind).items()
        if not declared.holds(getattr(law, name))
    ]
    if faults:
        raise ValueError(" ".join(faults))
