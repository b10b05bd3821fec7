"""The drawings of the theory and of the architecture, made from the package's geometry, kinematics and runs.

    python docs/tools/drawings.py [FOLDER]

The SVGs go to `docs/drawings` or the folder. Lengths in drawings of the motor are in mm, of the default
setup. Whatever is not to scale is written on the drawing.
"""

import sys
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle
from scipy.interpolate import CubicSpline

import contactlab as cl
from contactlab.arrays import Array
from contactlab.engine.propagator import radau_rule
from contactlab.engine.state import NODES
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.ritz import ClampedBeam, RitzResonator
from contactlab.plot.overview import shade
from contactlab.plot.recording import Recording, recording_of
from contactlab.plot.style import COLOURS, STYLE
from contactlab.results.files import whole_file
from contactlab.variables import CONTACT_MODE

ROOT: Final = Path(__file__).resolve().parents[2]
FOLDER: Final = ROOT / "docs" / "drawings"

INK, FAINT, STEEL, CERAMIC = "0.15", "0.5", "#C9D3DC", "#F3D9A8"
ACCENT, FORCE, SPEED = COLOURS["stick"], COLOURS["fault"], "#009E73"
"""Colours: outlines, the state at rest, materials; displacements and electrodes, forces, velocities."""

THIN, LINE, BOLD = 0.7, 1.2, 2.4
"""Line widths of dimensions, of outlines and arrows, and of electrodes [pt]."""

WIDTH: Final = 7.2
"""Of every drawing [in]: 691 px, so that a point of text is 1.33 px."""

HOUSE: Final[dict[str, Any]] = STYLE | {
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    **dict.fromkeys(("font.size", "axes.titlesize", "axes.labelsize"), 10),
    **dict.fromkeys(("xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 9),
    "savefig.bbox": None,
    "savefig.transparent": True,
    "svg.fonttype": "path",
    "hatch.linewidth": 0.5,
}

THICKER, GAP_SHOWN = 2.5, 1.0
"""Factor of the thicknesses in the drawing of the motor, and its gap at rest [mm]."""

STEP_SHOWN: Final = 16e-6
"""Length of the drawn step [s]; the engine's are shorter."""

INTERVAL: Final = 1e-7
"""Time between records of the runs that are drawn [s]."""


def arrow(axes: Axes, start: Any, end: Any, colour: str = INK, gid: str = "", style: str = "-|>") -> None:
    """Draw an arrow between two points; `gid` is its name in the figure and in the SVG."""
    axes.annotate(
        "", tuple(end), tuple(start), gid=gid or None,
        arrowprops={"arrowstyle": style, "color": colour, "linewidth": THIN if "<" in style else LINE,
                    "shrinkA": 0, "shrinkB": 0, "mutation_scale": 9},
    )  # fmt: skip


def dimension(axes: Axes, a: Any, b: Any, text: str, shift: tuple[float, float], **options: Any) -> None:
    """Draw a dimension between two points, with its text beside the middle."""
    arrow(axes, a, b, INK, style="<|-|>")
    label(axes, 0.5 * (np.asarray(a) + b) + shift, text, **options)


def label(axes: Axes, place: Any, text: str, colour: str = INK, **options: Any) -> None:
    """Write a text centred at a point."""
    axes.text(*place, text, color=colour, **({"ha": "center", "va": "center"} | options))


def turn(
    axes: Axes, centre: Any, radius: float, degrees: tuple[float, float], colour: str, gid: str = ""
) -> None:
    """Draw an arrow along an arc from one angle to another, counted from x, counter-clockwise."""
    angle = np.radians(np.linspace(*degrees, 60))
    points = np.asarray(centre) + radius * np.column_stack((np.cos(angle), np.sin(angle)))
    axes.plot(*points[:-2].T, color=colour, linewidth=LINE, solid_capstyle="butt")
    arrow(axes, points[-3], points[-1], colour, gid)


def scene(axes: Axes, x: tuple[float, float], y: tuple[float, float], title: str = "") -> None:
    """Make axes a drawing to scale without frame."""
    axes.set(xlim=x, ylim=y, aspect="equal")
    axes.set_axis_off()
    axes.set_title(title, fontweight="bold", color=INK)


def sheet(height: float, x: tuple[float, float], y: tuple[float, float]) -> tuple[Figure, Axes]:
    """Return a figure of some inches with one drawing that fills it."""
    figure = Figure(figsize=(WIDTH, height))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    scene(axes, x, y)
    return figure, axes


def in_modes(axes: Axes, x: Array, y: Array, modes: Array) -> None:
    """Draw the parts of a line where the contact slips and where it sticks."""
    for k, name in enumerate(CONTACT_MODE.flags[1:], 1):
        parts = (np.where(modes == k, values, np.nan) for values in (x, y))
        axes.plot(*parts, color=COLOURS[name], linewidth=BOLD, label=name)


def box(axes: Axes, x: float, y: float, width: float, height: float, text: str, **options: Any) -> None:
    """Draw a box with a text about its centre."""
    options = {"facecolor": STEEL, "edgecolor": INK, "linewidth": LINE} | options
    low = (x - 0.5 * width, y - 0.5 * height)
    axes.add_patch(FancyBboxPatch(low, width, height, boxstyle="round,pad=0,rounding_size=0.6", **options))
    label(axes, (x, y), text, linespacing=1.35)


def resonator(setup: cl.Setup) -> RitzResonator:
    """Return the beam of a setup in the basis of the paper."""
    values = setup.configuration["resonator"]
    names = ("length", "width", "beam_thickness", "patch_thickness", "shapes")
    start, end = (setup.configuration["placement"][name] for name in ("start", "end"))
    return RitzResonator(patch_start=start, patch_end=end, **{name: values[name] for name in names})


def draw_motor(setup: cl.Setup | None = None) -> Figure:
    """Draw beam, patches, electrodes, poling, tip and rotor of the default or another setup, with lengths."""
    setup = setup or cl.build()
    beam, geometry = resonator(setup), setup.motor.geometry
    length, tip, radius = 1e3 * beam.length, 1e3 * geometry.tip_length, 1e3 * geometry.rotor_radius
    half, layer = 0.5e3 * THICKER * beam.beam_thickness, 1e3 * THICKER * beam.patch_thickness
    outer, end = half + layer, 0.5 * length
    figure, axes = sheet(5.0, (-36.0, 36.0), (-17.0, 33.0))

    axes.add_patch(Rectangle((-end, -half), length, 2.0 * half, facecolor=STEEL, edgecolor=INK))
    for side in (-1.0, 1.0):
        clamp = (min(side * end, side * (end + 4.0)), -7.0), 4.0, 14.0
        axes.add_patch(Rectangle(*clamp, facecolor="none", edgecolor=FAINT, hatch="////", linewidth=0.0))
        axes.plot([side * end] * 2, [-7.0, 7.0], color=INK, linewidth=LINE)
    # Outer electrodes at U, the beam at zero: a positive moment shortens the upper layer, whose field
    # points to the beam then, along the poling.
    poling = -np.sign(beam.moment_per_voltage)
    for number, (first, last) in enumerate(beam.patches, 1):
        a, b = 1e3 * first - end, 1e3 * last - end
        for side in (-1.0, 1.0):
            low = min(side * half, side * outer)
            axes.add_patch(
                Rectangle((a, low), b - a, layer, facecolor=CERAMIC, edgecolor=INK, gid=f"patch_{number}")
            )
            axes.plot([a, b], [side * outer] * 2, color=ACCENT, linewidth=BOLD, solid_capstyle="butt")
            x, middle = 0.5 * (a + b), side * (half + 0.5 * layer)
            arrow(axes, (x - 2.2, middle - 0.9 * poling), (x - 2.2, middle + 0.9 * poling), INK, "poling")
            label(axes, (x - 0.6, middle), "P")
            axes.plot([x + 1.4] * 2, [side * outer, side * 7.0], color=ACCENT, linewidth=LINE)
            axes.plot(x + 1.4, side * 7.4, "o", color=ACCENT, markerfacecolor="none", markersize=5)
            label(axes, (x + 2.3, side * 7.4), f"$U_{number}$", ACCENT, ha="left")
    first, last = beam.patches[0]
    a, b = 1e3 * first - end, 1e3 * last - end
    for x, top, low in (
        (a, -outer - 0.3, -12.6),
        (b, -outer - 0.3, -12.6),
        (-end, -7.0, -15.4),
        (end, -7.0, -15.4),
    ):
        axes.plot([x] * 2, [top, low], color=FAINT, linewidth=THIN)
    text = f"$a_1$ to $b_1$:  {1e3 * first:.3f} to {1e3 * last:.3f} mm"
    dimension(axes, (a, -11.6), (b, -11.6), text, (0.5 * (b - a) + 0.8, 0.0), ha="left")
    dimension(axes, (-end, -15.0), (end, -15.0), f"$L$ = {length:.0f} mm", (0.0, 1.0))
    axes.plot([6.0] * 2, [-half, -5.5], color=INK, linewidth=LINE)
    for k, wide in enumerate((1.5, 0.9, 0.3)):
        axes.plot([6.0 - wide, 6.0 + wide], [-5.5 - 0.6 * k] * 2, color=INK, linewidth=LINE)
    label(axes, (8.2, -5.9), "beam at 0 V", ha="left")

    rim = tip + GAP_SHOWN
    axes.add_patch(Circle((0.0, rim + radius), radius, facecolor=COLOURS["rotor"], edgecolor=INK))
    outline = [(-1.5, half), (-1.5, tip - 3.0), (0.0, tip), (1.5, tip - 3.0), (1.5, half)]
    axes.add_patch(Polygon(outline, facecolor=STEEL, edgecolor=INK, gid="tip"))
    label(axes, (0.0, 29.5), f"rotor,  $R$ = {radius:.0f} mm,  inertia $J$")
    turn(axes, (0.0, rim + radius), 21.0, (-112.0, -68.0), SPEED)
    label(axes, (8.6, 26.3), r"$\Omega$", SPEED)
    for y in (0.0, tip):
        axes.plot([0.6 if y else 9.0, 17.4], [y] * 2, color=FAINT, linewidth=THIN)
    dimension(axes, (16.6, 0.0), (16.6, tip), f"tip\n$L_t$ = {tip:.0f} mm", (5.4, 2.0))
    for y, way in ((tip, 2.4), (rim + 0.2, -2.4)):
        arrow(axes, (3.4, y - way), (3.4, y))
    gap = f"gap at rest\n$g_0$ = {1e6 * geometry.clearance:g} µm,\ndrawn {GAP_SHOWN:g} mm"
    label(axes, (4.4, tip - 0.8), gap, ha="left", va="top")
    for end_of, place, name in (((6.8, 0.0), (7.6, 0.0), "$x$"), ((0.0, 7.0), (-0.75, 6.4), "$y$")):
        arrow(axes, (0.0, 0.0), end_of)
        label(axes, place, name)
    notes = (
        f"{1e3 * beam.width:.0f} mm wide, into the page",
        f"beam {1e3 * beam.beam_thickness:g} mm, patches {1e3 * beam.patch_thickness:g} mm thick,",
        f"drawn {THICKER:g} times as thick",
        "P: poling;  blue: electrodes",
        f"$U_e$ > 0 {'shortens' if poling < 0.0 else 'stretches'} the upper patch",
    )
    label(axes, (-35.0, 23.0), "\n".join(notes), ha="left", va="top", linespacing=1.4, fontsize=9)
    return figure


def draw_modes() -> Figure:
    """Draw what each tone does: the two bending modes, and the path of the tip's end that both make."""
    setup = cl.build()
    beam = resonator(setup)
    x = np.linspace(0.0, beam.length, 200)
    shapes, matrices = ClampedBeam(beam.length, beam.shapes), beam.matrices
    _, vectors = scipy.linalg.eigh(matrices.stiffness, matrices.mass)
    # A mode's sign is free: here that of a positive voltage on the first electrode.
    vectors = vectors * np.sign(vectors.T @ matrices.coupling[:, 0])
    figure = Figure(figsize=(WIDTH, 3.3))
    texts = ("first tone,\n$U_1 = U_2$:\nthe tip rises", "second tone,\n$U_1 = -U_2$:\nthe tip leans")
    for k, text in enumerate(texts):
        axes = figure.add_axes((0.01, 0.52 - 0.5 * k, 0.5, 0.46))
        scene(axes, (-30.0, 30.0), (-5.0, 22.0))
        w, middle, slope = (
            np.tensordot(vectors[:, k], shapes.evaluate(place, order), 1)
            for place, order in ((x, 0), (0.5 * beam.length, 0), (0.5 * beam.length, 1))
        )
        for sign, colour in ((-1.0, FAINT), (1.0, ACCENT)):
            scale = sign * 2.2 / np.abs(w).max()
            axes.plot(1e3 * x - 28.5, scale * w, color=colour, linewidth=BOLD)
            foot, theta = scale * middle, np.arctan(1e-3 * scale * slope)
            end = (-19.0 * np.sin(theta), foot + 19.0 * np.cos(theta))
            axes.plot([0.0, end[0]], [foot, end[1]], color=colour, linewidth=BOLD)
        label(axes, (-29.0, 14.0), text, ha="left", fontsize=9)
    period = 1.0 / float(setup.motor.drive.frequency[0])
    settled = cl.simulate(setup, duration=0.4, record_interval=period)
    free = cl.simulate(cl.build(["contact.clearance=1 mm"]), duration=0.05, record_interval=period / 400)
    path = figure.add_axes((0.62, 0.16, 0.36, 0.76))
    for run, colour in (
        (free, FAINT),
        (cl.simulate(start=settled, duration=period, record_interval=period / 400), INK),
    ):
        across, up = (1e6 * run[f"tip_{n}_displacement"].values[-401:] for n in ("tangential", "normal"))
        path.plot(across, up, color=colour, linewidth=LINE)
        for i in range(20, across.size, 75):
            arrow(path, (across[i - 1], up[i - 1]), (across[i], up[i]), colour)
        if colour == INK:
            in_modes(path, across, up, run["contact_mode"].values[-401:])
    path.axhline(1e6 * setup.motor.geometry.clearance, color=INK, linewidth=THIN, linestyle="--")
    label(path, (0.1, -4.5), "without rotor", FAINT, fontsize=9)
    label(path, (0.5, -2.85), "with rotor", fontsize=9)
    label(path, (-0.5, 1.4), "gap closed", fontsize=9)
    path.legend(ncols=2, loc="upper center")
    path.set(xlabel="tip end along $x$ (µm)", ylabel="displacement $u$ (µm)", ylim=(-5.2, 5.6))
    return figure


@dataclass(frozen=True)
class Pose:
    """Points of a displaced motor as they are drawn, in metres, origin in the middle of the beam at rest.

    Args:
        u, theta, alpha: displacement [m] and slope [rad] of the beam's middle, angle of the rotor [rad].
        geometry: lengths.
    """

    u: float
    theta: float
    alpha: float
    geometry: ContactGeometry

    @property
    def tip(self) -> Array:
        """End of the tip: perpendicular to the beam's slope, counter-clockwise for a positive one."""
        return np.array((0.0, self.u)) + self.geometry.tip_length * np.array(
            (-np.sin(self.theta), np.cos(self.theta))
        )

    @property
    def centre(self) -> Array:
        """Centre of the rotor."""
        g = self.geometry
        away = np.array((np.sin(g.angle), np.cos(g.angle)))
        return np.array((0.0, g.tip_length)) + (g.clearance + g.rotor_radius) * away

    def rim(self, degrees: float) -> Array:
        """Return a point of the rim, by its angle from x at alpha = 0; it turns counter-clockwise."""
        angle = np.radians(degrees) + self.alpha
        return self.centre + self.geometry.rotor_radius * np.array((np.cos(angle), np.sin(angle)))

    @property
    def directions(self) -> tuple[Array, Array]:
        """Normal n and tangent t, from the engine's frame; t is n turned by +90 degrees."""
        # Seen along t and along n, a unit displacement u is t_y = n_x and n_y.
        _, n_y, _, n_x, _ = self.geometry.frame(self.u, self.theta)
        return np.array((n_x, n_y)), np.array((-n_y, n_x))


def shown_pose() -> Pose:
    """Return the displaced motor of the drawing: lengths of the default setup, displacements in mm."""
    g = cl.build().motor.geometry
    return Pose(3e-3, 0.2, 0.24, ContactGeometry(g.tip_length, g.rotor_radius, 6.5e-3))


def draw_frame() -> Figure:
    """Draw the contact with every sign: displacements, forces and velocities, each in its positive sense."""
    figure = Figure(figsize=(WIDTH, 4.5))
    left, middle, right = (
        figure.add_axes((x, 0.1, w, 0.82)) for x, w in ((0.0, 0.42), (0.42, 0.29), (0.71, 0.29))
    )
    _draw_displacements(left, shown_pose())
    rest = Pose(0.0, 0.0, 0.0, cl.build().motor.geometry)
    _draw_forces(middle, rest)
    _draw_velocities(right, rest)
    texts = (
        "Every arrow shows its positive sense.",
        r"In slip  $F = -\mu N\, \mathrm{sign}(v)$ ;",
        r"rotor  $J\,\dot\Omega = -R F - C_r \Omega - \tau$ .",
    )
    figure.text(0.02, 0.035, "   ".join(texts), color=INK)
    return figure


def _draw_displacements(axes: Axes, pose: Pose) -> None:
    scene(axes, (-17.0, 17.0), (-6.0, 36.5), "Displacements")
    u, tip, centre = 1e3 * pose.u, 1e3 * pose.tip, 1e3 * pose.centre
    normal, _ = pose.directions
    length, radius = 1e3 * pose.geometry.tip_length, 1e3 * pose.geometry.rotor_radius
    edge = centre + radius * normal
    axes.add_patch(Circle(tuple(centre), radius, facecolor=COLOURS["rotor"], edgecolor=INK))
    axes.plot([-16.0, 16.0], [0.0] * 2, color=FAINT, linewidth=LINE, linestyle="--")
    axes.plot([0.0] * 2, [u, length], color=FAINT, linewidth=LINE, linestyle="--")
    # Halves of a beam that is clamped at +-16 mm: cubics with w(0) = u, w'(0) = theta.
    s = np.linspace(0.0, 1.0, 50)
    for side in (-1.0, 1.0):
        w = u * (1.0 - 3.0 * s**2 + 2.0 * s**3) + side * 16.0 * np.tan(pose.theta) * s * (1.0 - s) ** 2
        axes.plot(side * 16.0 * s, w, color=INK, linewidth=BOLD)
    axes.plot([0.0, tip[0]], [u, tip[1]], color=INK, linewidth=BOLD, solid_capstyle="round", gid="tip")
    arrow(axes, (0.0, 0.0), (0.0, u), ACCENT, "u")
    label(axes, (1.4, 0.45 * u), "$u$", ACCENT)
    turn(axes, (0.0, u), 11.0, (90.0, 90.0 + np.degrees(pose.theta)), ACCENT, "theta")
    label(axes, (-0.2, u + 12.4), r"$\theta$", ACCENT)
    arrow(axes, edge, tip, ACCENT, "g")
    label(axes, 0.5 * (edge + tip) - (1.6, 0.0), "$g$", ACCENT)
    for alpha, style, colour in ((0.0, "--", FAINT), (pose.alpha, "-", INK)):
        outer = 1e3 * Pose(0.0, 0.0, alpha, pose.geometry).rim(-80.0)
        mark = np.transpose([outer, centre + 0.74 * (outer - centre)])
        axes.plot(*mark, color=colour, linewidth=LINE, linestyle=style)
    turn(axes, centre, 0.83 * radius, (-80.0, -80.0 + np.degrees(pose.alpha)), ACCENT, "alpha")
    label(axes, (6.0, 33.4), r"$\alpha$", ACCENT)
    label(axes, (-9.5, 34.0), "rotor")
    label(
        axes, (9.6, 13.5), "tip end $L$ at\n$x = -L_t \\sin\\theta$\n$y = u + L_t \\cos\\theta$", fontsize=9
    )
    label(axes, (-10.5, -3.0), "beam", va="top")
    arrow(axes, (7.0, -5.0), (12.0, -5.0))
    arrow(axes, (7.0, -5.0), (7.0, -1.2))
    label(axes, (13.0, -5.0), "$x$")
    label(axes, (5.9, -2.0), "$y$")


def _two_bodies(axes: Axes, title: str) -> tuple[Array, Array]:
    """Draw the rotor above and the tip below it, apart, and return the two points that touch."""
    scene(axes, (-12.0, 12.0), (-16.0, 27.0), title)
    tip, edge = np.array((0.0, 0.0)), np.array((0.0, 12.0))
    axes.add_patch(Circle((0.0, 37.0), 25.0, facecolor=COLOURS["rotor"], edgecolor=INK))
    outline = [(-1.5, -16.0), (-1.5, -3.0), tip, (1.5, -3.0), (1.5, -16.0)]
    axes.add_patch(Polygon(outline, facecolor=STEEL, edgecolor=INK))
    return tip, edge


def _draw_forces(axes: Axes, pose: Pose) -> None:
    tip, edge = _two_bodies(axes, "Forces")
    normal, tangent = pose.directions
    for name, point, sign, side in (("tip", tip, 1.0, 1.0), ("rotor", edge, -1.0, -1.0)):
        arrow(axes, point - 5.0 * sign * normal, point, FORCE, f"N on the {name}")
        arrow(axes, point, point + 6.5 * sign * tangent, FORCE, f"F on the {name}")
        label(axes, point - 3.6 * sign * normal - (1.4, 0.0), "$N$", FORCE)
        label(axes, point + 7.8 * side * tangent, "$F$", FORCE)
    label(axes, (6.6, -10.5), "on the tip:\n$N\\,n + F\\,t$", fontsize=9)
    label(axes, (0.0, 25.2), "on the rotor: the opposite", fontsize=9)
    corner = np.array((-8.5, -5.0))
    for name, way in (("n", normal), ("t", tangent)):
        arrow(axes, corner, corner + 4.5 * way, INK, name)
        label(axes, corner + 5.8 * way, f"${name}$")
    turn(axes, (0.0, 37.0), 17.5, (-68.0, -108.0), FORCE, "tau")
    label(axes, (8.0, 20.2), r"$\tau$", FORCE)


def _draw_velocities(axes: Axes, pose: Pose) -> None:
    tip, edge = _two_bodies(axes, "Velocities")
    _, tangent = pose.directions
    fast, slow = 9.5, 4.0
    arrow(axes, tip, tip + fast * tangent, SPEED, "tip velocity")
    label(axes, (5.6, -2.2), r"$t \cdot \dot L$", SPEED)
    arrow(axes, edge, edge + slow * tangent, SPEED, "surface velocity")
    label(axes, (7.0, 11.4), r"$R\,\Omega$", SPEED)
    axes.plot([slow] * 2, [edge[1], 4.6], color=FAINT, linewidth=THIN, linestyle="--")
    axes.plot([fast] * 2, [tip[1], 6.6], color=FAINT, linewidth=THIN, linestyle="--")
    arrow(axes, (slow, 5.6), (fast, 5.6), ACCENT, "v")
    label(axes, (6.7, 7.2), "$v$", ACCENT)
    turn(axes, (0.0, 37.0), 17.5, (-112.0, -68.0), SPEED, "Omega")
    label(axes, (8.4, 21.0), r"$\Omega$", SPEED)
    label(axes, (0.0, 25.2), "rotor", fontsize=9)
    label(axes, (6.7, -10.5), "slip velocity\n$v = t\\cdot\\dot L - R\\Omega$", fontsize=9)


@cache
def contact_run() -> cl.Solution:
    """Return the first contacts of the default motor, a Hertz contact with Coulomb friction."""
    return cl.simulate(cl.build(), duration=5.2e-4, record_interval=INTERVAL)


@cache
def impact_run() -> cl.Solution:
    """Return the first contacts of the same motor under a rigid law."""
    return cl.simulate(cl.build(["law=lagrange_stick"]), duration=1.8e-3, record_interval=INTERVAL)


def impulses_of(run: cl.Solution, name: str) -> Array:
    """Return the normal or friction impulses of the impacts that contacts begin with [N s], shape (contact,).

    The force recorded for an impact is its impulse and that of the force after it over the interval.
    """
    time, force = run["time"].values, run[f"{name}_force"].values
    start = run.contacts["start_time"].values
    at = np.searchsorted(time, start)
    return np.asarray(force[at] * INTERVAL - force[at + 1] * (time[at] - start))


def friction_coefficient() -> float:
    """Return mu of the default setup."""
    return float(cl.build().configuration["contact"]["friction_coefficient"])


def around(run: cl.Solution, k: int) -> Recording:
    """Return the part of a run around one of its contacts."""
    start, lasts = (float(run.contacts[name][k]) for name in ("start_time", "duration"))
    return recording_of(run.tree).between(start - 10e-6, start + lasts + 10e-6)


def shown_contact() -> Recording:
    """Return the part of the compliant run around the contact that sticks longest."""
    return around(contact_run(), int(contact_run().contacts["stick_duration"].values.argmax()))


def draw_contact() -> Figure:
    """Draw one compliant contact over time: gap, forces, slip velocity and energies."""
    part = shown_contact()
    figure, energy = _draw_over_time(part, "touch-down")
    time = 1e6 * (part.time - part.contacts["start_time"][0])
    stored = 1e6 * part.series["contact_energy"]
    energy.plot(time, stored, color=ACCENT)
    label(energy, (time[stored.argmax()], 0.72 * stored.max()), "stored $V_c$", ACCENT)
    return figure


def draw_impact() -> Figure:
    """Draw one rigid contact over time, likewise: an impact, and the forces of the contact that lasts."""
    part = around(impact_run(), 1)
    figure, energy = _draw_over_time(part, "impact")
    time, lost = 1e6 * (part.time - part.contacts["start_time"][0]), 1e6 * part.series["contact_loss"]
    energy.plot(time, lost - lost[0], color=INK)
    label(energy, (time[-1], lost[-1] - lost[0]), "lost in the impact $W_n$ ", ha="right", va="bottom")
    figure.axes[0].set_ylim(-0.25, 0.62)
    for axes, name, scale in zip(figure.axes[1:3], ("normal", "friction"), (11.0, 3.3), strict=True):
        axes.set_ylim(-0.15 * scale if name == "normal" else -scale, scale)
        impulse = 1e6 * impulses_of(impact_run(), name)[1]
        arrow(axes, (0.0, 0.0), (0.0, 0.95 * scale), FORCE)
        label(axes, (0.8, 0.8 * scale), f"impulse {impulse:.3g} µN s", FORCE, ha="left")
    return figure


def _draw_over_time(part: Recording, event: str) -> tuple[Figure, Axes]:
    """Draw what both kinds of contact have, with the name of their first event; the last panel is energy."""
    start = float(part.contacts["start_time"][0])
    time = 1e6 * (part.time - start)
    # Forces are means over the record interval before; what an impact is in has no force.
    before, impact = time - 0.5e6 * INTERVAL, np.isinf(part.contacts["peak_normal_force"][0])
    forces = {name: part.series[f"{name}_force"].copy() for name in ("normal", "friction")}
    for force in forces.values():
        force[np.searchsorted(time, 0.0)] *= np.nan if impact else 1.0
    figure = Figure(figsize=(WIDTH, 7.0), layout="constrained")
    panels = figure.subplots(5, 1, sharex=True)
    gap, normal, friction, slip, energy = panels
    gap.plot(time, 1e6 * part.series["gap"], color=INK)
    normal.plot(before, forces["normal"], color=FORCE)
    friction.plot(before, forces["friction"], color=FORCE)
    bound = friction_coefficient() * forces["normal"]
    most = float(np.nanmax(bound))
    # Where the bound has fallen to half of its largest.
    half = int(np.flatnonzero(bound > 0.5 * most)[-1])
    for sign, text in ((-1.0, r"$-\mu N$"), (1.0, r"$\mu N$")):
        friction.plot(before, sign * bound, color=INK, linewidth=THIN, linestyle="--", zorder=1.5)
        label(friction, (before[half] + 1.5, sign * 0.95 * most), text)
    slip.plot(time, 1e3 * part.series["slip_velocity"], color=SPEED)
    lost = 1e6 * (part.series["friction_loss"] - part.series["friction_loss"][0])
    energy.plot(time, lost, color=FORCE)
    label(energy, (time[-1], lost[-1]), "lost in friction $W_f$ ", FORCE, ha="right", va="bottom")
    texts = ("gap $g$\n(µm)", "normal force\n$N$ (N)", "friction\n$F$ (N)", "slip velocity\n$v$ (mm/s)")
    for axes, text in zip(panels, (*texts, "energy\n(µJ)"), strict=True):
        shade(axes, part, start)
        axes.axhline(0.0, color=FAINT, linewidth=THIN)
        axes.set_ylabel(text)
        axes.margins(x=0.0, y=0.12)
    energy.set_xlabel("time since touch-down (µs)")
    figure.align_ylabels(panels)
    spans = [(*span, mode) for mode, times in part.spans().items() for span in times]
    first, last = min(a for a, _, _ in spans), max(b for _, b, _ in spans)
    for instant, name, ha in ((first, f"{event} ", "right"), (last, " release", "left")):
        gap.plot(1e6 * (instant - start), 0.0, "o", color=INK)
        label(gap, (1e6 * (instant - start), -0.1), name, ha=ha, va="top", fontsize=9)
    for a, b, name in ((part.start, first, "approach"), *spans, (last, part.end, "flight")):
        label(gap, (1e6 * (0.5 * (a + b) - start), 1.13), name, transform=gap.get_xaxis_transform())
    return figure, energy


def draw_step() -> Figure:
    """Draw a collocated step: the force at the nodes, the polynomial through them, and what it misses."""
    part, setup = shown_contact(), cl.build()
    start, lasts = (float(part.contacts[name][0]) for name in ("start_time", "duration"))
    gap = CubicSpline(part.time - start, part.series["gap"])
    stiffness = float(setup.configuration["law"]["stiffness"])

    def force(s: Array) -> Array:
        return np.asarray(stiffness * np.maximum(-gap(s), 0.0) ** 1.5)

    nodes, _, lagrange, _ = radau_rule(NODES)
    x, h = np.linspace(0.0, 1.0, 200), STEP_SHOWN

    def polynomial(begin: float, length: float, at: Array) -> Array:
        return np.asarray((at[:, None] ** np.arange(NODES)) @ (force(begin + length * nodes) @ lagrange))

    figure = Figure(figsize=(WIDTH, 3.6), layout="constrained")
    whole, step = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
    time = np.linspace(0.0, lasts, 400)
    whole.plot(1e6 * time, force(time), color=INK)
    for begin in np.arange(0.0, lasts, h):
        whole.axvline(1e6 * begin, color=FAINT, linewidth=THIN, linestyle="--", zorder=0)
        at = begin + h * nodes
        whole.plot(1e6 * at[at < lasts], force(at[at < lasts]), "o", color=FORCE, markersize=4)
    whole.axvspan(0.0, 1e6 * h, color=ACCENT, alpha=0.15, linewidth=0.0)
    whole.set_title("A contact in steps", fontweight="bold")
    step.plot(x, force(h * x), color=INK, linewidth=LINE)
    step.plot(x, polynomial(0.0, h, x), color=FORCE, linestyle="--", linewidth=LINE, gid="polynomial")
    step.plot(nodes, force(h * nodes), "o", color=FORCE, markersize=6, gid="nodes")
    step.set_title("The first step", fontweight="bold")
    for k, c in enumerate(nodes, 1):
        step.plot([c, c], [0.0, float(force(h * np.array([c]))[0])], color=FAINT, linewidth=THIN, zorder=0)
        label(step, (c, -0.45), f"$c_{k}$")
    label(
        step,
        (0.02, 3.6),
        "$N_m$ at five nodes, and the\npolynomial through them",
        FORCE,
        ha="left",
        fontsize=9,
    )
    inset = step.inset_axes((0.12, 0.66, 0.34, 0.24))
    near = x[x < 0.08]
    inset.plot(near, 1e3 * force(h * near), color=INK, linewidth=LINE)
    inset.plot(near, 1e3 * polynomial(0.0, h, near), color=FORCE, linestyle="--", linewidth=LINE)
    missed = 1e3 * float(polynomial(0.0, h, np.zeros(1))[0])
    arrow(inset, (0.0, 0.0), (0.0, missed), ACCENT)
    inset.set_title("missed at the start (mN)", color=ACCENT, fontsize=9)
    whole.set(xlabel="time since touch-down (µs)", ylabel="normal force $N$ (N)")
    step.set(xlabel="$x = s/h$", ylim=(-0.8, 7.4))
    for axes in (whole, step, inset):
        axes.axhline(0.0, color=FAINT, linewidth=THIN)
    return figure


def draw_cone() -> Figure:
    """Draw Coulomb's cone with the reactions of a compliant contact and the impulses of rigid impacts."""
    figure = Figure(figsize=(WIDTH, 3.7), layout="constrained")
    forces, impulses = figure.subplots(1, 2)
    part = shown_contact()
    normal, friction = part.series["normal_force"], part.series["friction_force"]
    # Forces are means: of intervals within one mode.
    modes = np.where(np.diff(part.series["contact_mode"], prepend=0) == 0, part.series["contact_mode"], 0)
    in_modes(forces, friction, normal, modes)
    forces.set_title("Forces of a compliant contact", fontweight="bold")
    forces.set(xlabel="friction $F$ (N)", ylabel="normal force $N$ (N)")
    normal, friction = (1e6 * impulses_of(impact_run(), name) for name in ("normal", "friction"))
    limit = friction_coefficient() * (1.0 - 1e-6)
    slips = np.abs(friction) >= limit * normal
    for those, name in ((slips, "slip"), (~slips, "stick")):
        impulses.plot(friction[those], normal[those], "o", color=COLOURS[name], markersize=6)
        for x, y in zip(friction[those], normal[those], strict=True):
            impulses.plot([0.0, x], [0.0, y], color=COLOURS[name], linewidth=THIN)
    impulses.set_title("Impulses of rigid impacts", fontweight="bold")
    impulses.set(xlabel="tangential impulse $p_t$ (µN s)", ylabel="normal impulse $p_n$ (µN s)")
    for axes, most in ((forces, part.series["normal_force"].max()), (impulses, normal.max())):
        reach = 1.15 * most
        edge = friction_coefficient() * reach
        axes.fill([0.0, -edge, edge], [0.0, reach, reach], color=FAINT, alpha=0.15, linewidth=0.0, zorder=0)
        for side in (-1.0, 1.0):
            axes.plot([0.0, side * edge], [0.0, reach], color=INK, linewidth=LINE, zorder=1)
        axes.axvline(0.0, color=FAINT, linewidth=THIN, zorder=0)
        axes.set(xlim=(-1.35 * edge, 1.35 * edge), ylim=(0.0, 1.02 * reach))
        label(axes, (0.0, 1.09 * most), "$|F| \\leq \\mu N$" if axes is forces else r"$|p_t| \leq \mu p_n$")
    forces.legend(loc="lower left")
    return figure


def draw_flight() -> Figure:
    """Draw the search for a touch-down: parabolas below the gap prove pieces of a flight open."""
    run = cl.simulate(cl.build(["contact.clearance=1 mm"]), duration=5e-4, record_interval=INTERVAL)
    time, gap = run["time"].values, run["gap"].values
    dips = np.flatnonzero((gap[1:-1] < gap[:-2]) & (gap[1:-1] < gap[2:])) + 1
    # The first dip stays open by little.
    gap = gap - gap[dips[0]] + 0.25e-6
    first, last = int(dips[0]) - 800, int(dips[1])
    time, gap = time[first : last + 1], gap[first : last + 1]
    rate = np.gradient(gap, time)
    bound = 1.05 * float(np.abs(np.gradient(rate, time)).max())
    figure = Figure(figsize=(WIDTH, 3.8), layout="constrained")
    axes = figure.subplots()
    origin = time[0]

    def search(a: int, b: int) -> bool:
        s = time[a : b + 1]
        left = gap[a] + rate[a] * (s - s[0]) - 0.5 * bound * (s - s[0]) ** 2
        right = gap[b] - rate[b] * (s[-1] - s) - 0.5 * bound * (s[-1] - s) ** 2
        below, s = np.maximum(left, right), 1e6 * (s - origin)
        if below.min() > 0.0:
            axes.plot(s, 1e6 * below, color=SPEED, gid="bound")
            axes.plot(s[[0, -1]], 1e6 * gap[[a, b]], "o", color=SPEED)
            return False
        if gap[b] < 0.0 and rate[a] + bound * (time[b] - time[a]) < 0.0:
            axes.axvspan(s[0], s[-1], color=FORCE, alpha=0.25, linewidth=0.0)
            return True
        return search(a, (a + b) // 2) or search((a + b) // 2, b)

    search(0, gap.size - 1)
    axes.plot(1e6 * (time - origin), 1e6 * gap, color=INK)
    axes.axhline(0.0, color=FAINT, linewidth=THIN)
    touch = int(np.flatnonzero(gap < 0.0)[0])
    axes.plot(1e6 * (time[touch] - origin), 0.0, "o", color=FORCE, markersize=6)
    label(axes, (1e6 * (time[touch] - origin) - 12.0, -0.45), "touch-down", FORCE, ha="right")
    label(axes, (222.0, 5.15), "gap")
    label(axes, (230.0, 3.7), "parabolas of\ncurvature $-B$", SPEED)
    label(axes, (75.0, -0.5), "open: no zero is missed", SPEED)
    label(axes, (354.0, 4.4), "one\nzero", FORCE)
    axes.set(xlabel="time (µs)", ylabel="gap $g$ (µm)")
    return figure


def draw_memory() -> Figure:
    """Draw two things that a contact remembers: the stretch of its friction, and the dent that it left."""
    figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
    loop, dent = figure.subplots(1, 2)
    turns = np.linspace(0.0, 1.0, 801)[:-1]
    way = 1.2e-6 * np.sin(2.0 * np.pi * turns)
    for friction, colour, style in ((cl.Coulomb(), FAINT, "--"), (cl.Dahl(), FORCE, "-")):
        law = cl.Composed(friction=friction)
        run = cl.drive(law, 1e-3 * turns, gap=-1e-6, slip=way, degree=7, period=1e-3, duration=2e-3)
        x, force = run["tip_tangential_displacement"].values, run["friction_force"].values
        # Forces are means over the record interval before; the second turn is the loop.
        second = slice(x.size // 2, None)
        loop.plot(0.5e6 * (x[1:] + x[:-1])[second], force[1:][second], color=colour, linestyle=style)
    label(loop, (0.0, 0.9), "remembers\nits stretch $z$", FORCE, fontsize=9)
    label(loop, (-0.62, 2.1), "no memory", FAINT, fontsize=9)
    loop.set(xlabel="displacement along the surface (µm)", ylabel="friction $F$ (N)", ylim=(-3.6, 3.6))
    loop.set_title("Friction, to and fro", fontweight="bold")
    corners = 1e-6 * np.array([0.0, 1.0, 0.2, 1.5, 0.0])
    run = cl.drive(cl.Composed(cl.WaltonBraun()), 1e-3 * np.arange(5.0), gap=-corners, degree=1)
    depth, force = -1e6 * run["gap"].values, run["normal_force"].values
    dent.plot(0.5 * (depth[1:] + depth[:-1]), force[1:], color=FORCE, gid="yielding")
    left = 1e-6 * float(depth[1:][force[1:] > 0.0][-1])
    arrow(dent, (0.0, -0.9), (1e6 * left, -0.9), ACCENT, "dent", "<|-|>")
    label(dent, (0.5e6 * left, -1.9), "dent left", ACCENT, fontsize=9)
    label(dent, (0.62, 9.4), "loads along $k_1$", FORCE, fontsize=9)
    label(dent, (1.42, 4.0), "unloads and\nreloads\nalong $k_2$", FORCE, fontsize=9)
    dent.set(xlabel="penetration $-g$ (µm)", ylabel="normal force $N$ (N)", ylim=(-3.0, 16.5))
    dent.set_title("A contact that yields", fontweight="bold")
    for axes in (loop, dent):
        axes.axhline(0.0, color=FAINT, linewidth=THIN, zorder=0)
    return figure


SKIPPED: Final = 20
"""Periods of the drive from one drawn point of the period map to the next."""


def draw_map() -> Figure:
    """Draw the period map: the rotor from rest, some periods by some periods, and Floquet's multipliers."""
    setup = cl.build()
    state = cl.steady(setup)
    assert state.orbit is not None
    period = 1.0 / float(setup.motor.drive.frequency[0])
    run = cl.simulate(setup, duration=12 * SKIPPED * period, record_interval=period)
    velocity = run["rotor_velocity"].values[::SKIPPED]
    figure = Figure(figsize=(WIDTH, 3.5), layout="constrained")
    cobweb, circle = figure.subplots(1, 2)
    ends = np.array([1.15 * velocity.min(), 0.0])
    cobweb.plot(ends, ends, color=FAINT, linewidth=THIN)
    for a, b in pairwise(velocity):
        cobweb.plot([a, a, b], [a, b, b], color=ACCENT, linewidth=THIN)
    cobweb.plot(velocity[:-1], velocity[1:], "o-", color=ACCENT, gid="map")
    fixed = float(state.velocity.value)
    cobweb.plot(fixed, fixed, "o", color=FORCE, markersize=7, gid="fixed point")
    label(cobweb, (fixed + 0.12, fixed - 0.1), "fixed point, found by shooting", FORCE, ha="left", fontsize=9)
    label(cobweb, (-0.2, -1.05), "from rest", ACCENT, fontsize=9)
    cobweb.set(xlabel=r"$\Omega(t)$ (rad/s)", ylabel=rf"$\Omega(t + {SKIPPED}\,T)$ (rad/s)", aspect="equal")
    cobweb.set_title("The rotor, period by period", fontweight="bold")
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    circle.plot(np.cos(angle), np.sin(angle), color=FAINT, linewidth=LINE)
    multipliers = state.orbit.multipliers
    circle.plot(multipliers.real, multipliers.imag, "o", color=ACCENT, gid="multipliers")
    largest = float(np.abs(multipliers).max())
    label(circle, (0.86, 0.14), f"rotor, {largest:.4f}", ACCENT, ha="right", fontsize=9)
    label(circle, (0.0, -0.8), "stable inside", FAINT, fontsize=9)
    circle.set(xlabel=r"$\mathrm{Re}\,\lambda$", ylabel=r"$\mathrm{Im}\,\lambda$", aspect="equal")
    circle.set_title("Floquet's multipliers", fontweight="bold")
    return figure


def draw_energy() -> Figure:
    """Draw the way of the energy through a motor that has settled, per period of the drive."""
    setup = cl.build(["law=composed", "law/damping=hunt_crossley", "rotor.load_torque=-0.5 mN m"])
    period, each = 1.0 / float(setup.motor.drive.frequency[0]), 20
    run = cl.simulate(setup, duration=1.0, until="steady", record_interval=period / each)
    names = ("drive_work", "damping_loss", "friction_loss", "contact_loss", "load_work")
    works = [1e6 * float(run[name][-1] - run[name][-1 - each]) for name in names]
    drive, damping, friction, contact, load = works
    figure, axes = sheet(2.9, (0.0, 72.0), (0.0, 29.0))
    boxes = ((22.0, "resonator", "$T + V$"), (41.0, "contact", "$V_c$"), (60.0, "rotor", "$T$"))
    for x, name, energy in boxes:
        box(axes, x, 19.0, 10.0, 7.0, f"{name}\n{energy}")
    ends = ((5.0, 17.0), (27.0, 36.0), (46.0, 55.0))
    for (a, b), value in zip(ends, (drive, friction + contact + load, load), strict=True):
        arrow(axes, (a, 19.0), (b, 19.0), ACCENT)
        label(axes, (0.5 * (a + b), 20.6), f"{value:.3g} µJ", ACCENT, fontsize=9)
    label(axes, (10.5, 16.8), "drive $W_d$")
    for x, value, text, ha, shift in (
        (22.0, damping, "damping $W_c$", "center", 0.0),
        (38.6, friction, "friction $W_f$", "right", 1.6),
        (43.4, contact, "normal loss $W_n$", "left", -1.6),
        (60.0, load, "load $W_l$", "center", 0.0),
    ):
        arrow(axes, (x, 15.5), (x, 9.4), FORCE)
        label(axes, (x + shift, 6.8), f"{text}\n{value:.3g} µJ", FORCE, ha=ha, fontsize=9, linespacing=1.3)
    title = f"Default motor, settled under a load of {1e3 * abs(setup.motor.rotor.load_torque):g} mN m"
    label(axes, (36.0, 27.0), f"{title}: work per period of the drive")
    label(axes, (36.0, 1.8), "$W_d = W_c + W_f + W_n + W_l$, each from a quadrature of its own", fontsize=9)
    return figure


def layers() -> set[str]:
    """Return the modules of the import contracts of both packages."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    contracts = tomllib.loads(text)["tool"]["importlinter"]["contracts"]
    rows = (row for contract in contracts for row in contract.get("layers", ()))
    return {name for row in rows for name in row.split(" | ")}


def draw_data() -> Figure:
    """Draw the way of the data from a configuration to a page, with the modules that it passes."""
    figure, axes = sheet(5.0, (0.0, 72.0), (0.0, 50.0))

    def modules(place: tuple[float, float], *names: str, **options: Any) -> None:
        if unknown := {*names} - layers():
            raise ValueError(f"The import contract has no layer {', '.join(sorted(unknown))}.")
        label(axes, place, "\n".join(names), ACCENT, gid="modules", family="DejaVu Sans Mono",
              linespacing=1.4, fontsize=9, **options)  # fmt: skip

    for x, y, width, text, colour in (
        (11.0, 43.0, 20.0, "configuration\nconf/, overrides", "none"),
        (11.0, 24.0, 20.0, "run.nc, run.png\nand back by load", "none"),
        (11.0, 5.0, 20.0, "STUDY.nc\nreport.html", "none"),
        (64.0, 5.0, 14.0, "measured\ndata", "none"),
        (39.0, 43.0, 18.0, "Setup\nMotor, ContactLaw", STEEL),
        (39.0, 24.0, 18.0, "Solution\nseries, contacts, state", STEEL),
        (39.0, 5.0, 18.0, "Result\nnumbers, findings", STEEL),
    ):
        box(axes, x, y, width, 8.0, text, facecolor=colour)
    kernels = r"$g,\ \dot g,\ v \to N,\ F$", r"$\dot g,\ v,\ D \to p_n,\ p_t$"
    box(axes, 62.0, 33.5, 18.0, 9.0, "\n".join(("law's kernels", *kernels)))
    for start, end in (
        ((21, 43), (30, 43)), ((39, 39), (39, 28)), ((30, 24), (21, 24)), ((39, 20), (39, 9)),
        ((30, 5), (21, 5)), ((57, 5), (48, 5)), ((39.6, 34.5), (53, 34.5)), ((53, 32.5), (39.6, 32.5)),
    ):  # fmt: skip
        arrow(axes, start, end)
    modules((25.5, 45.0), "config")
    modules((49.0, 43.0), "motor", "laws", ha="left")
    modules((38.0, 33.5), "engine", ha="right")
    modules((25.5, 26.8), "results", "plot")
    modules((38.0, 14.5), "studies", ha="right")
    modules((40.0, 14.5), "steady_state", "inference", "metrics", ha="left")
    modules((52.6, 7.0), "measured")
    modules((25.5, 7.0), "studies")
    return figure


DRAWINGS: Final[dict[str, Callable[[], Figure]]] = {
    "motor": draw_motor,
    "modes": draw_modes,
    "frame": draw_frame,
    "contact": draw_contact,
    "step": draw_step,
    "impact": draw_impact,
    "cone": draw_cone,
    "flight": draw_flight,
    "memory": draw_memory,
    "energy": draw_energy,
    "map": draw_map,
    "data": draw_data,
}
"""Drawings by the names of their files."""


def main(folder: Path = FOLDER) -> None:
    """Make every drawing."""
    folder.mkdir(parents=True, exist_ok=True)
    with plt.rc_context(HOUSE):
        for name, draw in DRAWINGS.items():
            with whole_file(folder / f"{name}.svg") as partial:
                draw().savefig(partial, format="svg", metadata={"Date": None, "Creator": None, "Title": name})


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
