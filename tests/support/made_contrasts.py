"""Motors that `law_contrasts` and `law_practice` might have computed."""

import numpy as np
import xarray
from law_contrasts import CONTRASTS, POINTS, QUANTITIES, STATES, LawContrasts
from law_practice import FITTED, LawPractice
from motor_population import GROUPS, KNOWN, LAWS, drawn

import contactlab as cl


def motors_of(count: int) -> list[xarray.Dataset]:
    """Return motors whose laws differ by factors of their own; one turns, another has no speed."""
    rng = np.random.default_rng(7)
    parts = []
    for number in range(count):
        value = np.full((len(STATES), len(QUANTITIES)), np.nan)
        value[: len(LAWS)] = np.exp(
            rng.standard_normal() + 0.3 * rng.standard_normal((len(LAWS), len(QUANTITIES)))
        )
        for law, null in CONTRASTS.values():
            if null not in LAWS:
                value[STATES.index(null)] = value[STATES.index(law)] * (1.0 + 1e-9 * rng.random())
        if number == 0:
            value[LAWS.index("flores"), 0] *= -1.0
        if number == 1:
            value[LAWS.index("newton")] = np.nan
        groups = rng.random(len(GROUPS))
        groups[0] = drawn(number)[GROUPS[0]]
        data = {
            "value": (("state", "quantity"), value),
            "error": (("state", "quantity"), 1e-9 * np.abs(value)),
            "outcome": ("state", np.where(np.isnan(value[:, 0]), 1, 0)),
            "group_value": ("group", groups),
            "secant": (("input", "point"), 0.02 * rng.standard_normal((len(KNOWN), len(POINTS)))),
        }
        parts.append(xarray.Dataset(data))
    return parts


def data_of(count: int) -> xarray.Dataset:
    """Return the data of motors that were made up."""
    return LawContrasts().join(cl.build(), motors_of(count))


def practised_motors(count: int) -> list[xarray.Dataset]:
    """Return motors whose speed most laws predict within a tenth; the second has no `newton`."""
    rng = np.random.default_rng(8)
    errors, starts = np.abs(0.1 * rng.standard_normal((count, len(FITTED)))), rng.random((count, len(FITTED)))
    errors[1:2, FITTED.index("newton")] = np.nan
    return [
        xarray.Dataset(
            {
                "number": number,
                "prediction_error": ("law", errors[number]),
                "start_time": ("law", starts[number]),
                "start_time_error": ("law", 1e-6 * starts[number]),
            },
            {"law": [*FITTED]},
        )
        for number in range(count)
    ]


def practice_of(count: int) -> xarray.Dataset:
    """Return the data of motors to which laws might have been fitted."""
    return LawPractice().join(cl.build(), practised_motors(count))
