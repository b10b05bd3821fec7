"""What every law and part has to be before it has a value: a dataclass that says its words."""

from dataclasses import fields, is_dataclass
from functools import cache
from inspect import get_annotations, isabstract

from contactlab.checks import shown


@cache
def fault_of(kind: type, words: tuple[str, ...]) -> str:
    """What keeps a class from being a law or a part, as the end of a sentence; empty where nothing does.

    Args:
        kind: the class.
        words: what it has to say of itself.
    """
    if isabstract(kind):
        return f"lacks {', '.join(sorted(getattr(kind, '__abstractmethods__', ())))}"
    # A subclass of a dataclass that says nothing of fields is one too.
    decorated = "__dataclass_fields__" in vars(kind) or not get_annotations(kind)
    if not is_dataclass(kind) or not decorated:
        return "is no dataclass; decorate it with @dataclass(frozen=True)"
    if not getattr(kind, "__dataclass_params__").frozen:  # noqa: B009
        return "can be changed; decorate it with @dataclass(frozen=True)"
    if missing := [word for word in words if not hasattr(kind, word)]:
        return f"does not say its {', '.join(missing)}"
    if among := [field.name for field in fields(kind) if field.name in words]:
        return f"has its {', '.join(among)} among its parameters; annotate it with ClassVar"
    if not isinstance(name := getattr(kind, "name"), str):  # noqa: B009
        return f"has a name that is no text, {shown(name)}"
    return ""


def refuse_unsound(kind: type, words: tuple[str, ...]) -> None:
    """Refuse a class that cannot be a law or a part.

    Raises:
        TypeError: with a sentence.
    """
    if fault := fault_of(kind, words):
        raise TypeError(f"{kind.__name__} {fault}.")
