"""Animation of tip, rotor and force in true geometry, with traces and a cursor, as GIF or MP4."""

import errno
import subprocess
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrow, Polygon
from numpy.typing import NDArray
from PIL import Image

from contactlab.arrays import Array
from contactlab.plot.overview import DENSE, draw_normal, explain_shades, keep_ticks_short, shade
from contactlab.plot.recording import Film, drawable, envelope
from contactlab.plot.style import COLOURS
from contactlab.results.files import whole_file
from contactlab.results.netcdf import reached_end
from contactlab.results.summary import prefixed
from contactlab.variables import CONTACT_MODE

PIXELS: Final = (800, 640)
"""Width and height; multiples of 16, which every video codec takes."""

LONGEST: Final = 0.12
"""Largest length of the arrow at the peak force, in parts of the film's size."""

MARGIN: Final = 0.01
"""Distance that arrows keep from the edge of the scene, in parts of the film's size."""

COLOUR: Final = ("#707070", COLOURS["slip"], COLOURS["stick"])
"""Of the contact modes free, slip and stick."""

_DPI: Final = 100
_INCHES: Final = (PIXELS[0] / _DPI, PIXELS[1] / _DPI)
_STYLE: Final = DENSE | {
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
_HEIGHT: Final = 2.0 * _HALF_WIDTH * _SCENE[3] / _SCENE[2] * PIXELS[1] / PIXELS[0]
"""Limits of the scene in parts of the film's size."""


class Animation:
    """Draws the frames of a film that lasts some time [s]."""

    def __init__(self, film: Film, film_time: float) -> None:
        self.film, self.longest = film, longest_arrow(film)
        with rc_context(_STYLE):
            self.figure = Figure(figsize=_INCHES, dpi=_DPI)
            # matplotlib gives its functions no types.
            self._canvas = cast(Any, FigureCanvasAgg(self.figure))
            self._draw_texts(film_time)
            scene = self._draw_scene()
            self._add_moving(scene, self._draw_traces())
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
        """Return the pixels of a frame: red, green, blue and opacity, shape (height, width, 4)."""
        with rc_context(_STYLE):
            self._move(number)
            self._canvas.restore_region(self._still)
            for artist in self._moving:
                artist.axes.draw_artist(artist) if artist.axes else self.figure.draw_artist(artist)
        return np.array(self._canvas.buffer_rgba())

    def _draw_texts(self, film_time: float) -> None:
        run = self.film.run
        lasts = run.end - run.start
        title = f"{run.law}: 1 s shows {prefixed(lasts / film_time, 's')}"
        if not reached_end(run.attributes):
            title += " \u2013 the run is incomplete"
        text = (
            f"{prefixed(lasts, 's')} from t = {prefixed(run.start, 's')}; motion of the tip and angle of "
            f"the rotor drawn \u00d7 {self.film.magnification:g}"
        )
        self.figure.text(0.02, 0.975, title, va="top", fontsize=12)
        self.figure.text(0.02, 0.925, text, va="top", fontsize=9, color="0.3")

    def _draw_scene(self) -> Axes:
        """Draw what of the scene stands still: the rotor without its marks, the tip's path, a scale."""
        film, size = self.film, self.film.size
        axes = self.figure.add_axes(_SCENE)
        axes.set_axis_off()
        axes.set_xlim(-_HALF_WIDTH * size, _HALF_WIDTH * size)
        axes.set_ylim(_BOTTOM * size, (_BOTTOM + _HEIGHT) * size)
        # The rim beyond the picture is left out; a quarter of the circle is never in it.
        widest = min(1.1 * _HALF_WIDTH * size / film.run.radius, 0.5 * np.pi)
        rim = _on_circle(np.linspace(-widest, widest, 201), film.run.radius)
        corners = [*rim, (rim[-1, 0], 2.0 * size), (rim[0, 0], 2.0 * size)]
        axes.add_patch(Polygon(corners, facecolor="#E6E6E6", edgecolor="none"))
        axes.plot(*rim.T, color="0.35", linewidth=1.2, scalex=False, scaley=False)
        motion = (film.run.series[name] for name in ("tip_tangential_displacement", "gap"))
        path = film.tip_end(*map(drawable, motion))
        axes.plot(*path.T, color="0.6", linewidth=0.8, scalex=False, scaley=False, zorder=1.5)
        bar = 10.0 ** np.floor(np.log10(0.1 * size))
        left, low = -0.97 * _HALF_WIDTH * size, (_BOTTOM + 0.03) * size
        axes.plot([left, left + bar], [low, low], color="black", linewidth=2.0, solid_capstyle="butt")
        touches = film.normal.any() or film.friction.any()
        longest = f", longest {film.peak:.3g} N" if touches else ": none"
        impacts = "" if film.run.impacts is None else ", impacts among it"
        text = (
            f"arrow: force on the rotor, mean since\nthe frame before{impacts}{longest}\n"
            f"{prefixed(bar, 'm')} of the motor, {prefixed(bar / film.magnification, 'm')} of its motion"
        )
        axes.text(left, low + 0.008 * size, text, va="bottom", fontsize=9)
        top = (_BOTTOM + _HEIGHT - 0.015) * size
        axes.text(left, top, "rotor", va="top", fontsize=10, color="0.3")
        return axes

    def _draw_traces(self) -> list[Axes]:
        """Draw normal force and rotor velocity below the scene, with the contact modes shaded."""
        run, (unit, scale) = self.film.run, self.film.run.unit
        rows = self.figure.add_gridspec(
            2, 1, left=0.125, right=0.975 if run.impacts is None else 0.9, top=0.345, bottom=0.085, hspace=0.2
        )
        force = self.figure.add_subplot(rows[0])
        velocity = self.figure.add_subplot(rows[1], sharex=force)
        edges = (run.time - run.start) / scale
        impulses = draw_normal(force, run, run.start)
        values = drawable(run.series["rotor_velocity"])
        velocity.plot(*envelope(edges, values), color="black")
        keep_ticks_short(velocity, values)
        shade(velocity, run, run.start)
        for axes in (force, velocity, *([] if impulses is None else [impulses])):
            axes.locator_params(axis="y", nbins=4)
        force.set_ylabel("normal\nforce (N)" if impulses is None else "lasting\nforce (N)")
        if impulses is not None:
            impulses.set_ylabel(impulses.get_ylabel().replace(" (", "\n("))
        velocity.set_ylabel("velocity of the\nrotor (rad/s)", fontsize=9)
        velocity.set_xlabel(f"time since {prefixed(run.start, 's')} ({unit})")
        force.tick_params(labelbottom=False)
        self.figure.align_ylabels([force, velocity])
        explain_shades(force, 1.04)
        return [force, velocity]

    def _add_moving(self, scene: Axes, traces: list[Axes]) -> None:
        """Add what moves, left out of the still part."""
        moving: dict[str, Any] = {"animated": True}
        self.marks = LineCollection([], colors="0.35", zorder=2, **moving)
        self.tip = Polygon(np.zeros((1, 2)), edgecolor="0.2", linewidth=1.0, zorder=3, **moving)
        moving_arrow = moving | {"length_includes_head": True}
        self.arrow = FancyArrow(0, 0, 0, 0, edgecolor="black", linewidth=0.6, zorder=4, **moving_arrow)
        self.components = [
            FancyArrow(0, 0, 0, 0, facecolor="black", edgecolor="none", zorder=5, **moving_arrow)
            for _ in range(2)
        ]
        self.cursors = [axes.axvline(0.0, color=COLOURS["fault"], linewidth=1.5, **moving) for axes in traces]
        self.mode = self.figure.text(
            0.98, 0.975, "", va="top", ha="right", fontsize=12, fontweight="bold", **moving
        )
        self.numbers = scene.text(
            0.985, 0.03, "", va="bottom", ha="right", fontsize=9, transform=scene.transAxes,
            family="DejaVu Sans Mono", **moving,
        )  # fmt: skip
        scene.add_collection(self.marks, autolim=False)
        for patch in (self.tip, *self.components, self.arrow):
            scene.add_patch(patch)
        self._moving: list[Artist] = [
            self.marks, self.tip, self.arrow, *self.components, *self.cursors, self.mode, self.numbers,
        ]  # fmt: skip

    def _move(self, number: int) -> None:
        """Bring everything that moves to its place in a frame."""
        film, size = self.film, self.film.size
        now = slice(number, number + 1)
        end = film.tip_end(film.tangential[now], film.gap[now])[0]
        colour = COLOUR[film.mode[number]]
        self.marks.set_segments(list(_marks(film, number)))
        self.marks.set_linewidth([2.6, *[1.0] * 4])
        self.tip.set_xy(end + _tip_outline(film, number))
        self.tip.set_facecolor(colour)
        scale = self.longest * size / film.peak
        force = scale * film.force_on_rotor(number)
        _point(self.arrow, end, force, 0.011 * size)
        self.arrow.set_facecolor(colour)
        for arrow, along in zip(self.components, film.axes_of_contact(number), strict=True):
            _point(arrow, end, np.dot(force, along) * along, 0.003 * size)
        unit, second = film.run.unit
        times = (film.time - film.run.start) / second
        for cursor in self.cursors:
            cursor.set_xdata([times[number]] * 2)
        self.mode.set_text(CONTACT_MODE.flags[film.mode[number]])
        self.mode.set_color(colour)
        rows = (
            ("time", times, unit),
            ("normal force", film.normal, "N"),
            ("friction on rotor", -film.friction, "N"),
            ("rotor velocity", film.velocity, "rad/s"),
        )
        lines = [f"{name} {_steady(values, number):>9} {units:<5}" for name, values, units in rows]
        self.numbers.set_text("\n".join(lines))


def longest_arrow(film: Film) -> float:
    """Return the length of the arrow at the peak force that keeps all arrows in the scene, at most `LONGEST`.

    It is in parts of the film's size. The tip of a pressed motor stands deep in the rotor.
    """
    feet = film.tip_end(film.tangential, film.gap) / film.size
    forces = np.stack([film.force_on_rotor(frame) for frame in range(film.time.size)]) / film.peak
    edges = np.array([[-_HALF_WIDTH, _BOTTOM], [_HALF_WIDTH, _BOTTOM + _HEIGHT]])
    room = np.where(forces < 0.0, edges[0] + MARGIN - feet, edges[1] - MARGIN - feet)
    acts = np.abs(forces) > 0.0
    return max(0.0, float(np.nanmin(room[acts] / forces[acts], initial=LONGEST)))


def _steady(values: Array, number: int) -> str:
    """Write one of a sequence of values, with as many digits as four of the largest need in all of them."""
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if not 1e-4 < largest < 1e7:
        return f"{values[number] + 0.0:.3g}"
    digits = max(3 - int(np.floor(np.log10(largest))), 0)
    # Adding zero makes -0 a 0.
    return f"{round(float(values[number]), digits) + 0.0:.{digits}f}"


def _point(arrow: FancyArrow, foot: Array, vector: Array, width: float) -> None:
    """Draw an arrow of a width from its foot; one that is shorter than its head is a smaller head."""
    head = min(4.0 * width, float(np.hypot(*vector)))
    x, y, dx, dy = map(float, (*foot, *vector))
    arrow.set_data(x=x, y=y, dx=dx, dy=dy, width=0.25 * head, head_width=0.8 * head, head_length=head)


def _on_circle(angles: Array, radius: float) -> Array:
    """Return points of a circle that touches the origin from above, shape (point, 2)."""
    return np.column_stack((np.sin(angles), 2.0 * np.sin(0.5 * angles) ** 2)) * radius


def _marks(film: Film, number: int) -> Array:
    """Return the marks at the rim, the first of every five a longer one; shape (mark, 2, 2)."""
    radius, size = film.run.radius, film.size
    turned = film.magnification * film.angle[number]
    if not np.isfinite(turned):
        return np.empty((0, 2, 2))
    pitch = _pitch(film)
    widest = min(_HALF_WIDTH * size / radius, 0.5 * np.pi)
    # Mark 0 is at the bottom before the rotor turns; the first one drawn is a longer one.
    first = 5 * int(np.ceil((-widest - turned) / (5.0 * pitch)) - 1)
    numbers = np.arange(first, first + int(2.0 * widest / pitch) + 10)
    outer = _on_circle(numbers * pitch + turned, radius)
    length = np.where(numbers % 5 == 0, 0.03, 0.015) * size
    inner = outer + (np.array((0.0, radius)) - outer) * (length / radius)[:, None]
    return np.stack((outer, inner), axis=1)


def _pitch(film: Film) -> float:
    """Return the angle between two marks, some 0.06 of the film's size.

    A rotor that turns by five of them or more turns by fives alone, so that the film of a settled motor that
    repeats itself begins where it ends. That they need not close on the rotor's circle is never seen.
    """
    usual = 0.06 * film.size / film.run.radius
    angle = drawable(film.run.series["rotor_angle"])
    ends = np.interp((film.run.start, film.run.end), film.run.time, angle)
    turned = film.magnification * abs(float(ends[1] - ends[0]))
    fives = round(turned / (5.0 * usual)) if np.isfinite(turned) else 0
    return turned / (5.0 * fives) if fives else usual


def _tip_outline(film: Film, number: int) -> Array:
    """Return the tip as seen from its end, which is a point: a wedge and a bar that leaves the picture."""
    slope = film.magnification * film.slope[number] + film.run.angle
    width, wedge, bottom = 0.022 * film.size, 0.05 * film.size, film.run.tip_length
    corners = ((0, 0), (-width, -wedge), (-width, -bottom), (width, -bottom), (width, -wedge))
    across, along = (np.cos(slope), np.sin(slope)), (-np.sin(slope), np.cos(slope))
    return np.asarray(np.array(corners) @ np.array((across, along)))


Watch = Callable[[Iterable[int]], Iterable[int]]
"""Passes the numbers of the frames on, as a progress bar does."""


def write_gif(animation: Animation, fps: float, path: Path, watch: Watch = iter) -> None:
    """Write a GIF that repeats for ever, of at most 50 frames a second; the same frames give the same bytes.

    All frames have one palette, the commonest colours in 64 shades a channel: what stands still does not
    flicker.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    samples = np.concatenate([_shades(animation.frame(n)) for n in animation.samples])
    counted = sorted(Image.fromarray(samples).getcolors(samples.size) or (), reverse=True)
    colours = np.array([colour for _, colour in counted[:255]], dtype=np.uint8)
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours.tobytes())

    def image(number: int) -> Image.Image:
        pixels = Image.fromarray(_shades(animation.frame(number)))
        result = pixels.quantize(palette=palette, dither=Image.Dither.NONE)
        # White is white again.
        result.putpalette((colours | 3).tobytes())
        return result

    # The format counts hundredths of a second; rounding the sum keeps the pace on average.
    ends = np.round(100.0 * np.arange(len(animation) + 1) / fps).astype(int)
    images = map(image, watch(range(len(animation))))
    with whole_file(path) as partial, partial.open("wb") as stream:
        next(images).save(
            stream,
            format="GIF",
            save_all=True,
            append_images=images,
            duration=(10 * np.diff(ends)).tolist(),
            loop=0,
        )


def _shades(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return red, green and blue without the two lowest bits, which Pillow's choice of colours ignores."""
    return pixels[:, :, :3] & np.uint8(0xFC)


class NoEncoderError(RuntimeError):
    """There is no video encoder; the message is a sentence."""


def encoder() -> str:
    """Return the video encoder of the package imageio-ffmpeg.

    Raises:
        NoEncoderError: it is not installed.
    """
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError) as error:
        raise NoEncoderError(
            "An MP4 needs the package imageio-ffmpeg, which is not installed or has no encoder for this "
            "system. Install it with: pip install 'contactlab[video]' (in a clone: pip install -e "
            "'.[video]'), or choose a name that ends in .gif."
        ) from error


def write_mp4(animation: Animation, fps: float, path: Path, watch: Watch = iter) -> None:
    """Write an MP4 (H.264), which every browser plays; arguments as of `write_gif`.

    Raises:
        NoEncoderError: there is no encoder.
        OSError: the folder is missing, not writable or full.
    """
    sheet = Figure(figsize=_INCHES, dpi=_DPI)
    image = sheet.figimage(animation.frame(0))
    options = "-pix_fmt yuv420p -crf 18 -fflags +bitexact -flags:v +bitexact -movflags +faststart -f mp4"
    writer: Any = FFMpegWriter(cast(Any, fps), "libx264", extra_args=options.split())
    try:
        with (
            whole_file(path) as partial,
            rc_context({"animation.ffmpeg_path": encoder()}),
            writer.saving(sheet, str(partial.absolute()), _DPI),
        ):
            for number in watch(range(len(animation))):
                image.set_data(animation.frame(number))
                writer.grab_frame()
    except subprocess.CalledProcessError as error:
        # Ctrl-C ends the encoder too, which is no fault of its own.
        if isinstance(error.__context__, KeyboardInterrupt):
            raise error.__context__ from None
        text = str(error.stderr).strip() or "no message"
        raise OSError(errno.EIO, f"video encoder: {text.splitlines()[-1]}") from error
