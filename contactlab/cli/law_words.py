"""Laws as the words of a verb choose them, without a motor: names, parts, and what is free of each."""

from collections.abc import Iterable, Sequence
from itertools import product

from contactlab.cli.terminal import RefusalError
from contactlab.config.quantity import UnitError, to_si
from contactlab.config.schema import FRICTION
from contactlab.inference.candidates import usual_law, usual_laws
from contactlab.inference.free_parameters import free_parameters
from contactlab.inference.models import LawModel
from contactlab.laws import Composed
from contactlab.laws.declaration import SHARED
from contactlab.laws.registry import PARTS, law_names
from contactlab.studies.branch import RANGE
from contactlab.suggestion import suggestion

FORMS = "law=NAME,NAME, law/PART=NAME, law.NAME=VALUE or law.NAME=LOW..HIGH"

_PREFIX = "law."


def models_of(words: Sequence[str]) -> list[LawModel]:
    """Give the models of the laws that words choose, the usual ones where none is named.

    Lists of parts make every combination. A number with a value is held, one with a range is free in it;
    all others stay as they are.

    Raises:
        RefusalError: a word that is none of `FORMS`, or names what there is not; a sentence.
    """
    names: list[str] = []
    parts: dict[str, list[str]] = {}
    numbers: dict[str, str] = {}
    for word in words:
        key, sign, value = word.partition("=")
        if not sign or not value:
            raise RefusalError(f"{word} is not understood; it must have the form {FORMS}.")
        if key == "law":
            names += _listed(value)
        elif key.startswith("law/"):
            parts.setdefault(_family(key), []).extend(_listed(value))
        elif key.startswith(_PREFIX) or key == FRICTION:
            if key in numbers:
                raise RefusalError(f"{key} is given twice; it must be given once. Leave one out.")
            numbers[key] = word
        else:
            hint = suggestion(key, ["law", *(f"law/{family}" for family in PARTS)])
            raise RefusalError(
                f"{word} is no word of a law, and no motor is needed; it must have the form {FORMS}. "
                f"{hint}".rstrip()
            )
    if parts and Composed.name not in names:
        names.append(Composed.name)
    models = list(_named(names, parts)) if names else usual_laws()
    for key, word in numbers.items():
        models = _changed(models, key, word)
    return models


def _named(names: Iterable[str], parts: dict[str, list[str]]) -> Iterable[LawModel]:
    """Give the models of laws by name, a composed one in every combination of its parts."""
    for name in names:
        combinations = product(*parts.values()) if name == Composed.name else [()]
        for chosen in combinations:
            try:
                yield usual_law(name, **dict(zip(parts, chosen, strict=False)))
            except (ValueError, TypeError) as error:
                raise RefusalError(str(error)) from error


def _changed(models: Sequence[LawModel], key: str, word: str) -> list[LawModel]:
    """Hold a number of every law that has it, or free it in a range."""
    found = []
    for model in models:
        known = {name: said for name, _, said in model.law.effective() if said is not None}
        for name in known:
            if name == key.removeprefix(_PREFIX) or (key == FRICTION and name.rpartition(".")[2] == SHARED):
                found.append(_with(model, name, word, known[name].unit))
                break
        else:
            found.append(model)
    if all(one is other for one, other in zip(found, models, strict=True)):
        every = sorted({f"{_PREFIX}{name}" for model in models for name in model.law.describe()})
        hint = suggestion(key, every, f"They have {', '.join(every) or 'none'}.")
        raise RefusalError(f"None of these laws has a number {key}. {hint}")
    return found


def _with(model: LawModel, name: str, word: str, unit: str) -> LawModel:
    """Give a model with a number that is held at a value, or free in a range."""
    span = RANGE.fullmatch(word)
    ranges = {one.name: (one.low, one.high) for one in model.free}
    law = model.law
    try:
        if span:
            ranges[name] = to_si(span["start"].strip(), unit), to_si(span["end"].strip(), unit)
        else:
            law = law.changed(name, to_si(word.partition("=")[2].strip(), unit))
            ranges.pop(name, None)
        return LawModel(law, free_parameters(law, ranges), model.label)
    except UnitError as error:
        raise RefusalError(f"{word} has a value {error}; write it like KEY=0.3 or KEY=0.1..0.5.") from error
    except ValueError as error:
        raise RefusalError(f"{word}: {error}") from error


def _listed(text: str) -> list[str]:
    return [name.strip() for name in text.split(",")]


def _family(key: str) -> str:
    family = key.removeprefix("law/")
    if family not in PARTS:
        hint = suggestion(family, PARTS, f"{law_names()[0]} has none.")
        raise RefusalError(f"{key} is no part of a law; it must be one of {', '.join(PARTS)}. {hint}")
    return family
