"""Motors that `law_contrasts` might have computed."""

import numpy as np
import xarray
from law_contrasts import CONTRASTS, POINTS, PRACTISED, QUANTITIES, STATES, LawContrasts
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
            "start_time": ("law", rng.random(len(LAWS))),
            "start_time_error": ("law", 1e-6 * rng.random(len(LAWS))),
            "prediction_error": ("law", np.abs(0.1 * rng.standard_normal(len(LAWS)))),
        }
        parts.append(xarray.Dataset(data))
    return parts


def data_of(count: int) -> xarray.Dataset:
    """Return the data of motors that were made up."""
    motors = motors_of(count)
    practice = ["start_time", "start_time_error", "prediction_error"]
    parts = [motor.drop_vars(practice) for motor in motors]
    return LawContrasts().join(cl.build(), [*parts, *(motor[practice] for motor in motors[:PRACTISED])])
