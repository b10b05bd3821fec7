"""Claims on the declaration of a study: nothing that an author writes is ignored."""

from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from contactlab.studies.steady import Steady


def test_a_class_attribute_that_no_study_has_is_refused() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Stroke(Steady):
        name: ClassVar[str] = "stroke"
        forms: ClassVar[dict[str, Any]] = {}

    with pytest.raises(TypeError, match="forms"):
        Stroke()


def test_an_attribute_of_its_own_begins_with_an_underscore() -> None:
    @dataclass(frozen=True, kw_only=True)
    class Stroke(Steady):
        name: ClassVar[str] = "stroke"
        _forms: ClassVar[dict[str, Any]] = {}

        def own(self) -> int:
            return 1

    assert Stroke().own() == 1
