"""The table of recorded quantities is complete in itself."""

import re

from contactlab import variables

EVERY = (variables.TIME, *variables.SERIES, variables.CONTACT_MODE, *variables.RESONATOR, *variables.CONTACTS)


def test_every_name_is_said_once() -> None:
    names = [variable.name for variable in EVERY]
    assert len(names) == len(set(names))


def test_every_name_is_words_in_lower_case() -> None:
    assert all(re.fullmatch(r"[a-z]+(_[a-z]+)*", variable.name) for variable in EVERY)


def test_every_variable_says_unit_symbol_and_meaning() -> None:
    assert all(variable.units and variable.symbol and variable.long_name for variable in EVERY)


def test_series_run_over_time_and_contacts_over_contact() -> None:
    assert {variable.dims for variable in variables.SERIES} == {("time",)}
    assert {variable.dims for variable in variables.CONTACTS} == {("contact",)}


def test_forces_are_marked_as_means_and_nothing_else_is() -> None:
    means = {variable.name for variable in EVERY if variable.cell_methods}
    assert means == {"normal_force", "friction_force"}


def test_flags_follow_the_modes_of_the_laws() -> None:
    from contactlab.laws.base import FREE, SLIP, STICK

    flags = variables.CONTACT_MODE.flags
    assert (flags[FREE], flags[SLIP], flags[STICK]) == ("free", "slip", "stick")
