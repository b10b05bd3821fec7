"""Claims on repeated rows of measured impacts: copies are counted and belong to one measurement."""

from dataclasses import replace

import numpy as np
import pytest
from data_support.measured_impacts import drawn_impacts
from data_support.struck_discs import struck_discs

import contactlab as cl
from contactlab_data.inference.cross_validation import ValidationError


def copied(impacts, times):
    """Every impact several times, with numbers of their own."""
    many = impacts.part(np.tile(np.arange(len(impacts)), times))
    return replace(many, number=np.arange(1, len(many) + 1))


def test_impacts_without_copies_are_each_a_measurement_of_its_own():
    impacts = drawn_impacts(50, seed=0, covariance=True)

    assert impacts.measurements().tolist() == list(range(50))
    assert impacts.copies_warning() == ""


def test_copies_are_counted_and_belong_to_one_measurement():
    impacts = copied(drawn_impacts(50, seed=0, covariance=True), 5)

    assert impacts.measurements().tolist() == list(range(50)) * 5
    assert impacts.copies_warning().startswith("200 of 250 ")


def test_a_difference_in_the_last_bit_is_no_copy():
    impacts = copied(drawn_impacts(10, seed=0), 2)
    after = impacts.velocity_after.copy()
    after[13, 1] = np.nextafter(after[13, 1], np.inf)

    assert replace(impacts, velocity_after=after).copies_warning().startswith("9 of 20 ")


def test_labels_unite_and_copies_unite_labels():
    impacts = replace(drawn_impacts(6, seed=1), measurement=np.array([7, 7, 3, 3, 9, -2]))
    assert impacts.measurements().tolist() == [0, 0, 1, 1, 2, 3]
    assert impacts.copies_warning() == ""
    # The fifth repeats the first: 7 and 9 are one.
    places = np.array([0, 1, 2, 3, 0, 5])
    united = replace(impacts.part(places), measurement=impacts.measurement)
    assert united.measurements().tolist() == [0, 0, 1, 1, 0, 2]


def test_labels_change_the_digest():
    impacts = drawn_impacts(2, seed=1)

    assert replace(impacts, measurement=np.array([1, 1])).content_digest != impacts.content_digest


def test_a_validation_holds_copies_and_repeats_out_together_and_warns_of_copies():
    impacts = struck_discs(cl.Newton(0.5, 0.2), 20, seed=0, spread=0.02)
    many = copied(replace(impacts, measurement=np.arange(20) // 2), 2)
    outcome = cl.validate(cl.Newton(), data=many, folds=2)

    # Two copies of two repeats of a measurement.
    fold = outcome.data["fold"].values.reshape(2, 10, 2)
    assert (fold == fold[:1, :, :1]).all()
    assert any("20 of 40 " in line for line in outcome.findings)


def test_copies_do_not_make_enough_impacts():
    with pytest.raises(ValidationError):
        cl.validate(cl.Newton(), data=copied(struck_discs(cl.Newton(0.5, 0.2), 9, seed=0), 5))


def test_a_fit_warns_of_copies():
    impacts = copied(struck_discs(cl.Newton(0.5, 0.2), 10, seed=0, spread=0.02), 2)
    result = cl.fit(cl.build(["law=newton"]), data=impacts, points=25, starts=1)
    assert any("10 of 20 impacts" in line for line in result.findings)
