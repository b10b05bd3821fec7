"""The animation of a run: it shows the run's geometry and forces, repeats itself, and refuses in words."""

import dataclasses
import importlib.util
import sys
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray
from PIL import Image
from support.command_line import Command, left_behind
from support.synthetic import CONFIGURATION, FREQUENCY, PEAK_FORCE, synthetic_trajectory

from contactlab.cli import animate
from contactlab.laws.base import FREE, SLIP, STICK
from contactlab.plot.animation import COLOUR, LONGEST, Animation, _pitch, arrow_outline
from contactlab.plot.animation_files import _Palette, write_gif
from contactlab.plot.film import Film, film_of
from contactlab.plot.recording import UnfitRunError, recording_of
from contactlab.results.netcdf import to_datatree, write_tree

PERIOD = 1.0 / FREQUENCY
HAS_ENCODER = importlib.util.find_spec("imageio_ffmpeg") is not None


def film(frames: int = 100, tree: xarray.DataTree | None = None, end: float = 5e-3) -> Film:
    run = recording_of(tree or to_datatree(synthetic_trajectory(), CONFIGURATION))
    return film_of(run, max(end - 2.0 * PERIOD, 0.0), end, frames)


@pytest.fixture
def run_file(tmp_path: Path) -> Path:
    path = tmp_path / "run.nc"
    write_tree(to_datatree(synthetic_trajectory(), CONFIGURATION), path)
    return path


@pytest.fixture
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(animate, "FILM_TIME", 1.0)


def centre(shown: Film) -> np.ndarray:
    return np.array((0.0, shown.run.radius))


def test_a_tip_without_a_gap_touches_the_circle_wherever_it_is() -> None:
    shown = film()
    x = np.linspace(-3e-6, 3e-6, 7)
    distance = np.hypot(*(shown.tip_end(x, np.zeros(7)) - centre(shown)).T)
    assert distance == pytest.approx(shown.run.radius, rel=1e-14)


def test_the_drawn_gap_is_the_magnified_gap() -> None:
    shown = film()
    drawing = Animation(shown, 10.0)
    for number in (0, 30, 60, 90):
        drawing.frame(number)
        end = drawing.tip.get_xy()[0]
        gap = np.hypot(*(end - centre(shown))) - shown.run.radius
        assert gap == pytest.approx(shown.magnification * shown.gap[number], abs=1e-12)


def test_a_tip_that_sticks_travels_with_the_marks() -> None:
    shown = film()
    moved = dataclasses.replace(
        shown, angle=shown.angle * 0.0 + 1e-4, tangential=shown.tangential * 0.0 + 25e-3 * 1e-4
    )
    drawing = Animation(moved, 10.0)
    drawing.frame(0)
    end = moved.tip_end(moved.tangential[:1], np.zeros(1))[0]
    marks = np.array([segment[0] for segment in drawing.marks.get_segments()])
    assert np.min(np.hypot(*(marks - end).T)) < 1e-12


def test_the_arrow_is_proportional_to_the_force() -> None:
    shown = film()
    drawing = Animation(shown, 10.0)
    scales = []
    for number in np.flatnonzero(shown.normal > 0.01 * PEAK_FORCE):
        drawing.frame(int(number))
        foot, apex = drawing.tip.get_xy()[0], drawing.arrow.get_xy()[3]
        force = shown.force_on_rotor(int(number))
        assert np.hypot(*force) == pytest.approx(np.hypot(shown.normal[number], shown.friction[number]))
        scales.append((apex - foot) / force)
    assert np.ptp(scales) == pytest.approx(0.0, abs=1e-9 * np.max(scales))
    assert np.max(scales) == pytest.approx(LONGEST * shown.size / shown.peak)


def test_the_force_on_the_rotor_pushes_it_away_from_the_tip_and_against_the_force_on_the_tip() -> None:
    shown = dataclasses.replace(
        film(1), tangential=np.zeros(1), normal=np.array([2.0]), friction=np.array([0.5])
    )
    assert shown.force_on_rotor(0) == pytest.approx([-0.5, 2.0])


@pytest.mark.parametrize("length", [0.0, 1e-9, 1.0, 100.0])
def test_the_apex_of_an_arrow_lies_at_its_vector(length: float) -> None:
    vector = length * np.array((0.6, -0.8))
    assert arrow_outline(vector, 0.5)[3] == pytest.approx(vector)


@pytest.mark.parametrize("frames", [2, 7, 100, 2000])
def test_mean_forces_add_up_to_the_impulses(frames: int) -> None:
    shown = film(frames)
    interval = (shown.run.end - shown.run.start) / frames
    # Two contacts lie in two drive periods.
    impulse = 2.0 * 2.0 / np.pi * PEAK_FORCE * 60e-6
    assert shown.normal.sum() * interval == pytest.approx(impulse, rel=1e-9)


@pytest.mark.parametrize("frames", [100, 333, 2000])
def test_there_is_force_in_contact_and_nowhere_else(frames: int) -> None:
    shown = film(frames)
    assert set(shown.mode) == {FREE, SLIP, STICK}
    assert not shown.normal[shown.mode == FREE].any()
    assert (shown.normal[shown.mode == STICK] > 0.5 * PEAK_FORCE).all()


def test_the_motion_stays_in_the_picture() -> None:
    shown = film()
    drawing = Animation(shown, 10.0)
    scene = drawing.marks.axes
    for number in range(0, 100, 9):
        drawing.frame(number)
        for patch in (drawing.tip.get_xy()[:1], drawing.arrow.get_xy()):
            inside = scene.transAxes.inverted().transform(scene.transData.transform(patch))
            assert ((inside > 0.0) & (inside < 1.0)).all()


def test_frames_do_not_depend_on_their_order() -> None:
    drawing = Animation(film(), 10.0)
    first = drawing.frame(40)
    drawing.frame(70)
    assert np.array_equal(drawing.frame(40), first)
    assert not np.array_equal(drawing.frame(70), first)


def test_the_marks_of_a_motor_that_turns_evenly_end_where_they_begin() -> None:
    shown = film(100)
    angle = -2.3 * shown.run.series["time"]
    even = dataclasses.replace(shown.run, series=shown.run.series.assign(rotor_angle=angle))
    # The first frame lies an interval after the beginning, which is what the last one repeats.
    whole = film_of(even, even.start, even.end, 100)
    turned = whole.magnification * 2.3 * (even.end - even.start)
    fives = turned / (5.0 * _pitch(whole))
    assert round(fives) >= 1
    assert fives == pytest.approx(round(fives), rel=1e-12)
    assert _pitch(whole) == pytest.approx(0.06 * whole.size / even.radius, rel=0.5)


def test_a_gif_tells_what_changes_and_shows_whole_frames(tmp_path: Path) -> None:
    drawing = Animation(film(6), 1.0)
    write_gif(drawing, 10.0, tmp_path / "run.gif")
    with Image.open(tmp_path / "run.gif") as image:
        assert image.n_frames == 6
        for number in range(6):
            image.seek(number)
            with BytesIO() as alone:
                next(_Palette(drawing).images(iter([drawing.frame(number)]))).save(alone, format="GIF")
                whole = np.asarray(Image.open(alone).convert("RGB"))
            assert np.array_equal(np.asarray(image.convert("RGB")), whole)


@pytest.mark.long
@pytest.mark.usefixtures("_short", "run_file")
def test_a_gif_keeps_the_colours_of_the_modes(command: Command) -> None:
    assert command("animate", "run.nc", "--fps", "50")[0] == 0
    seen = set()
    with Image.open("run.gif") as image:
        for number in range(image.n_frames):
            image.seek(number)
            pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
            seen |= {mode for mode in (FREE, SLIP, STICK) if (pixels == rgb(COLOUR[mode])).all(1).any()}
    assert seen == {FREE, SLIP, STICK}


def rgb(colour: str) -> tuple[int, ...]:
    return tuple(bytes.fromhex(colour.removeprefix("#")))


def diverged() -> xarray.DataTree:
    whole = synthetic_trajectory()
    series = {name: values.copy() for name, values in whole.series.items()}
    for values in series.values():
        values[-100:] = np.nan
    return to_datatree(dataclasses.replace(whole, series=series), CONFIGURATION)


@pytest.mark.parametrize(
    "make",
    [
        diverged,
        lambda: to_datatree(synthetic_trajectory(contact=False), CONFIGURATION),
        lambda: to_datatree(synthetic_trajectory(interval=1e-4), CONFIGURATION),
        lambda: to_datatree(synthetic_trajectory(2e-3, 1e-7), CONFIGURATION),
    ],
    ids=["diverged", "without contact", "coarsely recorded", "finely recorded"],
)
def test_every_run_can_be_drawn(make: Callable[[], xarray.DataTree]) -> None:
    tree = make()
    drawing = Animation(film(20, tree, float(tree["time"][-1])), 10.0)
    assert {drawing.frame(number).shape for number in range(20)} == {(640, 800, 4)}


def test_a_part_that_has_diverged_is_refused() -> None:
    with pytest.raises(UnfitRunError, match="has diverged between"):
        film_of(recording_of(diverged()), 4.95e-3, 5e-3, 10)


@pytest.mark.usefixtures("_short")
def test_the_command_writes_a_gif_beside_the_run_and_the_same_bytes_again(
    run_file: Path, command: Command
) -> None:
    status, out, err = command("animate", "run.nc", "--fps", "24")
    assert (status, err) == (0, "")
    assert "Written to run.gif: 24 frames, 623.05 us of the run in 1 s" in out
    picture = run_file.with_suffix(".gif")
    with Image.open(picture) as image:
        assert image.n_frames == 24
        durations = []
        for number in range(24):
            image.seek(number)
            durations.append(image.info["duration"])
    # Hundredths of a second, right on average.
    assert sum(durations) == 1000
    # A folder with a run is the run.
    assert command("animate", ".", "--fps", "24", "--output", "again.GIF")[0] == 0
    assert Path("again.GIF").read_bytes() == picture.read_bytes()
    assert sorted(map(str, left_behind())) == ["again.GIF", "run.gif", "run.nc"]


@pytest.mark.usefixtures("_short", "run_file")
def test_start_and_duration_choose_the_part(command: Command) -> None:
    status, out, _ = command("animate", "run.nc", "--start", "1 ms", "--duration", "2e-4", "--fps", "24")
    assert status == 0
    assert "200 us of the run" in out


@pytest.mark.usefixtures("_short", "run_file")
def test_too_few_frames_to_see_the_vibration_are_told(command: Command) -> None:
    status, _, err = command("animate", "run.nc", "--fps", "24", "--duration", "5 ms")
    assert status == 0
    assert "Only 1.5 frames show a drive period" in err


@pytest.mark.skipif(
    not HAS_ENCODER, reason="There is no encoder of mp4; pip install 'contactlab[video]' brings one."
)
@pytest.mark.usefixtures("_short", "run_file")
def test_the_command_writes_an_mp4(command: Command) -> None:
    status, _, err = command("animate", "run.nc", "--fps", "24", "--output", "run.mp4")
    assert (status, err) == (0, "")
    assert Path("run.mp4").read_bytes()[4:8] == b"ftyp"
    assert sorted(map(str, left_behind())) == ["run.mp4", "run.nc"]


@pytest.mark.usefixtures("run_file")
def test_without_an_encoder_an_mp4_is_refused_with_the_way_out(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    status, out, err = command("animate", "run.nc", "--output", "run.mp4")
    assert (status, out) == (2, "")
    assert "pip install 'contactlab[video]'" in err
    assert "Traceback" not in err
    assert left_behind() == [Path("run.nc")]


@pytest.mark.skipif(
    sys.platform == "win32", reason="A script stands for the encoder; run the tests on Linux or macOS."
)
@pytest.mark.usefixtures("_short", "run_file")
def test_an_encoder_that_fails_leaves_nothing(
    command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    program = tmp_path_factory.mktemp("encoder") / "encoder"
    program.write_text("#!/bin/sh\necho no space left >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr("contactlab.plot.animation_files.encoder", lambda: str(program))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", fake_package(str(program)))
    status, _, err = command("animate", "run.nc", "--output", "run.mp4", "--fps", "24")
    assert status == 1
    assert "no space left" in err
    assert left_behind() == [Path("run.nc")]


def fake_package(program: str) -> object:
    return type("Package", (), {"get_ffmpeg_exe": staticmethod(lambda: program)})


@pytest.mark.usefixtures("_short", "run_file")
def test_ctrl_c_leaves_nothing(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(self: Animation, number: int) -> np.ndarray:
        raise KeyboardInterrupt

    monkeypatch.setattr(Animation, "frame", interrupted)
    status, _, err = command("animate", "run.nc")
    assert (status, err) == (130, "Interrupted before the animation was written.\n")
    assert left_behind() == [Path("run.nc")]


REFUSALS = {
    "no file": (["gone.nc"], "There is no file 'gone.nc'"),
    "folder without run": (["empty"], "There is no file 'empty/run.nc'"),
    "no netCDF": (["text.nc"], "'text.nc' cannot be read as netCDF"),
    "other netCDF": (["other.nc"], "'other.nc' has no variable 'time'"),
    "unknown suffix": (["run.nc", "--output", "a.avi"], "'a.avi', it must end in .gif or .mp4"),
    "no suffix": (["run.nc", "--output", "a"], "'a', it must end in"),
    "no folder": (["run.nc", "--output", "no/a.gif"], "there is no folder 'no'; create it"),
    "fps 0": (["run.nc", "--fps", "0"], "--fps is 0, it must be between 1 and 50"),
    "fps negative": (["run.nc", "--fps", "-5"], "--fps is -5, it must be between"),
    "fps nan": (["run.nc", "--fps", "nan"], "--fps is nan, it must be between"),
    "fps word": (["run.nc", "--fps", "fast"], "--fps is 'fast', which is not a number"),
    "late start": (["run.nc", "--start", "6 ms"], "--start is 6 ms, but the run lasts from 0 to 0.005"),
    "start at end": (["run.nc", "--start", "5 ms"], "at most 0.004999 s"),
    "early start": (["run.nc", "--start", "-1e-3"], "--start is -1e-3, but the run lasts"),
    "start in volts": (["run.nc", "--start", "3 V"], "whose unit 'V' cannot be converted to s"),
    "no duration": (["run.nc", "--duration", "0"], "it must be at least 1e-06 s"),
    "long duration": (
        ["run.nc", "--start", "4 ms", "--duration", "2 ms"],
        "at most 0.001 s, what the run lasts after --start",
    ),
}


@pytest.mark.parametrize(("arguments", "words"), REFUSALS.values(), ids=REFUSALS)
@pytest.mark.usefixtures("run_file")
def test_what_cannot_be_done_is_refused_in_a_sentence(
    arguments: list[str], words: str, command: Command
) -> None:
    Path("empty").mkdir()
    Path("text.nc").write_text("no netCDF")
    netCDF4.Dataset("other.nc", "w").close()
    before = sorted(left_behind())
    status, out, err = command("animate", *arguments)
    assert (status, out) == (2, "")
    assert words in err
    assert err.count("\n") == 1
    assert sorted(left_behind()) == before


@pytest.mark.usefixtures("run_file")
def test_a_run_that_is_not_as_it_was_left_is_refused(command: Command) -> None:
    Path("state.json").write_text('{"digest": "that of another file"}')
    status, _, err = command("animate", "run.nc")
    assert status == 2
    assert "'run.nc' is not as its run left it" in err


def test_help_tells_of_it(command: Command) -> None:
    assert "contactlab animate RUN.nc" in command("--help")[1]
    assert "--fps" in command("animate", "--help")[1]
