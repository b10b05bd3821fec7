"""Claims on files of measured impacts: units, layouts and formats, and that written files are read again."""

import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pandas
import pytest
import xarray
from data_support.measured_files import BODY, body_file
from data_support.measured_impacts import drawn_bodies, drawn_impacts
from hypothesis import HealthCheck, given, settings, strategies as st

from contactlab_data.measured.bodies import BodyImpacts
from contactlab_data.measured.columns import BODY_COLUMNS, CONTACT_COLUMNS, OTHER_COLUMNS, Column
from contactlab_data.measured.files import read_impacts, write_impacts
from contactlab_data.measured.impacts import MeasuredImpacts

PAGE = Path(__file__).resolve().parents[4] / "docs" / "measured_data.md"
WORD = st.text(st.characters(categories=("L", "N", "P", "Zs"), exclude_characters='"#'), max_size=20).map(
    str.strip
)


def same(
    first: MeasuredImpacts | BodyImpacts, other: MeasuredImpacts | BodyImpacts, but: tuple[str, ...] = ()
) -> bool:
    """Return whether two have the same bits."""
    names = [field.name for field in fields(first) if field.name not in but]
    pairs = [(getattr(first, name), getattr(other, name)) for name in names]
    return all(
        np.array_equal(a, b)
        if isinstance(a, np.ndarray)
        else same(a, b)
        if isinstance(a, BodyImpacts) and isinstance(b, BodyImpacts)
        else a == b
        for a, b in pairs
    )


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(1, 12), st.integers(0, 10**6), st.booleans(), WORD, WORD, st.sampled_from([".csv", ".nc"]))
def test_what_is_written_is_read_again_to_the_last_bit(
    tmp_path: Path, count: int, seed: int, covariance: bool, title: str, source: str, suffix: str
) -> None:
    made = drawn_impacts(count, seed, covariance=covariance)
    path = tmp_path / f"impacts{suffix}"
    made = replace(made, title=title or "impacts", source=source, notes=("One.", "Two, of it."))
    made = replace(made, measurement=np.arange(count) // 2 if seed % 2 else None)
    write_impacts(made, path)
    result = read_impacts(path)
    assert same(made, result, but=("notes",))
    assert result.notes[:2] == made.notes
    write_impacts(result, path)
    assert same(result, read_impacts(path))


def test_the_delassus_matrix_is_that_of_a_computation_by_hand(tmp_path: Path) -> None:
    """1/m + c^2/I on the diagonal, c_n c_t / I off it; u = G v."""
    result = read_impacts(body_file(tmp_path))
    expected = [[1 / 0.04 + 4e-6 / 1.8e-5, 6e-5 / 1.8e-5], [6e-5 / 1.8e-5, 1 / 0.04 + 9e-4 / 1.8e-5]]
    assert result.delassus == pytest.approx(np.array([expected, expected]), rel=1e-14)
    assert result.velocity_before == pytest.approx(np.array([[-2.0, 0.5], [-1.906, 0.01]]), rel=1e-14)
    assert result.kinetic_energy == pytest.approx(
        [0.02 * 4.25, 0.02 * (0.01 + 3.61) + 0.9e-5 * 9.0], rel=1e-14
    )
    assert result.velocity_after[0] == pytest.approx([1.05 + 2e-3 * 2.3, 0.32 + 0.03 * 2.3], rel=1e-14)
    assert result.covariance is None
    assert (result.title, result.left_out, result.number.tolist()) == ("Two drops", 0, [1, 2])


def test_the_error_is_that_of_the_bodies_in_the_norm_of_the_kinetic_energy() -> None:
    """||v+ - v+_predicted||_M / ||v-||_M, whatever impulse is predicted; so is the part that none reaches."""
    bodies, impacts = drawn_bodies(40, 2, noise=0.1), drawn_impacts(40, 2)
    made = replace(
        impacts,
        delassus=bodies.delassus(),
        velocity_before=bodies.contact(bodies.before),
        velocity_after=bodies.contact(bodies.after),
        kinetic_energy=bodies.energy(bodies.before),
        outside=bodies.outside(),
    )
    impulse = np.random.default_rng(1).normal(0.1, 0.05, (40, 2))
    jump = np.linalg.solve(bodies.mass, bodies.jacobian.transpose(0, 2, 1) @ impulse[..., None])[..., 0]
    predicted = bodies.before + jump
    expected = np.sqrt(bodies.energy(bodies.after - predicted) / bodies.energy(bodies.before))
    assert made.errors(bodies.contact(predicted)) == pytest.approx(expected, rel=1e-10)


def test_units_rows_and_columns_may_come_in_any_order(tmp_path: Path) -> None:
    expected = read_impacts(body_file(tmp_path))
    turned = read_impacts(
        body_file(
            tmp_path,
            mass_turn="# mass_turn [g mm^2]: 18000",
            normal_turn="# normal_turn: 0.002 m/rad",
            header="after_turn [rad s-1],before_y [mm/s],before_turn [deg/s],after_x [m s^-1],"
            "after_y [m/s],before_x [cm/s],impact",
            first=f"-2.5,-1900,{np.degrees(-3.0)},0.09,1.03,10,2",
            second="2.3,-2000,0,0.32,1.05,50,1",
        )
    ).part(np.array([1, 0]))
    for name in ("delassus", "velocity_before", "velocity_after", "kinetic_energy", "number"):
        assert getattr(turned, name) == pytest.approx(getattr(expected, name), rel=1e-13)
    assert turned.outside == pytest.approx(expected.outside, rel=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        "\ufeff" + "\r\n".join(BODY.values()),
        "\n\n".join(BODY.values()) + ",,,",
        "\n".join(BODY.values()).replace(",", ";").replace(".", ","),
        "\n".join(BODY.values()).replace(",", "\t"),
        "\n".join(f'"{line}",,,,,' if line[0] == "#" else line for line in BODY.values()),
        "\n".join(line + ",,,,," if line[0] == "#" else line for line in BODY.values()),
        "\r".join(BODY.values()).replace(",", " , "),
    ],
    ids=["mark and Windows", "empty lines", "semicolons", "tabulators", "quoted", "filled", "old Macintosh"],
)
def test_tables_as_spreadsheets_write_them_are_read(tmp_path: Path, text: str) -> None:
    """With decimal commas the comments have them too, and are numbers of all impacts still."""
    expected = read_impacts(body_file(tmp_path))
    path = tmp_path / "drops.csv"
    path.write_bytes(text.encode())
    assert same(expected, read_impacts(path))


def test_a_column_may_be_given_for_each_impact_or_once_for_all(tmp_path: Path) -> None:
    expected = read_impacts(body_file(tmp_path))
    each = body_file(
        tmp_path,
        mass_x="",
        normal_turn="",
        header=f"{BODY['header']},mass_x [kg],normal_turn [m]",
        first=f"{BODY['first']},0.04,0.002",
        second=f"{BODY['second']},4e-2,2e-3",
    )
    assert same(expected, read_impacts(each))


def test_flagged_impacts_are_counted_and_not_looked_at(tmp_path: Path) -> None:
    header = f"{BODY['header']},flag,flag_bounced"
    path = body_file(
        tmp_path,
        header=header,
        first=",,,,broken,,1,",
        second=f"{BODY['second']},,FALSE",
        third="nan,1,1,1,1,1,0,true",
    )
    result = read_impacts(path)
    assert (len(result), result.left_out, result.number.tolist()) == (1, 2, [2])


def test_two_bodies_with_six_coordinates_are_one_contact(tmp_path: Path) -> None:
    """The Delassus matrices of two bodies add up, and a body that nothing moves adds nothing."""
    masses, arms = {"a": 0.04, "b": 0.1}, {"a": 0.01, "b": -0.02}
    columns: dict[str, object] = {}
    for body, mass in masses.items():
        side = 1.0 if body == "a" else -1.0
        row = {"x": (0.0, side), "y": (side, 0.0), "turn": (side * 0.005, side * arms[body])}
        for name, (normal, tangential) in row.items():
            angle, coordinate = name == "turn", f"{name}{body}"
            velocity = "rad/s" if angle else "m/s"
            value = -1.0 if coordinate == "ya" else 0.0
            columns[f"before_{coordinate}"] = ("hit", [value], {"units": velocity})
            columns[f"after_{coordinate}"] = ("hit", [-0.5 * value], {"units": velocity})
            units = "kg m2" if angle else "kg"
            columns[f"mass_{coordinate}"] = ((), mass * (1e-4 if angle else 1.0), {"units": units})
            columns[f"normal_{coordinate}"] = ((), normal, {"units": "m"} if angle else {})
            columns[f"tangential_{coordinate}"] = ((), tangential, {"units": "m"} if angle else {})
    path = tmp_path / "two.nc"
    xarray.Dataset(columns, attrs={"jacobian": "checked", "history": "any tool"}).to_netcdf(path)
    result = read_impacts(path)
    nn = sum(1 / mass + 0.005**2 / (1e-4 * mass) for mass in masses.values())
    tt = sum(1 / mass + arms[body] ** 2 / (1e-4 * mass) for body, mass in masses.items())
    nt = sum(0.005 * arms[body] / (1e-4 * mass) for body, mass in masses.items())
    assert result.delassus[0] == pytest.approx(np.array([[nn, nt], [nt, tt]]), rel=1e-13)
    assert result.velocity_before[0] == pytest.approx([-1.0, 0.0])
    assert result.outside[0] > 0.0


def test_covariances_go_through_the_jacobian(tmp_path: Path) -> None:
    """G (C_after + C_before) G'; a variance, or its root, and what couples them."""
    path = body_file(
        tmp_path,
        errors="# error_after_x: 20 mm/s\n# error_after_y: 0.03 m/s",
        angle="# covariance_after_turn_turn: 4 rad2 s-2",
        coupling="# covariance_after_turn_x: 0.01 m rad/s^2",
        before="# error_before_x: 0 m/s\n# error_before_y: 0.04 m/s\n# error_before_turn: 0 rad/s",
    )
    normal, tangential = np.array([0.0, 1.0, 2e-3]), np.array([1.0, 0.0, 0.03])
    spread = np.array([[4e-4, 0.0, 0.01], [0.0, 9e-4 + 16e-4, 0.0], [0.01, 0.0, 4.0]])
    rows = np.stack([normal, tangential])
    assert read_impacts(path).covariance[0] == pytest.approx(rows @ spread @ rows.T, rel=1e-12)


def test_an_impact_along_the_normal_alone_has_no_slip(tmp_path: Path) -> None:
    path = tmp_path / "drops.csv"
    path.write_text("# mass_y: 2 kg\n# normal_y: -1\nbefore_y [m/s],after_y [m/s]\n3,-1\n")
    body = read_impacts(path)
    path.write_text("# delassus_nn: 0.5 kg-1\nbefore_gap_rate [m/s],after_gap_rate [m/s]\n-3,1\n")
    contact = read_impacts(path)
    assert same(body, contact)
    assert body.velocity_before.tolist() == [[-3.0, 0.0]]
    assert body.delassus.tolist() == [[[0.5, 0.0], [0.0, 0.5]]]
    assert body.kinetic_energy.tolist() == [9.0]


def test_a_table_of_pandas_is_a_file(tmp_path: Path) -> None:
    table = pandas.DataFrame({"before_gap_rate": [-1, -2], "after_gap_rate": [1, 1], "flag": [0.0, np.nan]})
    data = table.to_xarray().assign(delassus_nn=2.0)
    for name, unit in {"before_gap_rate": "m/s", "after_gap_rate": "m/s", "delassus_nn": "1/kg"}.items():
        data[name].attrs["units"] = unit
    data.to_netcdf(tmp_path / "table.nc")
    result = read_impacts(tmp_path / "table.nc")
    assert result.velocity_before[:, 0].tolist() == [-1.0, -2.0]
    assert result.number.tolist() == [0, 1]


@pytest.mark.parametrize("language", ["csv", "python"])
def test_the_examples_of_the_page_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, language: str
) -> None:
    examples = re.findall(rf"```{language}\n(.*?)```", PAGE.read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    if language == "csv":
        Path("drops.csv").write_text(examples[0])
        result = read_impacts(Path("drops.csv"))
        assert (len(result), result.left_out, result.title) == (3, 1, "A disc on a table")
        # The page's own reading of it.
        exec(re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)[0])
    else:
        exec(examples[1])
        result = read_impacts(Path("ball.nc"))
        assert (len(result), result.source) == (3, "Example, nobody measured it")
        assert result.delassus[0].tolist() == [[200.0, 0.0], [0.0, 700.0]]
        assert result.notes == ()


@pytest.mark.parametrize("column", [*BODY_COLUMNS, *CONTACT_COLUMNS[2:], *OTHER_COLUMNS])
def test_the_page_names_every_column(column: Column) -> None:
    assert f"`{column.form.format('NAME', 'OTHER')}`" in PAGE.read_text()
