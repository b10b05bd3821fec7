"""The registry of laws, what follows from declarations, and the listing of it all."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pytest
from support.command_line import Command

from contactlab import laws
from contactlab.cli.verbs.laws import declared_rows
from contactlab.laws import (
    Composed,
    HertzPenalty,
    InternalVariable,
    Linear,
    LuGre,
    Newton,
    NormalForce,
    PenaltyLaw,
    law,
    law_class,
    law_names,
    origin_of,
)
from contactlab.laws.declaration import FRICTION_COEFFICIENT, members_of
from contactlab.laws.memory import ODD
from contactlab.laws.registry import LAWS, PARTS, build_law
from contactlab.parameter import Parameter, from_cf, parameters_of
from contactlab.quantity import to_si


def test_every_law_of_the_package_is_found_by_its_name() -> None:
    assert set(law_names()) >= set(LAWS)
    for name in LAWS:
        assert law_class(name).name == name
        assert origin_of(name).package == "contactlab"
        assert hasattr(laws, law_class(name).__name__)


def test_every_law_and_part_that_is_written_is_in_a_table() -> None:
    home = Path(laws.__file__).parent
    written = {
        result
        for path in home.rglob("*.py")
        for result in re.findall(
            r"^@final\n@dataclass\(frozen=True\)\nclass (\w+)\(",
            path.read_text(encoding="utf-8"),
            re.MULTILINE,
        )
    }
    tables = LAWS, *PARTS.values()
    assert written == {result.__name__ for table in tables for result in table.values()}
    for family, table in PARTS.items():
        assert all(part.name == name and part.family == family for name, part in table.items())


def test_a_law_is_made_by_name_and_its_parts_too() -> None:
    assert law("newton", restitution=0.4) == Newton(restitution=0.4)
    assert law("composed", normal="linear", friction=LuGre(0.2)) == Composed(Linear(), friction=LuGre(0.2))


@pytest.mark.parametrize(
    ("name", "parameters", "kind", "key"),
    [
        ("newto", {}, ValueError, "newton"),
        (3, {}, TypeError, "3"),
        ("newton", {"restituton": 1.0}, TypeError, "restitution"),
        ("lagrange_slip", {"e": 1.0}, TypeError, "friction_coefficient"),
        ("newton", {"restitution": 2.0}, ValueError, "restitution"),
        ("newton", {"restitution": "a"}, TypeError, "restitution"),
        ("composed", {"friction": "lugr"}, ValueError, "lugre"),
        ("composed", {"friction": Linear()}, TypeError, "Friction"),
    ],
)
def test_what_is_no_law_is_refused_by_its_key(
    name: Any, parameters: dict[str, Any], kind: type[Exception], key: str
) -> None:
    with pytest.raises(kind, match=key):
        law(name, **parameters)


def is_known(unit: str) -> bool:
    """Whether a text in the unit is converted."""
    spelled = f"{unit[2:]}^-1" if unit.startswith("1/") else unit
    return to_si("2" if unit == "1" else f"2 {spelled}", unit) == 2.0


@pytest.mark.parametrize(
    ("cf", "written"),
    [
        ("N m-1.5", "N/m^1.5"),
        ("1", "1"),
        ("N s m-1", "N s/m"),
        ("m-1", "1/m"),
        ("kg m-1 s-2", "kg/m/s^2"),
        ("J m-2", "J/m^2"),
    ],
)
def test_units_of_cf_are_those_of_a_configuration(cf: str, written: str) -> None:
    assert from_cf(cf) == written
    assert is_known(written)


def test_every_declared_unit_is_known() -> None:
    owners = [*LAWS.values(), *(part for table in PARTS.values() for part in table.values())]
    for owner in owners:
        for declared in parameters_of(owner).values():
            assert is_known(from_cf(declared.units))


def test_a_field_without_declaration_is_refused() -> None:
    @dataclass(frozen=True)
    class Undeclared(HertzPenalty):  # type: ignore[misc]
        name = "undeclared"
        friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.1
        loss: Annotated[float, "none"] = 1.0

    with pytest.raises(ValueError, match="loss"):
        members_of(Undeclared)


def test_the_listing_has_every_law_and_part_with_its_parameters(command: Command) -> None:
    status, out, err = command("laws")
    assert (status, err) == (0, "")
    listed = " ".join(out.split())
    for owner in [*LAWS.values(), *(part for table in PARTS.values() for part in table.values())]:
        assert " ".join(owner.equation.split()) in listed
        assert all(
            f"parameter {name}: {each.symbol}" in listed for name, each in parameters_of(owner).items()
        )


def test_the_listing_has_one_law_or_part(command: Command) -> None:
    for name in ("coulomb", "friction/coulomb"):
        status, out, _ = command("laws", name)
        assert status == 0
        assert out.startswith("friction/coulomb\n")
        assert "hertz" not in out
    status, out, err = command("laws", "hertz_penalti")
    assert (status, out) == (2, "")
    assert "hertz_penalty" in err


@dataclass(frozen=True)
class Dented(NormalForce):
    """A normal force with every declaration."""

    name = "dented"
    equation = source = "this test"
    allows_tension = True
    guards = 2
    internal_variables = (InternalVariable("creep", "z", "m", "creep of the arm", parity=ODD, life="run"),)
    jump = limits = guard = staticmethod(lambda *_: 0.0)


def test_the_listing_has_rows_for_what_only_some_laws_have() -> None:
    rows = {"tension", "internal variable creep", "limits", "guards"}
    assert rows <= {word for word, text in declared_rows(Dented).items() if text}


@dataclass(frozen=True)
class Whole(PenaltyLaw):
    """A law with a whole number among its parameters."""

    name = "whole"
    equation = "N = k d^n"
    source = "this test"
    default_contact_step = 4e-6

    power: Annotated[int, Parameter("n", "1", "power", at_least=1.0)] = 2

    force = staticmethod(None)


def test_a_whole_number_of_a_law_is_made_from_a_key() -> None:
    assert build_law(Whole, {"power": 3.0}, 0.3) == Whole(3)
    with pytest.raises(TypeError, match="power"):
        build_law(Whole, {"power": 2.5}, 0.3)


def test_the_range_of_a_law_is_that_of_its_key(command: Command) -> None:
    declared: Parameter = parameters_of(LAWS["hertz_penalty"])["stiffness"]
    assert declared.above == 0.0
    assert "law.stiffness is 0" in command("law.stiffness=0")[2]
