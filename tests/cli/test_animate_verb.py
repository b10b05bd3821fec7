"""`contactlab animate` leaves whole pictures, the same again, or nothing and a sentence."""

import importlib.util
import sys
from pathlib import Path

import netCDF4
import numpy as np
import pytest
from PIL import Image
from support.command_line import Command, left_behind
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.cli.verbs import animate
from contactlab.plot.animation import Animation
from contactlab.results.netcdf import to_datatree, write_tree

needs_encoder = pytest.mark.skipif(
    importlib.util.find_spec("imageio_ffmpeg") is None,
    reason="There is no encoder of mp4; pip install 'contactlab[video]' brings one.",
)


@pytest.fixture
def run_file(tmp_path: Path) -> Path:
    path = tmp_path / "run.nc"
    write_tree(to_datatree(synthetic_trajectory(), CONFIGURATION), path)
    return path


@pytest.fixture
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(animate, "FILM_TIME", 1.0)


@pytest.mark.usefixtures("_short")
def test_the_command_writes_a_gif_beside_the_run_and_the_same_bytes_again(
    run_file: Path, command: Command
) -> None:
    status, out, err = command("animate", "run.nc", "fps=24")
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
    assert command("animate", ".", "fps=24", "output=again.GIF")[0] == 0
    assert Path("again.GIF").read_bytes() == picture.read_bytes()
    assert sorted(map(str, left_behind())) == ["again.GIF", "run.gif", "run.nc"]


@pytest.mark.usefixtures("_short", "run_file")
def test_start_and_duration_choose_the_part(command: Command) -> None:
    status, out, _ = command("animate", "run.nc", "start=1 ms", "duration=2e-4", "fps=24")
    assert status == 0
    assert "200 us of the run" in out


@needs_encoder
@pytest.mark.usefixtures("_short", "run_file")
def test_the_command_writes_an_mp4(command: Command) -> None:
    status, _, err = command("animate", "run.nc", "fps=24", "output=run.mp4")
    assert (status, err) == (0, "")
    assert Path("run.mp4").read_bytes()[4:8] == b"ftyp"
    assert sorted(map(str, left_behind())) == ["run.mp4", "run.nc"]


@pytest.mark.usefixtures("run_file")
def test_without_an_encoder_an_mp4_is_refused_with_the_way_out(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    status, out, err = command("animate", "run.nc", "output=run.mp4")
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
    monkeypatch.setattr("contactlab.plot.animation.encoder", lambda: str(program))
    status, _, err = command("animate", "run.nc", "output=run.mp4", "fps=24")
    assert status == 1
    assert "no space left" in err
    assert left_behind() == [Path("run.nc")]


@pytest.mark.parametrize("name", ["run.gif", pytest.param("run.mp4", marks=needs_encoder)])
@pytest.mark.usefixtures("_short", "run_file")
def test_ctrl_c_leaves_nothing(name: str, command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    draw = Animation.frame

    def interrupted(self: Animation, number: int) -> np.ndarray:
        if number == 12:
            raise KeyboardInterrupt
        return draw(self, number)

    monkeypatch.setattr(Animation, "frame", interrupted)
    status, _, _ = command("animate", "run.nc", "fps=24", f"output={name}")
    assert status == 130
    assert left_behind() == [Path("run.nc")]


REFUSALS = [
    (["gone.nc"], "gone.nc"),
    (["empty"], "empty/run.nc"),
    (["text.nc"], "text.nc"),
    (["other.nc"], "other.nc"),
    (["run.nc", "output=a.avi"], "output"),
    (["run.nc", "output=no/a.gif"], "output"),
    (["run.nc", "fps=0"], "fps"),
    (["run.nc", "fps=nan"], "fps"),
    (["run.nc", "fps=fast"], "fps"),
    (["run.nc", "start=5 ms"], "start"),
    (["run.nc", "start=3 V"], "start"),
    (["run.nc", "duration=0"], "duration"),
    (["run.nc", "start=4 ms", "duration=2 ms"], "duration"),
]


@pytest.mark.parametrize(("arguments", "key"), REFUSALS)
@pytest.mark.usefixtures("run_file")
def test_a_fault_is_refused_by_its_key(arguments: list[str], key: str, command: Command) -> None:
    Path("empty").mkdir()
    Path("text.nc").write_text("no netCDF")
    netCDF4.Dataset("other.nc", "w").close()
    before = sorted(left_behind())
    status, out, err = command("animate", *arguments)
    assert (status, out) == (2, "")
    assert key in err
    assert sorted(left_behind()) == before


@pytest.mark.usefixtures("run_file")
def test_a_run_that_is_not_as_it_was_left_is_refused(command: Command) -> None:
    Path("state.json").write_text('{"digest": "that of another file"}')
    status, _, err = command("animate", "run.nc")
    assert status == 2
    assert "'run.nc' is not as its run left it" in err
