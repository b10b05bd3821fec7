"""`contactlab animate RUN.nc`: tip, rotor and contact force of a run in slow motion, as GIF or MP4."""

import sys
from argparse import Namespace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from tqdm import tqdm

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser, number_in
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError
from contactlab.metrics import read_run
from contactlab.results.files import told

if TYPE_CHECKING:
    from contactlab.plot.recording import Recording

FILM_TIME = 10.0
"""How long an animation lasts [s], whatever it shows."""

PERIODS = 2
"""Drive periods that are shown unless a duration is given."""

SLOWEST, FASTEST = 1.0, 50.0
"""Frames a second; viewers of GIF show none that last less than 1/50 s."""

FEWEST = 10
"""Frames of a drive period below which the picture no longer shows the motion."""


def main(arguments: list[str]) -> int:
    """Write the animation and give the exit status; nothing is left behind where it cannot be made."""
    parser = Parser(
        "animate",
        ". Tip and rotor have their true shape, "
        "their motion is magnified by a factor that the picture tells. "
        f"It lasts {FILM_TIME:g} s, whatever it shows.",
    )
    parser.add_argument("run", metavar="RUN.nc", help="a dataset, or a folder with run.nc")
    for option, metavar, default, text in (
        ("output", "FILE", None, "ends in .gif or .mp4; the default is RUN.gif beside RUN.nc"),
        ("start", "T", None, "time in the run, '4 ms'; the default ends with the run"),
        ("duration", "T", None, f"of the run; the default is {PERIODS} drive periods"),
        ("fps", "N", "25", "frames a second, 1 to 50; the default is %(default)s"),
    ):
        parser.add_argument(f"--{option}", metavar=metavar, default=default, help=text)
    wanted = parser.read(arguments)
    try:
        _animate(wanted)
    except KeyboardInterrupt:
        raise KeyboardInterrupt("Interrupted before the animation was written.") from None
    except OSError as error:
        raise RefusalError(f"The animation could not be written: {told(error)}", INCOMPLETE) from error
    return COMPLETE


def _animate(wanted: Namespace) -> None:
    source = Path(wanted.run)
    if source.is_dir():
        source = source / "run.nc"
    if not source.is_file():
        raise RefusalError(
            f"There is no file '{source}'; it must be a run.nc that contactlab wrote, or a folder with one. "
            "`contactlab` without a verb makes a run."
        )
    output = source.with_suffix(".gif") if wanted.output is None else Path(wanted.output)
    if fault := _fault_of(output, source):
        raise RefusalError(f"--output is '{output}', {fault}.")
    fps = number_in("1", wanted.fps, "--fps")
    if not SLOWEST <= fps <= FASTEST:
        raise RefusalError(
            f"--fps is {wanted.fps}, it must be between {SLOWEST:g} and {FASTEST:g} frames a second; "
            "25 is usual."
        )
    # Imported here: they bring the plotting, which --help does not need.
    from contactlab.plot.animation import Animation
    from contactlab.plot.animation_files import NoEncoderError, encoder, write_gif, write_mp4
    from contactlab.plot.film import film_of
    from contactlab.plot.recording import UnfitRunError, recording_of

    frames = round(FILM_TIME * fps)
    is_film = output.suffix.lower() == ".mp4"
    try:
        if is_film:
            encoder()
        run = recording_of(read_run(source))
        start, end = _window(run, wanted.start, wanted.duration)
        film = film_of(run, start, end, frames)
    except UnfitRunError as error:
        raise RefusalError(
            f"'{source}' {error}; it must be a run.nc that contactlab wrote. Choose another one, or another "
            "part of it with --start and --duration."
        ) from error
    except (NoEncoderError, ValueError) as error:
        raise RefusalError(str(error)) from error
    _advise(run, end - start, frames)
    with terminal.raising():
        bar = partial(tqdm, unit="frame", leave=False, disable=None)
        (write_mp4 if is_film else write_gif)(Animation(film, FILM_TIME), fps, output, bar)
    print(
        f"Written to {output}: {frames} frames, {(end - start) * 1e6:.5g} us of the run in {FILM_TIME:g} s, "
        f"motion magnified by {film.magnification:g}."
    )


def _fault_of(output: Path, source: Path) -> str:
    """Say why the animation cannot go there, if so."""
    if output.suffix.lower() not in (".gif", ".mp4"):
        return "it must end in .gif or .mp4; choose such a name"
    if output.is_dir():
        return "which is a folder; choose the name of a file"
    if output.absolute() == source.absolute():
        return "the run itself; choose another name"
    if not output.parent.is_dir():
        return f"but there is no folder '{output.parent}'; create it first"
    return ""


def _window(run: "Recording", start_text: str | None, duration_text: str | None) -> tuple[float, float]:
    """Start and end of what is shown [s]."""
    first, last = float(run.time[0]), float(run.time[-1])
    shortest = float(run.time[1] - run.time[0])
    start = None if start_text is None else number_in("s", start_text, "--start")
    if start is not None and not first <= start <= last - shortest * (1.0 - 1e-9):
        raise RefusalError(
            f"--start is {start_text}, but the run lasts from {first:g} to {last:g} s; it must be at least "
            f"{first:g} s and at most {last - shortest:g} s, a record before the end. Choose a time within, "
            "or leave --start out."
        )
    longest = last - (first if start is None else start)
    duration = min(PERIODS * run.period, longest)
    if duration_text is not None:
        duration = number_in("s", duration_text, "--duration")
        if not shortest * (1.0 - 1e-9) <= duration <= longest * (1.0 + 1e-9):
            raise RefusalError(
                f"--duration is {duration_text}, it must be at least {shortest:g} s, a record interval, "
                f"and at most {longest:g} s, what the run lasts{'' if start is None else ' after --start'}. "
                f"Two drive periods are {2.0 * run.period:.4g} s."
            )
    begin = max(last - duration, first) if start is None else start
    return begin, min(begin + duration, last)


def _advise(run: "Recording", duration: float, frames: int) -> None:
    """Say so if the picture will not show the vibration."""
    if run.coarse:
        print(
            f"The records are {run.time[1] - run.time[0]:.3g} s apart, the drive period is {run.period:.3g} "
            "s: the motion between them is not shown. Run it again with a smaller record.interval.",
            file=sys.stderr,
        )
    per_period = frames * run.period / duration
    if per_period < FEWEST:
        print(
            f"Only {per_period:.2g} frames show a drive period, so the vibration is not seen as it is: "
            f"choose a --duration below {frames * run.period / FEWEST:.2g} s, or more --fps.",
            file=sys.stderr,
        )
