"""The figure of the paper: one motor under four laws, on the paper's four shapes and on the converged beam.

`python paper/figures.py` leaves `paper/laws.png` and `paper/laws.pdf`.
"""

from pathlib import Path
from typing import Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import contactlab as cl
from contactlab.plot.style import STYLE

HERE = Path(__file__).resolve().parent

LAWS: Final = {
    "Hertz, Coulomb": ["law=hertz_penalty"],
    "Hertz, Mindlin": ["law=composed", "law/damping=none", "law/friction=mindlin"],
    "rigid, sticks": ["law=lagrange_stick"],
    "restitution 0.5": ["law=newton"],
}
"""Laws that settle to an orbit on both beams, by what the figure calls them."""

BASES: Final = {"ritz": "four shapes of the 2001 paper", "finite_element": "converged beam"}


def main() -> None:
    """Run the motors, draw and print what the text of the paper quotes."""
    with plt.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.0, 2.7), width_ratios=(1.25, 1.0))
        _draw_transients(left)
        _draw_settled(right)
        figure.tight_layout()
        for suffix in ("png", "pdf"):
            metadata = {"Software": None} if suffix == "png" else {"CreationDate": None}
            figure.savefig(HERE / f"laws.{suffix}", metadata=metadata)


def _draw_transients(axes: Axes) -> None:
    """Draw the rotor's velocity from rest."""
    for words, law in LAWS.items():
        run = cl.simulate(cl.build(law))
        axes.plot(1e3 * run["time"], run["rotor_velocity"], label=words)
    axes.set(xlabel="time [ms]", ylabel="rotor velocity [rad/s]", xlim=(0.0, 20.0))
    axes.legend(loc="upper right")


def _draw_settled(axes: Axes) -> None:
    """Draw the mean velocity of the steady states, which are found by shooting."""
    settled = {
        basis: np.array(
            [cl.steady(cl.build([*law, f"resonator={basis}"])).velocity[0] for law in LAWS.values()]
        )
        for basis in BASES
    }
    place = np.arange(len(LAWS))
    for shift, (basis, words), marker in zip((-0.09, 0.09), BASES.items(), "os", strict=True):
        axes.plot(settled[basis], place + shift, marker, label=words, color="k" if shift > 0.0 else "0.55")
        values = settled[basis]
        told = ", ".join(f"{law} {value:.4f}" for law, value in zip(LAWS, values, strict=True))
        print(f"{basis} [rad/s]: {told}; apart by {np.ptp(values) / np.abs(values).mean():.0%} of their mean")
    axes.set(xlabel="settled rotor velocity [rad/s]", ylim=(len(LAWS) - 0.5, -1.2))
    axes.set_yticks(place, list(LAWS))
    axes.legend(loc="upper left", ncols=1)


if __name__ == "__main__":
    main()
