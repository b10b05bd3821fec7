"""The pictures of README, the home page, the paper and the steady states: a motor filmed, and laws compared.

`python docs/tools/readme_pictures.py` leaves `motor.gif`, `laws.png` and `order.png` in `docs/static`, or in
the folder that is given, and prints what pages quote of them. The last is drawn from `docs/results`.
"""

import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import contactlab as cl
from contactlab.plot.animation import Animation, write_gif
from contactlab.plot.recording import film_of, recording_of
from contactlab.plot.style import STYLE
from contactlab.results.files import whole_file

STATIC: Final = Path(__file__).resolve().parents[1] / "static"

SETTLED: Final = 0.4
"""Time after which the motor repeats itself, more than twenty times that in which it settles by e [s]."""

PERIODS, FRAMES, FPS = 2, 96, 24.0
"""Of the drive that are shown, frames of all of them, and frames a second."""

LAWS: Final = {
    "Hertz, Coulomb": ["law=hertz_penalty"],
    "Hertz, Mindlin": ["law=composed", "law/damping=none", "law/friction=mindlin"],
    "rigid, sticks": ["law=lagrange_stick"],
    "rigid, slips": ["law=lagrange_slip"],
    "restitution 0.5": ["law=newton"],
}
"""Laws by what the figure calls them."""

BASES: Final = {"ritz": "Four beam shapes (2001)", "finite_element": "Converged beam"}

SHOWN: Final = 0.2
"""Time that the transients are shown for [s]."""

APART: Final = 0.17
"""Least distance of two labels [rad/s]."""


ORDERED: Final = {"stick": "rigid, sticks", "newton": "restitution 0.5", "mindlin": "Hertz, Mindlin"}
"""Laws that are compared with a Hertz contact, by their names in the results."""

PHASES: Final = "converged, by phase"
DAMPINGS: Final = "converged, by damping ratio at equal free amplitude"
"""Sections of the results that they are compared in."""


def main(folder: Path = STATIC) -> None:
    """Make the pictures."""
    draw_motor(folder / "motor.gif")
    draw_laws(folder / "laws.png")
    draw_order(folder / "order.png")


def draw_motor(path: Path) -> None:
    """Film the default motor once it has settled: the last frame leads to the first."""
    setup = cl.build()
    settled = cl.simulate(setup, duration=SETTLED)
    period = recording_of(settled.tree).period
    run = recording_of(cl.simulate(start=settled, duration=PERIODS * period, record_interval=1e-6).tree)
    film = film_of(run, run.start, run.end, FRAMES)
    write_gif(Animation(film, FRAMES / FPS), FPS, path)


def draw_laws(path: Path) -> None:
    """Draw the same motor's way to its speed under every law, on both beams."""
    with plt.rc_context(STYLE | {"font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9}):
        figure, both = plt.subplots(1, 2, figsize=(7.4, 3.3), sharey=True, layout="constrained")
        for axes, (basis, text) in zip(both, BASES.items(), strict=True):
            speeds = _draw_beam(axes, basis)
            spread = np.ptp(speeds) / np.mean(speeds)
            axes.set_title(f"{text}: laws {spread:.0%} apart", fontweight="bold", loc="left")
        both[0].set_ylabel("rotor speed (rad/s)")
        with whole_file(path) as partial:
            figure.savefig(partial, format="png", pad_inches=0.12, metadata={"Software": None})
        plt.close(figure)


def _draw_beam(axes: Axes, basis: str) -> list[float]:
    """Draw the transients on one beam, in the motor's own sense, and give the settled speeds [rad/s]."""
    speeds, colours, end = [], [], 1.03e3 * SHOWN
    for text, law in LAWS.items():
        setup = cl.build([*law, f"resonator={basis}", f"solver.duration={SHOWN}", "record.interval=1e-4"])
        run, (velocity, error) = cl.simulate(setup), cl.steady(setup).velocity
        (line,) = axes.plot(1e3 * run["time"], -run["rotor_velocity"], linewidth=1.6)
        colours.append(line.get_color())
        axes.errorbar(end, -velocity, error, fmt="o", color=colours[-1], markersize=5, clip_on=False)
        speeds.append(-velocity)
        print(f"{basis}, {text}: {velocity:.5f} +- {error:.1g} rad/s")
    for place, k in zip(_spread(np.sort(speeds)), np.argsort(speeds), strict=True):
        axes.annotate(
            f"{list(LAWS)[k]}  {speeds[k]:.2f}", (end, speeds[k]), (1.09 * end, place),
            va="center", color="0.15", fontsize=9, annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": colours[k], "shrinkA": 1, "shrinkB": 0,
                        "relpos": (0.0, 0.5)},
        )  # fmt: skip
    axes.set(xlabel="time (ms)", xlim=(0.0, 1e3 * SHOWN), ylim=(0.0, 3.3))
    return speeds


def _spread(wanted: np.ndarray) -> np.ndarray:
    """Place ascending labels at least `APART` from each other, about where they belong."""
    steps = APART * np.arange(wanted.size)
    places = np.maximum.accumulate(wanted - steps) + steps
    return np.asarray(places - np.mean(places - wanted))


def draw_order(path: Path) -> None:
    """Draw settled speeds over that under a Hertz contact, by phase and by damping."""
    stored = json.loads((STATIC.parent / "results" / "motor.json").read_text(encoding="utf-8"))["sections"]
    phases, dampings = (stored[name]["results"] for name in (PHASES, DAMPINGS))
    names = [name if name == "configured" else f"{float(name):g} rad" for name in phases]
    with plt.rc_context(STYLE | dict.fromkeys(("font.size", "axes.labelsize", "legend.fontsize"), 9)):
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.4, 3.1), sharey=True, layout="constrained")
        for number, (law, text) in enumerate(ORDERED.items()):
            style: dict[str, Any] = {"color": f"C{number}", "marker": "o", "markersize": 5, "capsize": 2}
            values, errors = _ratios(phases.values(), law)
            left.errorbar(names, values, errors, linestyle="none", label=text, **style)
            for kind, inner in (("stiffness_damping", f"C{number}"), ("damping_ratio", "white")):
                cells = [cell for name, cell in dampings.items() if name.startswith(kind)]
                ratios = [cell["damping_ratio"][0] for cell in cells]
                right.errorbar(ratios, *_ratios(cells, law), markerfacecolor=inner, **style)
        left.set(xlabel="phase of the drive", ylabel="speed over that of Hertz, Coulomb")
        left.legend()
        left.margins(x=0.15)
        right.set(xlabel="damping ratio of the first mode", xscale="log")
        for axes in (left, right):
            axes.axhline(1.0, color="0.15", linewidth=0.8, zorder=1)
        with whole_file(path) as partial:
            figure.savefig(partial, format="png", pad_inches=0.12, metadata={"Software": None})
        plt.close(figure)


def _ratios(cells: Iterable[Mapping[str, Any]], law: str) -> tuple[list[float], list[float]]:
    """Return settled speeds over those under a Hertz contact, with errors; NaN where a law has none."""
    pairs = [(cell[law], cell["hertz"]["rotor_velocity"]) for cell in cells]
    values, errors = (
        [own[name] / hertz if name in own else np.nan for own, hertz in pairs]
        for name in ("rotor_velocity", "rotor_velocity_error")
    )
    return values, np.abs(errors).tolist()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
