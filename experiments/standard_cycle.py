"""The standard cycle of a contact law: a body too heavy to be disturbed presses and slides to and fro.

    d = 1 µm sin(pi t / T),   way = 1 µm sin(4 pi t / T),   0 <= t <= T = 50 µs

A rigid law has no force over penetration; it is asked about impacts of one body instead.
"""

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.testing.plants import block, way_of

DURATION, DEPTH, WAY, MASS = 50e-6, 1e-6, 1e-6, 1e3
"""[s], [m], [m], [kg]."""

TOLERANCE = 1e-12
"""Of the body's momentum, which is a millionfold the impulse of the contact."""

DELASSUS = np.array([[600.0, 250.0], [250.0, 800.0]])
"""Of the body that strikes [1/kg]: of the motor's size, and with coupled directions."""

APPROACH = 0.1
"""Of the impacts [m/s]."""


@dataclass(frozen=True)
class Curves:
    """Two curves, each with the words on its axes.

    Args:
        left, right: x and y.
        left_words, right_words: labels of x and y.
        numbers: what the page says of them.
    """

    left: tuple[Array, Array]
    right: tuple[Array, Array]
    left_words: tuple[str, str]
    right_words: tuple[str, str]
    numbers: str


def curves_of(law: ContactLaw) -> Curves:
    """The cycle of a compliant law, or the impacts of a rigid one."""
    if isinstance(law, MultiplierLaw):
        return _impacts(law)
    if isinstance(law, PenaltyLaw):
        return _cycle(law)
    raise TypeError(f"{type(law).__name__} is of neither family.")


def _cycle(law: PenaltyLaw) -> Curves:
    pressing, sliding = pi / DURATION, 4.0 * pi / DURATION
    motor = block(
        MASS,
        gap_rate=-DEPTH * pressing,
        normal_stiffness=MASS * pressing**2,
        velocity=WAY * sliding,
        stiffness=MASS * sliding**2,
    )
    run = simulate(motor, law, duration=DURATION, record_interval=DURATION / 1000.0, tolerance=TOLERANCE)
    series = run.series
    # Forces are means over the intervals before the records.
    depth, way = (0.5 * (x[1:] + x[:-1]) for x in (-series["gap"], way_of(series["tip_slope"])))
    normal, friction = series["normal_force"][1:], series["friction_force"][1:]
    contact, rubbing = series["contact_loss"][-1], series["friction_loss"][-1]
    return Curves(
        left=(depth * 1e6, normal),
        right=(way * 1e6, friction),
        left_words=("penetration [µm]", "normal force [N]"),
        right_words=("way [µm]", "friction [N]"),
        numbers=(
            f"In the standard cycle: peak normal force {normal.max():.3g} N, largest friction "
            f"{np.abs(friction).max():.3g} N, normal loss {_tidy(contact)} µJ, "
            f"friction loss {_tidy(rubbing)} µJ."
        ),
    )


def _tidy(energy: float) -> str:
    """An energy in microjoules; round-off of a loss that there is none of is zero."""
    return f"{0.0 if abs(energy) < 1e-12 else energy * 1e6:.3g}"


def _impacts(law: MultiplierLaw) -> Curves:
    (d_nn, d_nt), (_, d_tt) = DELASSUS
    behind: tuple[Any, ...] = (law.parameters(),)
    if law.told:
        # An impact finds the memory as it is at first.
        behind = law.default_contact_step, 1.0, np.array([one.initial for one in law.remembered]), *behind

    def answers(rate: float, slip: float) -> tuple[float, float]:
        solve: Any = law.solve
        p_n, p_t, _ = solve(-rate, slip, -rate, slip, d_nn, d_nt, d_tt, *behind)
        return p_n, p_t

    speeds = np.linspace(0.0, 2.0 * APPROACH, 201)[1:]
    slips = np.linspace(-3.0 * APPROACH, 3.0 * APPROACH, 601)
    normal = np.array([answers(speed, 0.5 * APPROACH)[0] for speed in speeds])
    friction = np.array([answers(APPROACH, slip)[1] for slip in slips])
    ends = [d_nn * p_n + d_nt * p_t for p_n, p_t in (answers(APPROACH, s) for s in slips)]
    # Round-off of a plastic impact is none, whatever its sign.
    rebound = np.round((np.array(ends) - APPROACH) / APPROACH, 9) + 0.0
    return Curves(
        left=(speeds, normal * 1e6),
        right=(slips, friction * 1e6),
        left_words=("approach [m/s]", "normal impulse [µN s]"),
        right_words=("slip before the impact [m/s]", "friction impulse [µN s]"),
        numbers=(
            f"In the standard impacts at {APPROACH} m/s: rebound over approach {rebound.min():.3f} to "
            f"{rebound.max():.3f}, largest friction impulse {np.abs(friction).max() * 1e6:.3g} µN s."
        ),
    )


def draw(curves: Curves) -> Figure:
    """The two curves side by side."""
    figure = Figure(figsize=(5.6, 2.0), layout="constrained")
    for axes, (x, y), (across, up) in zip(
        figure.subplots(1, 2),
        (curves.left, curves.right),
        (curves.left_words, curves.right_words),
        strict=True,
    ):
        axes.axhline(0.0, color="0.8", linewidth=0.6)
        axes.plot(x, y)
        axes.set(xlabel=across, ylabel=up)
    return figure
