"""A run's numbers as the metrics ask for them; what is not there stops the metric that asked."""

import json
from collections.abc import Mapping
from functools import cached_property
from typing import Any, Final, final

import numpy as np
import xarray
import yaml
from numpy.typing import NDArray

Array = NDArray[np.float64]

LAST_SHARE: Final = 0.25
"""Share of the run whose whole drive periods stand for its end: after it, what starts a motor from rest
has mostly died down, and several periods still fit in."""


class NotApplicableError(Exception):
    """A dataset lacks what a metric needs, or has nothing for it to measure."""


def needed(held: bool) -> None:
    """Stop a metric that has nothing to measure.

    Raises:
        NotApplicableError: the condition does not hold.
    """
    if not held:
        raise NotApplicableError


@final
class Record:
    """A dataset seen by the metrics.

    Args:
        tree: in the layout of a run.nc, see `contactlab.plausibility.read_run`.
    """

    def __init__(self, tree: xarray.DataTree) -> None:
        self._root = tree.to_dataset(inherit=False)
        group = tree.children.get("contacts")
        self._contacts = xarray.Dataset() if group is None else group.to_dataset(inherit=False)

    @cached_property
    def time(self) -> Array:
        """Of the records [s]."""
        return np.asarray(self._root["time"].values, dtype=np.float64)

    @cached_property
    def intervals(self) -> Array:
        """Lengths of the record intervals [s], one less than records."""
        return np.diff(self.time)

    def series(self, name: str) -> Array:
        """A series over time, all of it finite.

        Raises:
            NotApplicableError: it is not there, or has gaps.
        """
        return _finite(self._root, name)

    def contacts(self, name: str) -> Array:
        """A column of the contacts, of which there is at least one.

        A separation velocity may be missing (NaN); any other number may not.

        Raises:
            NotApplicableError: the column or any contact is not there.
        """
        needed(name in self._contacts.variables and self._contacts[name].size > 0)
        column = np.asarray(self._contacts[name].values, dtype=np.float64)
        needed(name == "separation_velocity" or bool(np.isfinite(column).all()))
        return column

    def touch_downs(self) -> Array:
        """Start times of the contacts [s]; empty where there is none, or none is known."""
        try:
            return self.contacts("start_time")
        except NotApplicableError:
            return np.empty(0)

    @cached_property
    def configuration(self) -> Mapping[str, Any]:
        """The configuration that ran; empty where it is not known."""
        try:
            read = yaml.safe_load(str(self._root.attrs.get("configuration", "")))
        except yaml.YAMLError:
            return {}
        return read if isinstance(read, Mapping) else {}

    @cached_property
    def law_parameters(self) -> dict[str, float]:
        """The law's parameters by name, SI; empty where they are not known."""
        try:
            read = json.loads(str(self._root.attrs.get("law_parameters", "")))
        except ValueError:
            return {}
        return read if isinstance(read, dict) else {}

    @property
    def law(self) -> str:
        """The law's name; empty where it is not known."""
        return str(self._root.attrs.get("law", ""))

    @property
    def contact_step(self) -> float:
        """Largest step in contact [s]; zero where it is not known."""
        given = self._root.attrs.get("contact_step", 0.0)
        return float(given) if isinstance(given, int | float | np.number) else 0.0

    def setting(self, section: str, key: str) -> float:
        """A number of the configuration, SI.

        Raises:
            NotApplicableError: it is not there.
        """
        found = self.configuration.get(section)
        value = found.get(key) if isinstance(found, Mapping) else None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise NotApplicableError
        return float(value)

    def last_periods(self) -> slice:
        """Records of the last whole drive periods that fit into the last quarter of the run.

        At least one period; where the drive's frequency is not known, the whole quarter.

        Raises:
            NotApplicableError: the run is shorter than a drive period.
        """
        start, end = self.time[0], self.time[-1]
        length = LAST_SHARE * (end - start)
        try:
            period = 1.0 / self.setting("drive", "frequency")
        except (NotApplicableError, ZeroDivisionError):
            pass
        else:
            # A quarter that holds a whole number may miss it by round-off.
            length = max(np.floor(length / period * (1.0 + 1e-12)), 1.0) * period
        first = int(np.argmin(np.abs(self.time - (end - length))))
        half = 0.5 * self.intervals.max()
        needed(end - length >= start - half and first < self.time.size - 1)
        return slice(first, self.time.size)

    def amplitude(self) -> float:
        """Of the tip's normal vibration [m]: half of its range over the last whole drive periods.

        Raises:
            NotApplicableError: it is not recorded, or zero.
        """
        half = 0.5 * float(np.ptp(self.series("tip_normal_displacement")[self.last_periods()]))
        needed(half > 0.0)
        return half

    def tangential_amplitude(self) -> float:
        """Of the tip's tangential velocity v + R Omega [m/s], as `amplitude`.

        Raises:
            NotApplicableError: it is not recorded, or zero.
        """
        radius = self.setting("rotor", "radius")
        tip = self.series("slip_velocity") + radius * self.series("rotor_velocity")
        half = 0.5 * float(np.ptp(tip[self.last_periods()]))
        needed(half > 0.0)
        return half

    def contact_force(self) -> float:
        """Mean normal force while there is contact [N]: all impulses over all durations.

        The scale of forces: unlike the peak it does not depend on the step of a rigid law.

        Raises:
            NotApplicableError: there is no contact, or no impulse.
        """
        duration = float(self.contacts("duration").sum())
        impulse = float(np.abs(self.contacts("normal_impulse")).sum())
        needed(duration > 0.0 and impulse > 0.0)
        return impulse / duration


def _finite(dataset: xarray.Dataset, name: str) -> Array:
    needed(name in dataset.variables)
    values = np.asarray(dataset[name].values, dtype=np.float64)
    needed(bool(np.isfinite(values).all()))
    return values
