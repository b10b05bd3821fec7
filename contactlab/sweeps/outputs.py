"""What a sweep keeps of every run: metrics and time series, or the numbers of a study."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import final

from contactlab.config import ConfigurationError
from contactlab.config.studies import study_class
from contactlab.laws import ContactLaw
from contactlab.metrics import METRICS
from contactlab.results.internal import internal_series
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import SERIES
from contactlab.sweeps.values import listed
from contactlab.variables import INTERNAL, Variable


@final
@dataclass(frozen=True)
class Outputs:
    """Names of the metrics and time series that are kept of every run.

    Args:
        metrics: keys of `contactlab.metrics.METRICS`, or the numbers of a study.
        series: names of time series, internal variables of laws included.
        internal: the internal variables among the series, which depend on the laws.
        study: name of the study whose numbers are kept, each with its error, in place of metrics of a run.
    """

    metrics: tuple[str, ...] = tuple(key for key, metric in METRICS.items() if metric.usual)
    series: tuple[str, ...] = ()
    internal: tuple[Variable, ...] = ()
    study: str = ""

    @classmethod
    def of_study(cls, name: str) -> "Outputs":
        """Return the outputs of a study: its numbers."""
        return cls(tuple(variable.name for variable in numbers_of(name)), study=name)

    @classmethod
    def named(cls, metrics: Iterable[str] | str | None, series: Iterable[str] | str) -> "Outputs":
        """Return outputs by names, each once; None is the usual metrics and 'all' all of them.

        Raises:
            ConfigurationError: a name that is no metric or no series, or nothing at all.
        """
        chosen = cls.metrics if metrics is None else METRICS if metrics == "all" else metrics
        asked, faults = [], []
        for kind, names, known in (("metric", chosen, [*METRICS]), ("series", series, [*SERIES])):
            asked.append(tuple(dict.fromkeys(listed(names) if isinstance(names, str) else names)))
            remembered = {name for name in asked[-1] if kind == "series" and name.startswith(INTERNAL)}
            for name in sorted({*asked[-1]} - {*known} - remembered):
                hint = suggestion(name, known, f"One is {known[0]}.")
                there = ", ".join(known)
                faults.append(f"There is no {kind} '{name}'; it must be one of {there}. {hint}")
        if not any(asked):
            faults.append("Nothing is asked for; there must be one metric or series at least.")
        if faults:
            raise ConfigurationError(faults)
        return cls(asked[0], asked[1])

    def of_laws(self, laws: Iterable[ContactLaw]) -> "Outputs":
        """Return the outputs with the internal variables of these laws among the series.

        Raises:
            ConfigurationError: one that no law has, or that is not the same in all that have it.
        """
        asked = {name: set[Variable]() for name in self.series if name not in SERIES}
        there: set[str] = set()
        for law in laws if asked else ():
            for one in internal_series(law):
                there.add(one.name)
                asked.get(one.name, set()).add(one)
        faults = []
        for name, found in asked.items():
            if not found:
                words = ", ".join(sorted(there)) or "nothing under these laws"
                hint = suggestion(name, there)
                faults.append(f"There is no series '{name}'; what is remembered is {words}. {hint}".rstrip())
            elif len(found) > 1:
                said = " and ".join(sorted(f"{one.long_name} [{one.units}]" for one in found))
                faults.append(
                    f"The series '{name}' is {said}; it must be the same under all laws. Leave it out."
                )
        if faults:
            raise ConfigurationError(faults)
        return replace(self, internal=tuple(one for found in asked.values() for one in found))

    @property
    def kept(self) -> tuple[Variable, ...]:
        """The series as variables, once the laws are known."""
        known = SERIES | {one.name: one for one in self.internal}
        return tuple(known[name] for name in self.series)

    @property
    def numbers(self) -> tuple[Variable, ...]:
        """The numbers of a study as variables; none for metrics of a run."""
        return numbers_of(self.study) if self.study else ()

    @property
    def sampled(self) -> bool:
        """Whether more records than the last are needed."""
        return bool(self.series) or any(METRICS[key].needs_records for key in self.metrics if key in METRICS)


def numbers_of(study: str) -> tuple[Variable, ...]:
    """Return the quantities of a study and their errors as variables of a sweep."""
    every = study_class(study).quantities
    errors = (
        replace(
            q, name=f"{q.name}_error", symbol=f"error of {q.symbol}", long_name=f"error of the {q.long_name}"
        )
        for q in every
    )
    return (*every, *errors)
