"""Claims on impacts of tracks: coverage of their velocities, exactness, breaks that are none, and files."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray
from data_support.tracks import (
    FRICTION,
    GRAVITY,
    HEAD,
    INERTIA,
    MASS,
    RADIUS,
    RESTITUTION,
    Throw,
    columns_of,
    read,
    text_of,
    throw,
    write_throws,
)
from scipy.special import stdtrit

import contactlab as cl
from contactlab.arrays import Array
from contactlab_data.measured.files import MeasurementError, read_impacts
from contactlab_data.measured.impacts import MeasuredImpacts
from contactlab_data.measured.tracks import CHANCE, CONSTANTS, FEWEST, POSITIONS, Motion, breaks_of, phases_of

DOCS = Path(__file__).resolve().parents[4] / "docs"
NOISE = (1e-4, 3e-4, 0.02)


def impacts_of(made: Throw, **head: str) -> MeasuredImpacts:
    return read(text_of(columns_of(made), **HEAD | head))


def reasons(impacts: MeasuredImpacts) -> list[str]:
    assert impacts.tracks is not None
    return [str(reason) for reason in impacts.tracks["reason"].values]


def refusal(made: Throw, **head: str) -> str:
    with pytest.raises(MeasurementError) as caught:
        impacts_of(made, **head)
    return str(caught.value)


def moved(made: Throw, position: Array) -> Throw:
    return made._replace(position=position)


def motion_of(made: Throw) -> Motion:
    rows = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, RADIUS]), np.array([MASS, MASS, INERTIA])
    return Motion(made.time, made.position, np.ones(made.time.size), GRAVITY, *rows)


@pytest.mark.parametrize("count", [200, pytest.param(1000, marks=pytest.mark.long)])
def test_intervals_of_95_percent_hold_the_true_velocities_before_and_after_in_95_percent_of_tracks(
    count: int,
) -> None:
    rng, inside, noises = np.random.default_rng(2), [], []
    for _ in range(count):
        made = throw(rng, noise=NOISE)
        phases, noise = phases_of(motion_of(made))
        noises.append(noise)
        only, *others = breaks_of(motion_of(made), phases, noise, None)
        if others or only.reason:
            continue
        missed = only.velocity - np.append(made.before, made.after)
        # The noise is of the residuals, so that errors over it have Student's distribution.
        end = stdtrit(made.time.size - 4, 0.975)
        inside.append(np.abs(missed) < end * np.sqrt(np.diag(only.covariance)))
    # Noise may add a break, and each kind of check may err.
    assert len(inside) >= (1.0 - 3.0 * CHANCE) * count
    share = np.mean(inside, axis=0)
    assert np.abs(share - 0.95).max() < 3.0 * np.sqrt(0.95 * 0.05 / len(inside)), share
    # Of a hundred samples a track; a root is low by a quarter of the reciprocal of their number.
    assert np.mean(noises, axis=0) == pytest.approx(NOISE, rel=3.0 / np.sqrt(200.0 * count) + 0.0025)


def test_a_track_without_noise_has_the_exact_velocities() -> None:
    made = throw(np.random.default_rng(2), impacts=4)
    impacts = impacts_of(made)
    assert impacts.bodies is not None
    assert (impacts.number.tolist(), impacts.left_out) == ([1, 2, 3, 4], 0)
    np.testing.assert_allclose(impacts.bodies.before, made.before, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(impacts.bodies.after, made.after, rtol=0.0, atol=1e-12)
    # A solid sphere that rolls where it sticks; no part of the jump is beyond impulses.
    assert impacts.delassus == pytest.approx(np.tile(np.diag([1.0, 3.5]) / MASS, (4, 1, 1)), rel=1e-12)
    assert impacts.velocity_before[:, 1] == pytest.approx(made.before[:, 0] + RADIUS * made.before[:, 2])
    assert impacts.outside.max() < 1e-12 * impacts.kinetic_energy.min()
    assert impacts.covariance is not None
    assert np.sqrt(impacts.covariance.max()) < 1e-5
    assert impacts.tracks is not None
    np.testing.assert_allclose(impacts.tracks["break_time"], made.instant, rtol=0.0, atol=1e-13)


def test_pixels_with_y_downwards_and_angles_of_a_turn_make_the_same_impacts() -> None:
    made = throw(np.random.default_rng(3), impacts=3, noise=NOISE)
    expected, scale = impacts_of(made), 2.5e-4
    x, y, angle = made.position.T
    columns = {
        "x": x / scale,
        "y": 800.0 - y / scale,
        "time": 1e3 * made.time,
        "angle": np.degrees(-angle) % 360.0,
    }
    units = {"time": "ms", "x": "px", "y": "px", "angle": "deg"}
    result = read(
        text_of(columns, units, **HEAD, scale="0.25 mm/px", gravity="-9.81 m/s^2", height="-800 px")
    )
    # The tangent points the other way.
    signs = np.array([1.0, -1.0])
    assert result.velocity_before == pytest.approx(expected.velocity_before * signs, abs=1e-9)
    assert result.velocity_after == pytest.approx(expected.velocity_after * signs, abs=1e-9)
    assert result.covariance == pytest.approx(
        expected.covariance * np.outer(signs, signs), rel=1e-6, abs=1e-14
    )


def test_a_surface_may_be_inclined_and_gravity_be_none() -> None:
    """A puck on a table, from a wall whose normal is (-0.6, 0.8); the noise of x and y is another."""
    time, normal, tangent = np.arange(60) * 0.01, np.array([-0.6, 0.8]), np.array([0.8, 0.6])
    before, after = -0.9 * normal + 0.5 * tangent, 0.6 * normal + 0.3 * tangent
    s = (time - 0.3037)[:, None]
    exact = np.where(s < 0.0, before * s, after * s)
    head = {"mass": "30 g", "gravity": "0 m/s^2", "normal_x": "-3", "normal_y": "4"}
    position = exact + np.random.default_rng(0).normal(size=exact.shape) * [1e-4, 4e-4]
    results = [read(text_of({"time": time, "x": x[:, 0], "y": x[:, 1]}, **head)) for x in (exact, position)]
    np.testing.assert_allclose(results[0].velocity_before, [[-0.9, 0.5]], rtol=1e-12)
    np.testing.assert_allclose(results[0].velocity_after, [[0.6, 0.3]], rtol=1e-12)
    covariance = results[1].covariance
    assert covariance is not None
    # 12 s^2 / (n (n^2 - 1) h^2) of x and y, turned to the normal; errors before act by the restitution.
    across, passed = np.array([[-0.6, 0.8], [0.8, 0.6]]), np.diag([-0.6 / 0.9, 1.0])
    left, right = (
        across @ np.diag([12.0 * noise**2 / (n * (n * n - 1.0) * 1e-4) for noise in (1e-4, 4e-4)]) @ across.T
        for n in (31, 29)
    )
    expected = right + passed @ left @ passed.T
    # The noise is of 56 residuals a coordinate: its square is known to a fifth.
    assert covariance[0] == pytest.approx(expected, rel=0.5, abs=0.2 * expected.max())
    missed = (results[1].velocity_after - [0.6, 0.3]) - (results[1].velocity_before - [-0.9, 0.5]) @ passed
    assert missed[0] @ np.linalg.solve(covariance[0], missed[0]) < 13.8  # 0.1 %


def test_breaks_that_are_no_impacts_are_left_out_with_their_reasons() -> None:
    made = throw(np.random.default_rng(4), impacts=3, rate=500.0, noise=NOISE)
    place = np.searchsorted(made.time, made.instant)
    assert reasons(impacts_of(made)) == ["", "", ""]
    middle = int(place[1] + place[2]) // 2
    # A wrong frame between two impacts, and a wall.
    position = made.position.copy()
    position[middle, 1] += 0.02
    position[middle + 40 :, 0] = 2.0 * position[middle + 40, 0] - position[middle + 40 :, 0]
    texts = reasons(impacts_of(moved(made, position)))
    assert [not text for text in texts] == [True, True, False, False, True]
    assert all("normal velocity" in text for text in texts if text)
    # Four frames in contact.
    position = made.position.copy()
    position[place[1] - 2 : place[1] + 2, 1] += np.array([0.0, 3e-3, -3e-3, 5e-3])
    impacts = impacts_of(moved(made, position))
    assert [bool(text) for text in reasons(impacts)] == [False, True, False]
    assert (impacts.left_out, impacts.number.tolist()) == (1, [1, 3])
    # A bat in the air that gives energy, or takes some.
    for factor, text in ((2.3, "gain"), (1.6, "distance")):
        hit = int(place[2]) - 15
        velocity = float(np.diff(made.position[hit - 5 : hit + 5, 1]).mean()) * 500.0
        position = made.position.copy()
        position[hit:, 1] -= factor * velocity * (made.time[hit:] - made.time[hit])
        cut = made._replace(time=made.time[: hit + 14], position=position[: hit + 14])
        texts = reasons(impacts_of(cut))
        assert [bool(each) for each in texts] == [False, False, True], texts
        assert text in texts[-1]


def test_a_ball_that_comes_to_rest_has_no_impacts_there() -> None:
    """Flights become shorter without end, then it rolls and slows down."""
    made = throw(np.random.default_rng(5), impacts=12, rate=500.0, noise=NOISE)
    rest = made.time[-1] + np.arange(1, 300) / 500.0
    way = 0.3 * (rest - made.time[-1]) * (1.0 - 0.5 * (rest - rest[0]))
    spread = np.random.default_rng(6).normal(size=(rest.size, 3)) * NOISE
    rolling = made.position[-1] * [1.0, 0.0, 1.0] + np.column_stack([way, 0.0 * way, -way / RADIUS]) + spread
    impacts = impacts_of(Throw(np.append(made.time, rest), np.vstack([made.position, rolling]), *made[2:]))
    assert impacts.tracks is not None
    instants = impacts.tracks["break_time"].values[impacts.number - 1]
    assert instants == pytest.approx(made.instant[: len(instants)], abs=1e-3)
    assert len(instants) >= 7
    assert any("rest" in text for text in reasons(impacts))


def test_flights_that_fall_otherwise_than_gravity_are_warned_of() -> None:
    made = throw(np.random.default_rng(7), impacts=3, noise=NOISE)
    assert not any("Warning" in note for note in impacts_of(made).notes)
    # The scale is 5 % too large.
    large = impacts_of(moved(made, made.position * [1.05, 1.05, 1.0]))
    assert any("Warning" in note for note in large.notes)


def test_a_faulty_file_of_tracks_is_refused_by_the_name_the_value_and_the_bound() -> None:
    made = throw(np.random.default_rng(8), impacts=2, noise=NOISE)
    count = made.time.size
    late = made._replace(time=np.where(np.arange(count) == 20, made.time[19], made.time))
    assert {"time", f"{made.time[19]:.9g}", "line 25"} <= tokens(refusal(late))
    nothing = moved(made, np.where(np.arange(count)[:, None] == 20, [np.nan, 0.0, 0.0], made.position))
    assert {"x", "nan", "line 25"} <= tokens(refusal(nothing))
    few = made._replace(time=made.time[:9], position=made.position[:9])
    assert {"9", str(2 * FEWEST)} <= tokens(refusal(few))
    before = int(np.searchsorted(made.time, made.instant[0]))
    assert "no impact" in refusal(made._replace(time=made.time[:before], position=made.position[:before]))
    assert "distance" in refusal(made, height="50 mm")
    for key, value in (
        ("mass", ""),
        ("mass", "-5 g"),
        ("radius", ""),
        ("inertia", "0 g mm^2"),
        ("scale", "1 m"),
    ):
        assert key in tokens(refusal(made, **{key: value}))
    assert {"normal_x", "normal_y", "0"} <= tokens(refusal(made, normal_y="0"))
    assert "whole" in refusal(made, track="1.5")
    # An angle that is counted clockwise.
    wrong = moved(made, made.position * [1.0, 1.0, -1.0])
    assert "tangential_angle" in refusal(wrong)
    impacts_of(wrong, jacobian="checked")
    assert "jacobian" in refusal(wrong, jacobian="fine")


def tokens(text: str) -> set[str]:
    """Return words of a message, and pairs of them."""
    each = [word.strip("'.,;#:") for word in text.split()]
    return {*each, *(f"{a} {b}" for a, b in pairwise(each))}


@pytest.mark.parametrize("name", ["time", *POSITIONS, "track", *CONSTANTS])
def test_the_page_names_every_column_and_constant(name: str) -> None:
    assert f"`{name}`" in (DOCS / "measured_data.md").read_text(encoding="utf-8")


def test_the_covariance_is_of_what_the_true_law_leaves_of_the_example() -> None:
    """Newton's law with the numbers in its title, to a root of 35; more of the slip, which mostly ends."""
    impacts = read_impacts(DOCS / "gallery" / "throws.csv")
    assert (len(impacts), impacts.left_out) == (35, 2)
    assert [text.partition(",")[0] for text in reasons(impacts) if text] == [
        "no change of the normal velocity",
        "rest",
    ]
    predicted = cl.impact(
        cl.Newton(0.05, 0.7), impacts.delassus, impacts.velocity_before
    ).velocity_after.values
    assert impacts.covariance is not None
    squares = (impacts.velocity_after - predicted) ** 2 / np.diagonal(impacts.covariance, 0, 1, 2)
    assert squares[:, 0].mean() == pytest.approx(1.0, abs=3.0 * np.sqrt(2.0 / 35))
    assert 0.3 < squares[:, 1].mean() < 1.0 + 3.0 * np.sqrt(2.0 / 35)


@pytest.mark.long
def test_a_file_of_tracks_is_validated_with_a_picture_of_them_and_fitted(tmp_path: Path) -> None:
    path = tmp_path / "throws.csv"
    write_throws(path, 6, 3, NOISE, seed=9)
    impacts = read_impacts(path)
    assert impacts.measurements().max() == 5
    result = cl.validate([cl.Newton()], data=path, folds=2, output=tmp_path / "out")
    value = result.data["value"].sel(law="newton")
    assert value.sel(parameter="restitution").values == pytest.approx(RESTITUTION, abs=2e-3)
    assert value.sel(parameter="friction_coefficient").values == pytest.approx(FRICTION, abs=1e-3)
    assert impacts.tracks is not None
    assert set(impacts.tracks.attrs["findings"].splitlines()) <= {*result.findings}
    read_back = cl.load(tmp_path / "out" / "validate.nc")
    assert isinstance(read_back, cl.Result)
    assert read_back.findings == result.findings
    xarray.testing.assert_equal(read_back.data["tracks"].to_dataset(inherit=False), impacts.tracks)
    assert {"tracks.png", "tracks.pdf"} <= {each.name for each in (tmp_path / "out").iterdir()}
    (candidate,) = cl.Fit(data=path).candidates({"": cl.build(["law=newton"])})
    assert candidate.origin["tracks"] == impacts.tracks.attrs["findings"]
