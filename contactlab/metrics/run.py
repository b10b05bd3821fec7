"""A run with the accessors that metrics and comparison use, and the reading of a dataset with its layout."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from inspect import getattr_static
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab import variables
from contactlab.arrays import Array
from contactlab.checks import check_declared
from contactlab.config.changes import KEY as CHANGES, changed
from contactlab.config.faults import ConfigurationError
from contactlab.config.nesting import flat
from contactlab.laws.base import Damping, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.memory import Remembering
from contactlab.laws.registry import PARTS, class_of
from contactlab.motor import Drive
from contactlab.quantity import UnitError, to_si
from contactlab.results.files import damage
from contactlab.results.netcdf import (
    configuration_of,
    contacts_in,
    groups_of,
    keep_contents,
    lasting_in,
    period_in,
)
from contactlab.settling.verdict import Settling, drive_period, settling_of
from contactlab.suggestion import excerpt, suggestion
from contactlab.trajectory import Trajectory
from contactlab.variables import Variable

if TYPE_CHECKING:
    import xarray

LAST_SHARE: Final = 0.25
"""Share of the run whose whole drive periods represent its end."""


class NotApplicableError(Exception):
    """A dataset lacks what a metric needs."""


class UnknownVariableError(NotApplicableError):
    """A metric asks for a variable that no dataset has."""


def needed(condition: object) -> None:
    """Raise `NotApplicableError` unless a metric has what it needs."""
    if not condition:
        raise NotApplicableError


def _missing(name: str, kind: str, known: Iterable[Variable]) -> NotApplicableError:
    """Return what a variable is missing as: of this run, or known to no dataset."""
    names = [variable.name for variable in known]
    # Names that laws, electrodes and points give are those of one motor.
    if name in names or name.startswith((variables.INTERNAL, variables.POINT, "charge_", "current_")):
        return NotApplicableError()
    return UnknownVariableError(
        f"{name!r}, a {kind} that no dataset has. {suggestion(name, names, 'There are ' + ', '.join(names))}"
    )


def positive(scale: float) -> float:
    """Return a scale; raise `NotApplicableError` if it is not positive."""
    needed(scale > 0.0)
    return scale


def has_limits(owner: Any) -> bool:
    """Return whether a law or a part defines the gaps at which a contact begins and ends."""
    limits = getattr_static(owner, "limits", None)
    idle = [base.__dict__.get("limits") for base in (Remembering, PenaltyLaw, Composed, Damping)]
    return limits is not None and limits not in idle


@final
@dataclass(frozen=True)
class Run:
    """A run, from its dataset or from memory; methods raise `NotApplicableError` where data are missing."""

    columns: Mapping[str, NDArray[Any]]  # of the root
    rows: Mapping[str, NDArray[Any]]  # a number a contact
    configuration: Mapping[str, Any]
    law: str
    law_parameters: Mapping[str, float]
    contact_step: float  # largest step in contact [s]; zero where there is none
    attributes: Mapping[Any, Any] = field(default_factory=dict)
    sound: bool = False  # its numbers are known to be finite
    source: str = ""  # where it is from
    label: str = ""  # beside other runs
    lasting: tuple[str, ...] = ()  # columns of internal variables whose life is the run
    drive: Drive | None = None  # of a run in memory, whose dataset has attributes

    @classmethod
    def of(cls, source: xarray.DataTree | Run) -> Run:
        """Return the run of a dataset in the layout of a run.nc; a run is returned as it is."""
        if isinstance(source, Run):
            return source
        groups = groups_of(source)
        text, step = source.attrs, source.attrs.get("contact_step", 0.0)
        parameters: dict[str, Any] = {}
        with suppress(ValueError, TypeError):
            parameters = dict(json.loads(str(text.get("law_parameters", ""))))
        return cls(
            columns=groups["/"].values,
            rows=contacts_in(groups),
            configuration=configuration_of(source.attrs),
            law=str(text.get("law", "")),
            law_parameters={k: x for k, x in parameters.items() if isinstance(x, int | float)},
            contact_step=float(step) if isinstance(step, int | float | np.number) else 0.0,
            attributes=text,
            lasting=lasting_in(groups["/"].variables),
        )

    @classmethod
    def of_trajectory(cls, trajectory: Trajectory, configuration: Mapping[str, Any]) -> Run:
        """Return the run of a trajectory; the numbers are those of its dataset."""
        return cls(
            columns={"contact_mode": trajectory.contact_mode, **trajectory.series, "time": trajectory.time},
            rows=trajectory.contacts_within,
            configuration=configuration,
            law=trajectory.law.name,
            law_parameters=trajectory.law.describe(),
            contact_step=trajectory.contact_step,
            sound=trajectory.ending.reached_end,
            lasting=trajectory.lasting,
            drive=trajectory.motor.drive,
        )

    @cached_property
    def time(self) -> Array:
        """Times of the records [s]."""
        return np.asarray(self.columns["time"], dtype=np.float64)

    @cached_property
    def intervals(self) -> Array:
        """Lengths of the record intervals [s], one less than records."""
        return np.diff(self.time)

    @cached_property
    def settings(self) -> dict[str, Any]:
        """The configuration by full key."""
        return flat(self.configuration)

    @cached_property
    def period(self) -> float:
        """Period of the drive's first tone [s]; zero where it is not known."""
        try:
            return 1.0 / self.setting("drive.frequency")
        except (NotApplicableError, ZeroDivisionError):
            return 0.0

    @cached_property
    def _drive_period(self) -> float:
        """Period after which all tones repeat themselves [s]; zero for none."""
        return drive_period(self.drive) if self.drive else period_in(self.attributes, self.configuration)

    @property
    def periods(self) -> float:
        """Periods of the drive that the run lasts, not rounded [1]; one where it has none."""
        return self.gain("time") / self._drive_period if self._drive_period else 1.0

    @cached_property
    def settling(self) -> Settling:
        """Whether the motor has settled, and to what."""
        return settling_of(self.columns, self.rows, self._drive_period, self.lasting)

    def holds(self, name: str) -> bool:
        """Return whether the root has this variable."""
        return name in self.columns

    def touches(self, name: str) -> bool:
        """Return whether there is a contact, with this column."""
        return name in self.rows and self.rows[name].size > 0

    def series(self, name: str) -> Array:
        """Return a series over time, all of it finite."""
        if not self.holds(name):
            raise _missing(
                name, "series", (variables.TIME, variables.CONTACT_MODE, variables.BEARING, *variables.SERIES)
            )
        return self._numbers(self.columns[name])

    def gain(self, name: str, span: slice = slice(None)) -> float:
        """Return the increase of a series over all or some of the records."""
        values = self.series(name)[span]
        return float(values[-1] - values[0])

    def contacts(self, name: str) -> Array:
        """Return a column of the contacts, at least one; only gap rates may be missing, of those cut."""
        if not self.touches(name):
            raise _missing(name, "column of contacts", (*variables.CONTACTS, *variables.IMPACTS))
        return self._numbers(self.rows[name], may_miss=name in ("approach_velocity", "separation_velocity"))

    def whole_contacts(self, name: str) -> Array:
        """Return a column of the contacts that begin and end within the run, at least one."""
        values = self.contacts(name)
        whole = np.ones(values.size, dtype=bool)
        for rate in ("approach_velocity", "separation_velocity"):
            whole &= np.isfinite(self.rows.get(rate, values))
        needed(whole.any())
        return values[whole]

    def _numbers(self, values: NDArray[Any], *, may_miss: bool = False) -> Array:
        numbers = np.asarray(values, dtype=np.float64)
        needed(self.sound or may_miss or np.isfinite(numbers).all())
        return numbers

    def setting(self, key: str) -> float:
        """Return a number of the configuration by its full key, SI."""
        value = self.settings.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise NotApplicableError
        return float(value)

    def course(self, key: str, unit: str) -> list[tuple[float, slice]]:
        """Return the values of a setting one after the other, which changes may change, and their records."""
        values, ends = [self.setting(key)], [0]
        changes = self.settings.get(CHANGES) or ()
        duration = self.setting("solver.duration") if changes else 0.0
        try:
            for time, later in changed(self.configuration, changes, duration):
                values.append(to_si(str(flat(later)[key]), unit))
                ends.append(int(np.argmin(np.abs(self.time - time))))
        except (ConfigurationError, UnitError) as fault:
            raise NotApplicableError from fault
        ends.append(self.time.size - 1)
        return [(value, slice(ends[i], ends[i + 1] + 1)) for i, value in enumerate(values)]

    def integral(self, key: str, unit: str, name: str) -> float:
        """Return the integral of a setting over the increase of a series."""
        return sum(value * self.gain(name, span) for value, span in self.course(key, unit))

    @cached_property
    def law_classes(self) -> dict[str, Any]:
        """The class of the law, under "", and those of its parts by family; none if it is not installed."""
        chosen = {family: self.settings.get(f"law.{family}.name") for family in PARTS}
        names = {"": self.law} | {family: str(name) for family, name in chosen.items() if name}
        try:
            return {family: class_of(name, family) for family, name in names.items()}
        except ValueError:
            return {}

    def last_periods(self) -> slice:
        """Return the records of the last whole drive periods in the last quarter of the run, at least one.

        Without a known frequency of the drive it is the whole quarter.
        """
        start, end = self.time[0], self.time[-1]
        length = LAST_SHARE * (end - start)
        if self.period:
            # A quarter that holds a whole number may miss it by round-off.
            length = max(np.floor(length / self.period * (1.0 + 1e-12)), 1.0) * self.period
        first = int(np.argmin(np.abs(self.time - (end - length))))
        half = 0.5 * self.intervals.max()
        needed(end - length >= start - half and first < self.time.size - 1)
        return slice(first, self.time.size)

    def amplitude(self, motion: Array) -> float:
        """Return half of the range of a motion over the last whole drive periods, which is not zero."""
        return positive(0.5 * float(np.ptp(motion[self.last_periods()])))

    def normal_amplitude(self) -> float:
        """Return the amplitude of the tip's normal vibration [m]."""
        return self.amplitude(self.series("tip_normal_displacement"))

    def contact_force(self) -> float:
        """Return all impulses over all durations [N], a scale of forces that does not depend on the step."""
        impulse = positive(float(np.abs(self.contacts("normal_impulse")).sum()))
        return impulse / positive(float(self.contacts("duration").sum()))


def read_run(source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Read a run.nc, or another file or tree in the same layout; the file is closed again.

    Metrics that need variables missing from it are not applicable.

    Raises:
        ValueError: the file cannot be read, is not as its run left it, or is laid out otherwise.
    """
    return checked_run(opened(Path(source)) if isinstance(source, str | Path) else source, source)


def checked_run(tree: xarray.DataTree, source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Return a tree that has the layout of a run.

    Raises:
        ValueError: it is laid out otherwise.
    """
    for fault in _faults(tree):
        text = f"'{source}'" if isinstance(source, str | Path) else "The dataset"
        raise ValueError(
            f"{text} has {fault} The layout is that of a run.nc, which `contactlab` writes; a variable may "
            "be left out, never be misnamed."
        )
    return tree


def is_complete(tree: xarray.DataTree) -> bool:
    """Return whether the run of a dataset reached its end; True without the attribute `complete`."""
    return bool(tree.attrs.get("complete", 1))


def opened(path: Path) -> xarray.DataTree:
    """Return the tree of a netCDF-4 file, checked to be as it was left; the file is closed again.

    Raises:
        ValueError: it cannot be read, or is damaged.
    """
    # Imported here: runs are written and assessed without.
    import xarray

    if not path.is_file():
        raise ValueError(f"'{path}' is not there; it must be a netCDF-4 file in the layout of a run.nc.")
    try:
        if not (damaged := damage(path)):
            check_declared(path)
            # Seconds are numbers here, not dates.
            with xarray.open_datatree(path, engine="netcdf4", decode_times=False) as opened:
                tree = opened.load()
                keep_contents(tree)
                return tree
    except (OSError, ValueError, LookupError, RuntimeError, AttributeError, TypeError) as fault:
        raise ValueError(
            f"'{path}' cannot be read as netCDF-4 ({getattr(fault, 'strerror', None) or fault}); it must be "
            "a whole file in the layout of a run.nc."
        ) from fault
    raise ValueError(damaged)


def _faults(tree: xarray.DataTree) -> Iterator[str]:
    """Yield what the metrics would misread in a layout."""
    root, known = tree.to_dataset(inherit=False), (*variables.SERIES, variables.CONTACT_MODE)
    names = [variable.name for variable in known]
    if "time" not in root.variables or root["time"].dims != ("time",):
        yield "no variable 'time' over a dimension 'time' at its root; it must have one, in seconds."
    yield from _misread(root, (variables.TIME, *known))
    time = root["time"].values
    if time.size < 2 or not np.all(np.diff(time) > 0.0):
        yield (
            f"{time.size} times that do not all increase; there must be at least two, strictly "
            "increasing, in seconds."
        )
    if root.variables.keys().isdisjoint(names):
        yield f"none of the time series; it must have at least one of {', '.join(names)}."
    text = tree.attrs.get("complete", 1)
    if np.size(text) != 1 or text not in (0, 1):
        yield (
            f"the attribute complete = {excerpt(repr(text))}; it must be 1 for a run that reached its "
            "end and 0 for another."
        )
    if group := tree.children.get("contacts"):
        yield from _misread(group.to_dataset(inherit=False), variables.CONTACTS)


def _misread(data: xarray.Dataset, known: Iterable[Variable]) -> Iterator[str]:
    """Yield which known variables have other dimensions or units, or are no numbers."""
    for must in (variable for variable in known if variable.name in data.variables):
        values = data[must.name]
        units = values.attrs.get("units", must.units)
        if values.dims != must.dims:
            yield f"'{must.name}' over {values.dims}; it must be over {must.dims}."
        if values.dtype.kind not in "fiu":
            yield f"'{must.name}' as {values.dtype}; it must be real numbers in {must.units}."
        if units != must.units:
            yield f"'{must.name}' in {excerpt(repr(units))}; it must be in {must.units!r}."
