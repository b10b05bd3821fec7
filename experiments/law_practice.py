"""How well does a law predict a motor to which its numbers are fitted?

This is the plan, written with that of `law_contrasts` before a motor ran: the motors are the first `MOTORS`
of `motor_population`. A law whose friction coefficient and restitution are fitted to the speeds at two
voltages under `TRUTH` predicts the third: |ln| of its ratio to the truth, by law. Beside it stand the times
in which the motor starts from rest under each law with the numbers as drawn.

How the search is made came later: it begins with the numbers as drawn, has `MOST_EVALUATIONS` evaluations
and follows the orbits that it knows; where its result has other speeds from rest, it begins again with motors
that all come from rest. `johnson` was left out for its cost when nearly half of the motors had run: its
restitution comes to one as the speed falls, and a fit of it to a pressed motor had not ended after most of an
hour.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final

import matplotlib.pyplot as plt
import numpy as np
import xarray
from contrast_figures import LAW, WIDTH, Numbers, array, cloud, rows
from experiment import Experiment, main, part_of
from law_contrasts import POINTS, begin, law_at, log_speeds, recorded, settle
from matplotlib.figure import Figure
from motor_population import LAWS
from scipy.optimize import least_squares
from verdicts import NONE, Number, less, share, some

import contactlab as cl
from contactlab.arrays import Array
from contactlab.estimate import Estimate
from contactlab.studies.characterise.transients import start_time
from contactlab.studies.study import Part, Setups, Task, option
from contactlab_data.inference.known_orbits import KnownOrbits

MOTORS: Final = 64

FITTED: Final = tuple(law for law in LAWS if law != "johnson")
"""Laws that are fitted."""

TRUTH: Final = "flores, mindlin"
"""The law that stands for the motor to which others are fitted: the one with most in it."""

FREE: Final = {"friction coefficient": (0.02, 1.5), "restitution": (0.02, 0.98)}
"""Numbers that are fitted to a motor, with their bounds."""

FIT_STEP, MOST_EVALUATIONS, MISSED = 0.01, 8, 3.0
"""Relative step of the finite differences of a fit, its most evaluations, and the residual of a motor that
has no steady state."""

ALIKE: Final = 1e-3
"""Difference of ln |speed| up to which a motion that was followed is that which is reached from rest."""

MARGIN: Final = 0.05
"""Error of a prediction of the speed that is small, as by default a difference of two laws is."""

BRIEF: Final = (3,)
BRIEF_LAWS: Final = ("poisson", TRUTH)
"""Motors and laws of the short form."""


def prediction_error(name: str, motor: Mapping[str, Any], speed: float, truth: Array) -> float:
    """Return |ln| of predicted over true speed where no law was fitted, infinite where the motor stands.

    It is NaN where the law cannot be had, or the truth stands or has no steady state at a point.

    Args:
        name: of the law.
        motor: as drawn.
        speed: of its own impacts [m/s].
        truth: ln |speed| at `POINTS`.
    """

    def residuals(logarithms: Array) -> Array:
        return np.nan_to_num(logarithms - truth[1:], nan=MISSED, neginf=-MISSED)

    def objective(known: KnownOrbits | None) -> Callable[[Array], Array]:
        return lambda values: residuals(
            log_speeds(name, motor | changed(values), speed, POINTS[1:], known, values)
        )

    def changed(values: Array) -> dict[str, float]:
        return dict(zip(FREE, values.tolist(), strict=True))

    if not np.isfinite(truth).all():
        return float("nan")
    start = [np.clip(motor[key], *bounds) for key, bounds in FREE.items()]
    bounds = np.transpose([*FREE.values()])
    try:
        for known in (KnownOrbits(), None):
            fit = least_squares(
                objective(known), start, bounds=bounds, diff_step=FIT_STEP, max_nfev=MOST_EVALUATIONS
            )
            predicted = log_speeds(name, motor | changed(fit.x), speed, POINTS)
            if np.allclose(residuals(predicted[1:]), fit.fun, rtol=0.0, atol=ALIKE):
                break
    # A law may have no such restitution.
    except ValueError:
        return float("nan")
    return float(abs(predicted[0] - truth[0]))


def time_to_start(name: str, motor: Mapping[str, Any], made: cl.Motor, speed: float) -> Estimate:
    """Return the time in which a motor starts, NaN where it has no steady state under the law."""
    try:
        state = settle(made, law_at(name, motor, made, speed))[1]
    except ValueError:
        state = None
    return start_time(state.setup, state.velocity.value) if state else Estimate(np.nan, np.nan)


def practised(number: int, laws: Sequence[str] = FITTED) -> Part:
    """Return the errors of laws that are fitted to a motor, and the times in which it starts."""
    motor, made, speed = begin(number)
    truth = log_speeds(TRUTH, motor, speed, POINTS)
    starts = [time_to_start(name, motor, made, speed) for name in laws]
    data = {
        "number": number,
        "prediction_error": ("law", [prediction_error(name, motor, speed, truth) for name in laws]),
        "start_time": ("law", [start.value for start in starts]),
        "start_time_error": ("law", [start.error for start in starts]),
    }
    return part_of(xarray.Dataset(data, {"law": [*laws]}))


def near(errors: Array) -> Number:
    """Return the share of motors whose speed is predicted within `MARGIN`."""
    return share(int((errors < np.log1p(MARGIN)).sum()), errors.size) if errors.size else NONE


def fitted(data: xarray.Dataset) -> dict[str, Array]:
    """Return the errors of each law in the motors to which every law was fitted."""
    own = data["prediction_error"].dropna("motor").transpose("law", "motor")
    return {str(law): errors for law, errors in zip(own["law"].values, own.values, strict=True)}


@dataclass(frozen=True, kw_only=True)
class LawPractice(Experiment):
    """Does a fit of friction and restitution make good for what a law lacks?"""

    says = "Some law, fitted at two operating points, misses the third speed of most motors by over 5 %."

    motors: Annotated[int, option("motors, the first ones of the population", at_least=2)] = MOTORS

    def tasks(self, setups: Setups) -> Iterator[Task]:
        """Yield a task a motor."""
        del setups
        for number in BRIEF if self.short else range(self.motors):
            yield Task(f"{number:04d}", practised, (number, BRIEF_LAWS if self.short else FITTED))

    def join(self, setup: cl.Setup, parts: Sequence[xarray.Dataset]) -> xarray.Dataset:
        """Return everything by motor."""
        del setup
        return xarray.concat(parts, "motor")

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Return the laws: quartiles of the error, and the share of motors within `MARGIN`."""
        rows: list[dict[str, object]] = []
        for law, errors in fitted(data).items():
            low, middle, high = np.quantile(errors, (0.25, 0.5, 0.75)) if errors.size else 3 * [np.nan]
            own = near(errors)
            rows.append(
                {"law": law, "motors": errors.size, "error": middle, "lower": low, "upper": high}
                | {"near": own.value, "low": own.low, "high": own.high}
            )
        return rows

    def numbers(self, data: xarray.DataTree) -> dict[str, Any]:
        """Return errors by law of the motors to which every law was fitted, and the times of all starts."""
        own = data.to_dataset()
        starts = own["start_time"].transpose("law", "motor")
        return {
            "motors": own.sizes["motor"],
            "error": {law: [*map(recorded, errors.tolist())] for law, errors in fitted(own).items()},
            "start": {
                str(law): [*map(recorded, times.values.tolist())]
                for law, times in zip(own["law"].values, starts, strict=True)
            },
        }

    def draw(self, data: xarray.Dataset) -> Figure:
        """Draw how far each law misses the speed at the third operating point."""
        return missed(self.numbers(xarray.DataTree(data)))

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """State how often each law predicts the third speed."""
        errors = fitted(data)
        own, motors = {law: near(x) for law, x in errors.items()}, min(x.size for x in errors.values())
        each = ", ".join(
            f"{law} in {100 * share.value:.0f} % ({100 * share.low:.0f} to {100 * share.high:.0f} %)"
            for law, share in own.items()
        )
        text = f"Of {motors} motors the third speed is predicted within {100 * MARGIN:.0f} % by {each}."
        return text, some(less(share, 0.5) for share in own.values()) is True


def missed(numbers: Numbers) -> Figure:
    """Draw how far each law, fitted at two operating points, misses the speed at a third."""
    own = numbers["error"]
    figure, axes = plt.subplots(figsize=(WIDTH, 0.27 * len(own) + 0.7), layout="constrained")
    for row, values in enumerate(own.values()):
        cloud(axes, array(values), row, LAW)
    rows(axes, own)
    axes.set_xscale("log")
    axes.axvline(np.log1p(MARGIN), color="0.5", linewidth=0.6)
    motors = max(map(len, own.values()))
    axes.set_xlabel(f"|ln of predicted over true speed| in each of {motors} motors (1)")
    return figure


if __name__ == "__main__":
    main(__file__)
