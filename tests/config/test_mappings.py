"""Claims on configurations as mappings: nested or whole keys, and folders with other files."""

from pathlib import Path
from typing import Any

import pytest

import contactlab as cl


@pytest.mark.parametrize(
    "values",
    [
        {"law": "newton", "contact.clearance": "0.5 um", "law.restitution": 0.8},
        {"law": {"name": "newton", "restitution": 0.8}, "contact": {"clearance": 5e-7}},
        {"law": "newton", "law.restitution": 0.8, "contact/clearance": 5e-7},
    ],
)
def test_whole_keys_are_nested_ones(values: dict[str, Any]) -> None:
    nested = cl.build({"law": {"name": "newton", "restitution": 0.8}, "contact": {"clearance": 5e-7}})
    assert cl.build(values).configuration == nested.configuration


def test_an_option_stands_beside_its_keys() -> None:
    parts = {"law": "composed", "law.friction": "dahl"}
    setup = cl.build(parts | {"drive": "two_phase", "drive.voltage_1": 3.0})
    law: Any = setup.law
    assert law.friction == cl.Dahl(friction_coefficient=0.3)
    assert abs(setup.motor.drive.phasors).max() >= 3.0
    assert setup.configuration["drive"]["voltage_1"] == 3.0


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"contact": {"clearance": 1e-6}, "contact.clearance": 1e-6}, "contact.clearance"),
        ({"contact": 5, "contact.clearance": 1e-6}, "contact"),
        ({"nosuch": 5, "nosuch.x": 1}, "nosuch"),
        ({"contact.nosuch": 1}, "contact.clearance"),
        ({"nosuch": 1}, "solver"),
    ],
)
def test_a_key_that_cannot_be_is_refused(values: dict[str, Any], key: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=key):
        cl.build(values)


def test_a_branch_over_no_key_names_those_that_there_are() -> None:
    with pytest.raises(cl.ConfigurationError, match="contact"):
        cl.branch(cl.build(), "nosuch", 1.0, 2.0)


@pytest.mark.parametrize("content", [b"a: [1\n", b"a: \xff\n", b'a: "\x01"\n', b"a: &a [1]\nb: *c\n"])
def test_a_broken_file_is_refused_only_where_it_is_chosen(content: bytes, tmp_path: Path) -> None:
    folder = tmp_path / "experiment"
    folder.mkdir()
    (folder / "broken.yaml").write_bytes(content)
    (folder / "good.yaml").write_text("# @package _global_\ncontact:\n  clearance: 5e-7\n")
    assert cl.build(["experiment=good"], tmp_path).motor.geometry.clearance == 5e-7
    with pytest.raises(cl.ConfigurationError, match="broken"):
        cl.build(["experiment=broken"], tmp_path)
    assert cl.build(["experiment=good"], tmp_path).motor.geometry.clearance == 5e-7


@pytest.mark.parametrize("preload", ["1e9", "1 GN"])
def test_a_preload_that_no_penetration_has_is_that_of_the_configuration(preload: str) -> None:
    with pytest.raises(cl.ConfigurationError, match=r"contact.preload") as caught:
        cl.build([f"contact.preload={preload}"])
    assert not isinstance(caught.value.__cause__, cl.LawError)
