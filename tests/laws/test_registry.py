"""The registry of laws, what follows from declarations, and the listing of it all."""

import re
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import Annotated, Any

import pytest
from support.command_line import Command

from contactlab import laws
from contactlab.cli.laws import declared_rows
from contactlab.config.quantity import to_si
from contactlab.laws import (
    Composed,
    Friction,
    HertzPenalty,
    InternalVariable,
    Linear,
    LuGre,
    MultiplierLaw,
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


def test_every_law_of_the_package_is_found_by_its_name() -> None:
    assert set(law_names()) >= set(LAWS)
    for name in LAWS:
        assert law_class(name).name == name
        assert origin_of(name).package == "contactlab"
        assert hasattr(laws, law_class(name).__name__)


def test_every_law_and_part_that_is_written_is_in_a_table() -> None:
    home = Path(laws.__file__).parent
    written = {
        found
        for path in home.rglob("*.py")
        for found in re.findall(
            r"^@final\n@dataclass\(frozen=True\)\nclass (\w+)\(",
            path.read_text(encoding="utf-8"),
            re.MULTILINE,
        )
    }
    tables = LAWS, *PARTS.values()
    assert written == {found.__name__ for table in tables for found in table.values()}
    for family, table in PARTS.items():
        assert all(part.name == name and part.family == family for name, part in table.items())


def test_an_unknown_law_is_told_with_those_there_are() -> None:
    with pytest.raises(ValueError, match=r"There is no law 'glue'; it must be one of .*, hertz_penalty"):
        law_class("glue")
    with pytest.raises(AttributeError):
        _ = laws.Glue


def test_a_law_is_made_by_name_and_its_parts_too() -> None:
    assert law("newton", restitution=0.4) == Newton(restitution=0.4)
    assert law("composed", normal="linear", friction=LuGre(0.2)) == Composed(Linear(), friction=LuGre(0.2))


@pytest.mark.parametrize(
    ("name", "parameters", "kind", "words"),
    [
        ("newto", {}, ValueError, "There is no law 'newto'; it must be .* Did you mean newton?"),
        (3, {}, TypeError, "The name of the law is 3; it must be a text"),
        ("newton", {"restituton": 1.0}, TypeError, "no parameter 'restituton'. Did you mean restit"),
        ("lagrange_slip", {"e": 1.0}, TypeError, "no parameter 'e'. It has friction_coefficient."),
        ("newton", {"restitution": 2.0}, ValueError, "restitution is 2.0; it must be at least 0"),
        ("newton", {"restitution": "a"}, TypeError, "restitution is 'a'; it must be a number"),
        ("composed", {"friction": "lugr"}, ValueError, "no friction 'lugr'; .* Did you mean lugre?"),
        ("composed", {"friction": Linear()}, TypeError, "it must be a Friction"),
    ],
)
def test_what_no_law_can_be_made_from_is_told(
    name: Any, parameters: dict[str, Any], kind: type[Exception], words: str
) -> None:
    with pytest.raises(kind, match=words):
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


def test_every_parameter_of_a_law_and_part_has_a_default() -> None:
    for owner in [*LAWS.values(), *(part for table in PARTS.values() for part in table.values())]:
        assert all(member.default is not MISSING for member in members_of(owner).values())


def test_a_field_without_declaration_is_told() -> None:
    @dataclass(frozen=True)
    class Undeclared(HertzPenalty):  # type: ignore[misc]
        name = "undeclared"
        friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.1
        loss: Annotated[float, "none"] = 1.0

    with pytest.raises(ValueError, match="undeclared has the field loss without a declaration"):
        members_of(Undeclared)


def test_the_listing_has_every_law_and_part_with_its_parameters(command: Command) -> None:
    status, out, err = command("laws")
    assert (status, err) == (0, "")
    words = " ".join(out.split())
    for owner in [*LAWS.values(), *(part for table in PARTS.values() for part in table.values())]:
        assert " ".join(owner.equation.split()) in words
        assert " ".join(owner.source.split()) in words
        for name, declared in parameters_of(owner).items():
            assert f"parameter {name}: {declared.symbol}" in words
    for reason in law_class("lagrange_slip").violations.values():
        assert " ".join(reason.split()) in words


def test_the_listing_has_one_law_or_part(command: Command) -> None:
    for asked in ("coulomb", "friction/coulomb"):
        status, out, _ = command("laws", asked)
        assert status == 0
        assert out.startswith("friction/coulomb\n")
        assert "hertz" not in out
    status, out, err = command("laws", "hertz_penalti")
    assert (status, out) == (2, "")
    assert err == "There is no law or part 'hertz_penalti'. Did you mean hertz_penalty?\n"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("newton", "default contact step: at most 5e-08 s"),
        ("moreau_jean", "default contact step: 5e-08 s"),
        ("hertz_penalty", "default contact step: 4e-06 s"),
        ("lugre", "z [m], deflection of the bristles, begins at 0 with every contact, odd in a mirror"),
    ],
)
def test_the_listing_says_what_is_a_bound_and_what_a_mirror_does(
    command: Command, name: str, words: str
) -> None:
    status, out, _ = command("laws", name)
    assert status == 0
    assert words in " ".join(out.split())


@dataclass(frozen=True)
class Dented(NormalForce):
    """A normal force that says all that it can."""

    name = "dented"
    equation = "none"
    source = "this test"
    allows_tension = True
    guards = 2
    internal_variables = (
        *(InternalVariable(f"creep_{i}", f"z_{i}", "m", f"creep of arm {i}", life="run") for i in (1, 2, 3)),
        InternalVariable("yields", "", "1", "whether it yields", initial=1.0),
    )
    jump = limits = guard = staticmethod(lambda *_: 0.0)


@dataclass(frozen=True)
class Sticky(Friction):
    """A friction whose cone and memory hang on its parameters."""

    name = "sticky"
    equation = "|F| <= mu (N + C)"
    source = "this test"

    count: Annotated[int, Parameter("n", "1", "springs", at_least=1.0)] = 1
    cohesion: Annotated[float, Parameter("C", "N", "cohesion", at_least=0.0)] = 2.0

    @property
    def friction_offset(self) -> float:
        return self.cohesion

    @property
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        return (InternalVariable("stretch", "z", "m", "stretch", parity=ODD),) * self.count


@dataclass(frozen=True)
class Told(MultiplierLaw):
    """A rigid law that has to be given a number."""

    name = "told"
    equation = "g = 0"
    source = "this test"
    default_contact_step = 5e-8

    power: Annotated[float, Parameter("n", "1", "power")]

    @property
    def friction_limit(self) -> float:
        return self.power

    solve = staticmethod(lambda *_: None)


@dataclass(frozen=True)
class Turned(PenaltyLaw):
    """A compliant law with a moment."""

    name = "turned"
    equation = "M = -k phi"
    source = "this test"
    default_contact_step = 4e-6

    force = moment = staticmethod(lambda *_: None)


@pytest.mark.parametrize(
    ("owner", "rows"),
    [
        (
            Dented,
            {
                "tension": "allowed",
                "internal variables creep_1 to creep_3": "z_1 to z_3 [m], creep of arm 1 to creep of arm 3, "
                "begin at 0 with the run and not with a contact",
                "internal variable yields": "whether it yields, begins at 1 with every contact",
                "limits": "a contact begins and ends at the gaps that it says, not at zero",
                "guards": "2: where one falls through zero, a step ends and what it remembers jumps",
            },
        ),
        (
            Sticky,
            {
                "stick": "exact",
                "cone": "widened by an offset C = 2 N",
                "internal variable stretch": "z [m], stretch, begins at 0 with every contact, odd "
                "in a mirror",
            },
        ),
        (Turned, {"moment": "a patch of some extent turns the tip"}),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_listing_says_what_is_special_of_a_law(owner: Any, rows: dict[str, str]) -> None:
    said = {word: text for word, text in declared_rows(owner).items() if text}
    # What every law says, whatever it is.
    common = {"family", "convergence order", "default contact step", "stick", "tension"}
    assert {word: said[word] for word in rows} == rows
    assert said.keys() <= rows.keys() | common


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
    with pytest.raises(TypeError, match=r"power is 2.5; it must be a whole number"):
        build_law(Whole, {"power": 2.5}, 0.3)


def test_the_range_of_a_law_is_that_of_its_key(command: Command) -> None:
    declared: Parameter = parameters_of(LAWS["hertz_penalty"])["stiffness"]
    assert declared.above == 0.0
    assert "law.stiffness is 0" in command("law.stiffness=0")[2]
