"""The state of a run is one record of its file; files of before, with a variable a field, are read too."""

from pathlib import Path

import numpy as np
import pytest
import xarray

import contactlab as cl

CUT = 3.7e-4
"""End of the first run, in a contact [s]."""


@pytest.fixture(scope="module", params=["hertz_penalty", "lagrange_stick"])
def setup(request: pytest.FixtureRequest) -> cl.Setup:
    return cl.build([f"law={request.param}", "record.interval=1e-5"])


def with_a_variable_a_field(run: cl.Solution) -> xarray.DataTree:
    """Return the tree of a run in the form of before."""
    tree = run.to_xarray().copy(deep=True)
    values = {name: np.asarray(value) for name, value in run.state.items()}
    whole = {name: x.astype(np.int8) if x.dtype.kind == "b" else x for name, x in values.items()}
    fields = {name: (tuple(f"{name}_{axis}" for axis in range(x.ndim)), x) for name, x in whole.items()}
    tree["state"] = xarray.DataTree(xarray.Dataset(fields))
    return tree


def test_a_saved_run_goes_on_as_the_uncut_one(setup: cl.Setup, tmp_path: Path) -> None:
    first = cl.simulate(setup, duration=CUT)
    first.save(tmp_path / "record.nc")
    with_a_variable_a_field(first).to_netcdf(tmp_path / "fields.nc", engine="netcdf4")
    whole = cl.simulate(setup, duration=2.0 * CUT)
    for name in ("record", "fields"):
        start = cl.load(tmp_path / f"{name}.nc")
        assert set(start.state) == set(first.state)
        later = cl.simulate(start=start, duration=CUT)
        assert later["rotor_velocity"][-1] == whole["rotor_velocity"][-1]
        for key in ("q", "v", "time", "energy_residual", "contact.start_time"):
            np.testing.assert_array_equal(later.state[key], whole.state[key], key)
    with xarray.open_dataset(tmp_path / "record.nc", group="state") as group:
        assert set(group.variables) == {b + name for b in ("", "before.") for name in ("q", "v", "record")}


def test_a_solution_answers_before_its_tree_is_made(setup: cl.Setup) -> None:
    run = cl.simulate(setup, duration=CUT)
    assert run.complete
    assert run.message == ""
    assert run.ending is cl.Ending.COMPLETE
    assert "tree" not in vars(run)
    assert run.to_xarray().attrs["complete"] == 1
    with pytest.raises(ValueError, match="read-only"):
        run["gap"].values[0] = 1.0
