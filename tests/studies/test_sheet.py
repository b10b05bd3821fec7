"""The data sheet: its balance, its sense, its loads, and motors that it was not made from."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray
from scipy.optimize import brentq
from support.command_line import Command, cases

import contactlab as cl
from contactlab.studies.characterise.operation import Periods, Point, operate
from contactlab.studies.characterise.sheet import root
from contactlab.studies.characterise.transients import holding_torque, start_time, stop_time


@cache
def sheet_of(*overrides: str) -> xarray.Dataset:
    return cl.characterise(cl.build(overrides)).data.to_dataset().isel(law=0)


def the(data: xarray.Dataset, role: str) -> xarray.Dataset:
    return data.isel(point=int(np.flatnonzero([role in str(r) for r in data["role"].values])[0]))


@pytest.mark.parametrize("belt", [None, 0.0, -2.0, 1.0])
@pytest.mark.parametrize(("law", "open_by"), [("lagrange_stick", 2e-5), ("hertz_penalty", 1e-10)])
def test_the_electrical_input_is_output_and_losses_to_the_ledgers_error(
    law: str, open_by: float, belt: float | None
) -> None:
    point = operate(cl.build([f"law={law}", "piezoceramic.loss_tangent=0.01"]), belt)
    parts = ("output_power", "damping_power", "friction_power", "contact_power", "dielectric_power")
    left = point.value("active_power") - sum(point.value(name) for name in parts)
    # On an orbit nothing is stored.
    assert abs(left) <= open_by * point.value("active_power")
    assert left == pytest.approx(point.value("balance"), abs=1e-9)
    assert abs(point.value("balance")) <= 1.5 * point["balance"].error + 1e-12


@pytest.mark.parametrize("law", cases(["lagrange_stick", "hertz_penalty"], ["hertz_penalty"]))
def test_the_free_rotor_turns_where_the_curve_is_zero_but_for_its_ripple(law: str) -> None:
    data = sheet_of(f"law={law}")
    apart = abs(float(data["no_load_velocity"] - data["curve_root"]))
    assert apart <= float(the(data, "no load")["velocity_ripple"] + data["curve_root_error"])
    assert apart < 0.005 * data["no_load_velocity"]


def test_the_root_of_a_bent_curve_lies_within_its_error() -> None:
    def point(velocity: float) -> Point:
        numbers = {"velocity": (velocity, 0.0), "torque": (1.0 - velocity**8, 0.0)}
        return Point(velocity, "periodic", {key: cl.Estimate(*pair) for key, pair in numbers.items()})

    # The line from 0.9 to 2 crosses zero at 0.9025.
    value, error = root(map(point, (0.0, 0.9, 2.0)))
    assert abs(value - 1.0) <= error


def test_a_sheet_tells_the_root_of_its_curve_from_the_free_rotors_velocity() -> None:
    result = cl.characterise(cl.build(["law=hertz_penalty"]))
    root_of, free = (result.numbers[name] for name in ("curve_root", "no_load_velocity"))
    assert abs(root_of.value - free.value) > root_of.error + free.error
    assert any(f"{root_of.value:.6g}" in sentence for sentence in result.findings)
    # A heavy rotor has no ripple.
    heavy = cl.steady(cl.build(["law=hertz_penalty", "rotor.inertia=48"])).velocity
    assert abs(abs(heavy.value) - root_of.value) <= root_of.error + heavy.error


def test_a_rotor_under_the_load_of_a_point_turns_as_fast_as_the_belt_of_that_point() -> None:
    data = sheet_of("law=hertz_penalty")
    best = the(data, "power")
    # The sheet says which sign brakes in the model.
    load = float(data["sense"] * best["torque"])
    heavy = cl.build(["law=hertz_penalty", f"rotor.load_torque={load!r}", "rotor.inertia=4.8e-4"])
    velocity, _ = cl.steady(heavy).velocity
    assert float(data["sense"]) * velocity == pytest.approx(float(best["velocity"]), rel=2e-3)


def test_a_load_that_brakes_is_told_from_one_that_drives() -> None:
    data = sheet_of("law=hertz_penalty")
    for velocity, torque, load in zip(data["velocity"], data["torque"], data["load"].values, strict=True):
        if velocity < -0.01:
            assert (load, torque > 0.0) == ("turns the motor back", True)
        elif 0.01 < velocity < 0.99 * data["no_load_velocity"]:
            assert (load, torque > 0.0) == ("brakes", True)
        elif velocity > 1.01 * data["no_load_velocity"]:
            assert (load, torque > 0.0) == ("drives the motor on", False)


def test_the_motor_in_the_mirror_has_the_same_sheet_in_the_other_sense() -> None:
    each, other = (operate(cl.build(["law=hertz_penalty", f"drive.phase={phase}"]), belt) for phase, belt in (
        (-np.pi / 5.0, -1.0), (-np.pi / 5.0 + np.pi / 2.0, 1.0)))  # fmt: skip
    turned = each.turned(-1.0)
    for name in ("velocity", "torque", "output_power", "active_power", "apparent_power", "peak_force"):
        assert turned.value(name) == pytest.approx(other.value(name), rel=1e-6)


def test_damping_of_the_rotor_takes_its_share_of_the_torque_and_counts_as_damping() -> None:
    free = operate(cl.build(["law=hertz_penalty"]), -1.0)
    damped = operate(cl.build(["law=hertz_penalty", "rotor.damping=1e-3"]), -1.0)
    assert damped.value("torque") == pytest.approx(free.value("torque") + 1e-3, abs=1e-10)
    assert damped.value("damping_power") == pytest.approx(free.value("damping_power") + 1e-3, abs=1e-10)
    assert abs(damped.value("balance")) < 1e-10


def test_the_dielectric_lowers_the_electrical_efficiency_alone() -> None:
    lossless = operate(cl.build(["law=hertz_penalty"]), -1.0)
    lossy = operate(cl.build(["law=hertz_penalty", "piezoceramic.loss_tangent=0.01"]), -1.0)
    assert lossless.value("electrical_efficiency") == lossless.value("mechanical_efficiency")
    assert lossy.value("mechanical_efficiency") == lossless.value("mechanical_efficiency")
    share = lossy.value("drive_power") / (lossy.value("drive_power") + lossy.value("dielectric_power"))
    assert lossy.value("electrical_efficiency") == pytest.approx(share * lossy.value("mechanical_efficiency"))
    assert lossy.value("power_factor") > lossless.value("power_factor")


def test_the_error_of_a_number_covers_what_a_much_finer_step_makes_of_it() -> None:
    setup = cl.build(["law=lagrange_stick", "solver.contact_step=5e-8"])
    coarse = operate(setup, -1.0)
    assert setup.contact_step is not None
    fine = operate(replace(setup, contact_step=setup.contact_step / 8.0), -1.0)
    for name in ("torque", "drive_power", "friction_power", "contact_share", "apparent_power"):
        assert abs(coarse.value(name) - fine.value(name)) <= 2.0 * coarse[name].error, name
    # The force of an impact is its impulse over the step.
    assert np.isinf(coarse["peak_force"].error)


def test_a_rotor_without_drive_falls_as_its_damping_says_once_the_tip_has_left() -> None:
    velocity, damping = -2.0, 1e-3
    setup = cl.build(["law=hertz_penalty", f"rotor.damping={damping}", f"rotor.initial_velocity={velocity}"])
    (time, _), (coasting, _) = stop_time(setup, setup.motor, velocity)
    inertia = setup.motor.rotor.inertia
    assert time == pytest.approx(inertia / damping * np.log(10.0), rel=1e-6)
    assert coasting < 2.0
    free = cl.build(["law=hertz_penalty", f"rotor.initial_velocity={velocity}"])
    assert stop_time(free, free.motor, velocity)[0][0] == np.inf


def test_a_start_takes_as_long_as_a_recorded_run_shows() -> None:
    setup = cl.build(["law=hertz_penalty"])
    time, error = start_time(setup, -2.191)
    period = 1.0 / setup.motor.drive.frequency[0]
    run = setup.run(duration=1.1 * time, record_interval=period / 8.0)
    # Its mean over the period before, without the ripple.
    mean = (run.series["rotor_angle"][8:] - run.series["rotor_angle"][:-8]) / period
    there = run.time[8:][np.flatnonzero(mean <= -0.9 * 2.191)[0]] - 0.5 * period
    assert abs(there - time) < error + 0.25 * period
    assert start_time(cl.build(["contact.clearance=1e-4"]), -2.0)[0] == np.inf


@pytest.mark.parametrize("law", ["lagrange_stick", "hertz_penalty"])
def test_what_presses_the_tip_on_the_rotor_holds_it_without_drive(law: str) -> None:
    setup = cl.build([f"law={law}", "contact.clearance=0"])
    assert holding_torque(setup, 1.0)[0] == 0.0
    modes = setup.motor.modes
    pressed = replace(setup, motor=replace(setup.motor, preload=2.0 * modes.tip_displacement))
    # Of 2 N at the tip, what the rotor does not take bends the beam into a contact that gives way.
    flexibility = float(np.sum(modes.tip_displacement**2 / modes.stiffness))
    depth = {"lagrange_stick": lambda _: 0.0, "hertz_penalty": lambda n: (n / setup.law.stiffness) ** (2 / 3)}
    normal = brentq(lambda n: flexibility * (2.0 - n) - depth[law](n), 0.0, 2.0)
    torque, error = holding_torque(pressed, 1.0)
    assert torque == pytest.approx(0.3 * setup.motor.geometry.rotor_radius * normal, rel=1e-3)
    assert error < 1e-3 * torque


def test_a_root_lies_within_its_error_of_the_nearest_belt() -> None:
    def at(velocity: float, torque: float) -> Point:
        return Point(
            velocity, "periodic", {"velocity": cl.Estimate(velocity, 0.0), "torque": cl.Estimate(torque, 0.0)}
        )

    value, error = root([at(0.0, 4.0), at(1.0, 1.0), at(2.0, -1.0)])
    assert (value, error) == (1.5, 0.5)
    assert np.isnan(root([at(0.0, 1.0), at(1.0, 0.5)])[0])


def test_a_motor_that_does_not_touch_has_a_sheet_that_says_so() -> None:
    sheet = cl.characterise(cl.build(["contact.clearance=1e-4"]))
    assert sheet.data["sense"].item() == 0.0
    assert set(sheet.data["kind"].values.ravel()) == {"without contact"}
    assert np.isnan(sheet["stall_torque"]).all()
    assert sheet["active_power"].values[0, 0] > 0.0
    assert sheet.findings
    assert not sheet.study.figures(sheet.data)
    # Without a steady state it has not even that.
    numbers = {name: x * np.nan for name, x in sheet.data.data_vars.items() if x.dtype.kind == "f"}
    nothing = xarray.DataTree(sheet.data.to_dataset().assign(numbers))
    assert sheet.tables.keys() > sheet.study.tables(nothing).keys() == {"motor"}


def test_a_setup_with_a_load_is_refused_by_its_key() -> None:
    with pytest.raises(cl.ConfigurationError, match=r"rotor\.load_torque"):
        cl.characterise(cl.build(["rotor.load_torque=1e-3"]))
    with pytest.raises(cl.ConfigurationError):
        cl.characterise([])


# The command.


def test_the_command_leaves_page_figure_and_dataset_that_agree(command: Command, tmp_path: Path) -> None:
    folder = tmp_path / "sheet"
    status, out, err = command("characterise", "law=hertz_penalty", f"output={folder}")
    assert (status, err) == (0, "")
    assert out.isascii()
    expected = cl.characterise(cl.build(["law=hertz_penalty"]))
    assert repr(expected) in out
    with xarray.open_dataset(folder / "characterise.nc") as data:
        assert data["torque"].attrs["units"] == "N m"
        assert {"torque_error", "kind", "role", "load", "sense"} <= set(data.variables)
        xarray.testing.assert_equal(data["torque"], expected["torque"])
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert all(finding[:40] in page for finding in expected.findings)
    assert page.count("<img") == 1
    assert "http" not in page
    assert (folder / "motor.csv").read_text().splitlines()[0] == (
        "quantity,unit,hertz_penalty,error of hertz_penalty"
    )


@pytest.mark.parametrize(
    ("overrides", "key"),
    [
        (("--law", "newton"), "--law"),
        (("law=newton,nothing",), "nothing"),
        (("rotor.load_torque=1e-3",), "rotor.load_torque"),
        (("drive.frequency_ratio=1.41421356",), "frequency"),
        (("drive.frequency_ratio",), "drive.frequency_ratio"),
    ],
)
def test_the_command_refuses_by_the_key(
    command: Command, tmp_path: Path, overrides: tuple[str, ...], key: str
) -> None:
    status, _, err = command("characterise", *overrides, f"output={tmp_path / 'sheet'}")
    assert status == 2
    assert key in err
    assert not (tmp_path / "sheet").exists()


@pytest.mark.parametrize("belt", [None, 0.1])
def test_what_a_pressed_motor_stores_off_its_orbit_is_in_the_balance(belt: float | None) -> None:
    """The rotor on its bearing has no strain energy, and lifting it is work against the preload."""
    setup = cl.build(["law=hertz_penalty", "contact.preload=5", "rotor.bearing_damping=300"])
    orbit = cl.steady(setup, belt=belt).details.orbit
    run = orbit.map.run(1.5 * orbit.state, 3.0, 128)
    numbers = Periods(orbit.map, run, 128, None).numbers()
    assert abs(numbers["balance"].value) < 1e-8 * numbers["drive_power"].value
