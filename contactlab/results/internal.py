"""What a law remembers, as quantities that a run records: over time, and where each contact ended."""

from collections.abc import Mapping
from typing import Any, Final

from contactlab.laws import ContactLaw, InternalVariable
from contactlab.laws.memory import ODD
from contactlab.variables import INTERNAL, Variable

LIVES: Final = {"contact": "Begins anew in every contact.", "run": "Goes on from contact to contact."}


def internal_series(law: ContactLaw) -> tuple[Variable, ...]:
    """Give the internal variables of a law as root variables over time."""
    return tuple(_recorded(one, "time", one.meaning) for one in law.internal_variables)


def internal_contacts(law: ContactLaw) -> tuple[Variable, ...]:
    """Give them as variables of the contacts: the value that each ended with."""
    return tuple(
        _recorded(one, "contact", f"{one.meaning}, where the contact ended") for one in law.internal_variables
    )


def lasting_in(variables: Mapping[Any, Any]) -> tuple[str, ...]:
    """Return the names of the internal variables whose life is the run among a dataset's variables."""
    return tuple(
        str(name)
        for name, each in variables.items()
        if str(name).startswith(INTERNAL) and str(each.attrs.get("comment")).startswith(LIVES["run"])
    )


def _recorded(one: InternalVariable, dimension: str, meaning: str) -> Variable:
    mirrored = " Changes its sign in a mirror." if one.parity == ODD else ""
    comment = LIVES[one.life] + mirrored
    return Variable(INTERNAL + one.name, (dimension,), one.units, one.symbol, meaning, comment=comment)
