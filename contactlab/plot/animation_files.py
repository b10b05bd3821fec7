"""An animation as a file, GIF or MP4, that stands under its name only when whole."""

import errno
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from contactlab.results.files import whole_file

Pixels = NDArray[np.uint8]
Watch = Callable[[Iterable[int]], Iterable[int]]
"""Passes the numbers of the frames on and watches them go by."""


class Frames(Protocol):
    """Frames that can be asked for in any order."""

    def __len__(self) -> int: ...

    @property
    def samples(self) -> Sequence[int]:
        """Frames that have all colours."""
        ...

    def frame(self, number: int) -> Pixels:
        """Red, green and blue, shape (height, width, 3)."""
        ...


class NoEncoderError(RuntimeError):
    """There is nothing to encode videos with; the message is a sentence."""


def write_gif(frames: Frames, fps: float, path: Path, watch: Watch = iter) -> None:
    """Write a GIF that repeats for ever. The same frames give the same bytes.

    Args:
        frames: what it shows.
        fps: frames a second, at most 50; viewers slow down shorter ones.
        path: in a folder that exists.
        watch: progress.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    palette = _Palette(frames)
    # The format counts hundredths of a second; rounding the sum keeps the pace on average.
    ends = np.round(100.0 * np.arange(len(frames) + 1) / fps).astype(int)
    images = (palette.image(frames.frame(n)) for n in watch(range(len(frames))))
    with whole_file(path) as partial:
        next(images).save(
            partial,
            format="GIF",
            save_all=True,
            append_images=images,
            duration=[10 * int(ticks) for ticks in np.diff(ends)],
            loop=0,
            optimize=False,
        )


class _Palette:
    """The commonest 256 colours of some frames, for all of them: what stands still does not flicker.

    Pillow's own choice of the nearest colour rounds, and makes white a grey.
    """

    def __init__(self, frames: Frames) -> None:
        packed = np.concatenate([_packed(frames.frame(n)).ravel() for n in frames.samples])
        colours, counts = np.unique(packed, return_counts=True)
        commonest = colours[np.argsort(-counts, kind="stable")[:256]]
        self._colours = np.column_stack([commonest >> shift & 255 for shift in (16, 8, 0)])
        self._nearest = np.full(1 << 24, -1, dtype=np.int16)

    def image(self, pixels: Pixels) -> Image.Image:
        """A frame in these colours."""
        packed = _packed(pixels)
        new = np.unique(packed[self._nearest[packed] < 0])
        apart = np.column_stack([new >> shift & 255 for shift in (16, 8, 0)])
        distances = ((apart[:, None, :] - self._colours) ** 2).sum(axis=2)
        self._nearest[new] = distances.argmin(axis=1)
        image = Image.fromarray(self._nearest[packed].astype(np.uint8))
        image.putpalette(self._colours.ravel().tolist())
        return image


def _packed(pixels: Pixels) -> NDArray[np.int64]:
    """Every colour as one number."""
    red, green, blue = np.moveaxis(pixels.astype(np.int64), -1, 0)
    return np.asarray(red << 16 | green << 8 | blue)


def encoder() -> str:
    """The video encoder that comes with the package imageio-ffmpeg.

    Raises:
        NoEncoderError: it is not installed.
    """
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError) as fault:
        raise NoEncoderError(
            "An MP4 needs the package imageio-ffmpeg, which is not installed or brought no encoder for "
            "this system. Install it with: pip install 'contactlab[video]' (in a clone: pip install "
            "-e '.[video]'), or choose a name that ends in .gif."
        ) from fault


def write_mp4(frames: Frames, fps: float, path: Path, watch: Watch = iter) -> None:
    """Write an MP4 (H.264), which every browser plays.

    Args:
        frames: what it shows, width and height even.
        fps: frames a second.
        path: in a folder that exists.
        watch: progress.

    Raises:
        NoEncoderError: there is no encoder.
        OSError: the folder is missing, not writable or full.
    """
    height, width, _ = frames.frame(0).shape
    options = (
        f"-loglevel error -nostdin -y -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {fps:g} -i pipe:0 "
        "-an -c:v libx264 -pix_fmt yuv420p -crf 18 -fflags +bitexact -flags:v +bitexact "
        "-movflags +faststart -f mp4"
    )
    program = encoder()
    with whole_file(path) as partial:
        command = [program, *options.split(), str(partial.absolute())]
        _feed(command, (frames.frame(n).tobytes() for n in watch(range(len(frames)))))


def _feed(command: list[str], images: Iterator[bytes]) -> None:
    """Start the encoder and give it the images; it ends with the body, whatever happens."""
    with subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        # Ctrl-C is for us: the encoder must not die first and look like a fault.
        start_new_session=True,
    ) as process:
        assert process.stdin is not None
        try:
            for image in images:
                process.stdin.write(image)
            _, said = process.communicate()
        except BrokenPipeError:
            said = process.stderr.read() if process.stderr else b""
            process.wait()
        except BaseException:
            process.kill()
            raise
    if process.returncode:
        lines = said.decode(errors="replace").strip().splitlines()
        raise OSError(errno.EIO, f"the video encoder says: {lines[-1] if lines else 'nothing'}")
