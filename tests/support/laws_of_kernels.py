"""Laws of kernels of choice."""

from collections.abc import Mapping
from dataclasses import field, make_dataclass
from typing import Annotated, Any, Final

from contactlab.laws import MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT

KERNELS: Final = {"force", "friction_force", "impact", "bound", "rate", "guard", "jump", "limits"}

FRICTION: Final = {"friction_coefficient": (FRICTION_COEFFICIENT, 0.3)}
"""Parameters of a law by their names, each with its declaration and its default."""


def law_class_of(
    base: type, title: str, parameters: Mapping[str, tuple[Any, float]] = FRICTION, **members: Any
) -> Any:
    """Return a class of laws with these kernels, declarations and parameters."""
    step = 5e-8 if issubclass(base, MultiplierLaw) else 4e-6
    namespace = {
        "name": title,
        "equation": "see its kernels",
        "source": "this test",
        "default_contact_step": step,
    }
    namespace |= {name: staticmethod(x) if name in KERNELS else x for name, x in members.items()}
    fields = [(name, Annotated[float, text], field(default=x)) for name, (text, x) in parameters.items()]
    return make_dataclass("Law", fields, bases=(base,), namespace=namespace, frozen=True)
