"""What fits and validations tell of themselves while one waits."""

import sys
from math import isfinite
from pathlib import Path

import pytest
from data_support.measured_impacts import drawn_impacts
from hypothesis import given, strategies as st
from support.terminals import assert_terminal_is_written_to, reports_of, slow

from contactlab.cli.main import main
from contactlab.parameter import Parameter
from contactlab.studies.study import Task
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.least_squares import LOOKS, Optimum, best_fit
from contactlab_data.inference.nested_sampling import _Left
from contactlab_data.measured.files import write_impacts

POINTS = "rotor.load_torque [N m],rotor_velocity [rad/s]\n-1e-4,-2\n-1e-3,-1\n"


# The child runs the command at once, and no thread is left in it.
@pytest.mark.filterwarnings("ignore:.*forkpty:DeprecationWarning")
@pytest.mark.parametrize(
    "arguments",
    [
        ["validate", "impacts.csv", "law=newton"],
        ["fit", "points.csv", "law=hertz_penalty", "contact.friction_coefficient=0.1..0.5"],
    ],
    ids=" ".join,
)
def test_a_terminal_is_written_to_while_a_task_takes_long(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("points.csv").write_text(POINTS)
    write_impacts(drawn_impacts(60, 1), Path("impacts.csv"))
    monkeypatch.setattr(Task, "__call__", slow)
    monkeypatch.setattr(sys, "argv", ["contactlab", *arguments])
    assert_terminal_is_written_to(main)


def test_least_squares_tell_every_evaluation_and_have_the_same_bits() -> None:
    free = [FreeParameter("x", 0.0, 1.0, False, Parameter("x", "1", "any number"))]
    optima: list[Optimum] = []

    def search() -> None:
        optima.append(best_fit(lambda values: values**2 - 0.3, free, 3, 0))

    reports = reports_of(search)
    shares = [share for _, share in reports]
    assert len(reports) > 3 * LOOKS
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= shares[-1] <= 1.0
    search()
    assert optima[0].values == optima[1].values


@given(st.floats(1e-6, 1e9), st.integers(25, 1000))
def test_evidence_left_has_an_estimate_that_ends_with_it(grows: float, points: int) -> None:
    left = _Left(points)

    class Results:
        delta_logz = grows

    ((text, share),) = reports_of(lambda: left(Results, 100, 500, dlogz=0.1))
    assert "500 evaluations" in text
    assert isfinite(share)
    assert 0.0 < share <= 1.0
    assert (share == 1.0) == (grows <= 0.1)
