"""A configuration either builds exactly what it says or is refused with all its faults at once."""

import math
from html import escape
from itertools import pairwise, product
from typing import Any, Literal

import numpy as np
import pytest
from support.configurations import CONF, altered, composed, options

import contactlab as cl
from contactlab.checks import MOST_RECORDS
from contactlab.config import ConfigurationError, build, rebuild, validate
from contactlab.config.groups import BASES, keys_of_law
from contactlab.config.nesting import flat
from contactlab.config.options import groups, known_keys
from contactlab.config.schema import declared_in
from contactlab.engine.defaults import DEFAULT_TOLERANCE
from contactlab.laws import LAWS, HertzPenalty, hertz_stiffness


def faults(changes: dict[str, object], **choices: str) -> list[str]:
    with pytest.raises(ConfigurationError) as caught:
        build(altered(changes, **choices))
    return caught.value.faults


def test_default_configuration_builds_the_motor_of_the_paper() -> None:
    setup = build(composed())
    assert setup.motor.modes.natural_frequency == pytest.approx(
        [3210.121, 5460.688, 13202.46, 17786.32], rel=1e-6
    )
    assert setup.law == HertzPenalty(stiffness=1e10, friction_coefficient=0.3)
    assert setup.motor.rotor.inertia == 4.8e-5
    assert setup.motor.geometry.clearance == 1e-6
    assert setup.duration == 0.02
    assert setup.record_interval == 1e-6


def test_resolved_configuration_holds_the_numbers_that_run() -> None:
    setup = build(composed())
    assert setup.configuration["drive"]["frequency"] == setup.motor.modes.natural_frequency[0]
    assert setup.configuration["drive"]["frequency"] == setup.motor.drive.frequency[0]
    assert setup.configuration["solver"]["contact_step"] == HertzPenalty.default_contact_step
    assert setup.configuration["solver"]["tolerance"] == DEFAULT_TOLERANCE
    assert setup.contact_step == HertzPenalty.default_contact_step
    assert setup.tolerance == DEFAULT_TOLERANCE


def test_resolved_configuration_builds_itself_again() -> None:
    changes: dict[str, object] = {"law.stiffness": None, "law.tip_radius": "5 mm", "drive.phase": "-36 deg"}
    first = build(altered(changes))
    again = build(first.configuration)
    assert again.configuration == first.configuration
    assert again.law == first.law
    assert np.array_equal(again.motor.drive.phasors, first.motor.drive.phasors)


@pytest.mark.parametrize(
    ("law", "resonator", "placement", "piezoceramic"),
    # A resonator of a file has tests of its own.
    list(product(options("law"), list(BASES), *(options(g) for g in ("placement", "piezoceramic")))),
)
def test_every_choice_builds(law: str, resonator: str, placement: str, piezoceramic: str) -> None:
    setup = build(composed(law=law, resonator=resonator, placement=placement, piezoceramic=piezoceramic))
    assert setup.law.name == law
    assert setup.configuration["resonator"]["basis"] == resonator
    assert setup.configuration["placement"] == composed(placement=placement)["placement"]


def test_law_has_one_name_as_option_section_and_class() -> None:
    assert set(options("law")) >= set(LAWS)
    for name in LAWS:
        assert LAWS[name].name == name
        assert composed(law=name)["law"]["name"] == name
        assert keys_of_law(LAWS[name])["name"].kind == Literal[name]


def test_all_but_time_stepping_takes_a_tolerance() -> None:
    for name in LAWS:
        assert build(composed(law=name)).tolerance == DEFAULT_TOLERANCE
    assert build(["law=lagrange_stick", "solver.contact_step=1e-7"]).tolerance is None
    (fault,) = faults({"solver.tolerance": 1e-6, "solver.contact_step": 1e-7}, law="lagrange_stick")
    assert fault.startswith("solver.tolerance is 1e-06; it must be null with law=lagrange_stick")


def test_texts_with_units_build_the_same_as_numbers() -> None:
    texts: dict[str, object] = {
        "contact.clearance": "1 um",
        "drive.frequency": "3.21 kHz",
        "drive.phase": "-36 deg",
        "solver.duration": "5 ms",
        "rotor.inertia": "480 g cm**2",
    }
    numbers: dict[str, object] = {
        "contact.clearance": 1e-6,
        "drive.frequency": 3210,
        "drive.phase": -math.pi / 5,
        "solver.duration": 0.005,
        "rotor.inertia": 4.8e-5,
    }
    assert build(altered(texts)).configuration == build(altered(numbers)).configuration


def test_stiffness_follows_from_the_tip_radius() -> None:
    setup = build(altered({"law.stiffness": None, "law.tip_radius": 5e-3}))
    assert isinstance(setup.law, HertzPenalty)
    assert setup.law.stiffness == hertz_stiffness(5e-3, 25e-3)
    assert setup.configuration["law"]["stiffness"] == setup.law.stiffness
    assert setup.configuration["law"]["tip_radius"] is None
    (fault,) = faults({"law.tip_radius": 5e-3})
    assert "tip_radius is 0.005; exactly one of them must be a number and the other null" in fault


FAULTS: list[tuple[str, object]] = [
    ("solver.contact_step", -1e-7),
    ("solver.contact_step", 1.0),
    ("solver.contact_step", 1e-300),
    ("solver.duration", "abc"),
    ("solver.duration", True),
    ("solver.duration", [1.0]),
    ("solver.duration", math.inf),
    ("solver.duration", "nan"),
    ("solver.duration", 10**400),
    ("solver.duration", "5 mm"),
    ("solver.precision", None),
    ("solver.precision", 0.0),
    ("solver.precision", 1e-4),
    ("solver.tolerance", 0.5),
    ("record.interval", 0.03),
    ("record.interval", 1e-12),
    ("contact.clearance", "-1 um"),
    ("contact.friction_coefficient", 30),
    ("contact.tip_length", 0),
    ("rotor.inertia", 0),
    ("rotor.damping", -1),
    ("rotor.load_torque", "strong"),
    ("law.stiffness", 0),
    ("law.stiffness", None),
    ("law.name", "lagrange_glue"),
    ("resonator.shapes", 41),
    ("resonator.shapes", 4.5),
    ("resonator.basis", "wavelets"),
    ("resonator.steel.poisson_ratio", 0.5),
    ("placement.start", 0.02),
    ("placement.end", 0.03),
    ("piezoceramic.constants", "guessed"),
    ("drive.frequency", "20 krad/s"),
    ("drive.frequency_ratio", -2),
    ("rotor", 5),
    ("rotor.qwxyz", 1.0),
    ("solver.contactstep", 1.0),
]


@pytest.mark.parametrize(("key", "value"), FAULTS)
def test_a_faulty_value_is_refused_by_its_key_alone(key: str, value: object) -> None:
    (fault,) = faults({key: value})
    assert key in fault


@pytest.mark.parametrize(
    ("key", "near"), [("frequency", "drive.frequency"), ("contact.stiffness", "law.stiffness")]
)
def test_the_nearest_key_is_suggested(key: str, near: str) -> None:
    (fault,) = faults({key: 1.0})
    assert near in fault


def test_key_of_another_law_is_refused() -> None:
    (fault,) = faults({"law.stiffness": 1e9}, law="lagrange_slip")
    assert fault.startswith("law.stiffness does not belong to lagrange_slip")


def test_missing_keys_and_groups_of_a_recorded_configuration_are_told() -> None:
    configuration = composed()
    del configuration["drive"]["phase"], configuration["rotor"], configuration["law"]["name"]
    with pytest.raises(ConfigurationError) as caught:
        rebuild(configuration)
    assert [fault.partition(";")[0] for fault in caught.value.faults] == [
        "law.name is missing",
        "drive.phase is missing",
        "rotor is missing",
    ]


def test_all_faults_come_at_once_those_between_keys_included() -> None:
    result = faults(
        {
            "law.tip_radius": 5e-3,
            "contact.clearance": -1e-6,
            "solver.contact_step": "abc",
            "record.interval": 1.0,
            "placement.end": 0.05,
            "resonator.shapes": 0,
            "drive.amplitude": 3.0,
            "motor": {},
        }
    )
    starts = [fault.split()[0] for fault in result]
    assert sorted(starts) == [
        "contact.clearance",
        "drive.amplitude",
        "law.stiffness",
        "motor",
        "placement.start",
        "record.interval",
        "resonator.shapes",
        "solver.contact_step",
    ]
    assert str(ConfigurationError(result)).splitlines() == result


def test_as_many_records_as_fit_are_admitted() -> None:
    assert validate(altered({"record.interval": 0.02 / MOST_RECORDS}))


def test_undamped_resonator_runs_off_resonance_only() -> None:
    undamped: dict[str, object] = {"resonator.mass_damping": 0, "resonator.stiffness_damping": 0}
    assert build(altered(undamped | {"drive.frequency": 3210.0}))
    (fault,) = faults(undamped)
    assert fault.startswith("drive.frequency is null, that is the first natural frequency")
    second = build(composed()).motor.modes.natural_frequency[1]
    (fault,) = faults(undamped | {"drive.frequency": float(second) / 2.0})
    assert fault.startswith("drive.frequency times drive.frequency_ratio is 5460.688")


def test_unstable_elastic_tensor_is_refused() -> None:
    (fault,) = faults({"piezoceramic.c13": 300e9}, piezoceramic="pz26_datasheet")
    assert "c13" in fault


def test_every_key_of_conf_is_explained_in_the_line_above() -> None:
    for path in CONF.glob("*/*.yaml"):
        lines = path.read_text(encoding="utf-8").splitlines()
        if path.parent.name == "experiment":
            assert lines[:1] == ["# @package _global_"]
            assert lines[1].startswith("# ")
            continue
        for above, line in pairwise(lines):
            _, colon, value = line.partition(":")
            if colon and value and not line.lstrip().startswith("#"):
                assert above.lstrip().startswith("# "), f"{path.name}: {line}"


def keys_of(section: dict[str, Any], path: str) -> set[str]:
    """Full keys of a configuration."""
    result = set()
    for name, value in section.items():
        key = f"{path}{name}"
        result |= keys_of(value, f"{key}.") if isinstance(value, dict) else {key}
    return result


def test_conf_gives_every_key_a_default() -> None:
    values = set()
    for group in groups():
        choice = {"law": "composed"} if group.startswith("law/") else {}
        for option in options(group):
            values |= keys_of(composed(**choice | {group: option}), "")
    assert values == set(known_keys())


def test_a_notebook_shows_every_number_that_runs_with_its_unit_and_meaning() -> None:
    setup = cl.build(["law=newton", "law.restitution=0.125", "contact.clearance=0.75 um"])
    html = setup._repr_html_()
    for key, text in {"law.restitution": "0.125", "contact.clearance": "7.5e-07 m"}.items():
        meaning = declared_in(setup.configuration)[key].meaning
        assert f"<th>{key}</th><td>{text}</td><td>{escape(meaning)}</td>" in html
    assert html.count("<tr>") == len(flat(setup.configuration))
