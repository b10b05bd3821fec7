"""How long 2000 impacts take under each law, once compiled: the dataset, and the arrays of a fit.

    python benchmarks/benchmark_impacts.py [impacts] [tolerance]

The bodies are drawn: D_nn and D_tt between 500 and 5000 / kg, coupled by up to half of what keeps D positive
definite; approaches of 0.01 to 0.5 m/s, slips of some 0.3 m/s. Each time is the least of some calls. The
dataset is the whole of `cl.impact`, checks and xarray included; the arrays are those of prepared
`contactlab.impacts.Impacts`, asked with parameters that it was not asked with before.
"""

import sys
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

import contactlab as cl
from contactlab.impacts import Impacts
from contactlab.laws import LAWS, MultiplierLaw

CALLS = 3
COMPOSED: dict[str, dict[str, Any]] = {
    "linear": {"normal": cl.Linear()},
    "hunt_crossley": {"normal": cl.HertzPoint(), "damping": cl.HuntCrossley()},
    "thornton": {"normal": cl.Thornton()},
    "jkr": {"normal": cl.Jkr()},
    "mindlin": {"friction": cl.Mindlin()},
    "lugre": {"friction": cl.LuGre()},
    "iwan": {"friction": cl.Iwan()},
}
"""Parts, of all kinds, by a name for the table."""


@dataclass(frozen=True)
class Timing:
    """A law and its times [s]: of the dataset, and of the arrays; and how many have no number."""

    name: str
    dataset: float
    arrays: float
    unanswered: int


def drawn(count: int, seed: int = 0) -> tuple[Any, Any]:
    """Matrices [1/kg] and velocities before [m/s]."""
    rng = np.random.default_rng(seed)
    nn, tt = rng.uniform(500.0, 2000.0, count), rng.uniform(500.0, 5000.0, count)
    nt = 0.5 * rng.uniform(-1.0, 1.0, count) * np.sqrt(nn * tt)
    matrices = np.stack([nn, nt, nt, tt], axis=1).reshape(-1, 2, 2)
    return matrices, np.column_stack([-rng.uniform(0.01, 0.5, count), rng.normal(0.0, 0.3, count)])


def other(law: cl.ContactLaw, call: int) -> cl.ContactLaw:
    """Return the law with another friction coefficient for each call."""
    mu = 0.3 - 1e-3 * (call + 1)
    if isinstance(law, cl.Composed):
        return replace(law, friction=replace(law.friction, friction_coefficient=mu))
    made: Any = law
    return replace(made, friction_coefficient=mu)


def measure(count: int, tolerance: float) -> list[Timing]:
    """Time every registered law and the compositions."""
    matrices, rates = drawn(count)
    impacts = Impacts(matrices, rates)
    laws = {name: cl.law(name) for name in LAWS if name != "composed"}
    laws |= {name: cl.Composed(**parts) for name, parts in COMPOSED.items()}
    timings = []
    for name, law in laws.items():
        options = None if isinstance(law, MultiplierLaw) else tolerance
        # Compiles what there is to compile.
        cl.impact(law, matrices[:1], rates[:1], tolerance=options)
        impacts.velocities_after(law, options)
        times: list[tuple[float, float]] = []
        for call in range(CALLS):
            start = perf_counter()
            result = cl.impact(law, matrices, rates, tolerance=options)
            between = perf_counter()
            impacts.velocities_after(other(law, call), options)
            times.append((between - start, perf_counter() - between))
        dataset, arrays = (min(column) for column in zip(*times, strict=True))
        timings.append(Timing(name, dataset, arrays, int((result.status != 0).sum())))
    return timings


def main() -> None:
    """Print the table."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    tolerance = float(sys.argv[2]) if len(sys.argv) > 2 else 1e-4
    print(f"{count} impacts, tolerance {tolerance:g} of the compliant ones")
    print(f"{'law':18}{'dataset [ms]':>14}{'arrays [ms]':>14}{'no number':>11}")
    for each in measure(count, tolerance):
        print(f"{each.name:18}{1e3 * each.dataset:14.2f}{1e3 * each.arrays:14.2f}{each.unanswered:11d}")


if __name__ == "__main__":
    main()
