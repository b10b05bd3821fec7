"""The Python function of a study, made from its declaration: `gain = function_of(Gain)`.

Options of the study are its keyword arguments; before them stands what the study is put to, after them what
every study takes, `output` and `progress`.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, replace
from inspect import Parameter as Argument, Signature, signature
from textwrap import fill
from typing import Annotated, Any, Final, get_args, get_origin

from contactlab.checks import check_kind, checked_arguments
from contactlab.config import Setup, build
from contactlab.engine.defaults import default_contact_step
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.parameter import DeclaredField, declared_fields
from contactlab.steady_state.search import steady_setup
from contactlab.studies.docstrings import entries_in, paragraphs_in, sections_in
from contactlab.studies.study import WITHOUT_EFFECT, Result, Setups, Study, check_options

Put = tuple[Setups, dict[str, Any]]
"""What a study is put to: setups by label, and options that follow from the arguments."""

RESULT: Final = "    The result: data, numbers, findings, tables and figures."
"""Section `Returns` of a study that has none."""

WIDTH: Final = 100
"""Of the lines of a docstring."""


def of_setup(setup: Setup) -> Put:
    """Put a study to one setup.

    Args:
        setup: what it is put to.
    """
    return {"": setup}, {}


def of_setups(setups: Setup | Sequence[Setup] | Mapping[str, Setup]) -> Put:
    """Put a study to setups.

    Args:
        setups: what it is put to: one or several, by label if they have any.
    """
    return by_label(setups, Setup), {}


def of_motors(
    motors: Motor | Setup | Sequence[Motor | Setup] | Mapping[str, Motor | Setup],
    law: ContactLaw | Sequence[ContactLaw] | None = None,
) -> Put:
    """Put a study on which the duration of a run has no effect to motors made in Python, or to setups.

    Args:
        motors: setups, or motors made in Python: one or several, by label if they have any.
        law: what acts in the motors that are no setups, one or several; setups have their own.
    """
    laws = [*law] if isinstance(law, Sequence) else [law]
    every = by_label(motors, Motor | Setup)
    setups = [(label, steady_setup(motor, each)) for label, motor in every.items() for each in laws]
    return (dict(setups) if len(laws) == 1 else by_label([setup for _, setup in setups], Setup)), {}


def of_laws(
    setups: Setup | ContactLaw | Sequence[Setup | ContactLaw] | Mapping[str, Setup | ContactLaw] = (),
) -> Put:
    """Put a study of laws to laws, or to setups.

    Args:
        setups: laws, or setups that have them: one or several, by label if they have any. A law stands for
            the default motor under it.
    """
    every, default = by_label(setups, Setup | ContactLaw), build()
    for label, each in every.items():
        if isinstance(each, ContactLaw):
            step = default_contact_step(default.motor, each, default.duration)
            every[label] = replace(default, law=each, contact_step=step)
    return every, {}


def by_label(every: Any, kind: Any) -> dict[str, Any]:
    """Return one or several objects of a kind by label: a number where they have none, "" of a single one.

    Raises:
        TypeError: an object is of another kind.
    """
    if isinstance(every, kind):
        every = [every]
    if not isinstance(every, Mapping):
        every = {"" if len(every) == 1 else str(place): each for place, each in enumerate(every, 1)}
    for label, each in every.items():
        check_kind(f"setups[{label!r}]", each, kind)
    return {**every}


def function_of(
    study: type[Study],
    arguments: Callable[..., Put] | None = None,
    /,
    *,
    name: str = "",
    without: Sequence[str] = (),
    **defaults: Any,
) -> Callable[..., Result]:
    """Return the function of a study, with signature and docstring of its declaration.

    Args:
        study: its class. The docstring may have an example and the sections `Returns` and `Raises` after the
            paragraphs that are the help of the verb.
        arguments: takes what the study is put to, under the names and annotations of the function's first
            arguments and described by its docstring; by default setups, or one if the study takes no several.
        name: of the function; that of the study.
        without: options that `arguments` gives.
        defaults: of options, where they differ from those of the class.

    Raises:
        TypeError: an option has no `Parameter`, or is a tuple.
    """
    check_options(study)
    take = arguments or (of_setups if study.several else of_setup)
    first = signature(take, eval_str=True).parameters
    called = signature(study.__call__, locals={"Setup": Setup}, eval_str=True).parameters
    last = {x.name: x for x in called.values() if x.kind is Argument.KEYWORD_ONLY}
    # What every study has stands after its own.
    fields = sorted(declared_fields(study).items(), key=lambda item: item[0] in WITHOUT_EFFECT)
    options = {x: field for x, field in fields if x not in (*first, *without)}
    every = [*map(_plain, first.values()), *_as_arguments(options, defaults), *last.values()]

    def function(*positional: Any, **named: Any) -> Result:
        values = declared.bind(*positional, **named).arguments
        setups, further = take(**{x: values.pop(x) for x in first if x in values})
        call = {x: values.pop(x) for x in last if x in values}
        return study(**{**defaults, **values, **further})(setups, **call)

    declared = Signature(sorted(every, key=lambda argument: argument.kind), return_annotation=Result)
    function.__name__ = function.__qualname__ = name or study.name
    function.__module__ = study.__module__
    function.__signature__ = declared  # type: ignore[attr-defined]
    # Options are checked by the class.
    function.__annotations__ = {x.name: x.annotation for x in (*first.values(), *last.values())}
    function.__doc__ = _docstring(study, take, options, last)
    return checked_arguments()(function)


def _plain(argument: Argument) -> Argument:
    """Return an argument without what is declared of its number beside the kind."""
    kind = argument.annotation
    return argument.replace(annotation=get_args(kind)[0] if get_origin(kind) is Annotated else kind)


def _as_arguments(options: Mapping[str, DeclaredField], defaults: Mapping[str, Any]) -> Iterator[Argument]:
    """Yield the options of a study as keyword arguments."""
    for name, field in options.items():
        default = defaults.get(name, field.default)
        default = Argument.empty if default is MISSING else default
        yield Argument(name, Argument.KEYWORD_ONLY, default=default, annotation=field.kind)


def _docstring(
    study: type[Study],
    take: Callable[..., Put],
    options: Mapping[str, DeclaredField],
    last: Mapping[str, Argument],
) -> str:
    """Return the docstring of a function: question, text, example, arguments, what is returned and raised."""
    called = entries_in(Study.__call__.__doc__) | entries_in(study.__call__.__doc__)
    arguments = [
        *entries_in(take.__doc__).values(),
        *(_described(name, field) for name, field in options.items()),
        *(called[name] for name in last),
    ]
    sections = sections_in(study.__doc__)
    raised = [f"Raises:\n{sections['Raises']}"] if "Raises" in sections else []
    return "\n\n".join(
        [
            *paragraphs_in(study.__doc__),
            "\n".join(["Args:", *arguments]),
            f"Returns:\n{sections.get('Returns', RESULT)}",
            *raised,
        ]
    )


def _described(name: str, field: DeclaredField) -> str:
    """Return the entry of an option: meaning, unit and bounds."""
    assert field.parameter is not None
    unit = f" [{field.parameter.unit}]" if field.parameter.label else ""
    bounds = f"; {field.parameter.range}" if field.parameter.range else ""
    text = f"{name}: {field.parameter.meaning}{unit}{bounds}."
    return fill(
        text,
        WIDTH,
        initial_indent=" " * 4,
        subsequent_indent=" " * 8,
        break_long_words=False,
        break_on_hyphens=False,
    )
