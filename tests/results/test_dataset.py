"""The file of a run keeps its contract: names, units, every bit, and whole or not at all."""

import json
import os
import platform
from pathlib import Path

import numpy as np
import pytest
import xarray
import yaml
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.results.netcdf import to_datatree, to_groups, write_groups, write_tree
from contactlab.trajectory import Ending, Trajectory

# Spelt out again, not taken from the package: this table is what readers of the files rely on.
ROOT = {
    "tip_normal_displacement": (("time",), "m"),
    "tip_tangential_displacement": (("time",), "m"),
    "tip_slope": (("time",), "rad"),
    "gap": (("time",), "m"),
    "slip_velocity": (("time",), "m s-1"),
    "rotor_velocity": (("time",), "rad s-1"),
    "rotor_angle": (("time",), "rad"),
    "normal_force": (("time",), "N"),
    "friction_force": (("time",), "N"),
    "contact_mode": (("time",), "1"),
    "kinetic_energy": (("time",), "J"),
    "strain_energy": (("time",), "J"),
    "contact_energy": (("time",), "J"),
    "drive_work": (("time",), "J"),
    "damping_loss": (("time",), "J"),
    "friction_loss": (("time",), "J"),
    "contact_loss": (("time",), "J"),
    "load_work": (("time",), "J"),
    "energy_residual": (("time",), "J"),
    "charge_1": (("time",), "C"),
    "current_1": (("time",), "A"),
    "charge_2": (("time",), "C"),
    "current_2": (("time",), "A"),
    "natural_frequency": (("mode",), "Hz"),
    "damping_ratio": (("mode",), "1"),
    "electromechanical_coupling": (("shape", "electrode"), "N V-1"),
}
CONTACTS = {
    "start_time": "s",
    "duration": "s",
    "stick_duration": "s",
    "normal_impulse": "N s",
    "friction_impulse": "N s",
    "peak_normal_force": "N",
    "max_penetration": "m",
    "approach_velocity": "m s-1",
    "separation_velocity": "m s-1",
    "energy_loss": "J",
}


def write(trajectory: Trajectory, path: Path) -> xarray.DataTree:
    """Write a run and give its tree."""
    tree = to_datatree(trajectory, CONFIGURATION)
    write_tree(tree, path)
    return tree


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    """A run of 5 ms with 16 contacts."""
    return synthetic_trajectory()


@pytest.fixture(scope="module")
def path(trajectory: Trajectory, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run's file."""
    path = tmp_path_factory.mktemp("run") / "run.nc"
    write(trajectory, path)
    return path


def test_root_has_the_contracted_names_dimensions_and_units(path: Path) -> None:
    with xarray.open_dataset(path) as root:
        result = {name: (array.dims, array.attrs["units"]) for name, array in root.items()}
        assert result == ROOT
        assert root["time"].dims == ("time",)
        assert root["time"].attrs["units"] == "s"
        assert root.sizes["electrode"] == 2


def test_contacts_have_the_contracted_names_and_units(path: Path) -> None:
    with xarray.open_dataset(path, group="contacts") as contacts:
        assert {name: array.attrs["units"] for name, array in contacts.items()} == CONTACTS
        assert {array.dims for array in contacts.values()} == {("contact",)}
        assert contacts.sizes == {"contact": 16}


def test_the_tree_given_back_is_the_one_in_the_file(tmp_path: Path, trajectory: Trajectory) -> None:
    written = write(trajectory, tmp_path / "run.nc")
    with xarray.open_datatree(tmp_path / "run.nc") as read:
        assert read.identical(written)


def test_the_groups_that_a_run_leaves_are_its_tree(tmp_path: Path, trajectory: Trajectory) -> None:
    files = tmp_path / "groups.nc", tmp_path / "again.nc"
    for file in files:
        write_groups(to_groups(trajectory, CONFIGURATION), file)
    assert files[0].read_bytes() == files[1].read_bytes()
    written = write(trajectory, tmp_path / "tree.nc")
    with xarray.open_datatree(files[0]) as read, xarray.open_datatree(tmp_path / "tree.nc") as other:
        assert read.identical(written)
        for node, twin in zip(read.subtree, other.subtree, strict=True):
            for name, variable in node.variables.items():
                stored = {key: variable.encoding[key] for key in ("dtype", "zlib", "shuffle", "chunksizes")}
                assert stored.items() <= twin.variables[name].encoding.items()


def test_contact_modes_are_flags_after_the_cf_conventions(path: Path) -> None:
    with xarray.open_dataset(path) as root:
        attributes = root["contact_mode"].attrs
        assert attributes["flag_meanings"] == "free slip stick"
        np.testing.assert_array_equal(attributes["flag_values"], [0, 1, 2])
        assert attributes["flag_values"].dtype == root["contact_mode"].dtype


def test_attributes_record_what_ran(path: Path, trajectory: Trajectory) -> None:
    with xarray.open_dataset(path) as root:
        attributes = root.attrs
    assert attributes["Conventions"] == "CF-1.11"
    assert attributes["history"]
    assert yaml.safe_load(attributes["configuration"]) == CONFIGURATION
    assert json.loads(attributes["law_parameters"]) == trajectory.law.describe()
    assert json.loads(attributes["solver_statistics"]) == trajectory.statistics
    for name in ("contact_step", "duration", "record_interval"):
        assert attributes[name] == getattr(trajectory, name)
    names = {"law", "title", "source", "references", "git_revision", "git_dirty", "ending", "message"}
    packages = ("contactlab", "python", "numpy", "scipy", "numba", "xarray", "netCDF4")
    assert names | {f"{package}_version" for package in packages} <= attributes.keys()
    text = " ".join(map(str, attributes.values()))
    assert str(path.parent) not in text
    assert platform.node() not in text.split()


@pytest.mark.parametrize("ending", set(Ending) - {Ending.COMPLETE})
def test_a_run_cut_short_is_kept_and_marked(tmp_path: Path, ending: Ending) -> None:
    trajectory = synthetic_trajectory(2e-3, ending=ending, message="It stopped at 2 ms.")
    write(trajectory, tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc") as root:
        assert root.attrs["complete"] == 0
        assert root.attrs["ending"] == ending.name.lower()
        assert root.attrs["message"] == "It stopped at 2 ms."
        assert root.sizes["time"] == trajectory.time.size


def test_a_run_without_contact_has_an_empty_group(tmp_path: Path) -> None:
    write(synthetic_trajectory(contact=False), tmp_path / "run.nc")
    with xarray.open_datatree(tmp_path / "run.nc") as tree:
        assert tree["contacts"].sizes["contact"] == 0
        assert set(tree["contacts"].data_vars) == set(CONTACTS)


def test_the_same_run_leaves_the_same_bytes(tmp_path: Path) -> None:
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        write(synthetic_trajectory(), tmp_path / name / "run.nc")
    first, second = ((tmp_path / name / "run.nc").read_bytes() for name in ("first", "second"))
    assert first == second


@pytest.mark.parametrize("reason", [KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_a_writing_that_stops_half_way_leaves_nothing(
    tmp_path: Path, trajectory: Trajectory, monkeypatch: pytest.MonkeyPatch, reason: BaseException
) -> None:
    def stop_after_the_series(tree: xarray.DataTree, path: Path, **_: object) -> None:
        tree.to_dataset().to_netcdf(path)
        assert [*tmp_path.iterdir()] == [path]
        raise reason

    monkeypatch.setattr(xarray.DataTree, "to_netcdf", stop_after_the_series)
    with pytest.raises(type(reason)):
        write(trajectory, tmp_path / "run.nc")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(
    getattr(os, "geteuid", int)() == 0, reason="Root may write anywhere; run the tests as another user."
)
def test_an_unwritable_folder_is_left_as_it_is(tmp_path: Path, trajectory: Trajectory) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(PermissionError, match="run"):
            write(trajectory, tmp_path / "run.nc")
    finally:
        tmp_path.chmod(0o700)
    assert not list(tmp_path.iterdir())
