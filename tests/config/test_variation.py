"""Setups of one configuration with other values of a key are those that are built whole."""

from math import inf

import pytest

from contactlab.config import ConfigurationError, rebuild, variation
from contactlab.config.composition import compose, with_references
from contactlab.config.nesting import Value, with_key
from contactlab.config.schema import numbers_in
from contactlab.config.setup import Setup, Values
from contactlab.config.variation import Variation
from contactlab.parameter import DeclaredField

BASES = {
    "default": [],
    "rigid": ["law=newton", "solver.duration=5 ms"],
    "on a bearing": ["law=lagrange_stick", "contact.preload=1 N", "drive=two_phase"],
    "composed": ["law=composed", "law/normal=hertz_point", "law/friction=lugre", "record.interval=2 us"],
    "chirp": ["drive=chirp", "resonator=finite_element", "solver.contact_step=1 us"],
}

NUMBERS = {
    f"{name}: {key}": (lines, key, field)
    for name, lines in BASES.items()
    for key, field in numbers_in(compose(lines)).items()
}


def built(configuration: Values) -> Setup:
    return rebuild(with_references(configuration))


def outcome(make: object) -> Setup | tuple[str, ...] | None:
    try:
        return make()  # type: ignore[operator, no-any-return]
    except ConfigurationError as error:
        return tuple(error.faults)


def some_values(field: DeclaredField, now: object) -> list[Value]:
    """Values near the present one, and others that are refused or nearly so."""
    usual = now if isinstance(now, int | float) else 1e-5
    near: list[Value] = [usual * 1.01 if usual else 1e-3, usual * 0.98]
    return [*near, 0, -1.0, 1e3, inf, "a text", usual]


@pytest.mark.parametrize("case", NUMBERS)
def test_a_varied_number_gives_the_setup_of_its_whole_configuration_or_its_faults(case: str) -> None:
    lines, key, field = NUMBERS[case]
    base = compose(lines)
    now = base
    for name in key.split("."):
        now = now[name]
    variation = Variation(base, built)
    for value in some_values(field, now):
        varied = outcome(lambda value=value: variation.setup({key: value}))
        whole = outcome(lambda value=value: built(with_key(base, key, value)))
        assert varied == whole
        checked = outcome(lambda value=value: variation.check({key: value}))
        assert checked == (None if isinstance(whole, Setup) else whole)
        if isinstance(varied, Setup) and isinstance(whole, Setup):
            assert str(varied.configuration) == str(whole.configuration)
            assert varied.origin is not None
            assert varied.source == whole.source


def test_one_configuration_is_built_whole_and_what_a_number_does_not_change_is_shared() -> None:
    whole = []

    def counted(configuration: Values) -> Setup:
        whole.append(configuration)
        return built(configuration)

    variation = Variation(compose([]), counted)
    setups = [variation.setup({"drive.phase": 0.1 * i, "contact.clearance": 1e-6}) for i in range(4)]
    assert len(whole) == 1
    assert [setup.configuration["drive"]["phase"] for setup in setups] == [0.1 * i for i in range(4)]
    assert all(setup.motor.modes is setups[0].motor.modes for setup in setups)
    assert all(setup.law is setups[0].law for setup in setups)
    # Another number changes the law.
    assert variation.setup({"contact.friction_coefficient": 0.2}).law != setups[0].law
    assert variation.setup({"contact.friction_coefficient": 0.1}).law.friction_limit == 0.1
    assert len(whole) == 2


def test_numbers_that_their_ranges_and_relations_alone_can_refuse_are_checked_without_a_setup(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    check = Variation(compose(["law=newton"]), built)
    check.check({"drive.phase": 0.0, "contact.clearance": 1e-6})

    def refused(*_: object) -> Setup:
        raise AssertionError("A setup was built.")

    monkeypatch.setattr(variation, "assembled", refused)
    check.check({"drive.phase": 1.0, "contact.clearance": 2e-6})
    # Thicker than the beam.
    with pytest.raises(ConfigurationError, match=r"contact\.clearance"):
        check.check({"drive.phase": 1.0, "contact.clearance": 0.1})


def test_a_number_that_others_refer_to_changes_them_too() -> None:
    variation = Variation(with_key(compose([]), "drive.voltage_2", "${drive.voltage_1}"), built)
    for voltage in (80.0, 90.0):
        drive = variation.setup({"drive.voltage_1": voltage}).configuration["drive"]
        assert drive["voltage_1"] == drive["voltage_2"] == voltage
