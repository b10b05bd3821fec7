"""Error over processor time of every family of laws: the work-precision diagram of the documentation.

    python benchmarks/work_precision.py [repeats] [--output PICTURE]

Work: case A (placement 2, clearance 1 um, mu 0.3, 3210 and 6420 Hz) for 20 ms, recorded at its ends.
Collocated contact is run at falling tolerances, rigid laws also in time stepping at falling contact steps.
Error: that of the rotor velocity at the end, relative to the finest tolerance, which the tests hold to
independent solvers. The times are the shortest of some repeats, in one process.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import matplotlib.pyplot as plt
import pandas

from contactlab.laws import Composed, ContactLaw, HertzPenalty, LagrangeStick, MultiplierLaw, Newton
from contactlab.laws.friction import LuGre
from contactlab.testing.plants import last, paper_motor, run

DURATION = 20e-3
FINEST = 1e-12
TOLERANCES = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
STEPS = (1e-6, 3e-7, 1e-7, 3e-8, 1e-8)
"""Of time stepping [s]."""

LAWS: dict[str, ContactLaw] = {
    "hertz_penalty": HertzPenalty(1e10, 0.3),
    "LuGre friction": Composed(friction=LuGre()),
    "lagrange_stick": LagrangeStick(0.3),
    "newton": Newton(0.3, 0.5),
}


@dataclass(frozen=True)
class Timing:
    """A law at a setting of the solver: shortest processor time [s], relative error of the velocity [1]."""

    law: str
    method: str
    setting: float
    seconds: float
    error: float


def measure(duration: float = DURATION, repeats: int = 3) -> list[Timing]:
    """Run every law at every setting."""
    motor, timings = paper_motor(), []
    for name, law in LAWS.items():
        exact = last(run(motor, law, duration, tolerance=FINEST), "rotor_velocity")
        settings = [("collocated", "tolerance", value) for value in TOLERANCES]
        if isinstance(law, MultiplierLaw):
            settings += [("time stepping", "contact_step", value) for value in STEPS]
        for method, option, value in settings:
            # The first run compiles.
            result = last(run(motor, law, duration, **{option: value}), "rotor_velocity")
            spent = []
            for _ in range(repeats):
                began = process_time()
                run(motor, law, duration, **{option: value})
                spent.append(process_time() - began)
            timings.append(Timing(name, method, value, min(spent), abs(result / exact - 1.0)))
    return timings


def draw(timings: Sequence[Timing], path: Path) -> None:
    """Draw error over time of a motor second."""
    figure, axes = plt.subplots(figsize=(6.0, 4.6), layout="constrained")
    styles = dict(zip(LAWS, ("C0", "C1", "C2", "C3"), strict=True))
    for law, colour in styles.items():
        for method, line in (("collocated", "o-"), ("time stepping", "s--")):
            of = [each for each in timings if (each.law, each.method) == (law, method)]
            if of:
                times = [each.seconds / DURATION for each in of]
                # An error below round-off stands at it.
                errors = [max(each.error, 1e-15) for each in of]
                axes.loglog(errors, times, line, color=colour, ms=4, lw=1, label=f"{law}, {method}")
    axes.set_xlabel("relative error of the rotor velocity after 20 ms (1)")
    axes.set_ylabel("processor time of a motor second (s)")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Print the table and draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("repeats", nargs="?", type=int, default=3)
    parser.add_argument("--output", type=Path, default=Path("work_precision.png"))
    arguments = parser.parse_args()
    timings = measure(repeats=arguments.repeats)
    print(pandas.DataFrame(timings).to_string(index=False, float_format="{:.2e}".format))
    draw(timings, arguments.output)


if __name__ == "__main__":
    main()
