"""`contactlab compare`: what is compared, what is refused, and that all outputs tell the same.

The runs are compared as they were recorded, which is quick; settled motors are in `test_settled.py`.
"""

import csv
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray
from support.command_line import Command
from support.configurations import LAWS, leave, leave_all

from contactlab import load
from contactlab.comparison import ComparisonError, compare
from contactlab.comparison.curves import one_contact_each
from contactlab.comparison.figures import draw_energy
from contactlab.comparison.findings import conclusion, differences, verdicts
from contactlab.comparison.reruns import Refined
from contactlab.comparison.runs import collect
from contactlab.comparison.scorecard import LATEX, as_latex, as_text, energy_flow, rows
from contactlab.metrics import (
    FAIL,
    METRICS,
    NOT_APPLICABLE,
    PASS,
    SENSITIVITIES,
    STEP_METRICS,
    VERDICTS,
    Run,
    read_run,
)
from contactlab.metrics.convergence import richardson

FIGURES = ("contact_force", "tip_trajectory", "rotor_velocity", "energy_flow", "phase_portrait")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return leave_all(tmp_path_factory.mktemp("sweep"))


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("compared") / "below"


@pytest.fixture(scope="module")
def data(sweep: Path, output: Path) -> xarray.Dataset:
    return compare([sweep], output, transient=True)


def _change(path: Path, **attributes: object) -> None:
    with netCDF4.Dataset(path / "run.nc", "a") as file:
        for name, value in attributes.items():
            file.setncattr(name, value)


def test_a_sweep_is_found_in_its_order_and_each_run_once(sweep: Path) -> None:
    first = sweep / f"0_law={LAWS[0]}"
    runs, notes = collect([sweep, first, first / "run.nc"])
    assert [run.label for run in runs] == list(LAWS)
    assert notes == []


def test_every_law_has_every_metric(data: xarray.Dataset) -> None:
    assert data["law"].values.tolist() == list(LAWS)
    assert set(data["metric"].values) == {*METRICS, *STEP_METRICS, *SENSITIVITIES}
    judged = [bool(threshold) for threshold in data["threshold"].values]
    assert judged == sorted(judged, reverse=True)
    value = data["value"].to_pandas()
    for key in ("peak_force_exponent", "rotor_velocity_by_friction", "rotor_velocity_by_basis"):
        assert np.isfinite(value[key]).all(), key
    assert value["peak_force_exponent"]["lagrange_slip"] == pytest.approx(-1.0, abs=0.02)


def test_laws_differ_by_more_than_their_numerical_errors(data: xarray.Dataset) -> None:
    value = data["value"].sel(metric="final_rotor_velocity").values
    error = data["numerical_error"].sel(metric="final_rotor_velocity").values
    assert np.all(error < 1e-2 * np.abs(value))
    assert np.ptp(value) > 3.0 * error.sum()
    assert "times the numerical errors, is resolved; what it owes to basis" in differences(data)[0]
    assert "it does not converge" in differences(data)[1]


def test_all_files_are_there_and_agree(data: xarray.Dataset, output: Path) -> None:
    for name in FIGURES:
        assert (output / f"{name}.png").stat().st_size > 5000
        assert (output / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    with xarray.open_dataset(output / "metrics.nc") as written:
        xarray.testing.assert_identical(written.load()["value"], data["value"])
        assert written["verdict"].attrs["flag_meanings"].split()[1] == "pass"
        assert "law:" in str(written["configuration"].values[0])
        assert written.attrs["numpy_version"]
        recorded_by = written["contactlab_version"].values
        assert set(recorded_by) == {written.attrs["contactlab_version"]}
    with (output / "scorecard.csv").open(encoding="utf-8") as file:
        table = {row["metric"]: row for row in csv.DictReader(file)}
    page = (output / "report.html").read_text(encoding="utf-8")
    for key in data["metric"].values:
        for law in LAWS:
            cell = data.sel(metric=key, law=law)
            said = table[key][law]
            number = float(cell["value"])
            assert said == ("n/a" if np.isnan(number) else f"{number:.9g}")
            flags = ("n/a", "pass", "fail", "-")
            assert table[key][f"{law} verdict"] == flags[int(cell["verdict"])]
            if np.isfinite(number):
                assert f"{number:.4g}".replace("-", "\N{MINUS SIGN}") in page
    assert page.count("data:image/png;base64,") == len(FIGURES)
    assert "viewport" in page
    assert "http" not in page
    assert "<script" not in page


def test_the_energy_flow_adds_up_to_the_work_of_the_drive(data: xarray.Dataset) -> None:
    total = data["energy"].sum("term").values
    np.testing.assert_allclose(total, data["drive_work"].values, rtol=1e-12)
    assert (data["energy"].sel(term="damping_loss") > 0.0).all()


def test_the_bars_that_are_drawn_add_up_too(tmp_path: Path) -> None:
    # A motor that is driven backwards by its load gives energy back: bars on both sides of zero.
    start = {"rotor__initial_velocity": -2.0, "rotor__load_torque": 1e-3}
    data = compare([leave(tmp_path / law, law, **start) for law in LAWS], refine=False, transient=True)
    assert (data["energy"].min("term") < 0.0).all()
    figure = draw_energy(data)
    (axes,) = figure.axes
    scale = {"mJ": 1e-3, "\N{MICRO SIGN}J": 1e-6}[axes.get_xlabel().split("(")[1][:-1]]
    for row in range(len(LAWS)):
        bars = [bar for bar in axes.patches if bar.get_y() < row < bar.get_y() + bar.get_height()]
        total = sum(bar.get_width() for bar in bars)
        work = float(data["drive_work"][row])
        assert scale * total == pytest.approx(work, rel=3e-3)


def test_a_row_of_impacts_is_one_contact(tmp_path: Path) -> None:
    hertz = leave(tmp_path / "hertz", "hertz_penalty")
    runs, _ = collect([leave(tmp_path / "newton", "newton", law__restitution=0.1), hertz])
    contacts = dict(one_contact_each([Refined(run) for run in runs]))
    assert contacts.keys() == {0, 1}
    starts = runs[0].rows["start_time"]
    row = (starts >= contacts[0].start) & (starts <= contacts[0].start + contacts[0].duration)
    assert np.count_nonzero(row) > 1
    assert contacts[0].time[-1] == pytest.approx(contacts[1].time[-1], abs=2e-6)


@pytest.mark.long
def test_runs_that_never_touch_or_hardly_record_are_compared(tmp_path: Path) -> None:
    free = leave(tmp_path / "free", "hertz_penalty", contact__clearance=1e-3)
    compare([free], tmp_path / "one", transient=True)
    assert not (tmp_path / "one" / "contact_force.png").exists()
    assert (tmp_path / "one" / "rotor_velocity.png").exists()
    coarse = leave(tmp_path / "coarse", "lagrange_slip", record__interval=5e-4)
    compare([coarse], tmp_path / "two", refine=False, transient=True)
    assert "Contact law lagrange_slip" in (tmp_path / "two" / "report.html").read_text()


@pytest.mark.long
def test_motors_without_friction_are_compared(tmp_path: Path) -> None:
    """Their rotor stays at rest, without an error that a logarithmic axis could show."""
    smooth = [leave(tmp_path / law, law, contact__friction_coefficient=0.0) for law in LAWS[1:]]
    data = compare(smooth, tmp_path / "out", transient=True)
    assert (data["value"].sel(metric="final_rotor_velocity") == 0.0).all()
    assert "lagrange_stick is frictionless" in data.attrs["notes"]
    assert (tmp_path / "out" / "rotor_velocity.png").stat().st_size > 5000


def test_the_latex_table_is_whole(data: xarray.Dataset) -> None:
    text = as_latex(data)
    bare = text.replace(r"\{", "").replace(r"\}", "")
    assert bare.count("{") == bare.count("}")
    assert text.count("$") % 2 == 0
    rows = [line for line in text.splitlines() if line.endswith(r"\\")]
    assert len(rows) == 1 + data.sizes["metric"]
    assert all(row.replace(r"\&", "").count("&") == 1 + data.sizes["law"] for row in rows)
    assert text.isascii()
    assert "a_b & 50 % < #".translate(LATEX) == r"a\_b \& 50 \% \textless{} \#"


def test_words_name_what_fails_with_value_and_bound(data: xarray.Dataset) -> None:
    assert all(said[0].startswith("Meets ") for said in verdicts(data).values())
    driven = data.copy(deep=True)
    place = {"metric": "friction_work", "law": "lagrange_slip"}
    driven["value"].loc[place] = 0.5
    driven["verdict"].loc[place] = VERDICTS.index(FAIL)
    (work,) = [s for s in verdicts(driven)["lagrange_slip"] if "friction_work" in s]
    assert "must be <= 0.001" in work
    for label in driven["law"].values:
        judged = driven.sel(law=label, metric=[m.key for m, _ in rows(driven) if m.judges_law])["verdict"]
        met, failed, absent = (
            int((judged == VERDICTS.index(verdict)).sum()) for verdict in (PASS, FAIL, NOT_APPLICABLE)
        )
        assert f"{label} meets {met}, fails {failed}, and {absent} do not apply" in conclusion(driven)


def test_without_reruns_what_needs_them_is_not_applicable(sweep: Path) -> None:
    data = compare([sweep], refine=False, transient=True)
    for key in (*STEP_METRICS, *SENSITIVITIES):
        assert np.isnan(data["value"].sel(metric=key)).all(), key
        assert (data["verdict"].sel(metric=key) == 0).all(), key
    assert np.isnan(data["numerical_error"]).all()
    assert "n/a" in as_text(data)
    assert "nothing is known of the numerical error" in differences(data)[0]


def test_other_motors_are_refused_with_key_values_and_runs(sweep: Path, tmp_path: Path) -> None:
    other = leave(tmp_path / "other", "hertz_penalty", contact__clearance=2e-6)
    with pytest.raises(ComparisonError) as refused:
        compare([sweep / "0_law=lagrange_slip", other])
    (fault,) = refused.value.faults
    assert "contact.clearance is 1e-06 in" in fault
    assert "and 2e-06 in" in fault
    assert "other" in fault
    with pytest.raises(ComparisonError, match="' and 1 more and 2e-06 in '"):
        compare([sweep, other])
    longer = leave(tmp_path / "longer", "hertz_penalty", solver__duration=3e-3)
    with pytest.raises(ComparisonError, match=r"solver.duration \[s\] is 0.002 in"):
        compare([sweep / "0_law=lagrange_slip", longer], transient=True)


@pytest.mark.parametrize(
    ("law", "key", "values"),
    [
        ("hertz_penalty", "stiffness", ("1e+10", "5e+09")),
        ("composed", "normal.stiffness", ("1e+10", "3e+10")),
    ],
)
def test_runs_of_one_law_are_told_apart_by_its_keys_and_those_of_its_parts(
    tmp_path: Path, law: str, key: str, values: tuple[str, str]
) -> None:
    change = {f"law__{key.replace('.', '__')}": float(values[1])}
    runs, _ = collect([leave(tmp_path / "one", law), leave(tmp_path / "two", law, **change)])
    assert [run.label for run in runs] == [f"{law} ({key} {value})" for value in values]
    again = leave(tmp_path / "again", law)
    with pytest.raises(ComparisonError, match="2 runs with the same parameters"):
        collect([tmp_path / "one", again])


def test_an_incomplete_run_is_refused(tmp_path: Path) -> None:
    folder = leave(tmp_path / "cut", "hertz_penalty")
    _change(folder, complete=0, message="Interrupted at 0.001 s.")
    with pytest.raises(ComparisonError, match=r"is incomplete: .*Interrupted at 0.001 s\."):
        compare([folder])


def test_a_file_of_ones_own_takes_part_as_it_is(sweep: Path, tmp_path: Path) -> None:
    own = tmp_path / "measured.nc"
    hertz = read_run(sweep / "2_law=hertz_penalty" / "run.nc")
    kept = hertz.to_dataset(inherit=False)[["rotor_velocity", "gap"]]
    kept.attrs = {"title": "from the bench"}
    kept.to_netcdf(own)
    data = compare([sweep / "0_law=lagrange_slip", own], tmp_path / "out", transient=True)
    assert data["law"].values.tolist() == ["lagrange_slip", "measured"]
    assert np.isfinite(data["value"].sel(law="measured", metric="final_rotor_velocity"))
    for key in (*STEP_METRICS, *SENSITIVITIES):
        assert np.isnan(data["value"].sel(law="measured", metric=key)), key
    assert np.isnan(data["energy"].sel(law="measured")).all()
    assert "measured is taken as recorded" in data.attrs["notes"]
    assert "taken on trust" in data.attrs["notes"]
    assert (tmp_path / "out" / "report.html").exists()


def test_runs_in_memory_are_compared(sweep: Path) -> None:
    trees = [read_run(sweep / f"{i}_law={law}" / "run.nc") for i, law in enumerate(LAWS)]
    held = [load(sweep / f"0_law={LAWS[0]}" / "run.nc"), *trees[1:]]
    for given in (trees, held):
        assert compare(given, refine=False, transient=True)["law"].values.tolist() == list(LAWS)
    flow = energy_flow(Run.of(trees[2]))
    assert flow["contact_loss"] == 0.0
    with pytest.raises(ComparisonError, match="nothing to compare"):
        compare([])


def test_a_run_that_other_code_left_is_told(tmp_path: Path) -> None:
    folder = leave(tmp_path / "run", "hertz_penalty")
    with netCDF4.Dataset(folder / "run.nc", "a") as file:
        file["rotor_velocity"][-1] = 7.0
    assert "not at the recorded 7 rad/s" in compare([folder], transient=True).attrs["notes"]


def test_richardson_gives_the_error_of_a_known_series() -> None:
    steps = np.array([4.0, 2.0, 1.0])
    for order in (1.0, 2.0):
        values = [np.asarray(5.0 + h**order) for h in steps]
        assert float(richardson(values, 2.0, order)) == pytest.approx(1.0)
        # What converges more slowly than declared is not given the declared error.
        assert float(richardson(values, 2.0, order + 1.0)) == pytest.approx(1.0)
    growing = [np.asarray(x) for x in (1.0, 2.0, 4.0)]
    assert float(richardson(growing, 2.0, 1.0)) == pytest.approx(18.0)


def test_the_command_prints_and_writes(sweep: Path, command: Command) -> None:
    status, out, err = command("compare", str(sweep), "--no-refine", "--transient", "--output", "here")
    assert (status, err) == (0, "")
    assert "final_rotor_velocity [rad/s]" in out
    assert "Written to here" in out
    assert out.isascii()
    assert Path("here/report.html").exists()


def test_the_command_refuses_in_sentences(tmp_path: Path, command: Command) -> None:
    Path("empty").mkdir()
    Path("file").write_text("no netCDF")
    status, out, err = command("compare", "nowhere", "empty", "file")
    assert (status, out) == (2, "")
    assert [line.split(" ")[0] for line in err.splitlines()] == ["'nowhere'", "'empty'", "'file'"]
    assert not Path("comparison").exists()
    status, _, err = command("compare", "empty", "--output", "file/below")
    assert status == 2
    assert "'file/below'" in err
    assert command("compare")[0] == 2
