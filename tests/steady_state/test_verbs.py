"""The verbs `branch` and `basins`: what they print, leave and refuse."""

from pathlib import Path

import pytest
import xarray
from support.command_line import Command, left_behind

MOTOR = ("law=newton", "contact.clearance=3 um")


def test_the_command_follows_a_branch_and_leaves_dataset_and_picture(command: Command) -> None:
    text = ("drive.phase=-40 deg..-36 deg", "law=newton", "step=0.5", "output=here")
    status, out, err = command("branch", *text)
    assert (status, err) == (0, "")
    assert "-3.049 " in out
    assert out.isascii()
    with xarray.open_dataset("here/branch.nc") as data:
        assert data.attrs["parameter"] == "drive.phase"
        assert data["value"].attrs["units"] == "rad"
    assert Path("here/branch.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_maps_starts_and_leaves_dataset_and_picture(command: Command) -> None:
    status, _, err = command("basins", *MOTOR, "count=2")
    assert (status, err) == (0, "")
    with xarray.open_dataset("basins/basins.nc") as data:
        assert data.attrs["unresolved"] == 0
        assert data["kind"].values.tolist() == ["periodic"]
        assert dict(data.label.sizes) == {"rotor_velocity": 2, "drive_phase": 2}


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (("branch", "law=newton"), "study.over"),
        (("branch", "contact.clearnce=1e-6..2e-6"), "contact.clearance"),
        (("branch", "contact.clearance=1 V..2 um"), "contact.clearance"),
        (("branch", "contact.clearance=9 um..2 um", "law=newton"), "contact.clearance"),
        (("branch", "resonator.shapes=2..6"), "resonator.shapes"),
        (("branch", "resonator=finite_element", "resonator.kept_modes=2..6"), "kept_modes"),
        (("basins", "angle=0..1", "drive_phase=0..1"), "angle"),
        (("basins", "count=1"), "count"),
    ],
)
def test_what_has_no_range_or_no_orbit_is_refused_by_its_key(
    command: Command, arguments: tuple[str, ...], key: str
) -> None:
    status, out, err = command(*arguments)
    assert (status, out) == (2, "")
    assert key in err
    assert "Traceback" not in err
    assert left_behind() == []
