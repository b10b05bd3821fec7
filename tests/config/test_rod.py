"""The rod of the tip has one length."""

import pytest

import contactlab as cl


def test_a_rod_as_long_as_the_tip_is_built_and_another_is_refused() -> None:
    overrides = ["resonator=finite_element", "resonator.rod_length=19 mm"]
    assert cl.build(overrides).configuration["resonator"]["rod_length"] == 0.019
    with pytest.raises(cl.ConfigurationError, match=r"resonator\.rod_length"):
        cl.build([*overrides, "contact.tip_length=18 mm"])
