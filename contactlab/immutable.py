"""Arrays and mappings whose content cannot be changed."""

from collections.abc import Mapping
from types import NoneType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, NoReturn, TypeVar, final

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Kind = TypeVar("Kind", bound="np.generic")

PLAIN: Final = frozenset((float, int, bool, str, NoneType))
"""Types of most values of a configuration, which need no closer look."""


def read_only(values: "NDArray[Kind]") -> "NDArray[Kind]":
    """Return an array that cannot be made writable: a copy, or the array itself if it is one."""
    if isinstance(values.base, bytes) and not values.flags.writeable:
        return values
    # Imported here, as below: help needs no NumPy.
    import numpy as np

    order: Literal["C", "F"] = "C" if values.flags.c_contiguous else "F"
    return np.ndarray(values.shape, values.dtype, values.tobytes(order), order=order)


@final
class Frozen(dict[str, Any]):
    """A read-only mapping of read-only values, see `frozen`; it is written, compared and copied as a dict."""

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError(
            "A configuration cannot be changed in place; setup.with_('KEY=VALUE') returns a setup with "
            "another value."
        )

    __setitem__ = __delitem__ = __ior__ = _refuse
    update = pop = popitem = clear = setdefault = _refuse

    def __reduce__(self) -> tuple[type, tuple[dict[str, Any]]]:
        return Frozen, (dict(self),)


def frozen(value: Any) -> Any:
    """Return a value with all mappings in it as `Frozen`, and all lists as tuples."""
    if type(value) in PLAIN or isinstance(value, Frozen):
        return value
    if isinstance(value, Mapping):
        return Frozen({key: x if type(x) in PLAIN else frozen(x) for key, x in value.items()})
    return tuple(map(frozen, value)) if isinstance(value, list | tuple) else value


class Immutable:
    """Base class of frozen dataclasses, `eq=False`, with arrays, whose copies are immutable too.

    Two of one class are equal where all fields are, arrays by their numbers and shapes.
    """

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(getattr(self, name), getattr(other, name)) for name in self.__dataclass_fields__)

    # Arrays have none.
    __hash__ = None  # type: ignore[assignment]

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)
        self.freeze()

    def freeze(self) -> None:
        """Make all arrays in the fields read-only, and all mappings."""
        import numpy as np

        for name, value in vars(self).items():
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, read_only(value))
            elif isinstance(value, Mapping):
                rows = {key: read_only(x) if isinstance(x, np.ndarray) else x for key, x in value.items()}
                object.__setattr__(self, name, frozen(rows))


def _same(first: Any, other: Any) -> bool:
    """Return whether two values of a field are equal."""
    import numpy as np

    if isinstance(first, np.ndarray):
        return isinstance(other, np.ndarray) and first.dtype == other.dtype and np.array_equal(first, other)
    if isinstance(first, Mapping):
        return (
            isinstance(other, Mapping)
            and first.keys() == other.keys()
            and all(_same(x, other[key]) for key, x in first.items())
        )
    return bool(first == other)
