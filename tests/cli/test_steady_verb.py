"""`contactlab steady` tells what a settled motor does, and leaves it as a dataset and a picture."""

from pathlib import Path

import numpy as np
import pytest
import xarray
from support.command_line import Command

import contactlab as cl


def test_the_verb_prints_and_writes_what_python_finds(command: Command) -> None:
    text = ["law=newton", "contact.clearance=2 um"]
    status, out, _ = command("steady", *text, "load=-0.5 mN*m", "output=here")
    assert status == 0
    assert sorted(path.name for path in Path("here").iterdir()) == [
        "quantities.csv", "quantities.tex", "report.html", "steady.nc", "steady.pdf", "steady.png"
    ]  # fmt: skip
    assert "periodic" in out
    result = cl.converged(cl.build(text), load=-5e-4)
    with xarray.open_datatree("here/steady.nc") as tree:
        group = tree["steady"].dataset
        assert float(group["rotor_velocity"]) == result.velocity[0]
        assert float(group["rotor_velocity_error"]) == result.velocity[1]
        assert np.hypot(group["multiplier_real"], group["multiplier_imag"]).max() < 1.0
        assert tree["steady"].attrs["kind"] == "periodic"
        orbit = tree.to_dataset()["rotor_velocity"].values
        assert orbit[-1] == pytest.approx(orbit[0], rel=1e-8)
        assert f"{result.velocity[0]:.3f}"[:5] in out
        assert "load_torque: -0.0005" in tree.attrs["configuration"]


def test_a_brake_that_holds_is_told(command: Command) -> None:
    status, out, _ = command("steady", "law=newton", "brake=0.1", "refine=false")
    assert status == 0
    assert "0.1 N m" in out
    with xarray.open_datatree("steady/steady.nc") as tree:
        assert tree["steady"].attrs["kind"] == "standing"


def test_a_rotor_that_runs_away_is_incomplete(command: Command) -> None:
    status, _, err = command("steady", "law=newton", "load=0.1", "longest=200", "refine=false")
    assert status == 1
    assert err
