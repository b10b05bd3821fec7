"""Claims on fits of forces behind a frame: its numbers are found beside those of the law."""

from pathlib import Path

import numpy as np
import pytest

import contactlab as cl
from contactlab.cli.study import as_overrides
from contactlab.config import ConfigurationError
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.measured.series import MeasuredSeries

LOAD, FRICTION, STIFFNESS, NOISE = 10.0, 0.3, 2e6, 0.03
"""Load [N], friction coefficient, stiffness of the frame [N/m] and noise [N]: the truth."""

FREE = {"contact.friction_coefficient": (0.05, 1.0), "frame_stiffness": ("0.2 N/um", "20 N/um")}

TIME = np.linspace(0.0, 1.0, 161)
WAY = 6e-6 * np.sin(4.0 * np.pi * TIME) + 2e-6 * np.sin(2.0 * np.pi * TIME)


def jenkins(stiffness: float, most: float) -> np.ndarray:
    """Force of a spring and a slider in series, by its increments over a finer path."""
    fine = np.linspace(0.0, 1.0, 160 * 200 + 1)
    way = 6e-6 * np.sin(4.0 * np.pi * fine) + 2e-6 * np.sin(2.0 * np.pi * fine)
    force = np.zeros(fine.size)
    for i, moved in enumerate(np.diff(way)):
        force[i + 1] = min(max(force[i] - stiffness * moved, -most), most)
    return force[::200]


def measured(seed: int = 3, stiffness: float = STIFFNESS) -> MeasuredSeries:
    """A loop of rigid friction behind a frame, with noise."""
    exact = jenkins(stiffness, FRICTION * LOAD)
    force = exact + np.random.default_rng(seed).normal(0.0, NOISE, TIME.size)
    path = {"slip": WAY, "normal": LOAD + 0.0 * TIME}
    errors = {"friction_force": np.full(TIME.size, NOISE)}
    return MeasuredSeries(TIME, {"friction_force": force}, errors, {}, {}, "", path)


def test_stiffness_of_the_frame_and_friction_are_found_within_their_intervals() -> None:
    fit = cl.fit(
        cl.LagrangeStick(friction_coefficient=0.5),
        data=measured(),
        free=FREE,
        method="least_squares",
        output=None,
    )
    summary = next(iter(fit.data.children.values()))["summary"].to_dataset()
    for key, truth in zip(FREE, (FRICTION, STIFFNESS), strict=True):
        row = summary.sel(parameter=key)
        middle, half = 0.5 * float(row["high"] + row["low"]), 0.5 * float(row["high"] - row["low"])
        # Half of the 90 % interval is 1.6 deviations.
        assert abs(middle - truth) < 2.0 * half < 0.02 * truth
    attributes = next(iter(fit.data.children.values())).attrs
    assert attributes["fits"] == 1
    assert 0.8 < attributes["misfit"] < 1.2


def test_a_known_stiffness_is_in_the_prediction_and_a_damping_without_influence_is_not_free() -> None:
    """A slow loop feels no damper: c v is a billionth of the friction."""
    setup = {"": cl.build(["law=lagrange_stick"])}
    free = {"contact.friction_coefficient": (0.05, 1.0), "frame_damping": (1e-9, 1e-6)}
    (candidate,) = candidates_of(measured(), setup, free, frame={"frame_stiffness": STIFFNESS})
    assert [item.name for item in candidate.problem.parameters] == ["contact.friction_coefficient"]
    assert "frame_damping." in candidate.numbers
    predicted = candidate.problem.predict(np.array([FRICTION]))["friction_force"]
    np.testing.assert_allclose(predicted, jenkins(STIFFNESS, FRICTION * LOAD), atol=2e-3 * FRICTION * LOAD)


def test_each_file_may_have_a_frame_of_its_own() -> None:
    sets = {"soft": measured(4), "stiff": measured(5, 3.0 * STIFFNESS)}
    setup = {"": cl.build(["law=lagrange_stick"])}
    (candidate,) = candidates_of(sets, setup, FREE, own=["frame_stiffness"])
    names = [item.name for item in candidate.problem.parameters]
    assert names == ["contact.friction_coefficient", "soft.frame_stiffness", "stiff.frame_stiffness"]
    predicted = candidate.problem.predict(np.array([FRICTION, STIFFNESS, 3.0 * STIFFNESS]))
    for label, stiffness in (("soft", STIFFNESS), ("stiff", 3.0 * STIFFNESS)):
        exact = jenkins(stiffness, FRICTION * LOAD)
        np.testing.assert_allclose(predicted[f"{label}.friction_force"], exact, atol=2e-3 * FRICTION * LOAD)


@pytest.mark.parametrize(
    ("free", "frame", "key"),
    [
        (FREE, {"frame_stiffness": 1e6}, "frame_stiffness"),
        ({"frame_damping": (1.0, 10.0)}, {}, "frame_stiffness"),
        ({"frame_stiffness": (-1.0, 1e6)}, {}, "frame_stiffness"),
    ],
)
def test_a_frame_of_another_kind_is_refused(free: dict, frame: dict, key: str) -> None:
    with pytest.raises(ConfigurationError, match=key):
        candidates_of(measured(), {"": cl.build(["law=lagrange_stick"])}, free, frame=frame)


def test_a_frame_is_of_a_path_that_stays_closed() -> None:
    data, setup = measured(), {"": cl.build(["law=composed"])}
    path = {"slip": WAY, "gap": 1e-6 * np.cos(20.0 * TIME)}
    opens = MeasuredSeries(TIME, data.values, data.errors, {}, {}, "", path)
    with pytest.raises(ConfigurationError, match="gap"):
        candidates_of(opens, setup, FREE)
    series = MeasuredSeries(TIME, {"rotor_velocity": TIME}, {}, {}, {})
    with pytest.raises(ConfigurationError, match="frame_stiffness"):
        candidates_of(series, {"": cl.build([])}, FREE)


def test_on_the_command_a_number_of_the_frame_is_a_value_or_a_range(tmp_path: Path) -> None:
    lines = as_overrides("fit", ["loop.csv", "law=dahl", "frame_stiffness=1 N/um..9 N/um"])
    (free,) = (line for line in lines if line.startswith("study.free="))
    assert "frame_stiffness=1 N/um..9 N/um" in free
    lines = as_overrides("fit", ["loop.csv", "law=dahl", "frame_stiffness=2 N/um"])
    assert any(line.startswith("study.frame_stiffness=") for line in lines)
