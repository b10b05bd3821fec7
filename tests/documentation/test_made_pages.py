"""What is made from the code for the reference leaves nothing out."""

import builtins
import inspect
import re

import made_api
import made_dataset
import made_keys
import made_verbs

import contactlab
from contactlab.cli.arguments import VERBS
from contactlab.config.options import known_keys
from contactlab.laws import LAWS, PARTS
from contactlab.variables import CONTACTS, SERIES


def test_every_key_of_every_group_is_in_the_reference() -> None:
    made = made_keys.groups()
    told = {"resonator.basis", "piezoceramic.constants"}
    missing = {key for key in known_keys() if not key.startswith("law.")} - told
    assert not {key for key in missing if f"`{key}`" not in made}


def test_every_law_and_part_has_its_keys_in_the_reference() -> None:
    made = made_keys.laws()
    names = [f"### `law={name}`" for name in LAWS]
    names += [f"### `law/{family}={name}`" for family, parts in PARTS.items() for name in parts]
    assert not [name for name in names if name not in made]
    assert "`law.friction.static_ratio`" in made


def test_every_verb_prints_its_help_for_the_reference() -> None:
    made = made_verbs.verbs()
    assert all(f"usage: contactlab {verb}" in made for verb in VERBS)


def test_every_variable_is_in_the_reference() -> None:
    made = made_dataset.variables()
    assert all(f"| `{one.name}` |" in made for one in (*SERIES, *CONTACTS))


def test_every_name_of_the_front_door_is_in_the_reference() -> None:
    made = made_api.front_door()
    public = {name for name, one in vars(contactlab).items() if not name.startswith("_") and callable(one)}
    exported = made_api.exported()
    # A helper that the package takes in for itself is no name of the front door.
    assert public - set(exported) == {"versions"}
    assert all(f":: contactlab.{name}\n" in made for name in exported)


def test_what_a_function_of_the_front_door_says_that_it_raises_is_at_the_front_door() -> None:
    named = {
        (name, error)
        for name, one in made_api.exported().items()
        for each in ([one, *vars(one).values()] if inspect.isclass(one) else [one])
        for said in re.findall(r"^Raises:\n((?: .*\n?)+)", inspect.getdoc(each) or "", re.MULTILINE)
        for words in re.findall(r"^    ([\w., ]+): ", said, re.MULTILINE)
        for error in words.split(", ")
    }
    assert {("steady", "NotSettledError"), ("compare", "ComparisonError")} <= named
    there = made_api.exported().keys() | vars(builtins).keys()
    assert {(name, error) for name, error in named if error not in there} == set()


def test_every_further_module_has_names_in_the_reference() -> None:
    made = made_api.further()
    for name in ("measured.files.MeasurementError", "inference.study.study", "testing.LawContract"):
        assert f":: contactlab.{name}\n" in made
