"""Numbers of `law_contrasts` as predicates and sentences name them: of whatever number of motors has run."""

from collections.abc import Mapping
from math import isnan
from typing import Any, Final

import numpy as np
from contrast_figures import array, is_null
from contrast_map import BAR
from law_contrasts import FITTED, MOTORS, OUTCOMES
from recorded_numbers import rows_of, value
from verdicts import NONE, Number, exact, less, share, some

LONG: Final = "law_contrasts"

SPEED: Final = "rotor_velocity"

SPOKEN: Final = {SPEED: "speed", "stall_torque": "torque"}
"""Words for the quantities of which contrasts are recorded by motor."""

CONCLUSIONS: Final = {
    "catalogue": ("from a catalogue", "most designs need the law"),
    "bench": ("on a bench", "most motors of measured parts need the law"),
    "measured": ("by two operating points", "most motors that are measured themselves need the law"),
}
"""From which knowledge on a contrast shows in most motors, and what a designer may conclude, by level."""

VISIBLE: Final = 0.01
"""Change of ln |speed| by a null contrast from which on it is counted."""


def of_run(name: str) -> Any:
    """Return what is recorded of all motors under a name."""
    return value(f"{LONG}/numbers/{name}", "experiments")


def judged() -> int:
    """Return on how many motors the map is judged in a whole run."""
    return MOTORS - FITTED


def pairs() -> int:
    """Return the pairs of a motor and a law."""
    return without(*OUTCOMES)


def motors() -> int:
    """Return how many motors have run."""
    return int(of_run("motors"))


def quantities() -> list[str]:
    """Return the quantities of which contrasts are recorded by motor."""
    return [*of_run("size")]


def contrasts() -> list[str]:
    """Return all contrasts, null contrasts last."""
    return [*of_run("size")[SPEED]]


def levels() -> list[str]:
    """Return the levels of knowledge of a motor, from the least one."""
    return [*of_run("half-width")]


def differences() -> list[str]:
    """Return the contrasts of laws, without the null contrasts."""
    return [name for name in contrasts() if not is_null(name)]


def interaction(contrast: str, quantity: str = SPEED) -> Number:
    """Return the share of law x motor of a contrast, with its interval; `NONE` of too few motors."""
    (own,) = (x for x in rows_of(LONG) if (x["contrast"], x["quantity"]) == (contrast, quantity))
    if own.get("share") is None:
        return NONE
    return Number(float(own["share"]), float(own["low"]), float(own["high"]))


def interactions(*names: str) -> list[Number]:
    """Return the shares of law x motor of contrasts in speed and torque."""
    return [interaction(name, quantity) for quantity in quantities() for name in names]


def chance() -> Number:
    """Return the largest upper end of a null contrast's share of law x motor [1]."""
    return exact(max(each.high for each in interactions(*filter(is_null, contrasts()))))


def standing_out() -> bool | None:
    """Return whether a contrast of laws has a share of law x motor above chance."""
    return some(less(chance(), each) for each in interactions(*differences()))


def outstanding() -> list[str]:
    """Return the contrasts of laws with a share above chance, each with the quantities that have it."""
    named = {
        name: [spoken for key, spoken in SPOKEN.items() if less(chance(), interaction(name, key)) is True]
        for name in differences()
    }
    return [f"*{name}* in {' and '.join(own)}" for name, own in named.items() if own]


def largest_interaction() -> Number:
    """Return the largest share of law x motor of a contrast of laws, with its interval."""
    return max(interactions(*differences()), key=lambda each: -1.0 if isnan(each.value) else each.value)


def beyond(contrast: str, level: str) -> Number:
    """Return the share of motors whose speed a contrast changes by more than the prediction's half-width."""
    exceeding, known = beyond_counts(contrast, level)
    return share(exceeding, known) if known else NONE


def beyond_counts(contrast: str, level: str) -> tuple[int, int]:
    """Return in how many motors a contrast exceeds the half-width, and how many have both."""
    size, width = array(of_run("size")[SPEED][contrast]), array(of_run("half-width")[level])
    known = ~np.isnan(size) & np.isfinite(width)
    return int((size > width)[known].sum()), int(known.sum())


def beyond_of_all(contrast: str, level: str) -> Number:
    """Return that share of all motors; one without a half-width or a contrast counts as not exceeding."""
    return share(beyond_counts(contrast, level)[0], motors())


def bounded(level: str) -> int:
    """Return the motors of which the prediction has a half-width."""
    return int(np.isfinite(array(of_run("half-width")[level])).sum())


def in_most(contrast: str, level: str) -> bool | None:
    """Return whether a contrast changes the speed of most motors by more than the prediction's half-width."""
    return less(0.5, beyond(contrast, level))


def exceeding(level: str) -> int:
    """Return how many contrasts of laws do so."""
    return sum(in_most(name, level) is True for name in differences())


def oftenest(level: str) -> str:
    """Return the contrast of laws that does so in the most motors."""
    return max(differences(), key=lambda name: np.nan_to_num(beyond(name, level).value, nan=-1.0))


def conclusion(contrast: str) -> tuple[str, str]:
    """Return how well motors must be known for a contrast to show in most of them, and what follows."""
    undecided = ""
    for level in levels():
        known, needs = CONCLUSIONS[level]
        match in_most(contrast, level):
            case True:
                return f"{known}{undecided}", needs
            case None:
                undecided += f"; open {known}"
    if undecided:
        return f"in no other way{undecided}", "open"
    return "in none of these ways", "in most either law will do"


def turning(contrast: str) -> int:
    """Return how many motors turn the other way, or stand, under one of the two laws."""
    return int(np.isinf(array(of_run("size")[SPEED][contrast])).sum())


def middle(contrast: str) -> float:
    """Return the median |ln| of the ratio of speeds."""
    return float(np.nanmedian(array(of_run("size")[SPEED][contrast])))


def null_changes() -> tuple[int, int]:
    """Return how many pairs of a motor and a null contrast change the speed by `VISIBLE`, and all pairs."""
    sizes = np.concatenate([array(x) for name, x in of_run("size")[SPEED].items() if is_null(name)])
    sizes = sizes[~np.isnan(sizes)]
    return int((sizes > VISIBLE).sum()), sizes.size


def without(*outcomes: str) -> int:
    """Return how many pairs of a motor and a law have one of some outcomes."""
    return sum(own[outcome] for own in of_run("outcomes").values() for outcome in outcomes)


def maps() -> list[Mapping[str, float]]:
    """Return how well the map predicts each contrast of laws, in speed and torque, once it is judged."""
    return [own for each in of_run("map").values() for own in each.values()]


def is_mapped() -> bool | None:
    """Return whether the map predicts a contrast of laws; None before it is judged."""
    return any(own["low"] > BAR for own in maps()) if maps() else None


def best_map(end: str = "r2") -> Mapping[str, float]:
    """Return how well the map predicts the contrast of which R^2, or an end of its interval, is largest."""
    return max(maps(), key=lambda own: own[end])


def predictable() -> int:
    """Return how many contrasts, in speed and torque, the map predicts."""
    return sum(own["low"] > BAR for own in maps())


def unseen() -> int:
    """Return the most motors on which the map of a contrast is judged."""
    return int(max(own["motors"] for own in maps()))
