"""Claims on the free numbers of laws: a setup's law is what is fitted, ranges are data."""

import pytest
from data_support.struck_discs import struck_discs
from support.command_line import Command

import contactlab as cl
from contactlab.cli.study import as_overrides, setups_of
from contactlab.config import ConfigurationError
from contactlab_data.inference.law_numbers import Free, free_numbers, law_predictors


def setup(*overrides: str) -> dict[str, cl.Setup]:
    return {"": cl.build(overrides)}


@pytest.mark.parametrize(
    ("key", "ends"),
    [
        ("law.restitutio", (0.0, 0.5)),
        ("law.restitution", (0.5, 1.5)),
        ("law.restitution", ("hard", "soft")),
        ("law.restitution", (0.5,)),
        ("law.restitution", ("1 m", "2 m")),
        ("contact.friction_coefficient", (0.5, 0.1)),
    ],
)
def test_what_no_number_can_be_is_refused_by_its_key(key: str, ends: tuple[float | str, ...]) -> None:
    for refusing in (free_numbers, law_predictors):
        with pytest.raises(ConfigurationError, match=key):
            refusing(setup("law=newton"), {key: ends})


def test_numbers_that_are_stated_are_known_and_all_others_of_a_law_are_free(command: Command) -> None:
    made = setup("law=newton")
    assert len(free_numbers(made, {})[""]) == len(law_predictors(made, {})[0].free) == 2
    (predictor,) = law_predictors(
        setup("law=newton", "contact.friction_coefficient=0.2"), {}, ["contact.friction_coefficient"]
    )
    assert predictor.fixed == {"friction_coefficient": 0.2}
    known = ["law.restitution"]
    assert [item.name for item in free_numbers(made, {}, known)[""]] == ["contact.friction_coefficient"]
    (predictor,) = law_predictors(made, {}, known)
    assert [item.name for item in predictor.free] == ["friction_coefficient"]
    for refusing in (free_numbers, law_predictors):
        with pytest.raises(ConfigurationError, match=r"law\.stiffness"):
            refusing(made, {}, ["law.stiffness"])
    default = cl.Newton().restitution
    overrides = as_overrides("fit", ["a.csv", "law=newton", f"law.restitution={default}"])
    assert "study.known=['law.restitution']" in overrides


def test_ranges_alone_are_free_of_one_law_and_with_its_own_numbers_of_each_of_several() -> None:
    free: Free = {"contact.friction_coefficient": ("0.1", "0.5"), "drive.voltage_1": ("50 V", 0.15e3)}
    newton, stick = cl.build(["law=newton"]), cl.build(["law=composed", "law/normal=walton_braun"])
    (alone,) = free_numbers({"": newton}, free).values()
    assert [(item.name, item.low, item.high) for item in alone] == [
        ("contact.friction_coefficient", 0.1, 0.5),
        ("drive.voltage_1", 50.0, 150.0),
    ]
    several = free_numbers({"a": newton, "b": stick}, free)
    assert {item.name for item in several["a"]} == {*free, "law.restitution"}
    assert {item.name for item in several["b"]} > {*free, "law.normal.unloading_stiffness"}


def test_laws_of_a_command_are_setups_with_the_parts_and_numbers_that_they_have() -> None:
    lines = ["law/damping=flores", "law.damping.restitution=0.5", "contact.friction_coefficient=0.2"]
    made = setups_of([], ["law=newton,composed", "law/friction=coulomb,mindlin", *lines], {})
    assert {label: each.law for label, each in made.items()} == {
        "law=newton": cl.Newton(0.2),
        "law=composed, law/friction=coulomb": cl.law(
            "composed", damping=cl.Flores(0.5), friction=cl.Coulomb(0.2)
        ),
        "law=composed, law/friction=mindlin": cl.law(
            "composed", damping=cl.Flores(0.5), friction=cl.Mindlin(0.2)
        ),
    }
    with pytest.raises(ConfigurationError, match="stiffness"):
        setups_of([], ["law=newton,poisson", "law.stiffness=1"], {})
    with pytest.raises(ConfigurationError, match="newton"):
        setups_of([], ["law=newton,newton"], {})


def test_a_command_puts_its_overrides_on_the_motor_of_the_data() -> None:
    data = cl.build(["contact.clearance=0.7 um", "law=newton", "law.restitution=0.4"]).configuration
    assert setups_of([], [], data) == {}
    made = setups_of([], ["drive.phase=0.5"], data)[""]
    assert made.law == cl.Newton(restitution=0.4)
    assert made.motor.geometry.clearance == 0.7e-6
    other = setups_of([], ["law=poisson"], data)[""]
    assert other.law == cl.Poisson()
    assert other.motor.geometry.clearance == 0.7e-6


@pytest.mark.long
def test_options_are_data_in_python_and_in_the_file(tmp_path) -> None:
    discs = struck_discs(cl.Newton(0.2, 0.6), 30, seed=1, spread=0.05)
    free = {"law.restitution": (0.1, 0.9)}
    made = cl.validate(cl.Newton(), data=discs, free=free, folds=2, output=tmp_path)
    assert made.study.options["free"] == {"law.restitution": [0.1, 0.9]}
    again = cl.load(tmp_path / "validate.nc")
    assert again.study.free == {"law.restitution": [0.1, 0.9]}
    assert again.study.data == discs.content_digest


def test_a_range_that_is_stated_twice_is_refused(command: Command) -> None:
    for word in ("law.restitution=0.1..0.5", "free=law.restitution=0.1..0.5"):
        status, _, error = command("validate", "none.csv", word, "law.restitution=0..1")
        assert status == 2
        assert "law.restitution" in error


def test_a_number_of_a_law_that_has_no_value_yet_is_one_of_the_law() -> None:
    """Viscous friction is none by default, and may be free in a fit of a loop nevertheless."""
    key = "law.viscous_friction"
    (item,) = free_numbers({"": cl.build(["law=composed"])}, {key: (0.0, 40.0)})[""]
    assert item.field == "viscous_friction"
