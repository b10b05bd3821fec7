"""Show tip, rotor and contact force of a run in slow motion, as GIF or MP4.

Tip and rotor have their true shape, their motion is magnified by a factor that the picture states. It lasts
10 s, whatever it shows.
"""

import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final

from tqdm import tqdm

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError
from contactlab.metrics import read_run
from contactlab.quantity import UnitError, to_si
from contactlab.results.files import error_text

if TYPE_CHECKING:
    from contactlab.plot.recording import Recording

FILM_TIME = 10.0
"""Duration of an animation, whatever it shows [s]."""

PERIODS: Final = 2
"""Drive periods that are shown by default."""

SLOWEST, FASTEST = 1.0, 50.0
"""Frame rates [1/s]; viewers of GIF show no frame that lasts less than 1/50 s."""

USUAL: Final = "25"
"""Frame rate by default [1/s]."""

FEWEST: Final = 10
"""Frames of a drive period below which the picture no longer shows the motion."""


def main(arguments: list[str]) -> int:
    """Write the animation and return the exit status; nothing is left behind where it cannot be made."""
    parser = Parser(__name__, __doc__, "RUN.nc", "a dataset, or a folder with run.nc")
    parser.option("output", "FILE", "ends in .gif or .mp4; RUN.gif beside RUN.nc")
    parser.option("start", "T", "time in the run, '4 ms'; by default the film ends with the run")
    parser.option("duration", "T", f"of the run; {PERIODS} drive periods")
    parser.option("fps", "N", f"frames a second, {SLOWEST:g} to {FASTEST:g}; {USUAL}")
    (run,), options = parser.read(arguments)
    try:
        _animate(Path(run), options)
    except OSError as error:
        raise RefusalError(f"The animation could not be written: {error_text(error)}", INCOMPLETE) from error
    return COMPLETE


def _animate(path: Path, options: Mapping[str, str]) -> None:
    source = path / "run.nc" if path.is_dir() else path
    if not source.is_file():
        raise RefusalError(f"There is no file '{source}'; it must be a run.nc, or a folder with one.")
    output = Path(options.get("output") or source.with_suffix(".gif"))
    is_film = output.suffix.lower() == ".mp4"
    fits = is_film or output.suffix.lower() == ".gif"
    if not fits or output.is_dir() or not output.parent.is_dir() or output.absolute() == source.absolute():
        raise RefusalError(
            f"output is '{output}'; it must be a file that ends in .gif or .mp4, in a folder that exists."
        )
    fps = _number(options.get("fps", USUAL), "1", "fps", SLOWEST, FASTEST)
    # Imported here: they bring the plotting, which --help does not need.
    from contactlab.plot.animation import Animation, NoEncoderError, encoder, write_gif, write_mp4
    from contactlab.plot.recording import UnfitRunError, film_of, recording_of

    frames = round(FILM_TIME * fps)
    try:
        if is_film:
            encoder()
        run = recording_of(read_run(source))
        start, end = _window(run, options.get("start"), options.get("duration"))
        film = film_of(run, start, end, frames)
    except UnfitRunError as error:
        raise RefusalError(f"'{source}' {error}; see start and duration for another part.") from error
    except (NoEncoderError, ValueError) as error:
        raise RefusalError(str(error)) from error
    _warn(run, end - start, frames)
    with terminal.raising():
        bar = partial(tqdm, unit="frame", leave=False, disable=None)
        (write_mp4 if is_film else write_gif)(Animation(film, FILM_TIME), fps, output, bar)
    print(
        f"Written to {output}: {frames} frames, {(end - start) * 1e6:.5g} us of the run in {FILM_TIME:g} s, "
        f"motion magnified by {film.magnification:g}."
    )


def _number(text: str, unit: str, name: str, least: float, most: float) -> float:
    """Return a number in an SI unit, within its bounds but for round-off."""
    try:
        number = to_si(text.strip(), unit)
    except UnitError as error:
        raise RefusalError(f"{name} is '{text}', {error}; it must be a number in {unit}.") from error
    if not least * (1.0 - 1e-9) <= number <= most * (1.0 + 1e-9):
        end = f"at most {most:g} {unit}".removesuffix(" 1")
        raise RefusalError(f"{name} is {text}; it must be at least {least:g} and {end}.")
    return number


def _window(run: "Recording", start_text: str | None, duration_text: str | None) -> tuple[float, float]:
    """Return start and end of what is shown [s]."""
    first, last = float(run.time[0]), float(run.time[-1])
    shortest = float(run.time[1] - run.time[0])
    start = None if start_text is None else _number(start_text, "s", "start", first, last - shortest)
    longest = last - (first if start is None else start)
    duration = min(PERIODS * run.period, longest)
    if duration_text is not None:
        duration = _number(duration_text, "s", "duration", shortest, longest)
    begin = max(last - duration, first) if start is None else start
    return begin, min(begin + duration, last)


def _warn(run: "Recording", duration: float, frames: int) -> None:
    """Print why the picture will not show the vibration, if so."""
    if run.coarse:
        print(
            f"The records are {run.time[1] - run.time[0]:.3g} s apart, the drive period is {run.period:.3g} "
            "s: the motion between them is not shown. Run it again with a smaller record.interval.",
            file=sys.stderr,
        )
    per_period = frames * run.period / duration
    if per_period < FEWEST:
        print(
            f"Only {per_period:.2g} frames show a drive period; choose a duration below "
            f"{frames * run.period / FEWEST:.2g} s, or more fps.",
            file=sys.stderr,
        )
