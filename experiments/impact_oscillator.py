"""The oscillator that hits a stop: its period doubling and its grazing, by number and in closed form.

Period maps, branches and events of `contactlab.steady_state` are compared with known results: Shaw and Holmes
(J. Sound Vib. 90 (1983) 129) give the motions of one impact a period and their stability in closed form,
Guckenheimer and Holmes (Nonlinear Oscillations, 1983, sec. 2.4) the fold of the bouncing ball, and a motion
grazes where it just reaches the stop (Nordmark, J. Sound Vib. 145 (1991) 279).
"""

import re
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np
import xarray
from experiment import Experiment, main
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.style import context
from oscillator_with_stop import ImpactOscillator, doubling_between

import contactlab as cl
from contactlab.plot.style import STYLE
from contactlab.steady_state.continuation import Followed, Mark, follow
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.shooting import orbit_from
from contactlab.studies.orbit_figures import LINES

AGREE = 1e-6
"""Relative difference up to which a bifurcation counts as the published one."""

FASTEST, SLOWEST = 3.3, 2.5
"""Of the drive, over the natural frequency, stop at the place of rest, e = 0.8."""

DOUBLED = 2.68
"""Frequency at which the motion of two periods is stable."""

Family = Callable[[float], ImpactOscillator]


def swept(frequency: float) -> ImpactOscillator:
    """The oscillator of Shaw and Holmes: no damping, stop at the place of rest, e = 0.8."""
    return ImpactOscillator(stop=0.0, restitution=0.8, force=1.0, frequency=frequency)


def moved(stop: float) -> ImpactOscillator:
    """A damped oscillator above its resonance, whose stop moves."""
    return ImpactOscillator(stop, restitution=0.8, force=1.0, frequency=2.8, damping=0.1)


def ball(force: float) -> ImpactOscillator:
    """The ball on a table, e = 0.5, the force in its weight."""
    return ImpactOscillator(0.0, restitution=0.5, force=force, frequency=1.0, stiffness=0.0, weight=1.0)


def followed(family: Family, start: float, end: float, step: float) -> Followed:
    """The branch of motions with one impact a period, from that of the faster impact."""
    phase, z = family(start).impacts()[0].later(0.5)
    section = PeriodMap(family(start).setup(), phase=phase, belt=0.0)
    first = orbit_from(section, z * np.append(section.scale, 1.0))
    return follow(lambda value: PeriodMap(family(value).setup(), belt=0.0), first, start, end, step)


def doubled(start: float, end: float) -> Followed:
    """The branch of motions of two periods, from the one that the oscillator settles in."""
    result = cl.steady(swept(start).setup(-0.1), belt=0.0)
    if result.orbit is None or result.periods != 2:
        raise RuntimeError(
            f"At {start:g} the oscillator settles in a motion of {result.periods} periods, not 2."
        )
    return follow(lambda value: PeriodMap(swept(value).setup(), belt=0.0), result.orbit, start, end)


def speeds(branch: Followed) -> np.ndarray:
    """The speeds of the impacts of each orbit, shape (point, impact), the last of them where one grazes."""
    return np.array([np.sort(-p.run.contacts["approach_velocity"]) for p in branch.points])


def at_mark(branch: Followed, mark: Mark) -> float:
    """The parameter of the first event of a kind; NaN without one."""
    return next((p.value for p in branch.points if p.mark is mark), np.nan)


def settled(frequencies: Sequence[float] | np.ndarray, before: int, kept: int) -> np.ndarray:
    """The speeds of the last impacts after many periods, by no method but running on; NaN after chatter."""
    result = np.full((len(frequencies), kept), np.nan)
    for row, frequency in zip(result, frequencies, strict=True):
        section = PeriodMap(swept(float(frequency)).setup(), belt=0.0)
        with suppress(BrokenOffError):
            run = section.run(np.array([-0.1, 0.0]), before)
            row[:] = -run.contacts["approach_velocity"][-kept:]
    return result


def _published() -> list[float]:
    """The bifurcations in closed form."""
    doubling = doubling_between(swept, 2.6, 2.7)
    return [doubling, ball(1.0).ball_doubles_at, ball(1.0).ball_begins_at, moved(0.0).grazing_stop]


def _grazing_of(branch: Followed) -> float:
    """Where the branch says that its impact would be without speed."""
    stated = re.search(r"without speed at ([\d.e-]+):", branch.end)
    return float(stated[1]) if stated else np.nan


def _draw_branch(ax: Axes, data: xarray.Dataset, name: str, colour: str, label: str) -> None:
    """Solid where it is stable, dashed elsewhere."""
    value, speed = data[f"{name}_value"].values, data[f"{name}_speed"].values
    stable = data[f"{name}_stable"].values.astype(bool)
    for kind, line in LINES.items():
        shown = np.where((stable == kind)[:, None], speed, np.nan)
        lines = ax.plot(value, shown, linestyle=line, color=colour)
        if label:
            lines[0].set_label(f"{label}, {'stable' if kind else 'unstable'}")


class ImpactOscillatorBranches(Experiment):
    """Do computed bifurcations agree with those in closed form?"""

    says = "Nothing: the paper has no bifurcations. Published are those of the oscillator with a stop."

    def compute(self, setup: cl.Setup) -> xarray.Dataset:
        """Return branches, long runs (few of them in the short form) and bifurcations."""
        del setup
        step = 0.1 if self.short else 0.02
        item = followed(swept, SLOWEST, 2.7 if self.short else FASTEST, step)
        grazing = followed(moved, 0.1, 0.16, step)
        bouncing = followed(ball, 1.9, 1.0, step)
        frequencies = np.linspace(SLOWEST, FASTEST, 3 if self.short else 161)
        data = xarray.Dataset(
            {
                "settled_speed": (
                    ("frequency", "impact"),
                    settled(frequencies, 60 if self.short else 400, 20 if self.short else 60),
                    {"units": "m s-1", "long_name": "speed of the last impacts of a long run"},
                ),
                "published": ("event", _published(), {"long_name": "parameter in closed form"}),
                "found": (
                    "event",
                    [
                        at_mark(item, Mark.PERIOD_DOUBLING),
                        at_mark(bouncing, Mark.PERIOD_DOUBLING),
                        at_mark(bouncing, Mark.FOLD),
                        _grazing_of(grazing),
                    ],
                    {"long_name": "parameter that the branch gives"},
                ),
            },
            coords={
                "frequency": ("frequency", frequencies, {"units": "1", "long_name": "omega / omega_0"}),
                "event": ["period doubling", "period doubling of the ball", "fold of the ball", "grazing"],
            },
        )
        branches = {"one": item, "grazing": grazing}
        if not self.short:
            branches["two"] = doubled(DOUBLED, SLOWEST)
            branches["two_on"] = doubled(DOUBLED, FASTEST)
        for name, branch in branches.items():
            data[f"{name}_value"] = (f"{name}_point", [p.value for p in branch.points])
            data[f"{name}_speed"] = ((f"{name}_point", f"{name}_impact"), speeds(branch))
            data[f"{name}_stable"] = (f"{name}_point", [int(p.orbit.stable) for p in branch.points])
            data[f"{name}_value"].attrs["end"] = branch.end
        return data

    def rows(self, data: xarray.Dataset) -> list[dict[str, object]]:
        """Every bifurcation, in closed form and by the branch."""
        return [
            {
                "event": str(event.event.values),
                "closed form": float(event.published),
                "by continuation": float(event.found),
                "relative difference": float(event.found / event.published - 1.0),
            }
            for event in (data.sel(event=name) for name in data.event.values)
        ]

    def draw(self, data: xarray.Dataset) -> Figure:
        """Speeds of the impacts over frequency and over the place of the stop."""
        with context(STYLE):
            figure = Figure(figsize=(7.2, 3.2), layout="constrained")
            left, right = figure.subplots(1, 2, width_ratios=(1.7, 1.0))
            x = np.repeat(data.frequency.values, data.sizes["impact"])
            left.plot(
                x, data.settled_speed.values.ravel(), ".", color="0.5", markersize=0.6, label="long runs"
            )
            _draw_branch(left, data, "one", "#0072B2", "one impact a period")
            for name, label in (("two", "two"), ("two_on", "")):
                if f"{name}_value" in data:
                    _draw_branch(left, data, name, "#D55E00", label)
            doubling = float(data.published.sel(event="period doubling"))
            left.axvline(doubling, color="0.5", linewidth=0.6)
            left.text(doubling, left.get_ylim()[1], f" {doubling:.6f}", va="top", ha="left", fontsize=7)
            left.set(ylim=(0.0, None), xlabel=r"$\omega/\omega_0$", ylabel="speed of the impacts (m/s)")
            left.legend(loc="upper right")
            _draw_branch(right, data, "grazing", "#0072B2", "")
            grazing = float(data.published.sel(event="grazing"))
            stops = np.linspace(float(data.grazing_value.min()), grazing, 200)
            exact = [[i.speed for i in moved(stop).impacts()][:1] for stop in stops]
            right.plot(stops, [e[0] if e else 0.0 for e in exact], ":", color="black", label="closed form")
            right.plot(
                grazing, 0.0, "v", color="black", markerfacecolor="white", label="grazing", clip_on=False
            )
            right.set(xlabel="stop (m)", ylabel="speed of the impact (m/s)", ylim=(0.0, None))
            right.legend(loc="upper right")
        return figure

    def finding(self, data: xarray.Dataset) -> tuple[str, bool]:
        """How near the bifurcations are to the published ones."""
        apart = np.abs(data.found / data.published - 1.0)
        worst = str(data.event.values[int(np.argmax(apart.fillna(np.inf).values))])
        sentence = (
            "The period of the oscillator with its stop at the place of rest and e = 0.8 doubles at "
            f"{float(data.found[0]):.7f} of its natural frequency, in closed form at "
            f"{float(data.published[0]):.7f}. Of {apart.size} bifurcations the {worst} is farthest from the "
            f"published one, by {float(apart.max()):.1e} of it."
        )
        return sentence, bool((apart <= AGREE).all())


if __name__ == "__main__":
    main(__file__)
