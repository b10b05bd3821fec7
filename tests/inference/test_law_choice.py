"""Claims on laws and free numbers chosen by overrides."""

import pytest

from contactlab.config import ConfigurationError
from contactlab.inference.law_choice import law_predictors


@pytest.mark.parametrize(
    ("overrides", "named"),
    [
        (["law=newtn"], "newton"),
        (["law=newton", "law.restitutio=0.5"], "law.restitutio"),
        (["law=newton", "law.restitution=0.5..1.5"], "law.restitution"),
        (["law=newton", "law.restitution=hard"], "law.restitution"),
        (["law=newton", "law.restitution=0.5", "law.restitution=0.6"], "law.restitution"),
        (["law=newton", "law.restitution=0..1", "law.restitution=0..0.5"], "law.restitution"),
        (["law=newton,newton"], "law=newton"),
        (["drive.voltage_1=3"], "drive.voltage_1"),
        (["law=newton", "law/friction=sticky"], "sticky"),
        (["law/frictions=lugre"], "law/frictions"),
        (["newton"], "newton"),
    ],
)
def test_what_chooses_no_law_is_refused(overrides: list[str], named: str) -> None:
    with pytest.raises(ConfigurationError, match=named):
        law_predictors(overrides)


def test_parts_make_every_combination_and_numbers_are_fixed_or_free() -> None:
    overrides = ["law=newton", "law/damping=flores", "law/friction=coulomb,mindlin"]
    result = law_predictors([*overrides, "contact.friction_coefficient=0.2"])

    assert [item.label for item in result] == [
        "newton",
        "hertz_point + flores + coulomb",
        "hertz_point + flores + mindlin",
    ]
    assert [item.name for item in result[0].free] == ["restitution"]
    assert result[2].law.describe()["friction.friction_coefficient"] == 0.2
    (item,) = law_predictors(["law/normal=linear", "law.normal.stiffness=1 N/um..1 kN/um"])
    assert [(free.low, free.high) for free in item.free if free.name == "normal.stiffness"] == [(1e6, 1e9)]
