"""Claims on files of measured series: units, formats, and what is refused."""

import numpy as np
import pytest
import xarray

import contactlab as cl
from contactlab_data.measured.files import (
    MeasurementError,
    read_impacts,
    read_measurements,
    read_measurements as read,
)


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
    result = read_measurements(written(tmp_path))

    assert result.values["gap"][0] == pytest.approx(1e-6)
    np.testing.assert_allclose(result.errors["gap"], np.full(10, 1e-7))
    assert result.configuration == {"law": {"name": "newton"}}
    assert result.attributes["title"] == "ours"


def test_what_is_written_is_read_again_to_the_last_bit(tmp_path):
    first = read_measurements(written(tmp_path))
    first.to_xarray().to_netcdf(tmp_path / "again.nc")
    second = read_measurements(tmp_path / "again.nc")

    assert second.values["gap"].tobytes() == first.values["gap"].tobytes()
    assert second.errors["gap"].tobytes() == first.errors["gap"].tobytes()
    assert (second.configuration, second.attributes) == (first.configuration, first.attributes)


def test_a_run_is_a_file_of_measured_series(tmp_path):
    run = cl.simulate(cl.build(["solver.duration=2e-4", "record.interval=1e-5", "law=newton"]))
    run.save(tmp_path / "run.nc")
    result = read_measurements(tmp_path / "run.nc").only(["gap", "normal_force"])

    assert result.values["gap"].tobytes() == run["gap"].values.tobytes()
    assert result.configuration["law"]["name"] == "newton"
    with pytest.raises(ValueError, match="rotor_velocty"):
        read_measurements(tmp_path / "run.nc").only(["rotor_velocty"])


def renamed(**names):
    return lambda data: data.rename(names)


def scaled(name, factor, units):
    """Another series of a name, with its unit."""
    return lambda data: data.assign({name: (data[name].dims, data[name].values * factor, {"units": units})})


def shifted(data):
    return data.assign_coords(time=("time", data["time"].values - 1e-3, {"units": "s"}))


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (scaled("gap", np.nan, "um"), "gap.*0 rows"),
        (scaled("gap", 1.0, "kg"), "gap"),
        (scaled("rotor_velocity", 1.0, ""), "rotor_velocity"),
        (scaled("gap_error", 0.0, "um"), "gap_error"),
        (lambda data: data.isel(time=[0, 1, 2, 4, 3, 5, 6, 7, 8, 9]), "time"),
        (lambda data: data.isel(time=slice(5)), "time"),
        (shifted, "time"),
        (lambda data: data.drop_vars("time"), "time"),
        (renamed(rotor_velocity="omega", gap="distance"), "rotor_velocity"),
        (renamed(gap_error="gab_error"), "gab_error"),
        (lambda data: data.drop_vars("gap"), "gap_error"),
        (lambda data: data.assign_attrs(configuration="law: ["), "configuration"),
        (lambda data: data.assign_attrs(configuration="- law"), "configuration"),
    ],
)
def test_a_faulty_netcdf_is_refused(tmp_path, change, named):
    with pytest.raises(MeasurementError, match=rf"data\.nc.*{named}"):
        read_measurements(written(tmp_path, change))


ROWS = "".join(f"{at},{-10 * at},{at / 4}\n" for at in range(10))


def text(tmp_path, content):
    """A CSV file of series."""
    path = tmp_path / "series.csv"
    path.write_text(content)
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_series_in_csv_is_read_with_its_units_converted(tmp_path, separator):
    head = "# title: ours\n# rotor_velocity_error: 3 rpm\ntime [ms],rotor_velocity [rpm],gap [um]\n"
    result = read(text(tmp_path, (head + ROWS).replace(",", separator)))

    np.testing.assert_allclose(result.time, np.arange(10) * 1e-3, rtol=1e-15)
    np.testing.assert_allclose(result.values["rotor_velocity"], -np.arange(10) * np.pi / 3, rtol=1e-15)
    np.testing.assert_allclose(result.values["gap"], np.arange(10) * 0.25e-6, rtol=1e-15)
    np.testing.assert_allclose(result.errors["rotor_velocity"], np.full(10, 0.1 * np.pi), rtol=1e-15)
    assert (result.attributes, len(result.digest)) == ({"title": "ours"}, 64)


@pytest.mark.parametrize(
    ("head", "rows", "named"),
    [
        ("time [s],rotor_velocity [kg],gap [m]", "", "rotor_velocity"),
        ("time [s],rotor_velocity,gap [m]", "", "rotor_velocity"),
        ("time [s],rotor_velocty [rad/s],gap [m]", "", "rotor_velocty"),
        ("rotor_velocity [rad/s],gap [m],gap_error [m]", "", "time"),
        ("time [s],rotor_velocity [rad/s],gap [m]", "5,1,1\n", "time"),
        ("time [s],rotor_velocity [rad/s],gap [m]", "10,x,1\n", "rotor_velocity.*line 12"),
        ("# time: 1 s\nrotor_velocity [rad/s],gap [m],tip_slope [rad]", "", "time"),
    ],
)
def test_a_faulty_series_in_csv_is_refused(tmp_path, head, rows, named):
    with pytest.raises(MeasurementError, match=rf"series\.csv.*{named}"):
        read(text(tmp_path, f"{head}\n{ROWS}{rows}"))


def test_a_file_of_no_kind_is_refused_with_the_columns_of_each(tmp_path):
    with pytest.raises(MeasurementError) as refused:
        read_measurements(text(tmp_path, "t [s],omega [rad/s]\n" + "0,1\n1,1\n"))
    for name in ("t, omega", "before_NAME", "time", "rotor_velocity", "rotor.load_torque"):
        assert name in str(refused.value)


def test_series_are_not_impacts(tmp_path):
    path = text(tmp_path, "time [s],rotor_velocity [rad/s],gap [m]\n" + ROWS)
    with pytest.raises(MeasurementError, match="rotor_velocity"):
        read_impacts(path)
