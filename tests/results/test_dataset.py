"""The file of a run keeps its contract: names, units, every bit, and whole or not at all."""

import dataclasses
import json
import os
import platform
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray
import yaml
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab.results import netcdf
from contactlab.results.netcdf import to_datatree, write_tree
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


def test_root_holds_the_contracted_names_dimensions_and_units(path: Path) -> None:
    with xarray.open_dataset(path) as root:
        found = {name: (array.dims, array.attrs["units"]) for name, array in root.items()}
        assert found == ROOT
        assert root["time"].dims == ("time",)
        assert root["time"].attrs["units"] == "s"
        assert root.sizes["electrode"] == 2


def test_contacts_hold_the_contracted_names_and_units(path: Path) -> None:
    with xarray.open_dataset(path, group="contacts") as contacts:
        assert {name: array.attrs["units"] for name, array in contacts.items()} == CONTACTS
        assert {array.dims for array in contacts.values()} == {("contact",)}
        assert contacts.sizes == {"contact": 16}


def test_every_variable_says_what_it_is(path: Path) -> None:
    with xarray.open_datatree(path) as tree:
        for node in tree.subtree:
            for array in node.to_dataset().variables.values():
                assert array.attrs["long_name"]
                assert array.attrs["symbol"]


def test_every_bit_survives_the_file(path: Path, trajectory: Trajectory) -> None:
    with xarray.open_datatree(path) as tree:
        for name, values in {"time": trajectory.time, **trajectory.series}.items():
            assert tree[name].values.tobytes() == values.tobytes()
            assert tree[name].dtype == np.float64
        for name, values in trajectory.contacts.items():
            assert tree["contacts"][name].values.tobytes() == values.tobytes()
        assert tree["contact_mode"].values.tobytes() == trajectory.contact_mode.tobytes()
        assert tree["contact_mode"].dtype == np.int8
        modes = trajectory.motor.modes
        np.testing.assert_array_equal(tree["natural_frequency"], modes.natural_frequency)
        np.testing.assert_array_equal(tree["damping_ratio"], modes.damping_ratio)
        np.testing.assert_array_equal(tree["electromechanical_coupling"], modes.shape_coupling)


def test_the_tree_given_back_is_the_one_in_the_file(tmp_path: Path, trajectory: Trajectory) -> None:
    written = write(trajectory, tmp_path / "run.nc")
    with xarray.open_datatree(tmp_path / "run.nc") as read:
        assert read.identical(written)


def test_times_stay_numbers_and_are_not_decoded(path: Path) -> None:
    with xarray.open_datatree(path) as tree:
        assert tree["time"].dtype == np.float64
        for name in ("start_time", "duration", "stick_duration"):
            assert tree["contacts"][name].dtype == np.float64


def test_contact_modes_are_flags_after_the_cf_conventions(path: Path) -> None:
    with xarray.open_dataset(path) as root:
        attributes = root["contact_mode"].attrs
        assert attributes["flag_meanings"] == "free slip stick"
        np.testing.assert_array_equal(attributes["flag_values"], [0, 1, 2])
        assert attributes["flag_values"].dtype == root["contact_mode"].dtype


def test_sum_of_force_times_interval_is_the_impulse_of_the_contacts(path: Path) -> None:
    with xarray.open_datatree(path) as tree:
        assert tree["normal_force"].attrs["cell_methods"].startswith("time: mean")
        intervals = np.diff(tree["time"].values)
        recorded = float(np.sum(tree["normal_force"].values[1:] * intervals))
        assert recorded == pytest.approx(float(tree["contacts"]["normal_impulse"].sum()), rel=1e-12)


def test_numbers_are_compressed_without_loss(path: Path) -> None:
    with netCDF4.Dataset(path) as file:
        for group in (file, file["contacts"]):
            for variable in group.variables.values():
                filters = variable.filters()
                assert filters["zlib"]
                assert filters["shuffle"]
                assert filters["complevel"] == 1
                assert variable.quantization() is None


def test_attributes_say_what_ran(path: Path, trajectory: Trajectory) -> None:
    with xarray.open_dataset(path) as root:
        attributes = root.attrs
    assert attributes["Conventions"] == "CF-1.11"
    assert yaml.safe_load(attributes["configuration"]) == CONFIGURATION
    assert attributes["law"] == "hertz_penalty"
    assert json.loads(attributes["law_parameters"]) == trajectory.law.describe()
    assert json.loads(attributes["solver_statistics"]) == trajectory.statistics
    assert attributes["contact_step"] == trajectory.contact_step
    assert attributes["duration"] == trajectory.duration
    assert attributes["record_interval"] == trajectory.record_interval
    assert attributes["ending"] == "complete"
    assert attributes["message"] == ""
    for name in ("title", "source", "references", "git_revision", "git_dirty"):
        assert name in attributes
    for package in ("contactlab", "python", "numpy", "scipy", "numba", "xarray", "netCDF4"):
        assert attributes[f"{package}_version"]


def test_complete_is_the_last_attribute_and_one(path: Path) -> None:
    with netCDF4.Dataset(path) as file:
        assert file.ncattrs()[-1] == "complete"
        assert file.getncattr("complete") == 1


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


def test_a_run_longer_than_a_chunk_survives(tmp_path: Path) -> None:
    trajectory = synthetic_trajectory(duration=14e-3, interval=1e-7)
    assert trajectory.time.size > netcdf._CHUNK
    written = write(trajectory, tmp_path / "run.nc")
    with xarray.open_datatree(tmp_path / "run.nc") as read:
        assert read.identical(written)


def test_values_that_are_no_numbers_survive(tmp_path: Path) -> None:
    whole = synthetic_trajectory(ending=Ending.DIVERGED)
    gap = whole.series["gap"].copy()
    gap[-2:] = np.nan, np.inf
    trajectory = dataclasses.replace(whole, series=whole.series | {"gap": gap})
    write(trajectory, tmp_path / "run.nc")
    with xarray.open_dataset(tmp_path / "run.nc") as root:
        np.testing.assert_array_equal(root["gap"], gap)


def test_the_same_run_leaves_the_same_bytes(tmp_path: Path) -> None:
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        write(synthetic_trajectory(), tmp_path / name / "run.nc")
    first, second = ((tmp_path / name / "run.nc").read_bytes() for name in ("first", "second"))
    assert first == second


def test_no_attribute_betrays_where_it_was_written(path: Path) -> None:
    with xarray.open_dataset(path) as root:
        text = " ".join(map(str, root.attrs.values()))
    assert str(path.parent) not in text
    assert str(Path(netcdf.__file__).parent) not in text
    assert platform.node() not in text.split()


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


def test_a_file_that_cannot_grow_raises_a_sentence_and_leaves_nothing(
    tmp_path: Path, trajectory: Trajectory
) -> None:
    resource = pytest.importorskip(
        "resource", reason="This system bounds no file; run the tests on Linux or macOS."
    )
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, hard))
    try:
        with pytest.raises(OSError, match=r"'run\.nc' cannot be written .* has space left"):
            write(trajectory, tmp_path / "run.nc")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())
    write(trajectory, tmp_path / "run.nc")


def test_a_state_of_any_kind_survives(tmp_path: Path, trajectory: Trajectory) -> None:
    state = {"time": 5e-3, "q": np.array([0.1, -0.0, np.nan]), "contact.count": 3, "compliant": True}
    ended = dataclasses.replace(trajectory, state=state)
    write(ended, tmp_path / "run.nc")
    with xarray.open_datatree(tmp_path / "run.nc") as tree:
        found = netcdf.state_of(tree.load())
    assert found.keys() == state.keys()
    for name, value in state.items():
        assert np.asarray(found[name]).tobytes() == np.asarray(value).tobytes()


@pytest.mark.skipif(
    getattr(os, "geteuid", int)() == 0, reason="Root may write anywhere; run the tests as another user."
)
def test_an_unwritable_folder_raises_a_sentence(tmp_path: Path, trajectory: Trajectory) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(PermissionError, match="choose a folder that is writable"):
            write(trajectory, tmp_path / "run.nc")
    finally:
        tmp_path.chmod(0o700)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_refuses_the_file_raises_a_sentence(trajectory: Trajectory, tmp_path: Path) -> None:
    # A folder takes a file's place, for users who may write anywhere.
    (tmp_path / "run.nc").mkdir()
    with pytest.raises(OSError, match=r"'run\.nc' cannot be written"):
        write(trajectory, tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == [tmp_path / "run.nc"]


def test_the_tree_shares_the_trajectory_instead_of_copying_it(trajectory: Trajectory) -> None:
    tree = to_datatree(trajectory, CONFIGURATION)
    assert np.shares_memory(tree["gap"].values, trajectory.series["gap"])
