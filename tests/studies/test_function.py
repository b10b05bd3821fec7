"""The Python function of a study has signature and docstring of its declaration."""

from dataclasses import dataclass
from inspect import signature
from typing import Annotated, Any, ClassVar

import pytest
import xarray
from support.study_functions import assert_options_are_arguments

import contactlab as cl
from contactlab.studies import Part, Study, Task, function_of
from contactlab.studies.function import of_laws

OF_ARGUMENTS = {"basins": {"over"}, "branch": {"over"}, "compare": {"runs"}}
"""Options that follow from other arguments of a function."""

FUNCTIONS: dict[str, type[Study]] = {
    "basins": cl.Basins,
    "branch": cl.Branch,
    "characterise": cl.Characterise,
    "compare": cl.Compare,
    "converged": cl.Steady,
    "steady": cl.Steady,
}


@dataclass(frozen=True, kw_only=True)
class Echo(Study):
    """How long is an echo?

    It is as long as its option.

        >>> echo(setup)

    Raises:
        ValueError: it has no length.
    """

    name: ClassVar[str] = "echo"
    length: Annotated[float, cl.Parameter("l", "m", "length of the echo", above=0.0, at_most=2.0)] = 1.0

    def tasks(self, setups: Any) -> list[Task]:
        return [Task(label, echo_of, (self.length,)) for label in setups]

    def combine(self, setups: Any, parts: Any) -> xarray.DataTree:
        return xarray.DataTree(children=dict(parts)) if len(parts) > 1 else next(iter(parts.values()))

    def numbers(self, data: xarray.DataTree) -> dict[str, cl.Estimate]:
        return {"length": cl.Estimate(float(data["length"]), 0.0)}


class Echoes(Echo):
    name: ClassVar[str] = "echoes"
    several: ClassVar[bool] = True


def echo_of(length: float) -> Part:
    return Part(xarray.DataTree(xarray.Dataset({"length": length})))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_option_is_an_argument_with_its_meaning_bounds_and_default(name: str) -> None:
    assert_options_are_arguments(name, FUNCTIONS[name], OF_ARGUMENTS.get(name, set()))


def test_the_function_of_ones_own_study_takes_a_setup_and_the_options() -> None:
    echo = function_of(Echo, length=0.5)
    setup = cl.build()
    assert echo(setup).length.value == 0.5
    assert echo(setup, length="20 cm").length.value == 0.2
    names = ["setup", "length", "workers", "scheduler", "output", "stop", "progress"]
    assert [*signature(echo).parameters] == names
    assert "    length: length of the echo [m]; greater than 0 m and at most 2 m.\n" in echo.__doc__
    assert "    >>> echo(setup)\n" in echo.__doc__
    assert echo.__doc__.endswith("Raises:\n    ValueError: it has no length.")
    for call, error, key in (
        (lambda: echo(setup, lenght=1.0), TypeError, "lenght.*length"),
        (lambda: echo(setup, length=3.0), ValueError, "length"),
        (lambda: echo(cl.Newton()), TypeError, "setup"),
        (lambda: echo([setup, setup]), TypeError, "setup"),
        (lambda: echo(setup, output=5), TypeError, "output"),
    ):
        with pytest.raises(error, match=key):
            call()


def test_several_setups_have_labels_of_their_own_or_numbers() -> None:
    setup = cl.build()
    echoes, of_law = function_of(Echoes), function_of(Echoes, of_laws, name="of_law")
    assert [*echoes({"a": setup, "b": setup}).setups] == ["a", "b"]
    assert [*echoes([setup, setup]).setups] == ["1", "2"]
    assert [*echoes(setup).setups] == [*echoes([setup]).setups] == [""]
    assert of_law(cl.Newton(restitution=0.25)).setups[""].law == cl.Newton(restitution=0.25)
    assert of_law.__name__ == "of_law"
    with pytest.raises(TypeError, match="setups"):
        echoes([setup, cl.Newton()])


def test_a_law_stands_for_the_default_motor_under_it() -> None:
    for law in (cl.Newton(), cl.HertzPenalty()):
        of_law, built = of_laws(law)[0][""], cl.build([f"law={law.name}"])
        assert (of_law.contact_step, of_law.tolerance) == (built.contact_step, built.tolerance)
