"""What else than the law could make settled motors differ: how far each cause moves every quantity."""

from collections.abc import Collection, Iterator, Sequence
from typing import Final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.comparison.reruns import Refined
from contactlab.comparison.samples import Factor, Samples, holds_number, left_fixed
from contactlab.comparison.settled import LONGEST, QUANTITIES, Means
from contactlab.metrics import METRICS, NotApplicableError

NUMERICAL, BASIS, PARAMETERS, ATTRACTORS = "numerical error", "basis", "parameters", "start"
CAUSES: Final = (NUMERICAL, BASIS, PARAMETERS, ATTRACTORS)

UNSETTLED: Final = 0.01  # relative distance of a recorded run's velocity from the settled one that is told
FEWEST_DRAWN: Final = 8  # motors of a law; one more would move it further in a ninth of all cases
WITHOUT_CONTACT: Final = "without contact"
NOT_KNOWN: Final = "not known"  # kind of the motion of a run that was taken as recorded


def with_causes(
    data: xarray.Dataset,
    laws: Sequence[Refined],
    factors: Sequence[Factor],
    samples: Samples | None,
    ranges: Collection[str] = (),
) -> xarray.Dataset:
    """Add to the scorecard of settled motors what every cause makes of a law's values, and the shares.

    Args:
        data: the scorecard.
        laws: in its order.
        factors: what there is to be drawn; none where nothing was asked.
        samples: what was drawn; None where nothing was.
        ranges: keys of parameters whose range was given, zero among them.

    Returns:
        With `least` and `greatest` over (law, cause, quantity), the range of values that a cause gives,
        NaN where that is not known; and where motors were drawn `first_order` and `total_order` over
        (quantity, factor, estimate), and the motors themselves, `drawn` and `found`.
    """
    places = {id(law): place for place, law in enumerate(settled_of(laws))}
    least = np.full((len(laws), len(CAUSES), len(QUANTITIES)), np.nan)
    greatest = least.copy()
    for number, law in enumerate(laws):
        moves = _moved(law, samples, places.get(id(law)))
        if factors and not any(factor.keys for factor in factors) and NUMERICAL in moves:
            # All parameters are known exactly.
            moves[PARAMETERS] = np.zeros((1, len(QUANTITIES)))
        for cause, moved in moves.items():
            # A law without contact has no stick share, and nothing moves it.
            known = np.isfinite(moved).any(axis=0)
            value, at = law.means[-1].values[known], CAUSES.index(cause)
            least[number, at, known] = value + np.minimum(np.nanmin(moved[:, known], axis=0), 0.0)
            greatest[number, at, known] = value + np.maximum(np.nanmax(moved[:, known], axis=0), 0.0)
    three, units = ("law", "cause", "quantity"), {"comment": "units differ by quantity, see `quantity_units`"}
    found = data.assign(
        least=(three, least, {"long_name": "smallest value that a cause gives", **units}),
        greatest=(three, greatest, {"long_name": "largest value that a cause gives", **units}),
    ).assign_coords(
        cause=list(CAUSES),
        quantity=list(QUANTITIES),
        quantity_units=("quantity", [METRICS[key].units for key in QUANTITIES]),
        kind=("law", [law.means[-1].kind if law.means else NOT_KNOWN for law in laws]),
    )
    found = found.assign_coords(
        varied=("law", [_listed_ranges([f for f in factors if _varies(law, f)]) for law in laws]),
        not_varied=("law", [listed(left_fixed(law.run, factors, ranges)) if factors else "" for law in laws]),
    )
    found.attrs["first"] = "\n".join(_said_first(laws))
    found.attrs["parameters"] = _listed_ranges([f for f in factors if f.keys]) or "nothing"
    return found if samples is None else _with_samples(found, samples)


def settled_of(laws: Sequence[Refined]) -> list[Refined]:
    """Give the laws that can be drawn: settled at all steps."""
    return [law for law in laws if law.steps and law.means]


def _moved(law: Refined, samples: Samples | None, place: int | None) -> dict[str, Array]:
    """Give changes of the quantities by cause, rows of any number; a cause that is not known has none."""
    if not law.steps or not law.means:
        return {}
    as_recorded = law.means[0].values
    error = law.error([each.values for each in law.means], each=True) + law.means[-1].errors
    moved = {NUMERICAL: np.array([-error, error])}
    if law.elsewhere:
        moved[BASIS] = np.array([law.elsewhere.values - as_recorded])
    if law.reached:
        moved[ATTRACTORS] = np.array([each.values - as_recorded for each in law.reached])
    if samples is not None and place is not None:
        # On either basis, from what the law does there.
        nominal = [as_recorded, *([law.elsewhere.values] if law.elsewhere else [])]
        drawn = np.concatenate([samples.of_law(place, i) - here for i, here in enumerate(nominal)])
        if len(drawn) >= FEWEST_DRAWN:
            moved[PARAMETERS] = drawn
    return moved


def _with_samples(data: xarray.Dataset, samples: Samples) -> xarray.Dataset:
    shares = ("quantity", "factor", "estimate")
    first, total = samples.shares()
    words = "share of the variance of a quantity, with its 95 % interval"
    units = {"comment": "scales of parameters, levels of law, basis and step"}
    found = data.assign(
        first_order=(shares, first, {"units": "1", "long_name": f"{words}: the factor alone"}),
        total_order=(
            shares,
            total,
            {"units": "1", "long_name": f"{words}: the factor and what it does with others"},
        ),
        drawn=(("motor", "factor"), samples.drawn, {"long_name": "motors that were drawn", **units}),
        found=(("motor", "quantity"), samples.values, {"long_name": "their settled values"}),
    ).assign_coords(
        factor=[factor.name for factor in samples.factors],
        spread=("factor", [factor.spread for factor in samples.factors]),
        estimate=["share", "lower", "upper"],
    )
    if reasons := [reason for reason in samples.reasons if reason]:
        said = f"{len(reasons)} of the {len(samples.reasons)} motors drawn have no steady state: {reasons[0]}"
        found.attrs["notes"] = "\n".join(filter(None, (found.attrs["notes"], said)))
    return found


def _varies(law: Refined, factor: Factor) -> bool:
    """Return whether a factor changes a parameter of a law's run."""
    return any(holds_number(law.run, key) for key in factor.keys)


def _listed_ranges(factors: Sequence[Factor]) -> str:
    return ", ".join(f"{factor.name} +-{100.0 * factor.spread:.3g} %" for factor in factors)


def _said_first(laws: Sequence[Refined]) -> Iterator[str]:
    """Say what a reader of the headline must know of the laws before it, a sentence each."""
    moved = {law.run.label: speed for law in laws if (speed := _unsettled(law)) is not None}
    if moved:
        speeds = listed([f"{speed:.3g} rad/s with {label}" for label, speed in moved.items()])
        yield (
            f"The recorded motor had not settled: in the last quarter of the run it turns at {speeds}. What "
            "is compared is the settled motor."
        )
    for law in laws:
        label = law.run.label
        if not law.means and law.without:
            yield f"{label} has no steady state: its numbers are those of the recorded run. {law.without}"
            continue
        if not law.means:
            yield f"{label} is taken as recorded: whether its motor has settled is not known."
            continue
        kind = law.means[-1].kind
        if kind == WITHOUT_CONTACT:
            yield f"{label} settles without contact: nothing turns the rotor."
        elif kind != "periodic":
            yield (
                f"{label} settles to no periodic motion ({kind}): its values are means over "
                f"{LONGEST // 2} periods, with statistical errors."
            )
        if len(law.reached) > 1:
            speeds = listed([_told(each) for each in law.reached])
            yield f"{label} settles to more than one motion, by where it starts: {speeds}."


def _unsettled(law: Refined) -> float | None:
    """Give the velocity of a recorded run where it is not the settled one [rad/s]."""
    if not law.means:
        return None
    try:
        recorded = float(METRICS["rotor_velocity"].measure(law.run))
    except NotApplicableError:
        return None
    velocity = float(law.means[-1].values[0])
    return recorded if abs(recorded - velocity) > UNSETTLED * abs(velocity) else None


def _told(state: Means) -> str:
    """Tell a steady state by its velocity; without contact the rotor keeps whatever it had."""
    return WITHOUT_CONTACT if state.kind == WITHOUT_CONTACT else f"{state.values[0]:.3g} rad/s"


def listed(words: Sequence[str]) -> str:
    """Write a list as a sentence does."""
    if not words:
        return ""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last
