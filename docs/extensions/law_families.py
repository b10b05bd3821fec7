"""The laws and parts by the page that describes them."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from contactlab.laws import LAWS, PARTS, MultiplierLaw
from contactlab.laws.declaration import Declared

PAPER: Final = ("lagrange_slip", "lagrange_stick", "hertz_penalty")
"""The laws of the paper."""


class Family(NamedTuple):
    """Laws or parts of one page: its name and title, the words of a choice, and classes by name."""

    page: str
    title: str
    choice: str
    owners: Mapping[str, type[Declared]]

    def address(self, name: str) -> str:
        """Return where the pages describe a law or part."""
        return f"laws/{self.page}.md#{name}"


_RIGID: Final = {name: law for name, law in LAWS.items() if issubclass(law, MultiplierLaw)}

FAMILIES: Final = (
    Family("paper", "The paper's laws", "law", {name: LAWS[name] for name in PAPER}),
    Family("rigid", "Rigid impacts", "law", {n: law for n, law in _RIGID.items() if n not in PAPER}),
    Family(
        "compliant",
        "Compliant laws",
        "law",
        {name: LAWS[name] for name in LAWS if name not in {*_RIGID, *PAPER}},
    ),
    Family("normal", "Normal forces", "law/normal", PARTS["normal"]),
    Family("damping", "Dampings", "law/damping", PARTS["damping"]),
    Family("friction", "Frictions", "law/friction", PARTS["friction"]),
)
