"""The pictures of README's first screen: one law beside another, and a small one for each kind of reader.

`python docs/tools/reader_pictures.py` leaves `compared.png`, `for_motors.png`, `for_joints.png` and so on in
`docs/static`, or in the folder that is given. Every curve is computed.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import contactlab as cl
from contactlab.plot.style import STYLE
from contactlab.results.files import whole_file

STATIC: Final = Path(__file__).resolve().parents[1] / "static"

SMALL: Final = (2.2, 1.5)
"""Size of a reader's picture [inch]."""

FRICTIONS: Final = {
    "Coulomb": cl.Coulomb(0.27),
    "Dahl": cl.Dahl(0.27, rest_stiffness=4e5),
    "Iwan": cl.Iwan(0.27),
}
IMPACTS: Final = {
    "Newton": cl.Newton(restitution=0.8),
    "Hertz, Thornton": cl.Composed(cl.Thornton()),
    "Hertz, viscous": cl.Composed(damping=cl.Tsuji()),
}
MOTORS: Final = {
    "rigid, sticks": "law=lagrange_stick",
    "Hertz, Coulomb": "law=hertz_penalty",
    "restitution 0.5": "law=newton",
}
"""Laws by what the figure calls them."""


def main(folder: Path = STATIC) -> None:
    """Make the pictures."""
    with plt.rc_context(STYLE | {"font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9}):
        figure, panels = plt.subplots(1, 3, figsize=(9.0, 2.9), layout="constrained")
        for axes, (title, draw) in zip(panels, COMPARED.items(), strict=True):
            draw(axes)
            axes.set_title(title, fontweight="bold", loc="left")
            axes.legend(fontsize=7.5, loc="best")
        _save(figure, folder / "compared.png", 120)
        for name, draw in READERS.items():
            figure, axes = plt.subplots(figsize=SMALL, layout="constrained")
            draw(axes)
            axes.tick_params(labelbottom=False, labelleft=False, length=0)
            axes.xaxis.label.set_size(8)
            axes.yaxis.label.set_size(8)
            _save(figure, folder / f"for_{name}.png", 110)


def _save(figure: Any, path: Path, dpi: int) -> None:
    with whole_file(path) as partial:
        figure.savefig(partial, format="png", dpi=dpi, metadata={"Software": None})
    plt.close(figure)


def draw_path(axes: Axes) -> None:
    """Draw friction over displacement on one path."""
    time = np.linspace(0.0, 1.0, 2001)
    way = 6e-6 * np.sin(4.0 * np.pi * time) * (0.4 + 0.6 * time)
    for label, friction in FRICTIONS.items():
        loop = cl.drive(cl.Composed(friction=friction), time, normal=10.0, slip=way)
        axes.plot(
            1e6 * way, -np.interp(time, loop["time"], loop["friction_force"]), label=label, linewidth=1.2
        )
    axes.set(xlabel="displacement (um)", ylabel="friction (N)")


def draw_impact(axes: Axes) -> None:
    """Draw restitution over the speed of impact."""
    speeds = np.geomspace(0.02, 5.0, 25)
    for label, law in IMPACTS.items():
        table = cl.normal_impact(law, speeds, mass="0.01 kg")
        axes.semilogx(speeds, table["restitution"], label=label, linewidth=1.6)
    axes.set(xlabel="speed of impact (m/s)", ylabel="restitution", ylim=(0.0, 1.05))


def draw_motor(axes: Axes) -> None:
    """Draw the speed of the default motor over time."""
    for label, law in MOTORS.items():
        run = cl.simulate(cl.build([law, "solver.duration=0.1", "record.interval=1e-4"]))
        axes.plot(1e3 * run["time"], -run["rotor_velocity"], label=label, linewidth=1.6)
    axes.set(xlabel="time (ms)", ylabel="rotor speed (rad/s)")


def draw_tip(axes: Axes) -> None:
    """Draw the path of a motor's tip with its contacts."""
    run = cl.simulate(cl.build(["solver.duration=20 ms", "record.interval=1 us"]))
    last = run["time"].values > 19.0e-3
    x, y = (
        1e6 * run[name].values[last] for name in ("tip_tangential_displacement", "tip_normal_displacement")
    )
    axes.plot(x, y, linewidth=1.4)
    closed = run["contact_mode"].values[last] > 0
    axes.plot(x[closed], y[closed], ".", color="C1", markersize=2.5)
    axes.set(xlabel="along the rotor", ylabel="towards it")


def draw_joint(axes: Axes) -> None:
    """Draw nested loops of a joint with microslip."""
    time = np.linspace(0.0, 3.0, 3001)
    way = 3e-6 * np.ceil(np.maximum(time, 1e-9)) * np.sin(2.0 * np.pi * time)
    loop = cl.drive(cl.Composed(friction=cl.Iwan(0.27)), time, normal=10.0, slip=way, degree=1)
    axes.plot(way, -np.interp(time, loop["time"], loop["friction_force"]), linewidth=1.2)
    axes.set(xlabel="displacement", ylabel="friction")


def draw_creep(axes: Axes) -> None:
    """Draw a block that is pushed inside its cone: stick, and friction that is a function of slip."""
    pushed = cl.block(1.0, weight=10.0, push=2.4, height=-1e-5)
    for label, friction in (("regularised", cl.Regularised(0.3)), ("stick", cl.Coulomb(0.3))):
        run = cl.simulate(pushed, cl.Composed(cl.Linear(1e6), friction=friction), duration=1.0)
        way = np.cumsum(run["slip_velocity"].values) * np.diff(run["time"].values, prepend=0.0)
        axes.plot(run["time"], way, label=label, linewidth=1.6)
    axes.set(xlabel="time", ylabel="creep")
    axes.legend(fontsize=7, loc="upper left")


def draw_adhesion(axes: Axes) -> None:
    """Draw approach and retraction of an adhesive tip."""
    time = np.linspace(0.0, 1.0, 2001)
    gap = 5e-9 - 7e-9 * np.sin(np.pi * time)
    law = cl.Composed(cl.Jkr(radius=20e-9, effective_modulus=1e9, work_of_adhesion=0.05))
    curve = cl.drive(law, time, gap=gap)
    force = np.interp(time, curve["time"], curve["normal_force"])
    for part in (time < 0.5, time >= 0.5):
        axes.plot(gap[part], force[part], linewidth=1.4)
    axes.set(xlabel="distance", ylabel="force")


def draw_steps(axes: Axes) -> None:
    """Draw friction after steps of the load point's velocity."""
    ends = np.array([0.0, 20.0, 22.0, 42.0])
    way = np.array([0.0, 2e-5, 4e-5, 6e-5])
    laws = (cl.Ruina(0.6, renewal_distance=2e-6), cl.RateAndState(0.6, renewal_distance=2e-6))
    for friction in laws:
        law = cl.Composed(cl.Linear(1e9), friction=friction)
        run = cl.drive(law, ends, normal=1e3, slip=way, degree=1, frame_stiffness=1e9, record_interval=0.02)
        x = np.interp(run["time"], ends, way)
        shown = x > 1e-5
        axes.plot(x[shown], -run["friction_force"].values[shown], linewidth=1.2)
    axes.set(xlabel="displacement", ylabel="friction")


def draw_ball(axes: Axes) -> None:
    """Draw a ball that comes to rest."""
    fall = cl.simulate(
        cl.ball(0.1, height=0.05), cl.Newton(restitution=0.7), duration=0.6, record_interval=1e-3
    )
    axes.plot(fall["time"], fall["gap"], linewidth=1.6)
    axes.set(xlabel="time", ylabel="height")


COMPARED: Final[dict[str, Callable[[Axes], None]]] = {
    "on a path": draw_path,
    "in an impact": draw_impact,
    "in a motor": draw_motor,
}
READERS: Final[dict[str, Callable[[Axes], None]]] = {
    "motors": draw_tip,
    "joints": draw_joint,
    "robots": draw_creep,
    "afm": draw_adhesion,
    "rock": draw_steps,
    "teachers": draw_ball,
}
"""What is drawn, by title or by name of the file."""

if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
