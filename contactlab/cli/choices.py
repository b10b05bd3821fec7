"""Choices from a group: a law, a part, a basis comes with its parameters, and is not renamed by a key."""

from collections.abc import Callable

from contactlab.config.groups import group_told_by
from contactlab.config.nesting import flat


def misplaced(line: str, key: str, value: object, options: Callable[[str], list[str]]) -> str:
    """Why a value cannot be set because it is a choice from a group; empty where it is none.

    Args:
        line: as typed.
        key: whose value is set.
        value: a mapping is one of keys below.
        options: the options of a group, none for what is no group.
    """
    group = key.replace(".", "/")
    if "." in key and not isinstance(value, dict) and (known := options(group)):
        return (
            f"{line} gives a value to a group of keys; it must be a choice, {group}=NAME. "
            f"Choose one of {', '.join(known)}."
        )
    for below in flat({key: value if isinstance(value, dict) and value else None}):
        if group := group_told_by(below):
            names = ", ".join(options(group))
            return (
                f"{line} would hand the parameters of one {group} to another; they must be chosen together. "
                f"Choose one by {group}=NAME{names and f', of {names}'}."
            )
    return ""
