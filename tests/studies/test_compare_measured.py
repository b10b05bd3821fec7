"""Measurements in a comparison: which law predicts them better, by how much, and what is inconclusive."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.command_line import Command
from support.configurations import leave

import contactlab as cl
from contactlab.impacts import velocities_after
from contactlab.laws import Newton
from contactlab.measured import floors
from contactlab.measured.files import write_impacts
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.series import MeasuredSeries
from contactlab.metrics import CANNOT_TELL, NOT_APPLICABLE, VERDICTS
from contactlab.studies.compare.measured import nearest_laws, read_all

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
    texts = ("A ball & a plate", "drawn by a test", "none")
    return MeasuredImpacts(delassus, before, after, energy, np.zeros(count), None, *texts, 0, number)


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


def compared(runs: Sequence[Path | xarray.DataTree], *measured: Path) -> xarray.Dataset:
    return cl.compare(runs, refine=False, transient=True, measured=measured).data.to_dataset()


@pytest.fixture(scope="module")
def data(runs: list[Path], measured: Path) -> xarray.Dataset:
    return compared(runs, measured)


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


def test_an_error_is_told_over_that_of_the_best_admissible_impulses(runs: list[Path], folder: Path) -> None:
    """Noise on elastic impacts without friction gains energy in half of them, which no impulse may."""
    made = impacts(law=Newton(0.0, 1.0))
    write_impacts(made, folder / "elastic.csv")
    data = compared(runs[:2], folder / "elastic.csv")
    best = made.errors(floors.velocities_after(made, floors.best_admissible_impulses(made))).mean()
    assert 0.1 * NOISE < best < NOISE
    error, over_floor = (data["value"].sel(metric=f"impact_error{end}") for end in ("", "_over_floor"))
    np.testing.assert_allclose(over_floor, error / best, rtol=1e-9)
    assert (over_floor > 1.0).all()


def test_each_impact_is_nearest_to_one_law_where_no_two_are_alike(data: xarray.Dataset) -> None:
    share = data["value"].sel(metric="nearest_impacts")
    assert float(share.sum()) == pytest.approx(1.0, abs=1e-12)
    assert int(share.argmax("law")) == 0


def test_pairs_of_impacts_distinguish_laws(data: xarray.Dataset) -> None:
    labels = data["law"].values
    apart, low, high = data["nearer"].sel(law=labels[0], other_law=labels[1]).values[0]
    means = data["value"].sel(metric="impact_error")
    assert apart == pytest.approx(float(means[1] - means[0]), rel=1e-12)
    assert 0.0 < low < apart < high
    assert len([*nearest_laws(data)]) == 1


def test_pairs_of_impacts_may_be_inconclusive(runs: list[Path], folder: Path, measured: Path) -> None:
    """0.6 and 0.6005 differ by less than 400 noisy impacts show; two laws of one motion are equal."""
    close = leave(folder / "close", "newton", law__restitution=0.6005, contact__friction_coefficient=0.1)
    same = leave(folder / "same", "moreau_jean", law__restitution=0.6, contact__friction_coefficient=0.1)
    nearer = compared([runs[0], close, same], measured)["nearer"].values[0]
    assert nearer[0, 1, 1] < 0.0 < nearer[0, 1, 2]
    assert (nearer[0, 2] == 0.0).all()


def test_a_run_without_configuration_has_no_prediction(runs: list[Path], measured: Path) -> None:
    bare = xarray.open_datatree(runs[0] / "run.nc").load()
    del bare.attrs["configuration"]
    row = compared([bare, runs[1]], measured).sel(metric="impact_error")
    assert np.isnan(row["value"].values).tolist() == [True, False]
    assert VERDICTS[int(row["verdict"][0])] == CANNOT_TELL


def test_a_measured_velocity_is_missed_by_its_error_under_the_law_that_made_it(
    runs: list[Path], folder: Path
) -> None:
    with xarray.open_datatree(runs[0] / "run.nc") as tree:
        kept = tree.dataset.isel(time=slice(None, None, 4)).load()
    time, error = kept["time"].values, np.full(kept.sizes["time"], SERIES_NOISE)
    values = kept["rotor_velocity"].values + SERIES_NOISE * np.random.default_rng(3).standard_normal(
        time.size
    )
    stated = {"contact": {"clearance": "1 um"}}
    texts = {"title": "A rotor", "source": "drawn by a test"}
    series = MeasuredSeries(time, {"rotor_velocity": values}, {"rotor_velocity": error}, stated, texts)
    series.to_xarray().to_netcdf(folder / "rotor.nc")
    data = compared(runs[:3:2], folder / "rotor.nc")
    right, wrong = data["value"].sel(metric="rotor_velocity_misfit").values
    assert right == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * time.size))
    assert wrong > 1.5
    other = MeasuredSeries(time, series.values, series.errors, {"contact": {"clearance": 2e-6}}, texts)
    other.to_xarray().to_netcdf(folder / "other.nc")
    with pytest.raises(cl.ComparisonError, match=r"contact\.clearance"):
        compared(runs[:1], folder / "other.nc")


def test_the_command_takes_several_files_and_refuses_bad_ones_before_anything_is_written(
    runs: list[Path], tmp_path: Path, measured: Path, command: Command
) -> None:
    (tmp_path / "text.csv").write_text("gap,slip\n1,2\n")
    write_impacts(impacts(5), tmp_path / "few.csv")
    quick = ("compare", str(runs[0]), "--output", str(tmp_path / "out"), "--transient", "--no-refine")
    bad = [str(tmp_path / name) for name in ("text.csv", "few.csv", "none.csv")]
    status, out, err = command(*quick, "--measured", *bad)
    assert (status, out) == (2, "")
    assert [name in err for name in bad] == [True] * 3
    assert not (tmp_path / "out").exists()
    with pytest.raises(cl.ComparisonError):
        read_all([measured, measured])
    assert command(*quick, "--measured", str(measured))[0] == 0
    assert (tmp_path / "out" / "measurements.csv").exists()
