"""Claims on files of measured series: what is read, in which units, and what is refused in which words."""

import numpy as np
import pytest
import xarray

import contactlab as cl
from contactlab.measured.files import MeasurementError, read_impacts, read_measurements as read
from contactlab.measured.series import SeriesError, chosen_names, read_series, write_series


def written(tmp_path, change=lambda data: data):
    """A file of two series, changed."""
    time = np.arange(10) * 1e-5
    data = xarray.Dataset(
        {
            "rotor_velocity": ("time", np.linspace(0.0, -1.0, 10), {"units": "rad s-1"}),
            "gap": ("time", np.linspace(1.0, 2.0, 10), {"units": "um"}),
            "gap_error": ((), 0.1, {"units": "um"}),
        },
        coords={"time": ("time", time, {"units": "s"})},
        attrs={"configuration": "law: {name: newton}\n", "title": "ours"},
    )
    path = tmp_path / "data.nc"
    change(data).to_netcdf(path, engine="netcdf4")
    return path


def test_units_are_converted_and_one_error_stands_for_all_times(tmp_path):
    found = read_series(written(tmp_path))

    assert found.values["gap"][0] == pytest.approx(1e-6)
    np.testing.assert_allclose(found.errors["gap"], np.full(10, 1e-7))
    assert found.configuration == {"law": {"name": "newton"}}
    assert found.attributes["title"] == "ours"


def test_what_is_written_is_read_again_to_the_last_bit(tmp_path):
    first = read_series(written(tmp_path))
    write_series(first, tmp_path / "again.nc")
    second = read_series(tmp_path / "again.nc")

    assert second.values["gap"].tobytes() == first.values["gap"].tobytes()
    assert second.errors["gap"].tobytes() == first.errors["gap"].tobytes()
    assert (second.configuration, second.attributes) == (first.configuration, first.attributes)


def test_a_run_is_a_file_of_measured_series(tmp_path):
    run = cl.simulate(cl.build(["solver.duration=2e-4", "record.interval=1e-5", "law=newton"]))
    run.save(tmp_path / "run.nc")
    found = read_series(tmp_path / "run.nc").only(["gap", "normal_force"])

    assert found.values["gap"].tobytes() == run["gap"].values.tobytes()
    assert found.configuration["law"]["name"] == "newton"
    with pytest.raises(ValueError, match="Did you mean rotor_velocity"):
        read_series(tmp_path / "run.nc").only(["rotor_velocty"])


def nan(data):
    data["gap"][3] = np.nan
    return data


def units(data):
    data["gap"].attrs["units"] = "kg"
    return data


def no_units(data):
    del data["rotor_velocity"].attrs["units"]
    return data


def backwards(data):
    return data.isel(time=[0, 1, 2, 4, 3, 5, 6, 7, 8, 9])


def early(data):
    return data.assign_coords(time=data["time"] - 1e-3).assign_coords(
        time=lambda d: d.time.assign_attrs(units="s")
    )


def other_names(data):
    return data.rename(rotor_velocity="omega", gap="distance").drop_vars("gap_error")


def orphan(data):
    return data.rename(gap_error="gab_error")


def no_noise(data):
    data["gap_error"] = data["gap_error"] * 0.0
    data["gap_error"].attrs["units"] = "um"
    return data


def no_yaml(data):
    return data.assign_attrs(configuration="law: [")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (nan, "gap is nan in row 4; all must be finite"),
        (units, "gap is in 'kg'; it must be in m"),
        (no_units, "rotor_velocity has no units; it must be in rad/s"),
        (backwards, "time 3e-05 s stands behind 4e-05 s; times must increase"),
        (early, "time begins at -0.001 s; it must not be negative"),
        (other_names, "it has nothing that may be measured of a motor"),
        (orphan, "gab_error is there and gab is not"),
        (no_noise, "gap_error is 0 at the least; a standard deviation must be greater than 0"),
        (no_yaml, "its configuration is no YAML"),
        (lambda data: data.isel(time=slice(3)), "it has 3 times; there must be 8 at the least"),
        (lambda data: data.drop_vars("time"), "it has no time; there must be one, in seconds"),
    ],
)
def test_a_bad_file_is_refused_in_a_sentence(tmp_path, change, words):
    with pytest.raises(ValueError, match=r"data\.nc': ") as refused:
        read_series(written(tmp_path, change))

    assert words in str(refused.value)


def test_every_fault_of_a_file_is_told_and_what_is_no_netcdf_too(tmp_path):
    with pytest.raises(ValueError, match=r"gap is nan(.|\n)*gab_error"):
        read_series(written(tmp_path, lambda data: orphan(nan(data))))
    (tmp_path / "text.nc").write_text("no netCDF")
    with pytest.raises(ValueError, match="cannot be read as netCDF"):
        read_series(tmp_path / "text.nc")
    with pytest.raises(ValueError, match="Did you mean gap"):
        chosen_names("gapp")


ROWS = "".join(f"{at},{-10 * at},{at / 4}\n" for at in range(10))


def text(tmp_path, content):
    """A CSV file of series."""
    path = tmp_path / "series.csv"
    path.write_text(content)
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_series_in_csv_is_read_with_its_units_converted(tmp_path, separator):
    head = "# title: ours\n# rotor_velocity_error: 3 rpm\ntime [ms],rotor_velocity [rpm],gap [um]\n"
    found = read(text(tmp_path, (head + ROWS).replace(",", separator)))

    np.testing.assert_allclose(found.time, np.arange(10) * 1e-3, rtol=1e-15)
    np.testing.assert_allclose(found.values["rotor_velocity"], -np.arange(10) * np.pi / 3, rtol=1e-15)
    np.testing.assert_allclose(found.values["gap"], np.arange(10) * 0.25e-6, rtol=1e-15)
    np.testing.assert_allclose(found.errors["rotor_velocity"], np.full(10, 0.1 * np.pi), rtol=1e-15)
    assert (found.attributes, len(found.digest)) == ({"title": "ours"}, 64)


def test_a_series_is_the_same_from_csv_and_from_netcdf(tmp_path):
    first = read(text(tmp_path, "time [s],rotor_velocity [rad/s],gap [m]\n" + ROWS))
    write_series(first, tmp_path / "series.nc")
    second = read(tmp_path / "series.nc")

    assert second.time.tobytes() == first.time.tobytes()
    assert {name: each.tobytes() for name, each in second.values.items()} == {
        name: each.tobytes() for name, each in first.values.items()
    }


@pytest.mark.parametrize(
    ("content", "named"),
    [
        ("time [s],rotor_velocity [kg],gap [m]\n" + ROWS, "rotor_velocity"),
        ("time [s],rotor_velocity,gap [m]\n" + ROWS, "rotor_velocity"),
        ("time [s],rotor_velocty [rad/s],gap [m]\n" + ROWS, "Did you mean rotor_velocity"),
        ("rotor_velocity [rad/s],gap [m],gap_error [m]\n" + ROWS, "time"),
        ("time [s],rotor_velocity [rad/s],gap [m]\n" + ROWS + "5,1,1\n", "increase"),
        ("time [s],rotor_velocity [rad/s],gap [m]\n" + ROWS + "10,,1\n", "empty in line 12"),
        ("time [s],rotor_velocity [rad/s],gap [m]\n1,2,3\n", "1 times"),
        ("# time: 1 s\nrotor_velocity [rad/s],gap [m]\n1,2\n3,4\n", "time"),
    ],
)
def test_a_bad_series_in_csv_is_refused_as_a_series(tmp_path, content, named):
    with pytest.raises(SeriesError, match=r"series\.csv': ") as refused:
        read(text(tmp_path, content))

    assert named in str(refused.value)


def test_series_where_impacts_are_wanted_are_refused_with_the_columns(tmp_path):
    path = text(tmp_path, "time [s],rotor_velocity [rad/s],gap [m]\n" + ROWS)
    with pytest.raises(MeasurementError, match="rotor_velocity, gap"):
        read_impacts(path)
