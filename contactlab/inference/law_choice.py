"""What the words of a fit say: which numbers are free in which ranges, and all else of the configuration."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final, final

from contactlab.config import ConfigurationError, Setup, build, compose
from contactlab.config.composition import options_of
from contactlab.config.groups import NOT_OF_A_RUN
from contactlab.config.nesting import flat, nested
from contactlab.config.quantity import UnitError, to_si
from contactlab.config.schema import FRICTION, declared_in
from contactlab.inference.free_parameters import WIDE, Free, free_parameters
from contactlab.laws import Composed
from contactlab.laws.declaration import SHARED
from contactlab.suggestion import suggestion

LAW: Final = "law"
PART: Final = "law/"

_RANGE: Final = re.compile(r"(?P<key>[\w.]+)=(?P<low>[^=]+?)\.\.(?P<high>[^=]+)")


@final
@dataclass(frozen=True)
class Words:
    """The words of a fit, sorted.

    Args:
        laws: names; none for that of the data.
        ranges: both ends of what is free, as typed, by full key.
        overrides: all others.
    """

    laws: tuple[str, ...]
    ranges: Mapping[str, tuple[str, str]]
    overrides: tuple[str, ...]


def sorted_words(words: Sequence[str]) -> Words:
    """Sort the words of a fit.

    Raises:
        ConfigurationError: a key that is given twice.
    """
    laws: list[str] = []
    ranges: dict[str, tuple[str, str]] = {}
    others: list[str] = []
    faults = []
    for word in words:
        if found := _RANGE.fullmatch(word):
            if found["key"] in ranges:
                faults.append(f"{found['key']} has two ranges; it must have one. Leave one out.")
            ranges[found["key"]] = found["low"].strip(), found["high"].strip()
        elif word.startswith("law="):
            laws += [name.strip() for name in word.removeprefix("law=").split(",")]
        else:
            others.append(word)
    twice = [name for name in dict.fromkeys(laws) if laws.count(name) > 1]
    faults += [f"law={name} is given twice; every law must be given once. Leave one out." for name in twice]
    if faults:
        raise ConfigurationError(faults)
    return Words(tuple(laws), ranges, tuple(others))


def setups_of(words: Words, told: Mapping[str, Any]) -> list[Setup]:
    """Build what runs under each law, with all that is not free.

    Args:
        words: of the fit.
        told: configuration of the data, may be empty; the words go before it.

    Raises:
        ConfigurationError: with every fault.
    """
    lines = _choices(words)
    setups, faults = [], []
    kept = [_of_law(words, law) if len(lines) > 1 else _alone(words) for law in lines]
    for word in words.overrides:
        chosen = Composed.name in words.laws and word.startswith(PART)
        if not chosen and not any(word in each for each in kept):
            # The first law says what is wrong with it.
            kept[0].append(word)
    for law, own in zip(lines, kept, strict=True):
        try:
            setups.append(build(_configuration([*law, *own], told)))
        except ConfigurationError as error:
            faults += error.faults
    if faults:
        raise ConfigurationError(list(dict.fromkeys(faults)))
    return setups


def _choices(words: Words) -> list[tuple[str, ...]]:
    """Return the words that choose each law: a composed law stands in every combination of its parts.

    Raises:
        ConfigurationError: a part that is given twice.
    """
    lines: list[tuple[str, ...]] = []
    parts: dict[str, list[str]] = {}
    for word in words.overrides:
        if word.startswith(PART):
            key, _, value = word.partition("=")
            parts.setdefault(key, []).extend(f"{key}={part.strip()}" for part in value.split(","))
    twice = [part for each in parts.values() for part in dict.fromkeys(each) if each.count(part) > 1]
    if twice:
        raise ConfigurationError(
            [f"{part} is given twice; it must be given once. Leave one out." for part in twice]
        )
    for name in words.laws:
        lists = parts.values() if name == Composed.name else ()
        lines += [(f"law={name}", *chosen) for chosen in product(*lists)]
    return lines or [()]


def _alone(words: Words) -> list[str]:
    """Return the overrides of a fit of one law, without the parts that choose it."""
    composed = Composed.name in words.laws
    return [word for word in words.overrides if not (composed and word.startswith(PART))]


def _of_law(words: Words, law: tuple[str, ...]) -> list[str]:
    """Return the overrides without parts and without the numbers of laws that this one does not have."""
    known = flat(compose([*law]))
    return [
        word
        for word in words.overrides
        if not word.startswith(PART) and (not word.startswith("law.") or word.partition("=")[0] in known)
    ]


def numbers_of(setup: Setup, words: Words, keys: Sequence[Free]) -> str:
    """Say which numbers of a law are free and fixed, and which of the words' keys it does not have."""
    free = {one.name for one in keys}
    fixed = {_key(name): value for name, value in setup.law.describe().items() if _key(name) not in free}
    known = {*flat(setup.configuration), *free}
    asked = [*words.ranges, *(word.partition("=")[0] for word in words.overrides)]
    absent = [key for key in dict.fromkeys(asked) if key.startswith(f"{LAW}.") and key not in known]
    said = [
        f"Free: {'; '.join(map(str, keys)) or 'nothing'}.",
        f"Fixed: {', '.join(f'{key} = {value:.6g}' for key, value in fixed.items()) or 'nothing'}.",
        *([f"Not a number of this law: {', '.join(absent)}."] if absent else []),
    ]
    return " ".join(said)


def _configuration(lines: Sequence[str], told: Mapping[str, Any]) -> Mapping[str, Any]:
    """Give a configuration in which what the words name goes before what the data tell."""
    composed = {name: keys for name, keys in compose(lines).items() if name not in NOT_OF_A_RUN}
    if not told:
        return composed
    found, fresh = dict(told), flat(composed)
    for line in lines:
        key = line.partition("=")[0].lstrip("+~")
        top = key.replace("/", ".").partition(".")[0]
        if options_of(key):
            # A part of a law is chosen in the law.
            found[top] = composed[top]
    keys = flat(found)
    keys |= {key: fresh[key] for line in lines if (key := line.partition("=")[0].lstrip("+")) in fresh}
    return nested(keys)


def free_keys(setup: Setup, words: Words, *, race: bool) -> tuple[tuple[Free, ...], tuple[Free, ...]]:
    """Give what is free of law and motor, named by keys, and what of it is the law's, named by its fields.

    Without ranges every number of the law is free that has no value in the words, in the range that follows
    from its declaration; among several laws those are free beside the ranges, too.

    Args:
        setup: of the law.
        words: of the fit.
        race: whether several laws are compared.

    Raises:
        ConfigurationError: a key that there is not, or a range that is not admitted; a sentence each.
    """
    known, fields = declared_in(setup.configuration), _fields(setup)
    stated = {*words.ranges, *(word.partition("=")[0] for word in words.overrides)}
    usual = [one for one in free_parameters(setup.law) if _key(one.name) not in stated]
    if not words.ranges:
        return tuple(replace(one, name=_key(one.name)) for one in usual), tuple(usual)
    faults: list[str] = []
    keys: list[Free] = []
    own: list[Free] = []
    for key, ends in words.ranges.items():
        if key not in known:
            if key.startswith("law.") and race:
                continue
            hint = suggestion(key, known, "contactlab --help lists the keys.")
            faults.append(f"There is no number {key} under law={setup.law.name} that could be free. {hint}")
            continue
        said = known[key]
        try:
            low, high = (to_si(end, said.unit) for end in ends)
        except UnitError as error:
            faults.append(f"{key}={'..'.join(ends)} has an end {error}.")
            continue
        shown = f"{key} is free from {low:g} to {high:g}{said.label}"
        if not low < high:
            faults.append(f"{shown}; the end must be greater than the start. Turn them round.")
        elif bad := [end for end in (low, high) if not said.admits(end)]:
            faults.append(
                f"{shown}; both must be {said.range or 'finite'}, and {bad[0]:g} is not. {said.hint}".rstrip()
            )
        else:
            one = Free(key, low, high, low > 0.0 and high / low >= WIDE, said)
            keys.append(one)
            own += [replace(one, name=name) for name in fields if _key(name) == key]
    if faults:
        raise ConfigurationError(faults)
    if race:
        keys += [replace(one, name=_key(one.name)) for one in usual]
        own += usual
    return tuple(keys), tuple(own)


def refuse_unknown(setups: Sequence[Setup], words: Words) -> None:
    """Refuse ranges of keys that none of several laws has, by a ConfigurationError."""
    every = {key for setup in setups for key in declared_in(setup.configuration)}
    faults = [
        f"There is no number {key} under any of these laws. {suggestion(key, sorted(every), 'Leave it out.')}"
        for key in words.ranges
        if key not in every
    ]
    if faults:
        raise ConfigurationError(faults)


def _fields(setup: Setup) -> list[str]:
    return [one.name for one in free_parameters(setup.law)]


def _key(name: str) -> str:
    """Give the key of a configuration that a field of a law is."""
    return FRICTION if name.rpartition(".")[2] == SHARED else f"{LAW}.{name}"
