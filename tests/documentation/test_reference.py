"""The reference that is made from the code is complete."""

import builtins
import inspect
import re

import made_api
import made_dataset
import made_keys
import made_verbs

import contactlab
from contactlab.config.options import known_keys
from contactlab.laws import LAWS, PARTS
from contactlab.variables import CONTACTS, SERIES


def test_every_key_is_in_the_reference() -> None:
    made = made_keys.groups() + made_verbs.verbs()
    keys = {key for key in known_keys() if not key.startswith(("law.", "study."))}
    selectors = {"resonator.basis", "piezoceramic.constants", "drive.signal", "plant.name"}
    assert {key for key in keys if f"`{key}`" not in made} == selectors


def test_every_law_and_part_has_its_keys_in_the_reference() -> None:
    made = made_keys.laws()
    names = [f"law={name}" for name in LAWS]
    names += [f"law/{family}={name}" for family, parts in PARTS.items() for name in parts]
    assert not [name for name in names if f"### `{name}`" not in made]
    assert "`law.friction.static_ratio`" in made


def test_every_variable_is_in_the_reference() -> None:
    made = made_dataset.variables()
    assert all(f"| `{variable.name}` |" in made for variable in (*SERIES, *CONTACTS))


def test_every_public_name_is_in_the_reference() -> None:
    made = made_api.front_door()
    names = [name for name in dir(contactlab) if not name.startswith("_")]
    public = {name for name in names if callable(getattr(contactlab, name))}
    assert public - set(made_api.exported()) == {"attach"}
    assert all(f":: contactlab.{name}\n" in made for name in made_api.exported())
    assert ":: contactlab.testing.LawContract\n" in made_api.further()


def test_errors_that_public_functions_document_are_public() -> None:
    named = {
        (name, error)
        for name, item in made_api.exported().items()
        for each in ([item, *vars(item).values()] if inspect.isclass(item) else [item])
        for raises in re.findall(r"^Raises:\n((?: .*\n?)+)", inspect.getdoc(each) or "", re.MULTILINE)
        for names in re.findall(r"^    ([\w., ]+): ", raises, re.MULTILINE)
        for error in names.split(", ")
    }
    public = made_api.exported().keys() | vars(builtins).keys()
    assert {(name, error) for name, error in named if error not in public} == set()
