"""Laws against measured friction: made-up records of the published forms, whose truth is known."""

from itertools import pairwise
from pathlib import Path

import friction_loop
import joint_friction
import numpy as np
import pytest
import tribometer
import velocity_steps
import xarray
from experiment import perform
from friction_loop import FrictionLoop
from joint_friction import JointFriction
from scipy.integrate import solve_ivp
from velocity_steps import VelocitySteps

import contactlab as cl


def numbers_of(data: xarray.Dataset, law: str) -> np.ndarray:
    return data.numbers.sel(law=law).values


def test_rigid_friction_behind_a_frame_is_found_in_a_loop_that_it_has_made(tmp_path: Path) -> None:
    """A made record of the published form, by the return map of a spring and a slider."""
    mu, load, stiffness, zero = 0.45, 5.0, 4e4, 0.1
    time = np.arange(0.0, 62.0, 0.005)
    position = 0.115 * np.clip(1.6 * np.sin(2.0 * np.pi * (time - 20.8) / 4.0), -1.0, 1.0)
    force = np.zeros(time.size)
    for n in range(1, time.size):
        way = 1e-3 * (position[n] - position[n - 1])
        force[n] = np.clip(force[n - 1] - stiffness * way, -mu * load, mu * load)
    rng = np.random.default_rng(1)
    table = np.column_stack(
        [
            time,
            np.full(time.size, 1e6 * load),
            position,
            1e6 * (force + zero + 0.01 * rng.normal(size=time.size)),
        ]
    )
    published, target = tmp_path / "record.txt", tmp_path / "loop.csv"
    np.savetxt(published, table, header="Time Normal Position Friction", comments="")
    tribometer.convert(published, target)
    assert "The above copyright notice" in target.read_text(encoding="utf-8")
    data = FrictionLoop(path=str(target), short=True).compute(cl.build())
    best = numbers_of(data, "coulomb, frame")
    np.testing.assert_allclose(best[:2], [mu, stiffness], rtol=0.02)
    miss = (data.predicted - data.friction_force).sel(law="coulomb, frame")[
        friction_loop.unseen_in(data.cycle.values)
    ]
    assert float(np.sqrt((miss**2).mean())) < 0.03
    # A spring of the contact is in series with the frame.
    own = numbers_of(data, "mindlin")
    np.testing.assert_allclose(own[1] * 1e6, best[1], rtol=1e-4)


def test_the_shipped_loop_is_predicted_by_rigid_friction_behind_a_frame(tmp_path: Path) -> None:
    result = perform("friction_loop", tmp_path, short=True)
    rows = {row["law"]: row for row in result.tables["table"].to_dict("records")}
    assert result.data.attrs["holds"]
    assert rows["coulomb, frame"]["held out"] < 0.1 < 0.5 < rows["coulomb"]["held out"]
    assert (tmp_path / "friction_loop.png").is_file()


def records_of(folder: Path, dip: float) -> None:
    """Write records of the published form: 1.5 + 0.8 v and a Stribeck curve, with a little noise."""
    rng = np.random.default_rng(0)
    for speed in (0.03, 0.05, 0.09, 0.1, 0.3, 0.5, 0.7, 0.9, 1.3, 1.5):
        table = np.zeros((200, joint_friction.COLUMNS))
        table[:, joint_friction.VELOCITY] = speed + 1e-3 * rng.normal(size=200)
        torque = 1.5 + 0.8 * speed + dip * np.exp(-speed / 0.1)
        table[:, joint_friction.FRICTION] = -torque + 1e-2 * rng.normal(size=200)
        table[:100] = np.inf
        np.savetxt(folder / f"velocity_{speed:.6f}readings.csv", table)


@pytest.mark.parametrize(("dip", "none"), [(0.0, True), (0.6, False)])
def test_a_stribeck_curve_is_seen_where_there_is_one(tmp_path: Path, dip: float, none: bool) -> None:
    records_of(tmp_path, dip)
    experiment = JointFriction(path=str(tmp_path), short=True)
    data = experiment.compute(cl.build())
    assert experiment.finding(data)[1] == none
    if not none:
        best = numbers_of(data, joint_friction.CURVES[0])
        np.testing.assert_allclose([best[0], best[2], best[3]], [1.5, 0.1, 0.8], rtol=0.1)


def test_other_columns_of_a_joint_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="velocity_"):
        joint_friction.read_speeds(tmp_path)
    np.savetxt(tmp_path / "velocity_1.0readings.csv", np.zeros((10, 3)))
    with pytest.raises(ValueError, match="columns"):
        joint_friction.read_speeds(tmp_path)


A, B, D, K = 8e-3, 5e-3, 4e-5, 1e11
"""Effects, renewal distance [m] and stiffness [Pa/m] of a made rock."""


def rock(normal: float, time: np.ndarray, speeds: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return friction under Dieterich's law behind a spring, by SciPy in friction and logarithm of age."""

    def flow(t: float, z: np.ndarray) -> list[float]:
        pulled = speeds[min(np.searchsorted(edges, t, side="right") - 1, speeds.size - 1)]
        slip = 1e-5 * np.exp((z[0] - 0.58 - B * z[1]) / A)
        return [K / normal * (pulled - slip), (1e-5 * np.exp(-z[1]) - slip) / D]

    friction, state = [], np.array([0.58, 0.0])
    for begin, end in pairwise(edges):
        here = time[(time >= begin) & (time < end)]
        made = solve_ivp(flow, (begin, end), state, "LSODA", t_eval=here, rtol=1e-8, atol=1e-10)
        friction.append(made.y[0])
        state = solve_ivp(flow, (begin, end), state, "LSODA", rtol=1e-8, atol=1e-10).y[:, -1]
    return np.concatenate(friction)


def record_of(path: Path) -> dict[str, tuple[float, float]]:
    """Write a record of the published form with steps at two normal stresses; returns their times."""
    speeds = np.array([10.0, 1.0, 3.0, 10.0, 30.0, 10.0]) * 1e-6
    lasts = 4e-4 / speeds
    edges = np.append(0.0, np.cumsum(lasts))
    time = np.arange(0.0, edges[-1], 0.1)
    way = np.interp(time, edges, np.append(0.0, np.cumsum(speeds * lasts)))
    parts, windows = [np.zeros((600, 3))], {}
    for name, normal in (("15 MPa", 1.5e7), ("20 MPa", 2e7)):
        begin = 0.1 * sum(map(len, parts)) + 0.05
        friction = rock(normal, time, speeds, edges)
        parts.append(np.column_stack([parts[-1][-1, 0] + way, normal * friction, np.full(time.size, normal)]))
        windows[name] = (begin, 0.1 * sum(map(len, parts)) + 0.05)
    point, shear, normal_stress = np.concatenate(parts).T
    columns = np.stack(
        [
            np.full(point.size, 0.1 / velocity_steps.PERIOD),
            point / velocity_steps.POINT,
            shear / velocity_steps.SHEAR,
            np.zeros(point.size),
            normal_stress / velocity_steps.NORMAL,
        ]
    )
    head = bytearray(velocity_steps.HEAD)
    head[velocity_steps.COUNT_AT : velocity_steps.COUNT_AT + 4] = point.size.to_bytes(4, "big")
    path.write_bytes(bytes(head) + columns.astype(">f4").tobytes())
    return windows


def test_the_state_of_a_made_rock_is_found_and_carries_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "record"
    monkeypatch.setattr(velocity_steps, "WINDOWS", record_of(path))
    monkeypatch.setattr(velocity_steps, "MOVED", ())
    experiment = VelocitySteps(path=str(path), short=True)
    data = experiment.compute(cl.build())
    for seen in data.fitted.values:
        best = data.numbers.sel(law="rate_and_state", fitted=seen).values
        np.testing.assert_allclose(best[:3], [A, B, D], rtol=0.1)
        np.testing.assert_allclose(best[3], K, rtol=0.25)
        assert experiment.ratio(data, "rate_and_state", velocity_steps.REFERENCE, str(seen))["ratio"] < 0.2


def test_a_record_that_is_cut_off_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "record"
    record_of(path)
    path.write_bytes(path.read_bytes()[:-4])
    with pytest.raises(ValueError, match="columns"):
        velocity_steps.read_record(path)
