"""The frames of an animation: tip, rotor and force in true geometry, and a trace with a cursor.

What stands still is drawn once, and every frame adds to it what moves; the frames are the same
whatever order they are asked for in. The arrow is the force on the rotor.
"""

from typing import Any, Final, cast

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from contactlab.plot.animation_data import Film
from contactlab.plot.animation_trace import COLOUR, MODES, draw_traces
from contactlab.plot.overview import COLOURS, STYLE
from contactlab.plot.overview_data import drawable
from contactlab.results.netcdf import reached_end
from contactlab.results.summary import prefixed, prefixed_unit

Array = NDArray[np.float64]

PIXELS: Final = (800, 640)
"""Width and height; multiples of 16, which every video codec takes."""

LONGEST: Final = 0.12
"""Length of the arrow at the peak force, in parts of the film's size."""

_DPI: Final = 100
_STYLE: Final[dict[Any, Any]] = STYLE | {
    "figure.dpi": _DPI,
    "savefig.dpi": _DPI,
    "font.size": 10,
    "axes.labelsize": 10,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "legend.fontsize": 10,
    "lines.linewidth": 1.2,
}

_SCENE: Final = (0.0, 0.40, 1.0, 0.50)
"""Left, bottom, width and height of the scene in parts of the picture."""

_HALF_WIDTH: Final = 0.40
_BOTTOM: Final = -0.165
"""Limits of the scene in parts of the film's size."""


class Animation:
    """Draws the frames of a film.

    Args:
        film: what they show.
        film_time: how long the animation lasts [s], to say how slow the motion is.
    """

    def __init__(self, film: Film, film_time: float) -> None:
        self.film = film
        with rc_context(_STYLE):
            self.figure = Figure(figsize=(PIXELS[0] / _DPI, PIXELS[1] / _DPI), dpi=_DPI)
            # matplotlib gives its functions no types.
            self._canvas = cast(Any, FigureCanvasAgg(self.figure))
            self._draw_words(film_time)
            scene = self._draw_scene()
            traces = draw_traces(self.figure, film)
            self._add_moving(scene, traces)
            self._canvas.draw()
            self._still = self._canvas.copy_from_bbox(self.figure.bbox)

    def __len__(self) -> int:
        return self.film.time.size

    @property
    def samples(self) -> list[int]:
        """Frames that have all colours: the first of every contact mode, and that of the peak force."""
        force = np.nan_to_num(np.hypot(self.film.normal, self.film.friction))
        _, first = np.unique(self.film.mode, return_index=True)
        return sorted({*first.tolist(), int(np.argmax(force))})

    def frame(self, number: int) -> NDArray[np.uint8]:
        """The pixels of a frame, red, green and blue, shape (height, width, 3)."""
        with rc_context(_STYLE):
            self._move(number)
            self._canvas.restore_region(self._still)
            for artist in self._moving:
                artist.axes.draw_artist(artist) if artist.axes else self.figure.draw_artist(artist)
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _draw_words(self, film_time: float) -> None:
        film = self.film
        lasts = film.end - film.start
        law = str(film.run.root.attrs.get("law", "")) or "run"
        title = f"{law}: 1 s shows {prefixed(lasts / film_time, 's')}"
        words = (
            f"{prefixed(lasts, 's')} from t = {prefixed(film.start, 's')}; motion of the tip and angle of "
            f"the rotor drawn \u00d7 {film.magnification:g}"
        )
        if not reached_end(film.run.root.attrs):
            title += " \u2013 the run is incomplete"
        self.figure.text(0.02, 0.975, title, va="top", fontsize=12)
        self.figure.text(0.02, 0.925, words, va="top", fontsize=9, color="0.3")

    def _draw_scene(self) -> Axes:
        """What of the scene stands still: the rotor without its marks, the tip's path, a scale."""
        film, size = self.film, self.film.size
        axes = self.figure.add_axes(_SCENE)
        axes.set_axis_off()
        height = 2.0 * _HALF_WIDTH * _SCENE[3] / _SCENE[2] * PIXELS[1] / PIXELS[0]
        axes.set_xlim(-_HALF_WIDTH * size, _HALF_WIDTH * size)
        axes.set_ylim(_BOTTOM * size, (_BOTTOM + height) * size)
        # The rim beyond the picture is left out; a quarter of the circle is never in it.
        widest = min(1.1 * _HALF_WIDTH * size / film.run.radius, 0.5 * np.pi)
        angles = np.linspace(-widest, widest, 201)
        rim = _on_circle(angles, film.run.radius)
        top = 2.0 * size
        axes.add_patch(
            Polygon(
                [*rim, (rim[-1, 0], top), (rim[0, 0], top)], facecolor="#E6E6E6", edgecolor="none"
            )
        )
        axes.plot(*rim.T, color="0.35", linewidth=1.2, scalex=False, scaley=False)
        root, time = film.run.root, film.run.time
        shown = (time >= film.start) & (time <= film.end)
        path = film.tip_end(
            drawable(root["tip_tangential_displacement"].values)[shown],
            drawable(root["gap"].values)[shown],
        )
        axes.plot(*path.T, color="0.6", linewidth=0.8, scalex=False, scaley=False, zorder=1.5)
        bar = 10.0 ** np.floor(np.log10(0.1 * size))
        left, low = -0.97 * _HALF_WIDTH * size, (_BOTTOM + 0.03) * size
        axes.plot(
            [left, left + bar], [low, low], color="black", linewidth=2.0, solid_capstyle="butt"
        )
        touches = film.normal.any() or film.friction.any()
        longest = (
            f"the frame before, longest {film.peak:.3g} N" if touches else "the frame before: none"
        )
        words = (
            f"arrow: force on the rotor, mean since\n{longest}\n"
            f"{prefixed(bar, 'm')} of the motor, {prefixed(bar / film.magnification, 'm')} of its motion"
        )
        axes.text(left, low + 0.008 * size, words, va="bottom", fontsize=9)
        axes.text(
            left, (_BOTTOM + height - 0.015) * size, "rotor", va="top", fontsize=10, color="0.3"
        )
        return axes

    def _add_moving(self, scene: Axes, traces: list[Axes]) -> None:
        """What moves, left out of the still part."""
        nothing = np.zeros((1, 2))
        self.marks = LineCollection([], colors="0.35", zorder=2, animated=True)
        self.tip = Polygon(nothing, edgecolor="0.2", linewidth=1.0, zorder=3, animated=True)
        self.components = [
            Polygon(nothing, facecolor="black", edgecolor="none", zorder=5, animated=True)
            for _ in range(2)
        ]
        self.arrow = Polygon(nothing, edgecolor="black", linewidth=0.6, zorder=4, animated=True)
        self.cursors = [
            axes.axvline(0.0, color=COLOURS["fault"], linewidth=1.5, animated=True)
            for axes in traces
        ]
        self.mode = self.figure.text(
            0.98, 0.975, "", va="top", ha="right", fontsize=12, animated=True
        )
        self.mode.set_fontweight("bold")
        self.numbers = scene.text(
            0.985, 0.03, "", va="bottom", ha="right", fontsize=9, transform=scene.transAxes,
            family="DejaVu Sans Mono", animated=True,
        )  # fmt: skip
        scene.add_collection(self.marks, autolim=False)
        for patch in (self.tip, *self.components, self.arrow):
            scene.add_patch(patch)
        self._moving: list[Artist] = [
            self.marks, self.tip, self.arrow, *self.components, *self.cursors, self.mode, self.numbers,
        ]  # fmt: skip

    def _move(self, number: int) -> None:
        """Bring everything that moves to its place in a frame."""
        film = self.film
        now = slice(number, number + 1)
        end = film.tip_end(film.tangential[now], film.gap[now])[0]
        colour = COLOUR[film.mode[number]]
        self.marks.set_segments(list(_marks(film, number)))
        self.marks.set_linewidth([2.6, *[1.0] * 4])
        self.tip.set_xy(end + _tip_outline(film, number))
        self.tip.set_facecolor(colour)
        force = LONGEST * film.size / film.peak * film.force_on_rotor(number)
        foot = end
        along = _along_normal(film, number)
        parts = (np.dot(force, along) * along, force - np.dot(force, along) * along)
        for arrow, part in zip(self.components, parts, strict=True):
            arrow.set_xy(foot + arrow_outline(part, 0.003 * film.size))
        self.arrow.set_xy(foot + arrow_outline(force, 0.011 * film.size))
        self.arrow.set_facecolor(colour)
        _, scale = prefixed_unit(film.end - film.start, "s")
        for cursor in self.cursors:
            cursor.set_xdata([(film.time[number] - film.start) / scale] * 2)
        self.mode.set_text(MODES[film.mode[number]])
        self.mode.set_color(colour)
        self.numbers.set_text(self._numbers(number))

    def _numbers(self, number: int) -> str:
        film = self.film
        unit, scale = prefixed_unit(film.end - film.start, "s")
        rows = (
            ("time", (film.time - film.start) / scale, unit),
            ("normal force", film.normal, "N"),
            ("friction on rotor", -film.friction, "N"),
            ("rotor velocity", film.velocity, "rad/s"),
        )
        return "\n".join(
            f"{name} {_steady(values, number):>9} {symbol:<5}" for name, values, symbol in rows
        )


def _steady(values: Array, number: int) -> str:
    """One of a sequence of values, with as many digits as four of the largest need in all of them."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if not 1e-4 < largest < 1e7:
        return f"{values[number] + 0.0:.3g}"
    digits = max(3 - int(np.floor(np.log10(largest))), 0)
    # Adding zero makes -0 a 0.
    return f"{round(float(values[number]), digits) + 0.0:.{digits}f}"


def arrow_outline(vector: Array, width: float) -> Array:
    """An arrow from the origin; its apex, the fourth of seven corners, lies at the vector itself.

    Args:
        vector: shape (2,).
        width: of the shaft; an arrow shorter than its head is a smaller head.

    Returns:
        Corners, shape (7, 2).
    """
    length = float(np.hypot(*vector))
    if not length > 0.0:
        return np.zeros((7, 2))
    along = vector / length
    across = np.array((-along[1], along[0]))
    head = min(4.0 * width, length)
    half, wide, neck = 0.5 * width * head / (4.0 * width), 0.4 * head, length - head
    corners = (
        (0, half),
        (neck, half),
        (neck, wide),
        (length, 0),
        (neck, -wide),
        (neck, -half),
        (0, -half),
    )
    return np.array([a * along + b * across for a, b in corners])


def _along_normal(film: Film, number: int) -> Array:
    """The normal at the tip, from the rotor's centre, in the picture."""
    angle = film.magnification * film.tangential[number] / film.run.radius
    return np.array((np.sin(angle), -np.cos(angle)))


def _on_circle(angles: Array, radius: float) -> Array:
    """Points of a circle that touches the origin from above, shape (point, 2)."""
    return np.column_stack((np.sin(angles), 2.0 * np.sin(0.5 * angles) ** 2)) * radius


def _marks(film: Film, number: int) -> Array:
    """Marks at the rim, every fifth a longer one, the longer ones first of five; shape (mark, 2, 2)."""
    radius, size = film.run.radius, film.size
    count = 5 * max(round(2.0 * np.pi * radius / (5.0 * 0.06 * size)), 1)
    turned = film.magnification * film.angle[number]
    if not np.isfinite(turned):
        return np.empty((0, 2, 2))
    pitch = 2.0 * np.pi / count
    widest = min(_HALF_WIDTH * size / radius, 0.5 * np.pi)
    # Mark 0 is at the bottom before the rotor turns; the first one drawn is a longer one.
    first = 5 * int(np.ceil((-widest - turned) / (5.0 * pitch)) - 1)
    numbers = np.arange(first, first + int(2.0 * widest / pitch) + 10)
    angles = numbers * pitch + turned
    length = np.where(numbers % 5 == 0, 0.03, 0.015) * size
    centre = np.array((0.0, radius))
    outer = _on_circle(angles, radius)
    inner = outer + (centre - outer) * (length / radius)[:, None]
    return np.stack((outer, inner), axis=1)


def _tip_outline(film: Film, number: int) -> Array:
    """The tip as seen from its end, which is a point: a wedge and a bar that leaves the picture."""
    slope = film.magnification * film.slope[number]
    along, across = (
        np.array((-np.sin(slope), np.cos(slope))),
        np.array((np.cos(slope), np.sin(slope))),
    )
    width, wedge, bottom = 0.022 * film.size, 0.05 * film.size, film.run.tip_length
    corners = ((0, 0), (-width, -wedge), (-width, -bottom), (width, -bottom), (width, -wedge))
    return np.array([a * across + b * along for a, b in corners])
