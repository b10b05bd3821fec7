"""Claims on the calibration of laws to one datum."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import contactlab as cl
from contactlab.inference.calibration import Datum, calibrated
from contactlab.inference.free_parameters import with_values

BALL = np.array([[400.0, 0.0], [0.0, 1400.0]])
"""A free ball of 2.5 g."""


@settings(max_examples=5)
@given(st.floats(0.2, 0.9), st.floats(0.05, 0.5))
def test_laws_of_both_families_get_the_restitution(value: float, speed: float) -> None:
    datum = Datum("restitution", value, speed)
    for law in (cl.Newton(0.3, 0.5), cl.build(["law=composed", "law/damping=hunt_crossley"]).law):
        number = calibrated(law, datum, BALL)
        assert number is not None
        free, x = number
        assert datum.measured(with_values(law, [free], [x]), BALL) == pytest.approx(value, rel=1e-6)


def test_hertz_gets_a_contact_time_by_the_closed_form_of_its_stiffness() -> None:
    """t = 2.943 (m^2 / (k^2 v))^(1/5) for (5/4)^(2/5)-scaled k: t^5 k^2 is constant."""
    law = cl.build(["law=hertz_penalty"]).law
    times = (40e-6, 80e-6)
    numbers = [calibrated(law, Datum("contact_time", t, 0.1), BALL) for t in times]
    assert all(each is not None and each[0].name == "stiffness" for each in numbers)
    k = [each[1] for each in numbers if each]
    assert k[0] / k[1] == pytest.approx((times[1] / times[0]) ** 2.5, rel=1e-6)


def test_a_law_without_loss_has_no_restitution_to_be_set() -> None:
    assert calibrated(cl.build(["law=hertz_penalty"]).law, Datum("restitution", 0.5, 0.1), BALL) is None


@pytest.mark.parametrize(
    "text", ["restitution=1.5@0.1", "restitution=0.5", "contact_time=-1@1", "e=0.5@1", "restitution=a@1"]
)
def test_a_faulty_datum_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="restitution"):
        Datum.of_text(text)
