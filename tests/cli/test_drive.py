"""The verb drive: laws on the path of a file, and paths that are none."""

from pathlib import Path

import numpy as np
import pytest
from support.command_line import Command

import contactlab as cl

TIME = np.linspace(0.0, 1e-3, 101)


def written(**columns: np.ndarray) -> str:
    header = ",".join(f"{name} [{unit}]" for name, unit in zip(columns, UNITS.values(), strict=False))
    np.savetxt("path.csv", np.column_stack([*columns.values()]), delimiter=",", header=header, comments="")
    return "path.csv"


UNITS = {"time": "s", "slip": "m", "normal": "N"}


def path() -> str:
    return written(time=TIME, slip=1e-6 * np.sin(2e3 * np.pi * TIME), normal=np.full(TIME.size, 10.0))


def test_coulomb_loses_mu_n_times_the_way(command: Command) -> None:
    status, out, _ = command("drive", path(), "law=hertz_penalty,newton", "degree=7", "output=out")
    assert status == 0
    assert "newton" in out
    result = cl.load("out/drive.nc")
    assert isinstance(result, cl.Result)
    for law in ("hertz_penalty", "newton"):
        # Once to and fro: four amplitudes.
        np.testing.assert_allclose(result.numbers[f"{law}.friction_loss"].value, 1.2e-5, rtol=1e-9)
        assert result.numbers[f"{law}.drive_work"].error < 1e-12 * 1.2e-5
    assert {"drive.png", "report.html", "newton.png"} <= {file.name for file in Path("out").iterdir()}


def test_a_velocity_is_integrated_and_its_error_is_stated(command: Command) -> None:
    speed = 2.0 * np.pi * np.cos(2e3 * np.pi * TIME)
    table = np.column_stack([TIME, speed, np.full(TIME.size, 10.0), np.full(TIME.size, 0.01)])
    header = "time [s],velocity [mm/s],normal [N],velocity_error [mm/s]"
    np.savetxt("speed.csv", table, delimiter=",", header=header, comments="")
    status, out, _ = command("drive", "speed.csv", "law=newton", "output=out")
    assert status == 0
    assert "integral of velocity" in out
    np.testing.assert_allclose(cl.load("out/drive.nc").numbers["friction_loss"].value, 1.2e-5, rtol=1e-5)


def test_a_path_repeats_itself(command: Command) -> None:
    status, _, error = command(
        "drive", path(), "law=hertz_penalty", "degree=1", "period=1.01 ms", "duration=3.03 ms", "output=out"
    )
    assert (status, error) == (0, "")
    np.testing.assert_allclose(cl.load("out/drive.nc").numbers["friction_loss"].value, 3.6e-5, rtol=1e-3)


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["law=newton", "degree=4"], "degree"),
        (["law=newton", "rotor.inertia=1e-6"], "rotor.inertia"),
        ([], "law"),
        (["law=newton", "period=1e-4"], "period"),
        (["law=composed", "law/normal=prony"], "gap"),
    ],
)
def test_what_no_path_can_have_is_refused(command: Command, arguments: list[str], key: str) -> None:
    status, _, error = command("drive", path(), *arguments, "output=out")
    assert status == 2
    assert key in error
    assert not Path("out").exists()


def test_a_file_without_a_path_is_refused(command: Command) -> None:
    np.savetxt("path.csv", [[0.0, 1.0], [1.0, 2.0]], delimiter=",", header="time [s],gap [m]", comments="")
    status, _, error = command("drive", "path.csv", "law=newton", "output=out")
    assert status == 2
    assert "path" in error
