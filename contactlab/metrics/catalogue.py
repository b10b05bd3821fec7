"""The catalogue of the metrics: each is declared beside the function that computes it.

A package of one's own adds a metric of runs, a function declared by `metric`, by an entry point:

    [project.entry-points."contactlab.metrics"]
    contact_rate = "their_module:contact_rate"
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Container
from dataclasses import dataclass
from functools import partial
from importlib.metadata import entry_points
from math import inf, isfinite, isnan, nan
from typing import TYPE_CHECKING, Any, Final, final
from warnings import warn

import numpy as np

from contactlab.config.faults import add_place
from contactlab.metrics.run import NotApplicableError, Run, UnknownVariableError

if TYPE_CHECKING:
    import xarray

GROUP: Final = "contactlab.metrics"

Measure = Callable[[Any], float]

VERDICTS: Final = ("n/a", "pass", "fail", "-", "settled", "not settled", "inconclusive")
"""Verdicts in the order of their flags in a file. A metric without a threshold is reported, one that judges
the length of a run settled or not settled, a row of measurements possibly inconclusive."""
NOT_APPLICABLE, PASS, FAIL, REPORTED, SETTLED, UNSETTLED, _ = VERDICTS

ROUND_OFF: Final = 1e-6
"""Relative difference of numbers that are equal in theory: a file may be in single precision."""


@final
@dataclass(frozen=True)
class Metric:
    """One number by which a run is judged, with its meaning, its threshold and the reason for it."""

    key: str  # its name everywhere: in files, tables and code
    measure: Measure  # returns the number, or raises `NotApplicableError`
    symbol: str
    meaning: str
    units: str  # SI, in the words of the CF conventions; "1" without
    bound: float = inf  # the largest value that passes; infinite where it is only reported
    verdicts: tuple[str, str] = (PASS, FAIL)  # up to the bound and beyond it
    reason: str = ""  # for the bound
    source: str = ""
    invariant: bool = False  # holds for every law: where it fails, the solver or the file is wrong
    needs_records: bool = True  # takes other records than the last
    usual: bool = False  # computed by default in a sweep, as it costs next to nothing
    sums: bool = False  # over all contacts, so that it grows with the run

    @property
    def threshold(self) -> str:
        """What the value must be, "<= 0.01"; empty for a number that is only reported."""
        return f"<= {self.bound:g}" if isfinite(self.bound) else ""

    @property
    def judges_law(self) -> bool:
        """Whether a value beyond its bound is a fault of the law."""
        return bool(self.threshold) and FAIL in self.verdicts

    @property
    def conclusion(self) -> str:
        """What follows where the value is beyond its bound."""
        if self.invariant:
            return "the solver or the file is wrong, whatever the law"
        if self.judges_law:
            return "the law is implausible in this motion; nothing follows for other motions or other laws"
        return "nothing on the law"

    @property
    def unit(self) -> str:
        """The unit as it is read, rad/s for rad s-1, with a space before it; nothing without one."""
        return "" if self.units == "1" else " " + re.sub(r" (\w+)-1$", r"/\1", self.units)

    def verdict(self, value: float) -> str:
        """Return one of its `verdicts`, NOT_APPLICABLE for a NaN, or REPORTED."""
        if isnan(value):
            return NOT_APPLICABLE
        if not self.threshold:
            return REPORTED
        return self.verdicts[value > self.bound]


def brief(meaning: str) -> str:
    """Return the meaning of a metric without what explains it."""
    return re.split(r"[:;]|\. ", meaning)[0]


METRICS: Final[dict[str, Metric]] = {}  # of one run
STEP_METRICS: Final[dict[str, Metric]] = {}  # of a ladder of steps
SENSITIVITIES: Final[dict[str, Metric]] = {}  # of a run and its variants

INVARIANTS: Final[dict[str, Metric]] = {}
"""Those metrics of one run that hold whatever its law: where one fails, the solver or the file is wrong."""


def metric(
    symbol: str,
    meaning: str,
    units: str = "1",
    *,
    catalogue: dict[str, Metric] | None = None,
    key: str = "",
    **facts: Any,
) -> Callable[[Measure], Measure]:
    """Declare the function below as a metric, by default of runs; its name is the key where none is given.

    Args:
        symbol, meaning, units: of the number, SI in the words of the CF conventions.
        catalogue: that to which it is added; None is that of one run.
        key: its name everywhere.
        facts: further fields of `Metric`.
    """
    catalogue = METRICS if catalogue is None else catalogue

    def register(measure: Measure) -> Measure:
        entry = Metric(key or measure.__name__, measure, symbol, meaning, units, **facts)
        if entry.key in catalogue:
            raise ValueError(f"The metric {entry.key} is there already; another must have its own name.")
        catalogue[entry.key] = entry
        if entry.invariant:
            INVARIANTS[entry.key] = entry
        return measure

    return register


def add_others() -> None:
    """Import the metrics of other packages; one that cannot be imported is left out with a warning."""
    for point in entry_points(group=GROUP):
        try:
            # A module that is being imported registers its metrics itself.
            if point.module not in sys.modules:
                point.load()
        # A module of another package may fail in any way.
        except Exception as error:
            text = f"The metric {point.name} cannot be imported: {type(error).__name__}: {error}"
            warn(text, RuntimeWarning, stacklevel=2)


# For metrics that hold whatever the law, that take no record but the last, and of a ladder of steps.
invariant, without_records = partial(metric, invariant=True), partial(metric, needs_records=False)
of_steps = partial(metric, catalogue=STEP_METRICS)


def measured(
    catalogue: dict[str, Metric], subject: object, keys: Container[str] | None = None
) -> dict[str, float]:
    """Return the value of every metric, or of some; NaN where it is not applicable or not a number."""
    values = dict.fromkeys((key for key in catalogue if keys is None or key in keys), nan)
    with np.errstate(all="ignore"):
        for key in values:
            try:
                value = float(catalogue[key].measure(subject))
            except UnknownVariableError as error:
                warn(f"The metric {key} asks for {error}", RuntimeWarning, stacklevel=2)
                continue
            except NotApplicableError:
                continue
            # A metric of somebody else may fail in any way; it goes on to who can say so.
            except Exception as error:
                add_place(error, f"the metric {key}")
                raise
            values[key] = value if isfinite(value) else nan
    return values


def assess(run: xarray.DataTree | Run, keys: Container[str] | None = None) -> dict[str, float]:
    """Judge one run, a dataset in the layout of a run.nc (see `contactlab.metrics.read_run`).

    Returns:
        A number for every key of `METRICS`, or for those of them in `keys`, in SI; NaN where the run lacks
        what it needs.
    """
    return measured(METRICS, Run.of(run), keys)
