"""`contactlab animate RUN.nc`: tip, rotor and contact force of a run in slow motion, as GIF or MP4."""

import re
import sys
from argparse import Namespace
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.cli import interrupts
from contactlab.cli.arguments import Parser
from contactlab.cli.verbs import VERBS
from contactlab.config.quantity import UnitError, to_si
from contactlab.results.files import damage

if TYPE_CHECKING:
    import xarray

    from contactlab.plot.animation_data import Recording

WRITTEN, REFUSED = 0, 2
"""Exit statuses."""

FILM_TIME = 10.0
"""How long an animation lasts [s], whatever it shows."""

PERIODS = 2
"""Drive periods that are shown unless a duration is given."""

SLOWEST, FASTEST = 1.0, 50.0
"""Frames a second; viewers of GIF show none that last less than 1/50 s."""

FEWEST = 10
"""Frames of a drive period below which the picture no longer shows the motion."""

SUFFIXES = (".gif", ".mp4")


class RefusalError(ValueError):
    """What was asked for cannot be done; the message is a sentence."""


def main(arguments: list[str]) -> int:
    """Write the animation.

    Returns:
        The exit status: 2 if it cannot be made, and nothing is left behind then.
    """
    wanted = _parser().read(list(_joined(arguments)))
    try:
        _animate(wanted)
    except KeyboardInterrupt:
        print("Interrupted before the animation was written.", file=sys.stderr)
        return interrupts.STATUS
    except RefusalError as refusal:
        print(refusal, file=sys.stderr)
        return REFUSED
    except OSError as error:
        print(f"The animation could not be written: {error}", file=sys.stderr)
        return REFUSED
    return WRITTEN


def _joined(arguments: list[str]) -> Iterator[str]:
    """Arguments with negative values joined to their options: argparse takes -1e-3 for an option."""
    waiting = ""
    for argument in arguments:
        if waiting and re.match(r"-[\d.]", argument):
            argument, waiting = f"{waiting}={argument}", ""
        if waiting:
            yield waiting
        waiting = argument if argument.startswith("--") and "=" not in argument else ""
        if not waiting:
            yield argument
    if waiting:
        yield waiting


def _parser() -> Parser:
    parser = Parser(
        "animate",
        f"{VERBS['animate'].replace('show', 'Show', 1)}. Tip and rotor have their true shape, "
        "their motion is magnified by a factor that the picture tells. "
        f"It lasts {FILM_TIME:g} s, whatever it shows.",
    )
    parser.add_argument("run", metavar="RUN.nc", help="a dataset, or a folder with run.nc")
    parser.add_argument(
        "--output",
        metavar="FILE",
        help="ends in .gif or .mp4; the default is RUN.gif beside RUN.nc",
    )
    parser.add_argument(
        "--start", metavar="T", help="time in the run, '4 ms'; the default ends with the run"
    )
    parser.add_argument(
        "--duration", metavar="T", help=f"of the run; the default is {PERIODS} drive periods"
    )
    parser.add_argument(
        "--fps",
        metavar="N",
        default="25",
        help="frames a second, 1 to 50; the default is %(default)s",
    )
    return parser


def _animate(wanted: Namespace) -> None:
    source = Path(wanted.run)
    if source.is_dir():
        source = source / "run.nc"
    if not source.is_file():
        raise RefusalError(
            f"There is no file '{source}'; it must be a run.nc that contactlab wrote, or a folder with one. "
            "`contactlab` without a verb makes a run."
        )
    output = _output(wanted.output, source)
    fps = _number("--fps", wanted.fps, "1")
    if not SLOWEST <= fps <= FASTEST:
        raise RefusalError(
            f"--fps is {wanted.fps}, it must be between {SLOWEST:g} and {FASTEST:g} frames a second; "
            "25 is usual."
        )
    # Imported here: they bring the plotting, which --help does not need.
    from contactlab.plot.animation_data import UnfitRunError, film_of, run_of
    from contactlab.plot.animation_files import NoEncoderError, encoder, write_gif, write_mp4

    frames = round(FILM_TIME * fps)
    try:
        if output.suffix.lower() == ".mp4":
            encoder()
        run = run_of(_dataset(source))
        start, end = _window(run, wanted.start, wanted.duration)
        film = film_of(run, start, end, frames)
    except UnfitRunError as fault:
        raise RefusalError(
            f"'{source}' {fault}; it must be a run.nc that contactlab wrote. Choose another one, or another "
            "part of it with --start and --duration."
        ) from fault
    except NoEncoderError as fault:
        raise RefusalError(str(fault)) from fault
    _advise(run, end - start, frames)
    from contactlab.plot.animation import Animation

    write = write_mp4 if output.suffix.lower() == ".mp4" else write_gif
    animation = Animation(film, FILM_TIME)
    with interrupts.raising():
        write(animation, fps, output, _progress_bar)
    print(
        f"Written to {output}: {frames} frames, {(end - start) * 1e6:.5g} us of the run in {FILM_TIME:g} s, "
        f"motion magnified by {film.magnification:g}."
    )


def _output(text: str | None, source: Path) -> Path:
    """Where the animation goes."""
    output = source.with_suffix(".gif") if text is None else Path(text)
    if output.suffix.lower() not in SUFFIXES:
        raise RefusalError(
            f"--output is '{output}', it must end in {' or '.join(SUFFIXES)}; choose such a name."
        )
    if output.is_dir():
        raise RefusalError(f"--output is '{output}', which is a folder; choose the name of a file.")
    if output.absolute() == source.absolute():
        raise RefusalError(f"--output is '{output}', the run itself; choose another name.")
    if not output.parent.is_dir():
        raise RefusalError(
            f"--output is '{output}', but there is no folder '{output.parent}'; create it first."
        )
    return output


def _number(option: str, text: str, unit: str) -> float:
    try:
        return to_si(text, unit)
    except UnitError as fault:
        example = "25" if unit == "1" else "4e-3 or '4 ms'"
        raise RefusalError(f"{option} is '{text}', {fault}; write it like {example}.") from fault


def _dataset(source: Path) -> "xarray.DataTree":
    """All of a dataset, the file closed."""
    import xarray

    if damaged := damage(source):
        raise RefusalError(damaged)
    try:
        # Plain numbers as they were written: times in seconds are not to become dates.
        with xarray.open_datatree(source, engine="netcdf4", decode_cf=False) as tree:
            return tree.load()
    # The netCDF library tells of a damaged file by any of these.
    except (OSError, RuntimeError, ValueError, AttributeError, KeyError) as fault:
        raise RefusalError(
            f"'{source}' cannot be read as netCDF ({fault}); it must be a run.nc that contactlab wrote. "
            "Choose another file, or run it again."
        ) from fault


def _window(
    run: "Recording", start_text: str | None, duration_text: str | None
) -> tuple[float, float]:
    """Start and end of what is shown [s]."""
    first, last = float(run.time[0]), float(run.time[-1])
    shortest = float(run.time[1] - run.time[0])
    start = None if start_text is None else _number("--start", start_text, "s")
    if start is not None and not first <= start <= last - shortest * (1.0 - 1e-9):
        raise RefusalError(
            f"--start is {start_text}, but the run lasts from {first:g} to {last:g} s; it must be at least "
            f"{first:g} s and at most {last - shortest:g} s, a record before the end. Choose a time within, "
            "or leave --start out."
        )
    longest = last - (first if start is None else start)
    if duration_text is None:
        duration = min(PERIODS * run.period, longest)
    else:
        duration = _number("--duration", duration_text, "s")
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


def _progress_bar(numbers: Iterable[int]) -> Iterator[int]:
    """A bar over the frames on a terminal, nothing elsewhere."""
    if not sys.stderr.isatty():
        yield from numbers
        return
    from tqdm import tqdm

    yield from tqdm(numbers, unit="frame", leave=False, file=sys.stderr)
