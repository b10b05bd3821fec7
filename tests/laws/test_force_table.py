"""A normal force from a table: what its spline conserves, how it errs, and how its file is kept."""

import pickle
import subprocess
import sys
from math import gamma
from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.arrays import Array
from contactlab.config import ConfigurationError
from contactlab.laws.normal import ForceTable
from contactlab.laws.normal.force_table import Spline
from contactlab.testing.plants import block, first, run

ORDERS: dict[Spline, float] = {"cubic": 4.0, "monotone": 3.0}
"""Powers of the distance of the rows by which splines err."""

MASS, SPEED, STIFFNESS = 2e-3, 0.1, 1e10

ZIGZAG = np.array([0.0, 10.0, 2.0, 8.0, 5.0, 30.0])
"""Forces at equal distances [N]; every row between the ends is an extremum."""

SNAP = np.array([-1.0, -4.0, -2.0, 16.0, 6.0, 60.0])
"""The same with a pull at the touch."""

STEP = 4e-7
"""Distance of their rows [m]."""


def written(folder: Path, approach: Array, force: Array, head: str = "approach [m],force [N]") -> Path:
    path = folder / "rough.csv"
    np.savetxt(path, np.c_[approach, force], "%.17g", ",", header=head, comments="")
    return path


def sphere(folder: Path, pieces: int, spline: Spline) -> ForceTable:
    """Write a table of Hertz, a row of which is as deep as a ball of the speed comes."""
    deepest = (1.25 * MASS * SPEED**2 / STIFFNESS) ** 0.4
    depth = deepest * (np.arange(pieces + 1) / (0.75 * pieces)) ** (8.0 / 3.0)
    return ForceTable(str(written(folder, depth, STIFFNESS * depth**1.5)), spline=spline)


def bounced(part: ForceTable, speed: float = SPEED, tolerance: float | None = 1e-11) -> cl.Solution:
    ball = block(MASS, height=1e-7, gap_rate=-speed)
    return run(ball, cl.Composed(part), 2e-4, record_interval=1e-6, tolerance=tolerance)


@pytest.mark.parametrize(("spline", "order"), ORDERS.items())
def test_of_a_densely_sampled_sphere_it_makes_the_elastic_impact_of_hertz(
    tmp_path: Path, spline: Spline, order: float
) -> None:
    beta = gamma(0.4) * gamma(0.5) / gamma(0.9)
    lasts = 0.8 * beta * (1.25 * MASS / (STIFFNESS * SPEED**0.5)) ** 0.4
    errors = []
    for pieces in (4, 8, 16, 32):
        made = bounced(sphere(tmp_path, pieces, spline))
        assert first(made, "separation_velocity") == pytest.approx(SPEED, rel=1e-8)
        errors.append(abs(first(made, "duration") - lasts) / lasts)
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    # Of few rows the touch, where the force is no polynomial, has the larger part.
    assert orders[-1] == pytest.approx(order, abs=0.3)
    assert errors[-1] < 1e-6


@pytest.mark.parametrize(("spline", "order"), ORDERS.items())
def test_its_force_errs_by_a_power_of_the_distance_of_the_rows(
    tmp_path: Path, spline: Spline, order: float
) -> None:
    off = [
        max(
            abs(part.evaluate("elastic", depth=d)[0] - STIFFNESS * d**1.5)
            for d in np.linspace(0.0, part.rows[0][-1], 400)
        )
        for part in (sphere(tmp_path, pieces, spline) for pieces in (32, 64, 128))
    ]
    assert np.log2(np.divide(off[:-1], off[1:])) == pytest.approx(order, abs=0.2)


@pytest.mark.parametrize("forces", [ZIGZAG, SNAP], ids=["rises_and_falls", "pulls"])
def test_a_force_that_rises_and_falls_gives_back_the_work_that_it_took(tmp_path: Path, forces: Array) -> None:
    part = ForceTable(str(written(tmp_path, STEP * np.arange(6), forces)), spline="monotone")
    # Slopes: zero at extrema, and at the touch that of the parabola, at most three times the secant's.
    secants = np.diff(forces) / STEP
    at_touch = 0.5 * (3.0 * secants[0] - secants[1])
    if secants[0] * secants[1] < 0.0 and abs(at_touch) > 3.0 * abs(secants[0]):
        at_touch = 3.0 * secants[0]
    slopes = np.array([at_touch, 0.0, 0.0, 0.0, 0.0])
    areas = 0.5 * STEP * (forces[:4] + forces[1:5]) + STEP**2 / 12.0 * (slopes[:4] - slopes[1:])
    work = areas.sum()
    assert part.evaluate("elastic", depth=4 * STEP)[1] == pytest.approx(work, rel=1e-14)
    assert not part.rises
    # A ball of this energy comes to the fifth row, through the fall of the force.
    made = bounced(part, float(np.sqrt(2.0 * work / MASS)))
    assert first(made, "max_penetration") == pytest.approx(4 * STEP, rel=1e-6)
    assert np.abs(made.series["energy_residual"]).max() < 1e-9 * made.series["kinetic_energy"].max()
    assert first(made, "separation_velocity") == pytest.approx(-first(made, "approach_velocity"), rel=1e-7)
    assert part.allows_tension == (forces is SNAP)


@pytest.mark.parametrize("spline", ORDERS)
def test_the_energy_is_the_integral_of_the_force_beyond_the_last_row_too(
    tmp_path: Path, spline: Spline
) -> None:
    part = ForceTable(str(written(tmp_path, STEP * np.arange(6), SNAP)), spline=spline)
    # Three nodes of Gauss integrate the cubic exactly within a row.
    nodes, weights = np.polynomial.legendre.leggauss(3)
    edges = STEP * np.array([0.0, 0.3, 1.0, 2.0, 2.9, 3.0, 4.0, 5.0, 9.0])
    stored = [part.evaluate("elastic", depth=d)[1] for d in edges]
    for begin, end, growth in zip(edges[:-1], edges[1:], np.diff(stored), strict=True):
        at = 0.5 * (begin + end) + 0.5 * (end - begin) * nodes
        forces = np.array([part.evaluate("elastic", depth=d)[0] for d in at])
        assert growth == pytest.approx(0.5 * (end - begin) * (weights @ forces), rel=1e-12)
    force, _, stiffness, slope = part.evaluate("elastic", depth=5.0 * STEP)
    assert part.evaluate("elastic", depth=9.0 * STEP)[0] == pytest.approx(force + 4.0 * STEP * stiffness)
    assert (stiffness > 0.0, slope) == (True, 0.0)


def test_rows_that_rise_from_zero_give_a_force_that_rises(tmp_path: Path) -> None:
    # Through steps like these a spline of two continuous derivatives swings to both sides.
    forces = np.array([0.0, 1e-6, 2e-6, 50.0, 50.1, 50.2, 90.0])
    path = str(written(tmp_path, STEP * np.arange(7), forces))
    with pytest.raises(ValueError, match="file"):
        ForceTable(path)
    part = ForceTable(path, spline="monotone")
    values = [part.evaluate("elastic", depth=d)[0] for d in np.linspace(0.0, 6 * STEP, 500)]
    assert values[0] == 0.0
    assert (np.diff(values) > 0.0).all()
    assert part.rises


def test_units_scale_a_table_of_pure_numbers(tmp_path: Path) -> None:
    x = np.linspace(0.0, 2.0, 20)
    path = written(tmp_path, x, x**2, "approach,force")
    plain = ForceTable(str(path), approach_unit=1e-6, force_unit=10.0)
    other = ForceTable(str(written(tmp_path, x, 10.0 * x**2, "approach [um],force [N]")))
    for depth in (1e-7, 1.3e-6, 3e-6):
        expected = other.evaluate("elastic", depth=depth)
        assert plain.evaluate("elastic", depth=depth) == pytest.approx(expected, rel=1e-12)


def test_a_path_and_an_impact_of_a_law_by_itself(tmp_path: Path) -> None:
    law = cl.Composed(ForceTable(str(written(tmp_path, STEP * np.arange(6), ZIGZAG))))
    time = np.linspace(0.0, 1.0, 201)
    gap = -STEP * (2.5 - 2.4 * np.cos(2.0 * np.pi * time))
    loop = cl.drive(law, time, gap=gap, slip=1e-6 * time)
    assert np.abs(loop["energy_residual"]).max() < 1e-9 * np.abs(loop["contact_energy"]).max()
    stored = loop["contact_energy"].values
    assert stored[-1] == pytest.approx(stored[0], rel=1e-9)
    with pytest.raises(ValueError, match="gap"):
        cl.drive(law, time, normal=5.0, slip=1e-6 * time)
    after = cl.impact(law, [[1.0 / MASS, 0.0], [0.0, 3.5 / MASS]], [-0.08, 0.0])["velocity_after"]
    assert after.values[0, 0] == pytest.approx(0.08, rel=1e-6)


def test_a_load_on_a_rising_table_has_its_depth(tmp_path: Path) -> None:
    law, time = cl.Composed(sphere(tmp_path, 32, "cubic")), np.linspace(0.0, 1.0, 11)
    loop = cl.drive(law, time, normal=5.0, slip=1e-3 * time)
    assert float(loop["gap"][-1]) == pytest.approx(-((5.0 / STIFFNESS) ** (2.0 / 3.0)), rel=1e-4)
    assert float(loop["normal_force"][-1]) == pytest.approx(5.0, rel=1e-9)


FAULTY = {
    "no_force": ("approach [m]\n0\n1e-6\n", "force"),
    "another_column": ("approach [m],force [N],depth [m]\n0,0,0\n1e-6,1,0\n", "depth"),
    "text": ("approach [m],force [N]\n0,0\n1e-6,much\n", "force"),
    "other_unit": ("approach [m],force [m]\n0,0\n1e-6,1\n", "force"),
    "begins_later": ("approach [m],force [N]\n1e-7,0\n1e-6,1\n", "approach"),
    "not_in_order": ("approach [m],force [N]\n0,0\n1e-6,1\n1e-6,2\n", "approach"),
    "begins_with_a_push": ("approach [m],force [N]\n0,1\n1e-6,2\n", "force"),
    "falls_at_the_end": ("approach [m],force [N]\n0,0\n1e-6,2\n2e-6,1\n", "force"),
    "pulls_at_the_end": ("approach [m],force [N]\n0,-3\n1e-6,-2\n", "force"),
    "one_row": ("approach [m],force [N]\n0,0\n", "force"),
}


@pytest.mark.parametrize(("text", "column"), FAULTY.values(), ids=FAULTY)
def test_a_table_that_is_no_law_is_refused_by_key_and_column(tmp_path: Path, text: str, column: str) -> None:
    path = tmp_path / "faulty.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=f"file.*{column}"):
        ForceTable(str(path))
    with pytest.raises(ConfigurationError, match=rf"law\.normal\.file.*{column}"):
        cl.build(["law=composed", "law/normal=table", f"law.normal.file={path}"])


def test_a_file_that_is_not_there_and_a_digest_without_or_of_another_file_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path, STEP * np.arange(6), ZIGZAG)
    with pytest.raises(ValueError, match="file"):
        ForceTable(str(tmp_path / "absent.csv"))
    with pytest.raises(ValueError, match="digest"):
        ForceTable(digest="0123456789abcdef")
    with pytest.raises(ValueError, match="digest"):
        ForceTable(str(path), digest="0123456789abcdef")
    chosen = ["law=composed", "law/normal=table", f"law.normal.file={path}"]
    with pytest.raises(ConfigurationError, match=r"law\.normal\.digest"):
        cl.build([*chosen, "law.normal.digest='0123456789abcdef'"])
    with pytest.raises(ConfigurationError, match=r"law\.normal\.digest"):
        cl.build([*chosen[:2], "law.normal.digest='0123456789abcdef'"])


def test_a_run_and_a_process_keep_the_rows_of_a_file_that_is_gone(tmp_path: Path) -> None:
    path = written(tmp_path, STEP * np.arange(6), ZIGZAG)
    setup = cl.build(["law=composed", "law/normal=table", f"law.normal.file={path}"])
    made = cl.simulate(setup, duration=2e-4)
    made.save(tmp_path / "run.nc")
    path.write_text("approach [m],force [N]\n0,0\n1e-6,1\n")
    script = (
        "import contactlab as cl\n"
        f"run = cl.load(r'{tmp_path / 'run.nc'}')\n"
        "again = cl.simulate(run.setup, duration=2e-4)\n"
        "assert (again['tip_normal_displacement'].values == run['tip_normal_displacement'].values).all()\n"
        "assert run.setup.law.normal.rows[1][1] == 10.0\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
    # An object goes to other processes with its rows.
    part = setup.law.normal
    path.unlink()
    assert pickle.loads(pickle.dumps(part)).coefficients() == part.coefficients()
