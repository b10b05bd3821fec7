"""The Python functions of this package's studies have signature and docstring of their declarations."""

import pytest
from support.study_functions import assert_options_are_arguments

import contactlab as cl


@pytest.mark.parametrize("name", ["bench", "fit", "validate"])
def test_every_option_is_an_argument_with_its_meaning_bounds_and_default(name: str) -> None:
    assert_options_are_arguments(name, getattr(cl, name.capitalize()))
