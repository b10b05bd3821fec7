"""The standard cycle of a contact law: a prescribed path that presses and slides to and fro.

    d = 1 µm sin(pi t / T),   way = 1 µm sin(4 pi t / T),   -T/6 <= t <= 7 T/6,   T = 50 µs

It comes from a gap and leaves to one, so that a law may begin and end its contact where it says. One that
pulls is pressed in less, to ten times its pull at the touch, or nobody would see that.

A rigid law has no force over penetration; impacts of one body are drawn instead. One with internal variables
is drawn in stick-slip, too, and so is a compliant one whose variables the cycle does not change: a block of
2 g on a spring of 1 N/µm is pressed by 10 N onto a belt of 20 mm/s. Internal variables are drawn over time.

Beside each law is the reference, in grey: Hertz without damping and with Coulomb friction for a compliant
law, the plastic impact that sticks or slips for a rigid one. A curve that is the reference's is not drawn.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from math import pi

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.driving import drive
from contactlab.engine.binding import LIMITS, SIGNATURES
from contactlab.engine.preparation import take_in
from contactlab.laws import ContactLaw, LagrangeStick, MultiplierLaw, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.testing.plants import block, run

DURATION, DEPTH, WAY = 50e-6, 1e-6, 1e-6
"""[s], [m], [m]."""

BEFORE = 1.0 / 6.0
"""Time before and after the cycle in which the path comes and goes, over its duration."""

SAMPLES = 2001
"""Of the path."""

PULLS = 10.0
"""Largest push over the pull at the touch."""

STICKING_MASS, WEIGHT, SPRING, BELT = 2e-3, 10.0, 1e6, 0.02
"""[kg], [N], [N/m], [m/s]."""

STICKING_TIME = 1e-3
"""[s]."""

MOST_DRAWN = 4
"""Most internal variables with a line of their own in a picture."""

DELASSUS = np.array([[600.0, 250.0], [250.0, 800.0]])
"""Of the body that strikes [1/kg]: of the motor's size, and with coupled directions."""

APPROACH = 0.1
"""Of the impacts [m/s]."""

NO_ENERGY = 1e-12
"""Of a cycle: round-off below it [J]."""

SAME = 5e-3
"""Difference over the largest value below which two curves are one."""


@dataclass(frozen=True)
class Curves:
    """Two curves, each with the labels of its axes, and the internal variables.

    Args:
        left, right: x and y.
        left_labels, right_labels: labels of x and y.
        numbers: sentence of the page about them.
        loss: of the normal direction: "none", "some" or "all".
        rate: whether the same path, or impact, at another speed has other forces.
        time: of the internal variables [µs].
        memory: name of every internal variable, and its values over their largest.
    """

    left: tuple[Array, Array]
    right: tuple[Array, Array]
    left_labels: tuple[str, str]
    right_labels: tuple[str, str]
    numbers: str
    loss: str
    rate: bool
    time: Array = field(default_factory=lambda: np.empty(0))
    memory: tuple[tuple[str, Array], ...] = ()


@cache
def curves_of(law: ContactLaw) -> tuple[Curves, Curves]:
    """The cycle of a compliant law, or the impacts of a rigid one; and those of the reference."""
    pair: list[tuple[ContactLaw, Curves]]
    if isinstance(law, MultiplierLaw):
        pair = [(each, _impacts(each)) for each in (law, LagrangeStick())]
    elif isinstance(law, PenaltyLaw):
        depth = _depth_for(law)
        pair = [(each, _cycle(each, depth)) for each in (law, Composed())]
    else:
        raise TypeError(f"{type(law).__name__} is of neither family.")
    if law.internal_variables and not any(np.ptp(values) > 0.0 for _, values in pair[0][1].memory):
        pair = [(each, _with_stick_slip(curves, each)) for each, curves in pair]
    return pair[0][1], pair[1][1]


def _differ(first: Array, other: Array) -> bool:
    """Whether two courses of a quantity are apart."""
    return float(np.abs(first - other).max()) > SAME * max(np.abs(first).max(), np.abs(other).max())


def _normal_of(law: PenaltyLaw) -> Callable[[float], float]:
    """The force [N] of a depth [m] below the first touch, at rest and with the memory of that."""
    row, _, bound, _ = take_in(law)
    begins = 0.0 if law.limits is None else bound.kernels[LIMITS](0.0, row)[0]

    def normal(depth: float) -> float:
        return float(bound.kernels[0](begins - depth, 0.0, 0.0, 0.0, row)[0])

    return normal


def _depth_for(law: PenaltyLaw) -> float:
    """How deep a law is pressed [m]."""
    normal = _normal_of(law)
    touch = normal(0.0)
    if touch >= 0.0 or normal(DEPTH) < -PULLS * touch:
        return DEPTH
    return float(brentq(lambda depth: normal(depth) + PULLS * touch, 0.0, DEPTH))


def _driven(law: PenaltyLaw, depth: float, duration: float) -> dict[str, Array]:
    before = BEFORE * duration
    time = np.linspace(-before, duration + before, SAMPLES)
    path = {"gap": -depth * np.sin(pi / duration * time), "slip": WAY * np.sin(4.0 * pi / duration * time)}
    cycle = drive(law, time, **path, degree=7, record_interval=duration / 1000.0)
    return {name: values.values for name, values in cycle.items()}


def _cycle(law: PenaltyLaw, pressed: float) -> Curves:
    series = _driven(law, pressed, DURATION)
    slower = _driven(law, pressed, 2.0 * DURATION)
    # Forces are means over the intervals before the records.
    depth, way = (0.5 * (x[1:] + x[:-1]) for x in (-series["gap"], series["tip_tangential_displacement"]))
    normal, friction = series["normal_force"][1:], series["friction_force"][1:]
    contact, rubbing = series["contact_loss"][-1], series["friction_loss"][-1]
    touching = np.flatnonzero((normal != 0.0) | (friction != 0.0))
    shown = slice(max(touching[0] - 1, 0), touching[-1] + 2)
    pull = f", largest pull {-normal.min():.3g} N" if normal.min() < 0.0 else ""
    return Curves(
        left=(depth[shown] * 1e6, normal[shown]),
        right=(way[shown] * 1e6, friction[shown]),
        left_labels=("penetration (µm)", "normal force (N)"),
        right_labels=("tangential displacement (µm)", "friction (N)"),
        numbers=(
            f"In the standard cycle: peak normal force {normal.max():.3g} N{pull}, largest friction "
            f"{np.abs(friction).max():.3g} N, normal loss {_tidy(contact)} µJ, "
            f"friction loss {_tidy(rubbing)} µJ."
        ),
        loss="some" if contact > NO_ENERGY else "none",
        rate=any(_differ(series[name], slower[name]) for name in ("normal_force", "friction_force")),
        time=(series["time"] - BEFORE * DURATION) * 1e6,
        memory=_memory_of(law, series),
    )


def _memory_of(law: ContactLaw, series: Mapping[str, Array]) -> tuple[tuple[str, Array], ...]:
    """What a law remembers in a run, each variable over its largest value."""
    result = []
    for variable in law.internal_variables:
        values = series[f"internal_{variable.name}"]
        most = float(np.abs(values).max())
        unit = "" if variable.units == "1" else f" {variable.units}"
        text = variable.symbol or variable.name
        names = text if most in (0.0, 1.0) else f"{text} / {most:.2g}{unit}"
        result.append((names, values / most if most else values))
    return tuple(result)


def _tidy(energy: float) -> str:
    """An energy in microjoules; round-off of a loss that there is none of is zero."""
    return f"{0.0 if abs(energy) < NO_ENERGY else energy * 1e6:.3g}"


def _impacts(law: MultiplierLaw) -> Curves:
    row, _, bound, _ = take_in(law)
    (d_nn, d_nt), (_, d_tt) = DELASSUS

    def impulses(rate: float, slip: float) -> tuple[float, float]:
        # As the engine calls it in an impact, with the internal variables of a first touch.
        p_n, p_t = bound.kernels[[*SIGNATURES].index("impact")](-rate, slip, d_nn, d_nt, d_tt, row)
        return p_n, p_t

    speeds = np.linspace(0.0, 2.0 * APPROACH, 201)[1:]
    slips = np.linspace(-3.0 * APPROACH, 3.0 * APPROACH, 601)
    normal = np.array([impulses(speed, 0.5 * APPROACH)[0] for speed in speeds])
    friction = np.array([impulses(APPROACH, slip)[1] for slip in slips])
    ends = [d_nn * p_n + d_nt * p_t for p_n, p_t in (impulses(APPROACH, s) for s in slips)]
    # Round-off of a plastic impact is none, whatever its sign.
    rebound = np.round((np.array(ends) - APPROACH) / APPROACH, 9) + 0.0
    text = (
        f"In the standard impacts at {APPROACH} m/s: rebound over approach {rebound.min():.3f} to "
        f"{rebound.max():.3f}, largest friction impulse {np.abs(friction).max() * 1e6:.3g} µN s."
    )
    single, double = (np.array(impulses(speed, 0.5 * speed)) for speed in (APPROACH, 2.0 * APPROACH))
    return Curves(
        left=(speeds, normal * 1e6),
        right=(slips, friction * 1e6),
        left_labels=("approach (m/s)", "normal impulse (µN s)"),
        right_labels=("slip before the impact (m/s)", "friction impulse (µN s)"),
        numbers=text,
        loss="none" if rebound.min() >= 1.0 else "some" if rebound.max() > 0.0 else "all",
        rate=_differ(2.0 * single, double),
    )


def _with_stick_slip(curves: Curves, law: ContactLaw) -> Curves:
    """Curves with those of the block on the belt in the place of the right one."""
    normal = _normal_of(law) if isinstance(law, PenaltyLaw) else None
    pressed = brentq(lambda depth: normal(depth) - WEIGHT, 0.0, 10.0 * DEPTH) if normal else 0.0
    motor = block(
        STICKING_MASS, height=-pressed, velocity=BELT, weight=WEIGHT, stiffness=SPRING, belt_velocity=BELT
    )
    sticking = run(motor, law, STICKING_TIME, record_interval=1e-6)
    time, force = sticking.time * 1e6, sticking.series["friction_force"]
    return replace(
        curves,
        right=(time[1:], force[1:]),
        right_labels=("time (µs)", "friction (N)"),
        numbers=f"{curves.numbers} In stick-slip the friction goes up to {np.abs(force).max():.3g} N.",
        time=time,
        memory=_memory_of(law, sticking.series),
    )


def draw(curves: Curves, reference: Curves) -> Figure:
    """The curves that are not the reference's, each over that in grey, and what is remembered beside them."""
    panels = [
        (curves.left, reference.left, curves.left_labels),
        (curves.right, reference.right, curves.right_labels),
    ]
    panels = [panel for panel in panels if not _coincide(*panel[:2])] or panels
    count = len(panels) + bool(curves.memory)
    figure = Figure(figsize=(2.8 * count, 2.0), layout="constrained")
    every = figure.subplots(1, count, squeeze=False)[0]
    for axes, (own, other, (across, up)) in zip(every, panels, strict=False):
        axes.axhline(0.0, color="0.8", linewidth=0.6)
        axes.plot(*other, color="0.7", linewidth=2.2)
        axes.plot(*own)
        axes.set(xlabel=across, ylabel=up)
    for axes in every[len(panels) :]:
        axes.axhline(0.0, color="0.8", linewidth=0.6)
        several = len(curves.memory) > MOST_DRAWN
        for name, values in curves.memory:
            axes.plot(curves.time, values, label=None if several else name, linewidth=0.8)
        first, last = curves.memory[0][0], curves.memory[-1][0]
        axes.set(xlabel="time (µs)", ylabel="internal variables")
        if several:
            axes.set_title(f"{first} to {last}", fontsize="small")
        else:
            axes.legend(
                fontsize="small", frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2
            )
    return figure


def _coincide(own: tuple[Array, Array], other: tuple[Array, Array]) -> bool:
    return own[1].shape == other[1].shape and not any(map(_differ, own, other))
