"""An animation as a file, GIF or MP4.

matplotlib's own writers choose colours for every frame, so that what stands still flickers, and round the
time of a frame, so that the film is too short.
"""

import errno
import subprocess
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from contactlab.plot.animation import Animation
from contactlab.results.files import whole_file

Pixels = NDArray[np.uint8]
UNCHANGED: Final = 255
"""Of 256 numbers of colours, the one for a pixel that stays as the frame before left it."""

Watch = Callable[[Iterable[int]], Iterable[int]]
"""Passes the numbers of the frames on and watches them go by."""


class NoEncoderError(RuntimeError):
    """There is nothing to encode videos with; the message is a sentence."""


def write_gif(animation: Animation, fps: float, path: Path, watch: Watch = iter) -> None:
    """Write a GIF that repeats for ever, of at most 50 frames a second; the same frames give the same bytes.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    palette = _Palette(animation)
    # The format counts hundredths of a second; rounding the sum keeps the pace on average.
    ends = np.round(100.0 * np.arange(len(animation) + 1) / fps).astype(int)
    images = palette.images(animation.frame(n) for n in watch(range(len(animation))))
    with whole_file(path) as partial:
        next(images).save(
            partial,
            format="GIF",
            save_all=True,
            append_images=images,
            duration=[10 * int(ticks) for ticks in np.diff(ends)],
            loop=0,
            optimize=False,
            transparency=UNCHANGED,
            disposal=1,
        )


class _Palette:
    """The commonest 255 colours of some frames, for all of them: what stands still does not flicker.

    Pillow's own choice of the nearest colour rounds, and makes white a grey. One number more stands for what
    the frame before had there, which makes a file a quarter as large.
    """

    def __init__(self, animation: Animation) -> None:
        packed = np.concatenate([_packed(animation.frame(n)).ravel() for n in animation.samples])
        colours, counts = np.unique(packed, return_counts=True)
        self._colours = _parts(colours[np.argsort(-counts, kind="stable")[:UNCHANGED]])
        self._nearest = np.full(1 << 24, -1, dtype=np.int16)

    def images(self, frames: Iterable[Pixels]) -> Iterator[Image.Image]:
        """Yield frames in these colours, the first whole, of every other one what has changed."""
        before = None
        for pixels in frames:
            numbers = self._numbers(pixels)
            changed = numbers if before is None else np.where(numbers == before, UNCHANGED, numbers)
            before = numbers
            image = Image.fromarray(changed.astype(np.uint8))
            image.putpalette(self._colours.ravel().tolist())
            yield image

    def _numbers(self, pixels: Pixels) -> NDArray[np.int16]:
        """Return the nearest colour of every pixel."""
        packed = _packed(pixels)
        new = np.unique(packed[self._nearest[packed] < 0])
        distances = ((_parts(new)[:, None, :] - self._colours) ** 2).sum(axis=2)
        self._nearest[new] = distances.argmin(axis=1)
        return np.asarray(self._nearest[packed])


def _packed(pixels: Pixels) -> NDArray[np.int64]:
    """Return every colour as one number."""
    return np.asarray(pixels.view("<u4")[:, :, 0] & 0xFFFFFF, dtype=np.int64)


def _parts(packed: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return red, green and blue of such numbers, shape (colour, 3)."""
    return packed.astype("<u4")[:, None].view(np.uint8)[:, :3].astype(np.int64)


def encoder() -> str:
    """Find the video encoder that comes with the package imageio-ffmpeg.

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


def write_mp4(animation: Animation, fps: float, path: Path, watch: Watch = iter) -> None:
    """Write an MP4 (H.264), which every browser plays; arguments as of `write_gif`.

    Raises:
        NoEncoderError: there is no encoder.
        OSError: the folder is missing, not writable or full.
    """
    height, width, _ = animation.frame(0).shape
    options = (
        f"-loglevel error -nostdin -y -f rawvideo -pix_fmt rgba -s {width}x{height} -r {fps:g} -i pipe:0 "
        "-an -c:v libx264 -pix_fmt yuv420p -crf 18 -fflags +bitexact -flags:v +bitexact "
        "-movflags +faststart -f mp4"
    )
    program = encoder()
    with whole_file(path) as partial:
        command = [program, *options.split(), str(partial.absolute())]
        _feed(command, (animation.frame(n).tobytes() for n in watch(range(len(animation)))))


def _feed(command: list[str], images: Iterator[bytes]) -> None:
    """Give the images to an encoder that ends with this, whatever happens.

    In a session of its own it does not die of Ctrl-C first and look like a fault.
    """
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
    ) as process:
        assert process.stdin is not None
        try:
            for image in images:
                process.stdin.write(image)
            _, text = process.communicate()
        except BrokenPipeError:
            text = process.stderr.read() if process.stderr else b""
            process.wait()
        except BaseException:
            process.kill()
            raise
    if process.returncode:
        lines = text.decode(errors="replace").strip().splitlines()
        raise OSError(errno.EIO, f"the video encoder says: {lines[-1] if lines else 'nothing'}")
