"""Numbers of `law_practice` as predicates and sentences name them: of whatever number of motors has run."""

from typing import Any

import law_practice
import numpy as np
from contrast_figures import array
from law_practice import MARGIN as MARGIN, TRUTH
from recorded_numbers import value
from verdicts import Number

from contactlab.arrays import Array


def of_practice(name: str) -> Any:
    """Return what is recorded of all motors under a name."""
    return value(f"law_practice/numbers/{name}", "experiments")


def fitting() -> list[str]:
    """Return the laws that are fitted to motors."""
    return [*of_practice("error")]


def fitted() -> int:
    """Return the motors to which every law was fitted."""
    return max(len(of_practice("error")[law]) for law in fitting())


def practised() -> int:
    """Return the motors that have run."""
    return int(of_practice("motors"))


def near(law: str) -> Number:
    """Return the share of motors of which a law, fitted at two points, predicts the third within `MARGIN`."""
    return law_practice.near(array(of_practice("error")[law]))


def quartiles(values: Array) -> tuple[float, float, float]:
    """Return quartiles and median in their order; NaN of no values."""
    low, half, high = np.quantile(values, (0.25, 0.5, 0.75)) if values.size else (np.nan,) * 3
    return float(low), float(half), float(high)


def errors_of(law: str) -> tuple[float, float, float]:
    """Return quartiles and median of the relative error of the prediction."""
    return quartiles(np.expm1(array(of_practice("error")[law])))


def starts_of(law: str) -> tuple[float, float, float]:
    """Return quartiles and median of the time of a start over that of the truth, where both have one."""
    own, truth = (array(of_practice("start")[name]) for name in (law, TRUTH))
    ratio = own / truth
    return quartiles(ratio[np.isfinite(ratio)])


def worst() -> str:
    """Return the law that predicts the fewest motors."""
    return min(fitting(), key=lambda law: np.nan_to_num(near(law).value, nan=2.0))
