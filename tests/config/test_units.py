"""Texts with units become numbers in SI, and none becomes a wrong number."""

import math

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser
from hypothesis import given, strategies as st

import contactlab
from contactlab.cli.arguments import for_hydra
from contactlab.config.nesting import flat
from contactlab.laws.registry import own
from contactlab.parameter import from_cf, parameters_of
from contactlab.quantity import UnitError, to_si
from contactlab.studies.sweep.values import call_in


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("1 um", "m", 1e-6),
        ("1µm", "m", 1e-6),
        ("0.5 mm", "m", 0.5e-3),
        ("3.2 kHz", "Hz", 3200.0),
        ("7.5 Hz", "1/s", 7.5),
        ("5 ms", "s", 5e-3),
        ("311 us", "s", 311e-6),
        ("-36 deg", "rad", -math.pi / 5),
        ("-36°", "rad", -math.pi / 5),
        ("10 rpm", "rad/s", math.pi / 3),
        ("210 GPa", "Pa", 210e9),
        ("1.2 g", "kg", 1.2e-3),
        ("480 g cm**2", "kg m^2", 4.8e-5),
        ("7.85 g/cm^3", "kg/m^3", 7850.0),
        ("2 mN m", "N m", 2e-3),
        ("1 mNm", "N m", 1e-3),
        ("2 Nmm", "N m", 2e-3),
        ("3 µNms/rad", "N m s/rad", 3e-6),
        ("5 Ns/m", "N s/m", 5.0),
        ("1 uN m s", "N m s/rad", 1e-6),
        ("1 uN m s/rad", "N m s/rad", 1e-6),
        ("1e10 N/m**1.5", "N/m^1.5", 1e10),
        ("50 %", "1", 0.5),
        ("1e-6", "m", 1e-6),
        ("-3", "N m", -3.0),
    ],
)
def test_a_text_with_a_unit_becomes_the_nearest_number_in_si(text: str, unit: str, expected: float) -> None:
    assert to_si(text, unit) == pytest.approx(expected, rel=4e-16, abs=0.0)


def test_a_decimal_prefix_costs_no_digit() -> None:
    # In binary 311 * 1e-6 is another number than 311e-6, and so is 0.3 * 1e-3 than 0.3e-3.
    assert to_si("311 us", "s") == 311e-6
    assert to_si("0.3 ms", "s") == 0.3e-3


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("1 kg", "m"),
        ("1 um", "s"),
        ("20 krad/s", "Hz"),
        ("2 Hz", "rad/s"),
        ("3 rad", "1"),
        ("1 m", "1"),
        ("20 degC", "m"),
    ],
)
def test_a_unit_of_another_dimension_is_refused(text: str, unit: str) -> None:
    with pytest.raises(UnitError, match="cannot be converted"):
        to_si(text, unit)


@pytest.mark.parametrize("text", ["1 umm", "1 parsnip", "5 m s if", "1 m**", "2 m^^2"])
def test_an_unknown_unit_is_refused(text: str) -> None:
    with pytest.raises(UnitError, match="is unknown"):
        to_si(text, "m")


@pytest.mark.parametrize(
    "text", ["", "abc", "um", "1 2 m", "3 2 m", "1 um 3", "one um", "1,5 mm", "1 m; 2", "0x10", "1 'm'"]
)
def test_a_text_that_is_no_number_is_refused(text: str) -> None:
    with pytest.raises(UnitError):
        to_si(text, "m")


@pytest.mark.parametrize(
    ("units", "text"),
    [
        ("N m-1.5", "N/m^1.5"),
        ("kg m2", "kg m^2"),
        ("s-1", "1/s"),
        ("1", "1"),
        ("N m s rad-1", "N m s/rad"),
        ("m", "m"),
    ],
)
def test_units_of_the_cf_conventions_are_written_as_in_a_configuration(units: str, text: str) -> None:
    assert from_cf(units) == text


def printed_units() -> list[str]:
    owners = [type(getattr(contactlab.build().motor, name)) for name in ("geometry", "rotor")]
    owners += [law for family in ("", "normal", "damping", "friction") for law in own(family).values()]
    owners += [contactlab.Steel, contactlab.Piezoceramic, contactlab.RitzResonator]
    return sorted({message.unit for owner in owners for message in parameters_of(owner).values()} - {"1"})


@pytest.mark.parametrize("unit", printed_units())
@given(number=st.floats(-1e30, 1e30, allow_subnormal=False))
def test_a_number_in_any_unit_that_is_printed_is_read_as_it_is(unit: str, number: float) -> None:
    assert to_si(f"{number!r} {unit}", unit) == number


@pytest.mark.parametrize(
    ("line", "number"),
    [
        ("law.stiffness=2e10 N/m^1.5", 2e10),
        ("rotor.inertia=4e-5 kg m^2", 4e-5),
        ("resonator.mass_damping=8 1/s", 8.0),
        ("resonator.steel.density=7000 kg/m^3", 7000.0),
    ],
)
def test_such_a_unit_needs_no_quotes_of_its_own_on_the_command_line(line: str, number: float) -> None:
    assert flat(contactlab.build([line]).configuration)[line.partition("=")[0]] == number


@pytest.mark.parametrize("unit", printed_units())
def test_numbers_with_such_a_unit_are_listed_without_quotes_of_their_own(unit: str) -> None:
    (line,) = for_hydra([f"key=range(1 {unit},4 {unit},2 {unit})"])
    call = call_in(OverridesParser.create().parse_override(line).value())
    assert call is not None
    assert [to_si(end, unit) for end in call[1]] == [1.0, 4.0, 2.0]
