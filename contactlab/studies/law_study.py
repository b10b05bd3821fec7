"""Studies of laws by themselves: one task a law, a group and a column for each; and files that they read."""

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final, TypeVar

import xarray

from contactlab.config import ConfigurationError
from contactlab.estimate import Estimate
from contactlab.laws.composed import label_of
from contactlab.studies.study import Setups, Study

_Data = TypeVar("_Data")

NO_LAW: Final = "law is missing; choose one, law=newton, or several, law=newton,poisson."

OF_MOTOR: Final = (
    *("resonator", "piezoceramic", "placement", "drive", "rotor", "solver", "record"),
    *("contact.tip_length", "contact.clearance", "contact.preload"),
)
"""Groups and keys of a configuration on which impacts do not depend."""


@dataclass(frozen=True, kw_only=True)
class LawStudy(Study):
    """Base class of studies of laws without a motor."""

    several: ClassVar[bool] = True
    ignored: ClassVar[tuple[str, ...]] = OF_MOTOR

    @property
    def base(self) -> Mapping[str, Any]:
        """Nothing: without an override there is no law."""
        return {}

    def chosen(self, setups: Setups) -> Setups:
        """Return the setups, or raise a ConfigurationError if there is none."""
        if not setups:
            raise ConfigurationError(NO_LAW)
        return setups

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the data of the laws, a group for each."""
        names = [label_of(setup.law) for setup in setups.values()]
        if len({*names}) < len(names):
            names = [label.replace("/", ".") for label in setups]
        tree = xarray.DataTree(children=dict(zip(names, parts.values(), strict=True)))
        tree.attrs["title"] = self.title(", ".join(names))
        return tree

    @abstractmethod
    def title(self, names: str) -> str:
        """Return the title of the data of laws."""

    @abstractmethod
    def of_group(self, group: xarray.DataTree) -> dict[str, Estimate]:
        """Return the numbers of one law."""

    def columns(self, data: xarray.DataTree) -> dict[str, dict[str, Estimate]]:
        """Return the numbers by the label of the law."""
        return {label: self.of_group(group) for label, group in groups_of(data).items()}

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return the numbers, after the label of one of several laws."""
        every = self.columns(data)
        if len(every) == 1:
            return next(iter(every.values()))
        return {f"{label}.{name}": x for label, own in every.items() for name, x in own.items()}


def groups_of(data: xarray.DataTree) -> dict[str, xarray.DataTree]:
    """Return the groups of a result by the labels of their laws."""
    return {label: tree.copy() for label, tree in data.children.items() if label != "measured"}


def read_file(data: str | Path, read: Callable[[Path], _Data]) -> _Data:
    """Return the measurements of a file.

    Raises:
        ConfigurationError: the file is missing, or cannot be read.
    """
    if not str(data):
        raise ConfigurationError("study.data is missing; it must be a file of measurements.")
    try:
        return read(Path(data))
    except OSError as error:
        raise ConfigurationError(
            f"data is '{data}' and cannot be read ({error.strerror or error})."
        ) from error
    except ValueError as error:
        raise ConfigurationError([f"data: {line}" for line in str(error).splitlines()]) from error
