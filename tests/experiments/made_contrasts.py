"""Motors that `law_contrasts` might have computed, of which the truth is known."""

import numpy as np
import xarray
from law_contrasts import CONTRASTS, QUANTITIES, STATES, LawContrasts
from motor_population import GROUPS, KNOWN, LAWS

import contactlab as cl

POINTS = 3


def data_of(motors: int, apart: float = 0.3, told: float = 0.0, known: float = 0.02) -> xarray.Dataset:
    """Return the data of motors whose laws differ by a factor of their own in each motor.

    Args:
        motors: number of motors.
        apart: standard deviation of ln |Q| over the laws of a motor.
        told: share of this deviation that the first group decides.
        known: deviation of ln |speed| by each input on a bench.
    """
    rng = np.random.default_rng(7)
    groups = rng.random((motors, len(GROUPS)))
    decided = np.exp(2.0 * (told * np.sqrt(12.0) * (groups[:, 0] - 0.5)))
    own = apart * decided[:, None, None] * rng.standard_normal((motors, len(LAWS), len(QUANTITIES)))
    logarithm = rng.standard_normal((motors, 1, len(QUANTITIES))) + own
    value = np.full((motors, len(STATES), len(QUANTITIES)), np.nan)
    value[:, : len(LAWS)] = np.exp(logarithm)
    for law, null in CONTRASTS.values():
        if null not in LAWS:
            value[:, STATES.index(null)] = value[:, STATES.index(law)] * (1.0 + 1e-9 * rng.random())
    value[0, LAWS.index("flores"), 0] *= -1.0
    value[1, LAWS.index("newton")] = np.nan
    secant = known * rng.standard_normal((motors, len(KNOWN), POINTS))
    errors = np.abs(0.1 * rng.standard_normal((motors, len(LAWS))))
    parts = [
        xarray.Dataset(
            {
                "value": (("state", "quantity"), value[n]),
                "error": (("state", "quantity"), 1e-9 * np.abs(value[n])),
                "outcome": ("state", np.where(np.isnan(value[n, :, 0]), 1, 0)),
                "group_value": ("group", groups[n]),
                "secant": (("input", "point"), secant[n]),
                "prediction_error": ("law", errors[n]),
            }
        )
        for n in range(motors)
    ]
    return LawContrasts().join(cl.build(), parts)
