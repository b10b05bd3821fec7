"""Tables of names that import what they name only when it is asked for: listing them costs nothing."""

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, TypeVar, final

Named = TypeVar("Named")


@final
class Table(Mapping[str, Named]):
    """Classes by the names that they go by, each imported when it is taken out.

    Args:
        entries: "module:Class" by name.
    """

    def __init__(self, entries: Mapping[str, str]) -> None:
        self.entries = dict(entries)

    def __getitem__(self, name: str) -> Named:
        module, _, attribute = self.entries[name].partition(":")
        found: Named = getattr(import_module(module), attribute)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter(self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    def __contains__(self, name: object) -> bool:
        # What a mapping does by itself, to take it out and see, would import it.
        return name in self.entries

    def attribute(self, name: str) -> Any:
        """A class by its own name: the `__getattr__` of a module that exports the table's classes."""
        for entry in self.entries.values():
            module, _, attribute = entry.partition(":")
            if attribute == name:
                return getattr(import_module(module), attribute)
        raise AttributeError(f"There is no {name} here.")
