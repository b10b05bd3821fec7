"""The published impacts of an ellipse, which lie beside the project or not at all."""

import numpy as np
import pytest
from support.measurements import ELLIPSES

from contactlab.measured.ellipses import read_ellipses
from contactlab.measured.impacts import MeasuredImpacts

pytestmark = pytest.mark.skipif(
    not ELLIPSES.is_file(), reason="the published impacts of ellipses are not here"
)


@pytest.fixture(scope="module")
def ellipses() -> MeasuredImpacts:
    return read_ellipses(ELLIPSES)


def test_no_impulse_explains_the_ellipses_better_than_to_four_percent(ellipses: MeasuredImpacts) -> None:
    """The norm of the published comparisons, on the impacts that no flag marks."""
    assert (len(ellipses), ellipses.left_out) == (1718, 282)
    assert ellipses.errors(ellipses.velocity_after).mean() == pytest.approx(0.040, abs=5e-4)


def test_without_friction_the_ellipses_are_missed_by_more_than_a_quarter(ellipses: MeasuredImpacts) -> None:
    before, delassus = ellipses.velocity_before, ellipses.delassus
    errors = []
    for restitution in np.linspace(0.4, 0.7, 31):
        impulse = -(1.0 + restitution) * before[:, 0] / delassus[:, 0, 0]
        errors.append(ellipses.errors(before + delassus[:, :, 0] * impulse[:, None]).mean())
    assert min(errors) == pytest.approx(0.287, abs=0.005)


def test_every_ellipse_approaches_and_leaves_and_is_pushed(ellipses: MeasuredImpacts) -> None:
    jump = ellipses.velocity_after - ellipses.velocity_before
    impulse = np.linalg.solve(ellipses.delassus, jump[..., None])[:, 0, 0]
    assert (ellipses.velocity_before[:, 0] < 0.0).all()
    assert (ellipses.velocity_after[:, 0] > 0.0).all()
    assert (impulse > 0.0).all()


def test_the_sign_of_the_tangential_arm_is_found_and_told(ellipses: MeasuredImpacts) -> None:
    assert "reversed" in ellipses.notes[0]
    assert "0.05 %" in ellipses.notes[0]
    assert "3.07 %" in ellipses.notes[0]
