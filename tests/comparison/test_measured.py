"""Measurements in the comparison: which law is nearer to them, by how much, and what cannot be told."""

import csv
import re
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.command_line import Command
from support.configurations import leave

from contactlab.comparison import ComparisonError, compare
from contactlab.comparison.findings import differences
from contactlab.comparison.measurements import read_all
from contactlab.comparison.report import page
from contactlab.comparison.scorecard import as_csv, as_latex, as_text
from contactlab.impacts import velocities_after
from contactlab.laws import Newton
from contactlab.measured import floors
from contactlab.measured.files import write_impacts
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.series import MeasuredSeries
from contactlab.metrics import NOT_APPLICABLE, VERDICTS

COUNT, NOISE = 400, 0.02
"""Impacts, and the error of their velocities after, over the approach, in the norm of the kinetic energy."""

LAW = Newton(0.1, 0.6)

SERIES_NOISE = 1e-3
"""Error of the rotor velocity [rad/s]."""


def impacts(count: int = COUNT, law: Newton = LAW) -> MeasuredImpacts:
    """Impacts of a ball under a law, with noise."""
    rng = np.random.default_rng(2)
    angle = rng.uniform(0.1, 1.4, count)
    before = np.stack([-np.cos(angle), np.sin(angle)], axis=1)
    delassus = np.broadcast_to(np.diag([1.0, 3.5]), (count, 2, 2)).copy()
    energy = 0.5 * np.einsum("ni,nij,nj->n", before, np.linalg.inv(delassus), before)
    # Of unit size in that norm.
    noise = rng.standard_normal((count, 2)) * np.sqrt([1.0, 3.5])
    after = velocities_after(law, delassus, before)
    after += NOISE * noise * np.sqrt(2.0 * energy)[:, None]
    number = np.arange(1, count + 1)
    words = ("A ball & a plate", "drawn by a test", "none")
    return MeasuredImpacts(delassus, before, after, energy, np.zeros(count), None, *words, 0, number)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("measured")


@pytest.fixture(scope="module")
def runs(folder: Path) -> list[Path]:
    changes = {"contact__friction_coefficient": 0.1}
    restitutions = {"true": 0.6, "near": 0.55, "far": 0.2}
    return [leave(folder / name, "newton", law__restitution=e, **changes) for name, e in restitutions.items()]


@pytest.fixture(scope="module")
def measured(folder: Path) -> Path:
    write_impacts(impacts(), folder / "ball.csv")
    return folder / "ball.csv"


@pytest.fixture(scope="module")
def data(runs: list[Path], measured: Path) -> xarray.Dataset:
    return compare(runs, refine=False, transient=True, measured=[measured])


def test_the_error_of_the_law_that_made_them_is_the_noise(data: xarray.Dataset) -> None:
    """That is |z| of two standard normals times it, on average sqrt(pi/2)."""
    row = data.sel(metric="impact_error")
    expected = NOISE * np.sqrt(np.pi / 2.0)
    assert float(row["value"][0]) == pytest.approx(expected, abs=3.0 * float(row["numerical_error"][0]))
    # Half of a 95 % interval of the mean of Rayleigh's distribution.
    half = 1.96 * NOISE * np.sqrt((2.0 - np.pi / 2.0) / COUNT)
    assert float(row["numerical_error"][0]) == pytest.approx(half, rel=0.15)
    assert (np.diff(row["value"]) > 0.0).all()


def test_over_a_floor_that_is_round_off_no_error_is_told(data: xarray.Dataset) -> None:
    """Restitution and friction leave room for the noise: impulses make all contact velocities exactly."""
    row = data.sel(metric="impact_error_over_floor")
    assert np.isnan(row["value"]).all()
    assert (row["verdict"] == VERDICTS.index(NOT_APPLICABLE)).all()
    assert "impact_error_over_floor does not apply to A ball & a plate: " in data.attrs["notes"]
    assert re.search(r"impact_error_over_floor.* n/a +n/a +n/a", as_text(data))


def test_an_error_is_told_over_that_of_the_best_admissible_impulses(runs: list[Path], folder: Path) -> None:
    """Noise on elastic impacts without friction gains energy in half of them, which no impulse may."""
    made = impacts(law=Newton(0.0, 1.0))
    write_impacts(made, folder / "elastic.csv")
    data = compare(runs[:2], refine=False, transient=True, measured=[folder / "elastic.csv"])
    best = made.errors(floors.velocities_after(made, floors.best_admissible_impulses(made))).mean()
    assert 0.1 * NOISE < best < NOISE
    error, over_floor = (data["value"].sel(metric=f"impact_error{end}") for end in ("", "_over_floor"))
    np.testing.assert_allclose(over_floor, error / best, rtol=1e-9)
    assert (over_floor > 1.0).all()


def test_each_impact_is_nearest_to_one_law_where_no_two_are_alike(data: xarray.Dataset) -> None:
    share = data["value"].sel(metric="nearest_impacts")
    assert float(share.sum()) == pytest.approx(1.0, abs=1e-12)
    assert int(share.argmax("law")) == 0


def test_pairs_of_impacts_tell_laws_apart_and_the_sentence_says_by_how_much(data: xarray.Dataset) -> None:
    labels = data["law"].values
    apart, low, high = data["nearer"].sel(law=labels[0], other_law=labels[1]).values[0]
    means = data["value"].sel(metric="impact_error")
    assert apart == pytest.approx(float(means[1] - means[0]), rel=1e-12)
    assert 0.0 < low < apart < high
    said = [sentence for sentence in differences(data) if "measured" in sentence]
    assert len(said) == 2
    words = f"{labels[0]}'s impacts are nearer to what was measured (A ball & a plate) than {labels[1]}'s by"
    assert said[0].startswith(f"{words} {apart:.2g} +- ")


def test_what_pairs_do_not_tell_apart_is_said_so(runs: list[Path], folder: Path, measured: Path) -> None:
    """0.6 and 0.6005 differ by less than 400 noisy impacts show; two of one motion are alike."""
    close = leave(folder / "close", "newton", law__restitution=0.6005, contact__friction_coefficient=0.1)
    same = leave(folder / "same", "moreau_jean", law__restitution=0.6, contact__friction_coefficient=0.1)
    data = compare([runs[0], close, same], refine=False, transient=True, measured=[measured])
    said = " ".join(sentence for sentence in differences(data) if "A ball & a plate" in sentence)
    assert "cannot be told" in said
    assert "predict the impacts of A ball & a plate alike." in said


def test_page_tables_and_file_have_the_rows_and_where_they_are_from(
    data: xarray.Dataset, folder: Path, measured: Path
) -> None:
    (one,), report = read_all([measured]), page(data, [])
    for words in ("A ball &amp; a plate", "drawn by a test", "400 impacts", one.digest, "is half of a 95 %"):
        assert words in report
    table = {line["metric"]: line for line in csv.DictReader(StringIO(as_csv(data)))}
    data.to_netcdf(folder / "metrics.nc", engine="netcdf4")
    with xarray.open_dataset(folder / "metrics.nc") as written:
        assert written["measured_digest"].values.tolist() == [one.digest]
        xarray.testing.assert_identical(written["nearer"].load(), data["nearer"])
    assert table["impact_error_over_floor"][str(data["law"].values[0])] == "n/a"
    for key in ("impact_error", "nearest_impacts"):
        value = float(data["value"].sel(metric=key)[0])
        assert float(table[key][str(data["law"].values[0])]) == pytest.approx(value, rel=1e-8)
        assert f"{value:.4g}" in report
    assert r"A ball \& a plate" in as_latex(data)


def test_of_a_run_without_configuration_nothing_is_told(
    runs: list[Path], folder: Path, measured: Path
) -> None:
    bare = xarray.open_datatree(runs[0] / "run.nc").load()
    del bare.attrs["configuration"]
    data = compare([bare, runs[1]], refine=False, transient=True, measured=[measured])
    row = data.sel(metric="impact_error")
    assert np.isnan(row["value"].values).tolist() == [True, False]
    assert "cannot tell" in as_text(data)
    assert "has no configuration that builds" in data.attrs["notes"]
    assert np.isnan(data["value"].sel(metric="nearest_impacts")).all()
    assert "<td class='none'>cannot tell </td>" in page(data, [])


def test_a_measured_velocity_is_missed_by_its_error_under_the_law_that_made_it(
    runs: list[Path], folder: Path
) -> None:
    with xarray.open_datatree(runs[0] / "run.nc") as tree:
        kept = tree.dataset.isel(time=slice(None, None, 4)).load()
    time, error = kept["time"].values, np.full(kept.sizes["time"], SERIES_NOISE)
    values = kept["rotor_velocity"].values + SERIES_NOISE * np.random.default_rng(3).standard_normal(
        time.size
    )
    told = {"contact": {"clearance": "1 um"}}
    words = {"title": "A rotor", "source": "drawn by a test"}
    series = MeasuredSeries(time, {"rotor_velocity": values}, {"rotor_velocity": error}, told, words)
    series.to_xarray().to_netcdf(folder / "rotor.nc")
    data = compare(runs[:3:2], refine=False, transient=True, measured=[folder / "rotor.nc"])
    right, wrong = data["value"].sel(metric="rotor_velocity_misfit").values
    assert right == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * time.size))
    assert wrong > 1.5
    other = MeasuredSeries(time, series.values, series.errors, {"contact": {"clearance": 2e-6}}, words)
    other.to_xarray().to_netcdf(folder / "other.nc")
    with pytest.raises(ComparisonError, match=r"contact.clearance is 2e-06 in '.*other.nc' and 1e-06 in the"):
        compare(runs[:1], refine=False, transient=True, measured=[folder / "other.nc"])


def test_bad_files_are_refused_in_a_sentence_each_before_anything_is_written(
    runs: list[Path], tmp_path: Path, measured: Path, command: Command
) -> None:
    (tmp_path / "text.csv").write_text("gap,slip\n1,2\n")
    write_impacts(impacts(5), tmp_path / "few.csv")
    given = ["--measured", str(tmp_path / "text.csv"), str(tmp_path / "few.csv"), str(tmp_path / "none.csv")]
    status, out, err = command(
        "compare", str(runs[0]), "--output", str(tmp_path / "out"), "--transient", *given
    )
    assert (status, out) == (2, "")
    assert "has 5 impacts; laws are compared on 10 at the least" in err
    assert [name in err for name in ("text.csv", "few.csv", "none.csv")] == [True] * 3
    assert len(err.splitlines()) == 3
    assert not (tmp_path / "out").exists()
    with pytest.raises(ComparisonError, match="are the same measurements"):
        read_all([measured, measured])
