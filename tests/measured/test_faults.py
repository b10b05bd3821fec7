"""Bad files of measured impacts: each ends in a sentence with the file, the place and the way out."""

from pathlib import Path

import numpy as np
import pandas
import pytest
import scipy.io
import xarray
from support.measured_files import BODY, body_file
from support.measured_impacts import drawn_bodies, drawn_impacts

from contactlab.measured.files import read_impacts, write_impacts
from contactlab.measured.reduction import BodyImpacts

CONTACT = {
    "tt": "# delassus_tt: 100 kg-1",
    "nn": "# delassus_nn: 30 kg-1",
    "header": "before_gap_rate [m/s],before_slip [m/s],after_gap_rate [m/s],after_slip [m/s]",
    "first": "-1,0.5,0.6,0.4",
    "second": "-2,0.5,1.2,0.3",
}
HEADER, FIRST, SECOND = BODY["header"], BODY["first"], BODY["second"]


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        (
            {"header": HEADER.replace("before_y [m/s]", "before_y")},
            ["before_y", "has no unit", "before_y [m/s]"],
        ),
        ({"header": HEADER.replace("_y [m/s]", "_y []")}, ["before_y has no unit", "m/s"]),
        ({"header": HEADER.replace("[m/s]", "(m/s)")}, ["'before_x (m/s)'", "'before_x [m/s]'"]),
        ({"header": HEADER.replace("_turn [rad/s]", "_turn [1/s]")}, ["'1/s'", "no velocity", "rad/s"]),
        ({"header": HEADER.replace("after_turn [rad/s]", "after_turn [m/s]")}, ["after_turn", "rad/s"]),
        ({"header": HEADER.replace("_x [m/s]", "_x [kg]")}, ["before_x is in 'kg'", "m/s"]),
        ({"header": HEADER.replace("_x [m/s]", "_x [parsec]")}, ["before_x", "'parsec'"]),
        ({"mass_turn": "# mass_turn: 18 g"}, ["mass_turn is in 'g'", "kg m^2"]),
        ({"mass_x": "# mass_x: 0.04"}, ["mass_x has no unit", "mass_x [kg]."]),
        ({"mass_x": ""}, ["mass_x is missing", "mass_x [kg]"]),
        ({"mass_x": "# mas_x: 40 g"}, ["'mas_x'", "Did you mean mass_x?"]),
        ({"mass_x": "# mass_x: -40 g"}, ["mass matrix", "line 12", "not positive definite"]),
        ({"mass_x": "# mass_x: 40 g\n# mass_x_y: 0.05 kg"}, ["mass matrix", "not positive definite"]),
        ({"mass_x": "# mass_x: 40 g\n# mass_x: 41 g"}, ["'mass_x' is given a second time", "line 3"]),
        (
            {"mass_x": "# mass_x_y: 0 g\n# mass_y_x: 0 g\n# mass_x: 1 g"},
            ["mass_x_y and mass_y_x", "one will do"],
        ),
        ({"normal_turn": ""}, ["normal_turn is missing", "normal_turn [m/rad]"]),
        ({"tangential_x": ""}, ["tangential_x is missing"]),
        ({"normal_x": "# normal_x: 1", "normal_y": "# normal_y: 0"}, ["gap rate before", "normal_NAME"]),
        ({"normal_y": "# normal_y: -1"}, ["gap rate", "2 of 2 impacts", "reverse the columns normal_NAME"]),
        ({"first": FIRST.replace("-2", "2")}, ["line 12", "1 of 2 impacts", "flag"]),
        (
            {"first": FIRST.replace("1.05", "-1"), "second": SECOND.replace("1.03", "-1")},
            ["pass through each"],
        ),
        ({"first": FIRST.replace("1.05", "nan")}, ["after_y is 'nan'", "line 12", "flag"]),
        ({"first": FIRST.replace("1.05", "")}, ["after_y is empty", "line 12"]),
        ({"first": FIRST.replace("1.05", "1.0.5")}, ["after_y is '1.0.5'", "line 12"]),
        ({"first": FIRST.replace("1.05", "1_05")}, ["after_y is '1_05'", "line 12"]),
        ({"first": FIRST.replace("1.05", "1e200")}, ["after_y is '1e200'", "line 12"]),
        ({"first": FIRST.replace("1.05", "inf")}, ["after_y is 'inf'", "line 12"]),
        ({"first": FIRST + ",1"}, ["line 12 has 7 cells and the header 6"]),
        ({"first": FIRST.replace(".", ",")}, ["line 12 has", "decimal commas", "semicolons"]),
        ({"error": "# error_aftr_x: 1 m/s"}, ["'error_aftr_x'", "Did you mean error_after_x?"]),
        ({"header": HEADER.replace("before_x", "befor_x")}, ["'befor_x'", "Did you mean before_x?"]),
        ({"header": HEADER.replace("before_x", "before_z")}, ["before_x is missing"]),
        ({"header": HEADER.replace("after_x", "before_x")}, ["'before_x' is there 2 times"]),
        (
            {"header": HEADER.replace("before", "pre").replace("after", "post")},
            ["no velocities", "before_NAME"],
        ),
        ({"header": "", "first": "", "second": ""}, ["no line with the names"]),
        ({"first": "", "second": ""}, ["no impacts", "at least one"]),
        ({"error": "# error_after_x: 1 mm/s"}, ["error_after_y is missing"]),
        ({"error": "# error_before_x: 1 mm/s"}, ["error_before_y is missing"]),
        (
            {
                "error": "".join(
                    f"# error_after_{q}: 0 {u}/s\n" for q, u in (("x", "m"), ("y", "m"), ("turn", "rad"))
                )
                + "# covariance_after_x_y: 1 m2 s-2"
            },
            ["covariance", "line 12", "negative eigenvalue", "covariance_after_NAME_OTHER"],
        ),
        ({"jacobian": "# jacobian: fine"}, ["'jacobian' is 'fine'", "'checked'"]),
        ({"unit": "# mass_x [g]: 40 g", "mass_x": ""}, ["'mass_x' has two units"]),
        (
            {"header": HEADER + ",impact", "first": FIRST + ",1", "second": SECOND + ",1"},
            ["impact is 1 in 2 rows"],
        ),
        ({"header": HEADER + ",impact", "first": FIRST + ",1.5", "second": SECOND + ",1"}, ["whole number"]),
        (
            {"header": HEADER + ",flag", "first": FIRST + ",maybe", "second": SECOND + ",1"},
            ["'maybe'", "line 12"],
        ),
        ({"header": HEADER + ",flag", "first": FIRST + ",1", "second": SECOND + ",1"}, ["2 impacts", "none"]),
        ({"header": HEADER + ",", "first": FIRST + ",7", "second": SECOND + ",8"}, ["line 12 has 7 cells"]),
    ],
)
def test_a_bad_file_of_bodies_is_told_in_a_sentence(
    tmp_path: Path, changed: dict[str, str], told: list[str]
) -> None:
    with pytest.raises(ValueError, match=r"drops\.csv") as fault:
        read_impacts(body_file(tmp_path, **changed))
    for word in told:
        assert word in str(fault.value), str(fault.value)
    assert str(fault.value).endswith((".", "?"))


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"nn": ""}, ["delassus_nn is missing", "delassus_nn [1/kg]"]),
        ({"tt": ""}, ["delassus_tt is missing"]),
        ({"nn": "# delassus_nn: -1 1/kg"}, ["Delassus", "line 4", "not positive definite"]),
        ({"nt": "# delassus_nt: 60 1/kg"}, ["Delassus", "not positive definite"]),
        ({"nn": "# delassus_nn: 30 kg"}, ["delassus_nn is in 'kg'", "1/kg"]),
        ({"first": "1,0.5,0.6,0.4", "second": "2,0.5,1.2,0.3"}, ["2 of 2", "reverse the gap rates"]),
        ({"mass": "# mass_slip: 1 kg"}, ["'mass_slip' beside velocities of the contact"]),
        ({"jacobian": "# jacobian: checked"}, ["'jacobian' is given, and there is none"]),
        ({"energy": "# kinetic_energy: 0.01 J"}, ["kinetic_energy is 0.01 J", "line 4", "at least"]),
        ({"energy": "# outside_energy: -1 mJ"}, ["outside_energy is -0.001 J", "not be negative"]),
        ({"header": CONTACT["header"].replace("slip", "x")}, ["delassus_", "velocities of gap_rate, x"]),
        (
            {"header": "before_gap_rate [m/s],after_gap_rate [m/s]", "first": "-1,1", "second": "-1,1"},
            ["delassus_tt is given, and no slip"],
        ),
        (
            {"header": "before_slip [m/s],after_slip [m/s]", "first": "1,1", "second": "1,1"},
            ["before_gap_rate"],
        ),
    ],
)
def test_a_bad_file_of_contacts_is_told_in_a_sentence(
    tmp_path: Path, changed: dict[str, str], told: list[str]
) -> None:
    path = tmp_path / "drops.csv"
    path.write_text("\n".join(line for line in (CONTACT | changed).values() if line))
    with pytest.raises(ValueError, match=r"drops\.csv") as fault:
        read_impacts(path)
    for word in told:
        assert word in str(fault.value), str(fault.value)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "no line with the names"),
        (b"PK\x03\x04\0\0", "Save a spreadsheet as CSV"),
        ("# source: Müller\na\n".encode("latin-1"), "line 1 has a character that is not UTF-8"),
        (b"\x89HDF\r\n\x1a\n and no more", "cannot be read as netCDF"),
        (b"MATLAB 5.0 MAT-file" + bytes(200), "cannot be read as a MATLAB file"),
    ],
)
def test_what_is_no_such_file_is_told(tmp_path: Path, content: bytes, told: str) -> None:
    path = tmp_path / "drops.any"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"drops\.any.*" + told):
        read_impacts(path)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda data: data.rename(after_slip="slip_after"), "'slip_after'.*Did you mean after_slip"),
        (lambda data: data.drop_vars("after_slip"), "after_slip is missing"),
        (lambda data: data.assign(after_slip=("hit", [1.0, 2.0])), "after_slip lies along hit"),
        (lambda data: data.assign(after_slip=("impact", [1.0, np.nan, 1.0])), "after_slip.*has no unit"),
        (lambda data: data.where(data["impact"] != 5), "is 'nan'.*impact 2 of 3 in the file"),
        (
            lambda data: data.assign(velocity=(("impact", "way"), np.ones((3, 2)))),
            r"velocity.*\(impact, way\)",
        ),
        (lambda data: data.isel(impact=slice(0, 0)), "at least one"),
    ],
)
def test_a_bad_netcdf_is_told_in_a_sentence(tmp_path: Path, change: object, told: str) -> None:
    columns = {"before_gap_rate": -1.0, "after_gap_rate": 1.0, "before_slip": 0.5, "after_slip": 0.4}
    data = xarray.Dataset(
        {name: ("impact", [value] * 3, {"units": "m/s"}) for name, value in columns.items()}
        | {name: ("impact", [30.0] * 3, {"units": "1/kg"}) for name in ("delassus_nn", "delassus_tt")},
        coords={"impact": [4, 5, 6]},
    )
    path = tmp_path / "bad.nc"
    change(data).to_netcdf(path)
    with pytest.raises(ValueError, match=r"(?s)bad\.nc.*" + told):
        read_impacts(path)


def test_another_matlab_file_is_told_from_the_published_one(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "other.mat", {"bounce_array": np.eye(2)})
    with pytest.raises(ValueError, match=r"other\.mat.*without the ellipse impacts.*CSV or netCDF"):
        read_impacts(tmp_path / "other.mat")


def test_a_file_is_written_as_what_its_name_says_or_not_at_all(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"ends in '\.xlsx'; it must end in \.csv or \.nc"):
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
    with pytest.raises(ValueError, match=rf"with the sign of {row}_turn reversed\. Reverse that column"):
        read_impacts(written(bodies, tmp_path / "wrong.csv"))


def test_who_says_that_the_jacobian_is_right_keeps_it_and_is_told(tmp_path: Path) -> None:
    bodies = drawn_bodies(30, 4, noise=1e-3)
    bodies.tangential[:, 2] *= -1.0
    path = written(bodies, tmp_path / "impacts.csv")
    path.write_text("# jacobian: checked\n" + path.read_text())
    found = read_impacts(path)
    assert "with the sign of tangential_turn reversed" in found.notes[0]
    assert found.delassus == pytest.approx(bodies.delassus(), rel=1e-12)


def test_a_right_jacobian_is_never_refused_for_its_noise(tmp_path: Path) -> None:
    """Few impacts and much noise: another sign may be better by chance, and is not taken for it."""
    for seed in range(40):
        bodies = drawn_bodies(4, seed, noise=0.15)
        if (bodies.contact(bodies.after)[:, 0] > 0.0).all():
            read_impacts(written(bodies, tmp_path / "impacts.csv"))


def test_what_the_stated_errors_explain_is_no_wrong_sign(tmp_path: Path) -> None:
    """An arm of a millimetre and an error of a tenth: the sign is lost in it, and the errors say so."""
    bodies = drawn_bodies(400, 8, noise=0.05)
    errors = {"x": 0.05, "y": 0.05, "turn": 0.05 / np.sqrt(1.7e-5 / 0.04)}
    found = read_impacts(written(bodies, tmp_path / "impacts.csv", **errors))
    share = bodies.outside_share()
    explained = float(found.notes[0].split("explain ")[1].split(" %")[0]) / 100.0
    # The median of the square of one error is 0.455 of its mean.
    assert share == pytest.approx(0.455 * explained, rel=0.2)


def test_errors_that_are_stated_decide_how_much_is_too_much(tmp_path: Path) -> None:
    """A wrong sign that they could hide is noted, and one that they cannot is refused."""
    bodies = drawn_bodies(100, 4, noise=1e-3)
    bodies.tangential[:, 2] *= -1.0
    path, small, large = tmp_path / "impacts.csv", 1e-3, 1.0
    turn = 1.0 / np.sqrt(1.7e-5 / 0.04)
    with pytest.raises(ValueError, match=r"the stated errors explain .* with the sign of tangential_turn"):
        read_impacts(written(bodies, path, x=small, y=small, turn=small * turn))
    found = read_impacts(written(bodies, path, x=large, y=large, turn=large * turn))
    assert "it would be" in found.notes[0]
