"""What the Python function of every study has."""

import re
from collections.abc import Set
from inspect import Parameter as Argument, signature

import contactlab as cl
from contactlab.parameter import declared_fields
from contactlab.studies import Study
from contactlab.studies.docstrings import entries_in


def assert_options_are_arguments(name: str, study: type[Study], others: Set[str] = frozenset()) -> None:
    """Options but `others` are arguments with meaning, bounds and default, and every argument is described.

    Args:
        name: of the function of contactlab.
        study: its class.
        others: options that follow from other arguments.
    """
    function = getattr(cl, name)
    arguments, text = signature(function).parameters, function.__doc__
    fields = declared_fields(study)
    assert {*arguments} >= {*fields, "output", "progress"} - others
    assert others.isdisjoint(arguments)
    lines = " ".join(text.split())
    for option, field in fields.items():
        if option in arguments:
            assert f" {option}: {field.parameter.meaning}" in lines
            assert field.parameter.range in lines
            assert arguments[option].kind is Argument.KEYWORD_ONLY
            assert arguments[option].annotation == field.kind
            assert arguments[option].default == field.default or (name, option) == ("steady", "refine")
    assert function.__name__ == name
    assert all(f"\n{section}:\n" in text for section in ("Args", "Returns", "Raises"))
    described = entries_in(text).values()
    names = {each for entry in described for each in re.split(r"\W+", entry.partition(":")[0])}
    assert {*arguments} == names - {""}
