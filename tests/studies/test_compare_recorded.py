"""The study `compare` of recorded runs: what is read and refused, numbers, files, figures, command."""

import csv
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pytest
import xarray
from support.command_line import Command
from support.configurations import LAWS, leave, leave_all

import contactlab as cl
from contactlab.metrics import METRICS, SENSITIVITIES, STEP_METRICS, Run, assess, read_run
from contactlab.studies.compare.figures import contacts_of, draw_energy
from contactlab.studies.compare.laws import read_runs
from contactlab.studies.compare.scorecard import Reruns, energy_flow, motion

FIGURES = ("contact_force", "tip_trajectory", "rotor_velocity", "energy_flow", "phase_portrait")


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return leave_all(tmp_path_factory.mktemp("sweep"))


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("compared") / "below"


@pytest.fixture(scope="module")
def result(sweep: Path, output: Path) -> cl.Result:
    return cl.compare(sweep, output=output)


@pytest.fixture(scope="module")
def data(result: cl.Result) -> xarray.Dataset:
    return result.data.to_dataset()


def quick(sources: Any) -> xarray.Dataset:
    return cl.compare(sources).data.to_dataset()


def runs_of(*sources: Path) -> list[Run]:
    return read_runs(sources)


def test_a_sweep_is_read_in_its_order_and_each_run_once(sweep: Path) -> None:
    first = sweep / f"0_law={LAWS[0]}"
    assert [run.label for run in runs_of(sweep, first, first / "run.nc")] == list(LAWS)


def test_the_values_are_the_metrics_of_the_records(
    sweep: Path, data: xarray.Dataset, result: cl.Result
) -> None:
    assert data["law"].values.tolist() == list(LAWS)
    assert set(data["metric"].values) == {*METRICS, *STEP_METRICS, *SENSITIVITIES}
    for law, file in zip(LAWS, _files(sweep), strict=True):
        metrics = assess(Run.of(read_run(file)))
        np.testing.assert_equal(data["value"].sel(law=law, metric=[*metrics]).values, [*metrics.values()])
        assert result.numbers[law].value == metrics["final_rotor_velocity"]
    assert np.isnan(data["numerical_error"]).all()
    assert result.setups == {}


def test_all_files_are_there_and_agree(data: xarray.Dataset, output: Path) -> None:
    for name in FIGURES:
        assert (output / f"{name}.png").stat().st_size > 5000
        assert (output / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    with xarray.open_dataset(output / "compare.nc") as written:
        xarray.testing.assert_identical(written.load()["value"], data["value"])
    table: dict[str, dict[str, str]] = {}
    for name in ("invariants", "plausibility", "motion"):
        with (output / f"{name}.csv").open(encoding="utf-8") as file:
            table |= {row["key"]: row for row in csv.DictReader(file)}
    for key in data["metric"].values:
        for law in LAWS:
            number = float(data["value"].sel(metric=key, law=law))
            cell = table[key][law] if key in table else ""
            assert cell == "" if np.isnan(number) else float(cell) == number
    assert (output / "report.html").read_text(encoding="utf-8").count("data:image/png;base64,") == len(
        FIGURES
    )


def test_the_energy_flow_adds_up_to_the_work_of_the_drive(data: xarray.Dataset) -> None:
    total = data["energy"].sum("term").values
    np.testing.assert_allclose(total, data["drive_work"].values, rtol=1e-12)
    assert (data["energy"].sel(term="damping_loss") > 0.0).all()


def test_the_bars_that_are_drawn_add_up_too(tmp_path: Path) -> None:
    # A motor that is driven backwards by its load gives energy back: bars on both sides of zero.
    start = {"rotor__initial_velocity": -2.0, "rotor__load_torque": 1e-3}
    data = quick([leave(tmp_path / law, law, **start) for law in LAWS])
    assert (data["energy"].min("term") < 0.0).all()
    (axes,) = draw_energy(data).axes
    scale = {"mJ": 1e-3, "\N{MICRO SIGN}J": 1e-6}[axes.get_xlabel().split("(")[1][:-1]]
    for row in range(len(LAWS)):
        bars = [bar for bar in axes.patches if bar.get_y() < row < bar.get_y() + bar.get_height()]
        work = float(data["drive_work"][row])
        assert scale * sum(bar.get_width() for bar in bars) == pytest.approx(work, rel=3e-3)


def test_impacts_in_a_row_are_one_contact(tmp_path: Path) -> None:
    newton = leave(tmp_path / "newton", "newton", law__restitution=0.1)
    runs = runs_of(newton, leave(tmp_path / "hertz", "hertz_penalty"))
    contacts = contacts_of([motion(Reruns(run)) for run in runs])
    assert contacts.keys() == {0, 1}
    starts = runs[0].rows["start_time"]
    row = (starts >= contacts[0].start) & (starts <= contacts[0].start + contacts[0].duration)
    assert np.count_nonzero(row) > 1
    assert contacts[0].time[-1] == pytest.approx(contacts[1].time[-1], abs=2e-6)


@pytest.mark.long
def test_motors_without_friction_are_compared(tmp_path: Path) -> None:
    """Their rotor stays at rest, without an error that a logarithmic axis could show."""
    smooth = [leave(tmp_path / law, law, contact__friction_coefficient=0.0) for law in LAWS[1:]]
    data = cl.compare(smooth, output=tmp_path / "out")
    assert (data["value"].sel(metric="final_rotor_velocity") == 0.0).all()
    assert (tmp_path / "out" / "rotor_velocity.png").stat().st_size > 5000


def _files(sweep: Path) -> list[Path]:
    return [sweep / f"{number}_law={law}" / "run.nc" for number, law in enumerate(LAWS)]


def test_other_motors_are_refused(sweep: Path, tmp_path: Path) -> None:
    other = leave(tmp_path / "other", "hertz_penalty", contact__clearance=2e-6)
    with pytest.raises(cl.ComparisonError, match=r"contact\.clearance") as refused:
        cl.compare([sweep, other])
    assert len(refused.value.faults) == 1
    longer = leave(tmp_path / "longer", "hertz_penalty", solver__duration=3e-3)
    with pytest.raises(cl.ComparisonError, match=r"solver\.duration"):
        quick([_files(sweep)[0], longer])


@pytest.mark.parametrize(
    ("law", "key", "values"),
    [
        ("hertz_penalty", "stiffness", ("1e+10", "5e+09")),
        ("composed", "normal.stiffness", ("1e+10", "3e+10")),
    ],
)
def test_runs_of_one_law_are_labelled_by_the_keys_that_differ(
    tmp_path: Path, law: str, key: str, values: tuple[str, str]
) -> None:
    change = {f"law__{key.replace('.', '__')}": float(values[1])}
    first, other = leave(tmp_path / "first", law), leave(tmp_path / "other", law, **change)
    assert [run.label for run in runs_of(first, other)] == [f"{law} ({key} {value})" for value in values]
    with pytest.raises(cl.ComparisonError, match=law):
        runs_of(first, leave(tmp_path / "again", law))


def test_an_incomplete_run_is_refused(tmp_path: Path) -> None:
    folder = leave(tmp_path / "cut", "hertz_penalty")
    with netCDF4.Dataset(folder / "run.nc", "a") as file:
        file.setncattr("complete", 0)
    with pytest.raises(cl.ComparisonError, match="cut"):
        cl.compare(folder)


@pytest.mark.long
def test_a_file_of_ones_own_takes_part_as_it_is(sweep: Path, tmp_path: Path) -> None:
    own = tmp_path / "bench.nc"
    kept = read_run(_files(sweep)[2]).to_dataset(inherit=False)[["rotor_velocity", "gap"]]
    kept.attrs = {"title": "from the bench"}
    kept.to_netcdf(own)
    data = cl.compare([_files(sweep)[0], own], output=tmp_path / "out")
    assert data["law"].values.tolist() == ["lagrange_slip", "bench"]
    assert np.isfinite(data["value"].sel(law="bench", metric="final_rotor_velocity"))
    assert np.isnan(data["value"].sel(law="bench", metric=[*STEP_METRICS, *SENSITIVITIES])).all()
    assert np.isnan(data["energy"].sel(law="bench")).all()
    assert (tmp_path / "out" / "report.html").exists()


def test_runs_in_memory_are_compared(sweep: Path) -> None:
    trees = [read_run(path) for path in _files(sweep)]
    for sources in (trees, [cl.load(_files(sweep)[0]), *trees[1:]]):
        assert quick(sources)["law"].values.tolist() == list(LAWS)
    assert energy_flow(Run.of(trees[2]))["contact_loss"] == 0.0
    with pytest.raises(cl.ComparisonError):
        cl.compare([])


@pytest.mark.long
def test_the_command_compares_recorded_runs_and_nothing_beside_them(sweep: Path, command: Command) -> None:
    assert command("compare", str(sweep), "law=newton")[0] == 2
    assert not Path("compare").exists()
    assert command("compare", str(_files(sweep)[1]))[0] == 0
    written = cl.load("compare/compare.nc")
    assert isinstance(written, cl.Result)
    assert written.data["law"].values.tolist() == [LAWS[1]]


def test_the_command_refuses_what_is_no_run(command: Command) -> None:
    Path("empty").mkdir()
    Path("file").write_text("no netCDF")
    status, out, err = command("compare", "nowhere", "empty", "file")
    assert (status, out) == (2, "")
    assert [name in err for name in ("'nowhere'", "'empty'", "'file'")] == [True] * 3
    assert not Path("compare").exists()
    assert command("compare", "law=newton", "samples=3")[0] == 2
