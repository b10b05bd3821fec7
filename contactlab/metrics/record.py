"""A run's numbers as the metrics ask for them; what is not there stops the metric that asked."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.results.netcdf import configuration_of
from contactlab.trajectory import Trajectory

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
@dataclass(frozen=True)
class Record:
    """A run as the metrics see it.

    Args:
        columns: `time` and the series over it.
        rows: the contacts, a number each.
        configuration: that ran; empty where it is not known.
        law: the law's name; empty where it is not known.
        law_parameters: the law's parameters by name, SI; empty where they are not known.
        contact_step: largest step in contact [s]; zero where it is not known.
        sound: whether its numbers are known to be finite, as those of a run in memory are that reached
            its end.
    """

    columns: Mapping[str, NDArray[Any]]
    rows: Mapping[str, NDArray[Any]]
    configuration: Mapping[str, Any]
    law: str
    law_parameters: Mapping[str, float]
    contact_step: float
    sound: bool = False

    @classmethod
    def of_tree(cls, tree: xarray.DataTree) -> "Record":
        """A dataset in the layout of a run.nc, see `contactlab.metrics.read_run`."""
        group = tree.children.get("contacts")
        step = tree.attrs.get("contact_step", 0.0)
        return cls(
            columns=_values(tree),
            rows={} if group is None else _values(group),
            configuration=configuration_of(tree),
            law=str(tree.attrs.get("law", "")),
            law_parameters=_law_parameters(tree),
            contact_step=float(step) if isinstance(step, int | float | np.number) else 0.0,
        )

    @classmethod
    def of_trajectory(cls, trajectory: Trajectory, configuration: Mapping[str, Any]) -> "Record":
        """A run in memory; the same numbers as from its dataset."""
        return cls(
            columns={
                "time": trajectory.time,
                **trajectory.series,
                "contact_mode": trajectory.contact_mode,
            },
            rows=trajectory.contacts,
            configuration=configuration,
            law=trajectory.law.name,
            law_parameters=trajectory.law.describe(),
            contact_step=trajectory.contact_step,
            sound=trajectory.ending.reached_end,
        )

    @cached_property
    def time(self) -> Array:
        """Of the records [s]."""
        return np.asarray(self.columns["time"], dtype=np.float64)

    @cached_property
    def intervals(self) -> Array:
        """Lengths of the record intervals [s], one less than records."""
        return np.diff(self.time)

    def series(self, name: str) -> Array:
        """A series over time, all of it finite.

        Raises:
            NotApplicableError: it is not there, or has gaps.
        """
        needed(name in self.columns)
        values = np.asarray(self.columns[name], dtype=np.float64)
        needed(self.sound or bool(np.isfinite(values).all()))
        return values

    def contacts(self, name: str) -> Array:
        """A column of the contacts, of which there is at least one.

        A separation velocity may be missing (NaN); any other number may not.

        Raises:
            NotApplicableError: the column or any contact is not there.
        """
        needed(name in self.rows and self.rows[name].size > 0)
        column = np.asarray(self.rows[name], dtype=np.float64)
        may_miss = name == "separation_velocity"
        needed(self.sound or may_miss or bool(np.isfinite(column).all()))
        return column

    def contact_count(self) -> int:
        """Number of contacts.

        Raises:
            NotApplicableError: contacts are not recorded.
        """
        needed("start_time" in self.rows)
        return int(self.rows["start_time"].size)

    def touch_downs(self) -> Array:
        """Start times of the contacts [s]; empty where there is none, or none is known."""
        try:
            return self.contacts("start_time")
        except NotApplicableError:
            return np.empty(0)

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


def _values(tree: xarray.DataTree) -> dict[str, NDArray[Any]]:
    variables = tree.to_dataset(inherit=False).variables
    return {str(name): variable.values for name, variable in variables.items()}


def _law_parameters(tree: xarray.DataTree) -> dict[str, float]:
    """What the law's attribute holds; empty where it cannot be read."""
    try:
        found = json.loads(str(tree.attrs.get("law_parameters", "")))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
