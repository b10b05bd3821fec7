"""A setup tells its numbers, takes others without a composition, and is made again by what it writes."""

import shlex
from time import process_time

import pytest

import contactlab as cl
from contactlab.config import composition
from contactlab.config.groups import FAMILIES
from contactlab.parameter import Parameter, positive
from contactlab.results.yaml_text import read_yaml

SETUPS = {
    "default": [],
    "rigid": ["law=newton", "law.restitution=0.7", "contact.clearance=0.5 um"],
    "parts": ["law=composed", "law/normal=linear", "law/friction=dahl", "law.friction.exponent=2"],
    "pressed": ["law=newton", "contact.preload=5", "rotor.mass=0.1", "drive=two_phase"],
    "modes": ["resonator=ritz", "resonator.shapes=3", "placement=placement_1", "solver.duration=1 ms"],
}


@pytest.fixture(params=SETUPS.values(), ids=SETUPS)
def setup(request: pytest.FixtureRequest) -> cl.Setup:
    return cl.build(request.param)


def test_numbers_are_those_that_run_with_what_their_classes_declare(setup: cl.Setup) -> None:
    numbers = setup.numbers()
    for key, number in numbers.items():
        group, _, rest = key.partition(".")
        value = setup.configuration[group]
        for name in rest.split("."):
            value = value[name]
        assert number.value == value, key
        assert number.symbol or number.meaning
    assert numbers["contact.clearance"].unit == "m"
    assert numbers["contact.preload"].choices == (None,)


def test_numbers_are_of_what_is_selected() -> None:
    numbers = cl.build(["law=composed", "law/normal=linear"]).numbers()
    # The same key of a Hertz contact has another unit and another default.
    assert (numbers["law.normal.stiffness"].unit, numbers["law.normal.stiffness"].value) == ("N/m", 1e7)
    assert cl.build(["law=composed"]).numbers()["law.normal.stiffness"].unit == "N/m^1.5"
    assert cl.build(["drive=two_phase"]).numbers()["drive.voltage_1"].symbol == "V1"
    assert cl.build().numbers()["drive.voltage_1"].symbol == "U1"


def test_every_usual_end_of_drive_contact_rotor_and_law_builds(setup: cl.Setup) -> None:
    for key, number in setup.numbers().items():
        if number.usual is None or key.partition(".")[0] not in ("drive", "contact", "rotor", "law"):
            continue
        assert number.usual[0] < number.usual[1]
        for end in number.usual:
            assert number.parameter.admits(end)
            # A preload and what comes with it, or a frequency at which a mode resonates, are no ends' fault.
            if key not in ("contact.preload", "rotor.mass"):
                assert setup.with_({key: end}).numbers()[key].value == pytest.approx(end, rel=1e-15)


def test_usual_ends_are_admitted_for_every_law_and_part() -> None:
    every = [{"law": name} for name in cl.law_names()]
    for family, section in FAMILIES.items():
        every += [{"law": "composed", f"law/{family}": name} for name in section.options]
    for options in every:
        for number in cl.build().with_(options).numbers().values():
            if number.usual is not None:
                assert all(map(number.parameter.admits, number.usual)), number.key


def test_a_usual_range_follows_from_declaration_bounds_or_default() -> None:
    declared = Parameter("U", "V", "voltage", at_least=-1e5, at_most=1e5, usual=(0.0, 200.0))
    assert declared.usual_range(1e4) == (0.0, 200.0)
    assert Parameter("e", "1", "restitution", at_least=0.0, at_most=1.0).usual_range(0.5) == (0.0, 1.0)
    assert Parameter("s", "1", "share", above=0.0, below=1.0).usual_range(None) == (0.01, 0.99)
    mass = positive("m", "kg", "mass")
    assert mass.usual_range(-2.0 * -1.0) == (0.4, 10.0)
    assert mass.usual_range(None) is None


@pytest.mark.parametrize("usual", [(2.0, 1.0), (-1.0, 1.0), (0.0, 2e5)])
def test_a_usual_range_outside_of_the_range_is_refused(usual: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="U"):
        Parameter("U", "V", "voltage", above=0.0, at_most=1e5, usual=usual)


def test_another_number_or_law_needs_no_composition_and_under_3_ms(monkeypatch: pytest.MonkeyPatch) -> None:
    setup = cl.build(["law=newton"])
    monkeypatch.setattr(composition.hydra, "compose", None)
    took = []
    for value in range(20):
        began = process_time()
        other = setup.with_({"drive.voltage_1": 90.0 + value})
        took.append(process_time() - began)
        assert other.motor.drive.phasors[0, 0] == pytest.approx(
            setup.motor.drive.phasors[0, 0] * (0.9 + 0.01 * value)
        )
    assert min(took) < 3e-3
    assert setup.with_({"law": "hertz_penalty"}).law == cl.HertzPenalty()


@pytest.mark.parametrize("options", [["law=newton"], ["law=composed"], ["law=composed", "law/friction=iwan"]])
def test_options_by_declarations_are_those_of_the_composition(options: list[str]) -> None:
    mapping = dict(line.split("=") for line in options)
    assert cl.build().with_(mapping).configuration == cl.build(options).configuration


def test_a_refused_value_is_the_sentence_of_the_check() -> None:
    setup = cl.build(["law=newton"])
    with pytest.raises(cl.ConfigurationError, match=r"law\.restitution.*at most 1"):
        setup.with_({"law.restitution": 1.5})
    for faulty in ({"law.stiffness": 1.0}, {"law": "nutton"}, {"law.name": "poisson"}, {"drive.a.b": 1.0}):
        with pytest.raises(cl.ConfigurationError, match=next(iter(faulty)).partition(".")[0]):
            setup.with_(faulty)


def test_a_motor_made_in_python_has_the_numbers_that_it_takes() -> None:
    setup = cl.Setup.of(cl.ball(1e-3, height=1e-4), cl.Newton(restitution=0.5), 0.02)
    assert setup.numbers()["law.restitution"].value == 0.5
    assert setup.with_({"law.restitution": 0.8}).law == cl.Newton(restitution=0.8)
    for write in (setup.command, setup.python, setup.yaml):
        with pytest.raises(cl.ConfigurationError, match="Python"):
            write()


def test_command_python_and_yaml_make_the_setup_again(setup: cl.Setup) -> None:
    program, verb, *overrides = shlex.split(setup.command("steady"))
    assert (program, verb) == ("contactlab", "steady")
    names: dict[str, cl.Setup] = {}
    exec(setup.python(), names)
    for other in (cl.build(overrides), names["setup"], cl.build(read_yaml(setup.yaml()))):
        assert other.configuration == setup.configuration
        assert other.source == setup.source
