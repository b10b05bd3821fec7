"""Claims on files of measured impacts that are refused, each with its name and the column."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas
import pytest
import scipy.io
import xarray
from data_support.measured_files import BODY, body_file
from data_support.measured_impacts import drawn_bodies, drawn_impacts

from contactlab_data.measured.bodies import BodyImpacts
from contactlab_data.measured.files import MeasurementError, read_impacts, write_impacts

CONTACT = {
    "tt": "# delassus_tt: 100 kg-1",
    "nn": "# delassus_nn: 30 kg-1",
    "header": "before_gap_rate [m/s],before_slip [m/s],after_gap_rate [m/s],after_slip [m/s]",
    "first": "-1,0.5,0.6,0.4",
    "second": "-2,0.5,1.2,0.3",
}
HEADER, FIRST, SECOND = BODY["header"], BODY["first"], BODY["second"]
EXACT = "".join(f"# error_after_{q}: 0 {u}/s\n" for q, u in (("x", "m"), ("y", "m"), ("turn", "rad")))


def more(name: str, first: str, second: str) -> dict[str, str]:
    """Another column of a file of bodies."""
    return {"header": f"{HEADER},{name}", "first": f"{FIRST},{first}", "second": f"{SECOND},{second}"}


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"header": HEADER.replace("before_y [m/s]", "before_y")}, "before_y"),
        ({"header": HEADER.replace("_y [m/s]", "_y []")}, "before_y"),
        ({"header": HEADER.replace("[m/s]", "(m/s)")}, "before_x"),
        ({"header": HEADER.replace("_turn [rad/s]", "_turn [1/s]")}, "before_turn"),
        ({"header": HEADER.replace("after_turn [rad/s]", "after_turn [m/s]")}, "after_turn"),
        ({"header": HEADER.replace("_x [m/s]", "_x [parsec]")}, "before_x"),
        ({"mass_turn": "# mass_turn: 18 g"}, "mass_turn"),
        ({"mass_x": "# mass_x: 0.04"}, "mass_x"),
        ({"mass_x": ""}, "mass_x"),
        ({"mass_x": "# mas_x: 40 g"}, "'mas_x'.*mass_x"),
        ({"mass_x": "# mass_x: -40 g"}, "mass matrix of line 12"),
        ({"mass_x": "# mass_x: 40 g\n# mass_x_y: 0.05 kg"}, "mass matrix"),
        ({"mass_x": "# mass_x: 40 g\n# mass_x: 41 g"}, "mass_x"),
        ({"mass_x": "# mass_x_y: 0 g\n# mass_y_x: 0 g\n# mass_x: 1 g"}, "mass_x_y and mass_y_x"),
        ({"unit": "# mass_x [g]: 40 g", "mass_x": ""}, "mass_x"),
        ({"normal_turn": ""}, "normal_turn"),
        ({"tangential_x": ""}, "tangential_x"),
        ({"normal_y": "# normal_y: -1"}, "normal"),
        ({"first": FIRST.replace("-2", "2")}, "gap rate.*line 12.*flag"),
        ({"first": FIRST.replace("1.05", "-1"), "second": SECOND.replace("1.03", "-1")}, "after"),
        *(({"first": FIRST.replace("1.05", x)}, "after_y.*line 12") for x in ("nan", "", "1_05", "1e200")),
        ({"first": FIRST + ",1"}, "line 12"),
        ({"first": FIRST.replace(".", ",")}, "line 12"),
        ({"error": "# error_aftr_x: 1 m/s"}, "error_aftr_x"),
        ({"header": HEADER.replace("before_x", "before_z")}, "before_x"),
        ({"header": HEADER.replace("after_x", "before_x")}, "before_x"),
        ({"header": HEADER.replace("before", "pre").replace("after", "post")}, "before_NAME"),
        ({"header": "", "first": "", "second": ""}, "names"),
        ({"first": "", "second": ""}, "row"),
        ({"error": "# error_after_x: 1 mm/s"}, "error_after_y"),
        ({"error": "# error_after_x: -1 mm/s"}, "error_after_x"),
        ({"error": EXACT.replace("after", "before")}, "error_after"),
        ({"error": EXACT + "# covariance_after_x_y: 1 m2 s-2"}, "covariance_after"),
        ({"jacobian": "# jacobian: fine"}, "jacobian"),
        (more("impact", "1", "1"), "impact"),
        (more("impact", "1.5", "1"), "impact.*line 12"),
        (more("measurement", "1.5", "1"), "measurement.*line 12"),
        (more("flag", "maybe", "1"), "flag.*line 12"),
        (more("flag", "1", "1"), "2 impacts"),
        (more("", "7", "8"), "line 12"),
    ],
)
def test_a_faulty_file_of_bodies_is_refused(tmp_path: Path, changed: dict[str, str], named: str) -> None:
    with pytest.raises(MeasurementError, match=rf"drops\.csv.*{named}"):
        read_impacts(body_file(tmp_path, **changed))


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"nn": ""}, "delassus_nn"),
        ({"tt": ""}, "delassus_tt"),
        ({"nn": "# delassus_nn: -1 1/kg"}, "Delassus matrix of line 4"),
        ({"nt": "# delassus_nt: 60 1/kg"}, "Delassus"),
        ({"nn": "# delassus_nn: 30 kg"}, "delassus_nn"),
        ({"mass": "# mass_slip: 1 kg"}, "mass_slip"),
        ({"jacobian": "# jacobian: checked"}, "jacobian"),
        ({"energy": "# kinetic_energy: 0.01 J"}, "kinetic_energy.*line 4"),
        ({"energy": "# outside_energy: -1 mJ"}, "outside_energy"),
        ({"header": CONTACT["header"].replace("slip", "x")}, "velocities of x"),
        (
            {"header": "before_gap_rate [m/s],after_gap_rate [m/s]", "first": "-1,1", "second": "-1,1"},
            "delassus_tt",
        ),
        (
            {"header": "before_slip [m/s],after_slip [m/s]", "first": "1,1", "second": "1,1"},
            "before_gap_rate",
        ),
    ],
)
def test_a_faulty_file_of_contacts_is_refused(tmp_path: Path, changed: dict[str, str], named: str) -> None:
    path = tmp_path / "drops.csv"
    path.write_text("\n".join(line for line in (CONTACT | changed).values() if line))
    with pytest.raises(MeasurementError, match=rf"drops\.csv.*{named}"):
        read_impacts(path)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"PK\x03\x04\0\0",
        "# source: M\u00fcller\na\n".encode("latin-1"),
        b"\x89HDF\r\n\x1a\n and no more",
        b"MATLAB 5.0 MAT-file" + bytes(200),
    ],
)
def test_another_kind_of_file_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "drops.any"
    path.write_bytes(content)
    with pytest.raises(MeasurementError, match=r"drops\.any"):
        read_impacts(path)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda data: data.rename(after_slip="slip_after"), "slip_after"),
        (lambda data: data.drop_vars("after_slip"), "after_slip"),
        (lambda data: data.assign(after_slip=("hit", [1.0, 2.0], {"units": "m/s"})), "after_slip"),
        (lambda data: data.assign(after_slip=("impact", [1.0, np.nan, 1.0])), "after_slip"),
        (lambda data: data.where(data["impact"] != 5), "row 2 of 3"),
        (lambda data: data.assign(velocity=(("impact", "way"), np.ones((3, 2)))), "velocity"),
        (lambda data: data.isel(impact=slice(0, 0)), "row"),
    ],
)
def test_a_faulty_netcdf_is_refused(tmp_path: Path, change: object, named: str) -> None:
    columns = {"before_gap_rate": -1.0, "after_gap_rate": 1.0, "before_slip": 0.5, "after_slip": 0.4}
    data = xarray.Dataset(
        {name: ("impact", [value] * 3, {"units": "m/s"}) for name, value in columns.items()}
        | {name: ("impact", [30.0] * 3, {"units": "1/kg"}) for name in ("delassus_nn", "delassus_tt")},
        coords={"impact": [4, 5, 6]},
    )
    path = tmp_path / "bad.nc"
    change(data).to_netcdf(path)
    with pytest.raises(MeasurementError, match=rf"bad\.nc.*{named}"):
        read_impacts(path)


def test_another_matlab_file_is_refused(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "other.mat", {"bounce_array": np.eye(2)})
    with pytest.raises(MeasurementError, match=r"other\.mat"):
        read_impacts(tmp_path / "other.mat")


def test_a_file_of_another_format_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"\.xlsx"):
        write_impacts(drawn_impacts(2, 1), tmp_path / "impacts.xlsx")
    assert not list(tmp_path.iterdir())


def written(bodies: BodyImpacts, path: Path, **more: float) -> Path:
    """Write bodies as their columns, with errors of the velocity after if any."""
    columns = {}
    for at, name in enumerate(("x", "y", "turn")):
        velocity, arm, inertia = ("rad/s", " [m]", "kg m^2") if name == "turn" else ("m/s", "", "kg")
        columns[f"before_{name} [{velocity}]"] = bodies.before[:, at]
        columns[f"after_{name} [{velocity}]"] = bodies.after[:, at]
        columns[f"normal_{name}{arm}"] = bodies.normal[:, at]
        columns[f"tangential_{name}{arm}"] = bodies.tangential[:, at]
        columns[f"mass_{name} [{inertia}]"] = bodies.mass[:, at, at]
        if name in more:
            columns[f"error_after_{name} [{velocity}]"] = np.full(len(bodies.before), more[name])
    pandas.DataFrame(columns).to_csv(path, index=False)
    return path


@pytest.mark.parametrize("count", [3, 300])
@pytest.mark.parametrize("row", ["tangential", "normal"])
def test_the_arm_of_the_wrong_sign_is_named(tmp_path: Path, row: str, count: int) -> None:
    bodies = drawn_bodies(count, 4, noise=1e-3)
    read_impacts(written(bodies, tmp_path / "right.csv"))
    getattr(bodies, row)[:, 2] *= -1.0
    with pytest.raises(MeasurementError, match=f"{row}_turn"):
        read_impacts(written(bodies, tmp_path / "wrong.csv"))


def test_a_jacobian_that_is_stated_to_be_right_is_kept(tmp_path: Path) -> None:
    bodies = drawn_bodies(30, 4, noise=1e-3)
    bodies.tangential[:, 2] *= -1.0
    path = written(bodies, tmp_path / "impacts.csv")
    path.write_text("# jacobian: checked\n" + path.read_text())
    assert read_impacts(path).delassus == pytest.approx(bodies.delassus(), rel=1e-12)


def test_a_right_jacobian_is_never_refused_for_its_noise(tmp_path: Path) -> None:
    """Few impacts and much noise: another sign may be better by chance, and is not taken for it."""
    for seed in range(40):
        bodies = drawn_bodies(4, seed, noise=0.15)
        if (bodies.contact(bodies.after)[:, 0] > 0.0).all():
            read_impacts(written(bodies, tmp_path / "impacts.csv"))


def test_what_the_stated_errors_explain_is_no_wrong_sign(tmp_path: Path) -> None:
    bodies = drawn_bodies(400, 8, noise=0.05)
    errors = {"x": 0.05, "y": 0.05, "turn": 0.05 / np.sqrt(1.7e-5 / 0.04)}
    read_impacts(written(bodies, tmp_path / "impacts.csv", **errors))
    covariance = np.broadcast_to(np.diag(np.array(list(errors.values())) ** 2), (400, 3, 3))
    # The median of the square of one error is 0.455 of its mean.
    explained = replace(bodies, covariance=covariance).share_of_errors()
    assert bodies.outside_share() == pytest.approx(0.455 * explained, rel=0.2)


def test_errors_that_are_stated_decide_how_much_is_too_much(tmp_path: Path) -> None:
    """A wrong sign that they could hide is noted, and one that they cannot is refused."""
    bodies = drawn_bodies(100, 4, noise=1e-3)
    bodies.tangential[:, 2] *= -1.0
    path, small, large = tmp_path / "impacts.csv", 1e-3, 1.0
    turn = 1.0 / np.sqrt(1.7e-5 / 0.04)
    with pytest.raises(MeasurementError, match="tangential_turn"):
        read_impacts(written(bodies, path, x=small, y=small, turn=small * turn))
    assert read_impacts(written(bodies, path, x=large, y=large, turn=large * turn)).notes
