"""The study `bench`: contact questions with exact answers, put to laws."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
import pandas
import xarray

from contactlab.estimate import Estimate
from contactlab.laws import ContactLaw
from contactlab.studies.function import function_of, of_laws
from contactlab.studies.law_study import LawStudy
from contactlab.studies.study import Part, Setups, Task, listing
from contactlab.studies.tables import table_of_quantities
from contactlab.variables import Variable
from contactlab_data.studies.bench.questions import CREATED, errors_of, questions
from contactlab_data.studies.bench.responses import responses_of

SECONDS: Final = Variable("seconds", (), "s", "t", "processor time")

DIGITS: Final = 3
"""Digits of an error."""

KEPT: Final = ("question", "at", "quantity", "exact")
"""Fields of a case that stand beside its answer."""


@dataclass(frozen=True, kw_only=True)
class Bench(LawStudy):
    """Does a law stick, does it keep its energy, does it rebound as its numbers say?

    Contact questions with exact answers: creep in the cone, sliding, drift, stick-slip on a belt,
    restitution, oblique impacts, Painleve's rod, Kane's double pendulum, a ball that comes to rest. Friction
    and restitution are those of a question, all else is the law's: contactlab bench law=newton,poisson.

        >>> import contactlab as cl
        >>> round(cl.bench(cl.Newton()).numbers["energy_created"].value, 3)
        2.111

    Raises:
        LawError: a law contradicts itself, or its own code raised an exception, which is the cause.
        ConfigurationError: there is no law.
        OSError: the folder cannot be written to.
    """

    name: ClassVar[str] = "bench"
    quantities: ClassVar[tuple[Variable, ...]] = (*(x.variable for x in questions()[1]), CREATED, SECONDS)

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return one task a law."""
        return [Task(label, _answered, (setup.law,)) for label, setup in self.chosen(setups).items()]

    def title(self, names: str) -> str:
        """Return the title of the data."""
        return f"Contact questions put to {names}"

    def of_group(self, group: xarray.DataTree) -> dict[str, Estimate]:
        """Return the errors of a law's answers; NaN without an answer."""
        values = {**errors_of(group["response"].to_numpy()), SECONDS: float(group["seconds"].sum())}
        return {variable.name: Estimate(x, 0.0) for variable, x in values.items()}

    def findings(self, data: xarray.DataTree) -> list[str]:
        """Return which laws create energy, to what they have no answer, and their largest errors."""
        result, every = list[str](), self.columns(data)
        for label, numbers in every.items():
            if (created := numbers[CREATED.name].value) > 0.0:
                result.append(f"{label} creates energy: {created:.3g} of that before an impact, at most.")
            responses = zip(data[label]["response"].to_numpy(), questions()[0], strict=True)
            if silent := dict.fromkeys(case.question for x, case in responses if np.isnan(x)):
                result.append(f"{label} has no answer to {', '.join(silent)}.")
        errors = [each for each in self.quantities if each not in (CREATED, SECONDS)]
        return result + [f"{label}, largest errors: {listing(errors, own)}." for label, own in every.items()]

    def tables(self, data: xarray.DataTree) -> dict[str, pandas.DataFrame]:
        """Return the largest errors, a column a law."""
        errors = table_of_quantities(self.quantities, self.columns(data), "Largest errors")
        errors.attrs["digits"] = DIGITS
        return {self.name: errors}


def _answered(law: ContactLaw) -> Part:
    responses, seconds = responses_of(law)
    columns: dict[str, Any] = {"response": responses, "seconds": seconds}
    columns |= {name: [getattr(case, name) for case in questions()[0]] for name in KEPT}
    return Part(xarray.DataTree(xarray.Dataset({name: ("case", x) for name, x in columns.items()})))


bench = function_of(Bench, of_laws)
