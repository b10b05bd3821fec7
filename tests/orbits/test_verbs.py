"""The verbs `branch` and `basins`: what they print, leave and refuse."""

from pathlib import Path

import xarray
from support.command_line import Command

MOTOR = ("law=newton", "contact.clearance=3 um")


def test_the_command_follows_a_branch_and_leaves_dataset_and_picture(command: Command) -> None:
    words = ("drive.phase=-40 deg..-36 deg", "law=newton", "--step", "0.5", "--output", "here")
    status, out, err = command("branch", *words)
    assert (status, err) == (0, "")
    assert "-3.0507 rad/s" in out
    assert "It ends where the range of the parameter does, at -0.628318531." in out
    assert out.isascii()
    with xarray.open_dataset("here/branch.nc") as data:
        assert data.attrs["parameter"] == "drive.phase"
        assert data["value"].attrs["units"] == "rad"
    assert Path("here/branch.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_maps_starts_and_leaves_dataset_and_picture(command: Command) -> None:
    status, out, err = command("basins", *MOTOR, "--count", "2")
    assert (status, err) == (0, "")
    assert "100.0 %  periodic" in out
    assert "4 starts; of 0 it cannot be told where they go." in out
    with xarray.open_dataset("basins/basins.nc") as data:
        assert dict(data.label.sizes) == {"rotor_velocity": 2, "drive_phase": 2}


def test_what_has_no_range_or_no_orbit_is_refused_in_a_sentence(command: Command) -> None:
    for words, said in (
        (("branch", "law=newton"), "0 of the arguments have a range KEY=START..END"),
        (("branch", "contact.clearnce=1e-6..2e-6"), "Did you mean contact.clearance?"),
        (("branch", "contact.clearance=1 V..2 um"), "whose unit 'V' cannot be converted to m"),
        (("branch", "contact.clearance=9 um..2 um", "law=newton"), "settles in no periodic orbit"),
        (("branch", "resonator.shapes=2..6"), "resonator.shapes is a whole number"),
        (("branch", "resonator=finite_element", "resonator.kept_modes=2..6"), "kept_modes is a whole number"),
        (("basins", "--over", "angle=0..1", "drive_phase=0..1"), "it must be NAME=START..END with one of"),
        (("basins", "--count", "1"), "it must be at least 2"),
    ):
        status, out, err = command(*words)
        assert (status, out) == (2, "")
        assert said in err
        assert "Traceback" not in err
