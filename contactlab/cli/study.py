"""A study from the command line: its verb, written as arguments that Hydra reads, its help, and its work.

contactlab steady law=newton brake="2 mN m"     is     contactlab study=steady law=newton study.brake="2 mN m"
"""

import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import MISSING
from itertools import product
from operator import itemgetter
from pathlib import Path
from types import NoneType
from typing import Any, Final, get_args, get_origin

from contactlab.cli import terminal
from contactlab.cli.arguments import refuse_dashed, refuse_repeated, table_of
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, REFUSED, RefusalError, tell, unwritable
from contactlab.config import ConfigurationError, Setup, build, compose
from contactlab.config.faults import failure_of, is_sentence
from contactlab.config.nesting import flat, quoted
from contactlab.config.options import key_meant, known_keys
from contactlab.config.schema import FRICTION, KEYS
from contactlab.laws.registry import ways_to_choose
from contactlab.parameter import DeclaredField, declared_fields
from contactlab.results.files import LOG
from contactlab.studies.docstrings import paragraphs_in
from contactlab.studies.registry import study_class
from contactlab.studies.study import Setups, Study
from contactlab.studies.sweep.values import listed

LISTED: Final = re.compile(r"[\w/.]+=[^'\"\[{(]*,")
"""An override with several values."""

FILE: Final = re.compile(r"(?!-)[^=]+|(?![-+~]|law/|hydra/)[^=]*/.*")
"""A word that is neither an option nor an override; a folder of a sweep is named by them, two/law=newton."""

FOLDER: Final = "hydra.run.dir", "hydra.sweep.dir"
"""Keys that name the folder of the files, of a single study and of a sweep."""


def as_overrides(verb: str, arguments: Sequence[str]) -> list[str]:
    """Return the arguments of a verb as Hydra reads them.

    An option of the study is written NAME=VALUE, and the folder of the files output=DIR.

    Raises:
        RefusalError: an option is written --NAME, or a key has two values.
    """
    study = study_class(verb)
    options = declared_fields(study)
    sweeps = not {"-m", "--multirun"}.isdisjoint(arguments)
    place = FOLDER[sweeps]
    lines, single, others = [f"study={verb}"], list[str](), list[str]()
    matched: dict[str, list[str]] = defaultdict(list)
    # Kinds that are read from a word by itself know such words.
    patterns = {
        name: each.PATTERN
        for name, field in options.items()
        for kind in field.kinds
        for each in (kind, *get_args(kind))
        if hasattr(each, "of_text")
    }
    patterns |= {study.files: FILE} if study.files else {}
    refuse_dashed(arguments, (*options, "output", *KEYS))
    for word in arguments:
        name, sign, value = word.partition("=")
        # A number with a range is free, an option's too.
        taken = next((key for key, form in patterns.items() if form.fullmatch(word)), "")
        if word == "output=":
            raise RefusalError("output is empty; it must be a folder.")
        if name == "output" and sign:
            lines.append(f"{place}={quoted(value)}")
        elif name in options and sign and not (taken not in ("", study.files) and options[name].is_number):
            listed = _takes_several(options[name])
            apart = listed and not value.startswith("[")
            matched[name] += map(str.strip, value.split(",")) if apart else [value]
            single += [] if listed else [word]
        elif taken:
            matched[taken].append(word)
        else:
            others.append(word)
    refuse_repeated([*single, *others])
    _refuse_unknown(verb, options, others, arguments)
    keys = (line.partition("=")[0] for line in others if "known" in options)
    matched["known"] += [key for key in keys if key.startswith("law.") or key == FRICTION]
    for name, values in filter(itemgetter(1), matched.items()):
        kinds = options[name].kinds
        if len(values) > 1 and name in patterns and not _takes_several(options[name]):
            raise RefusalError(f"{name} is {', '.join(values)}; it must be one. Leave the others out.")
        worded = str in kinds or name in patterns
        texts = [quoted(value) if worded and value != "null" else value for value in values]
        if _takes_several(options[name]) and not values[0].startswith("["):
            texts = [f"[{','.join(map(quoted, values))}]"]
        lines.append(f"study.{name}={texts[-1]}")
    several = [] if sweeps else _of_setups(study, others)
    chosen = [word.partition("=")[0] for word in others]
    own = {"experiment", "plant"}
    free = [each for each in study.presets if {each.partition("=")[0], *own}.isdisjoint(chosen)]
    lines += [*free, *(word for word in others if word not in several)]
    if several:
        lines.append(f"sweep.over=[{','.join(map(quoted, several))}]")
    # What a user sets comes later and prevails.
    return lines if sweeps else [f"{place}={verb}", "hydra.output_subdir=null", *lines]


def _refuse_unknown(
    verb: str, options: Iterable[str], lines: Iterable[str], arguments: Iterable[str]
) -> None:
    """Refuse what is neither an option of a verb nor a group of a run, and list the options: a RefusalError.

    Whether a key of a group exists depends on what is chosen, and is seen when it is composed. A name of a
    law without a key is no file.
    """
    bare = [word for word in arguments if word.isidentifier() and not Path(word).exists()]
    if bare and (way := ways_to_choose(*bare)):
        raise RefusalError(way)
    for key, sign, _ in (line.partition("=") for line in lines):
        if sign and key.isidentifier() and key not in (*KEYS, "experiment", "study", "sweep", "hydra"):
            own = [*options, "output"]
            known = [*own, *(each for each in known_keys() if not each.startswith("study."))]
            hint = key_meant(key, known, f"Options of {verb} are {', '.join(own)}.")
            raise RefusalError(f"{key} is not a known key. {hint}")


def _of_setups(study: type[Study], overrides: Sequence[str]) -> list[str]:
    """Return the overrides by which the setups of a study are made, beside the run that Hydra composes.

    These are listed values and, of several laws, parts and numbers of a law; where the data of a study state
    a motor they are all.
    """
    if study.base is not Study.base:
        return [line for line in overrides if not re.match(r"\W*(study|sweep|hydra)\b", line)]
    listing = [line for line in overrides if study.several and LISTED.match(line)]
    own = ("law/", "law.") if any(line.startswith("law=") for line in listing) else ()
    return [line for line in overrides if line in listing or line.startswith(own)]


def _takes_several(field: DeclaredField) -> bool:
    return any(get_origin(kind) is list for kind in field.kinds)


def setups_of(
    lines: Sequence[str], over: Sequence[str], base: Mapping[str, Any] | None = None
) -> dict[str, Setup]:
    """Return the setups of a study: of its overrides, and of every combination of the listed values.

    Among several laws, parts and numbers of a law are those of the laws that have them.

    Args:
        lines, over: overrides, and those with several values.
        base: the configuration below the overrides, without any of which there is no setup; None is the
            default run.

    Raises:
        ConfigurationError: an override is faulty.
    """
    rest = [line for line in lines if not re.match(r"\+*(study|sweep|hydra)\b", line)]
    axes = [
        [f"{o.partition('=')[0]}={x}" for x in listed(o.partition("=")[2])] if LISTED.match(o) else [o]
        for o in over
    ]
    if faults := [
        f"{o} must have one value at least, and each once."
        for o, axis in zip(over, axes, strict=True)
        if not axis or len({*axis}) < len(axis)
    ]:
        raise ConfigurationError(faults)
    if base is not None and not rest and not axes:
        return {}
    every = [[*rest, *chosen] for chosen in product(*axes)]
    applying = [_applying(lines) if len(every) > 1 else lines for lines in every]
    used = {line for own in applying for line in own}
    differing = {line for axis in axes for line in axis if len(axis) > 1}
    result: dict[str, Setup] = {}
    for whole, known in zip(every, applying, strict=True):
        # What applies to no law is refused with the first.
        own = [line for line in whole if line in known or line not in used]
        label = ", ".join(line for line in own if line in differing)
        if label not in result:
            result[label] = build(base).with_(*own) if base else build(own)
    return result


def _applying(lines: Sequence[str]) -> list[str]:
    """Return overrides without those of parts and numbers that their law has not."""
    law = [line for line in lines if line.startswith("law=")]
    if not law or not any(line.startswith(("law/", "law.")) for line in lines):
        return [*lines]
    parts = [line for line in lines if line.startswith("law/")]
    parts = [line for line in parts if line[4:].partition("=")[0] in compose(law)["law"]]
    known = {*law, *parts, *flat(compose([*law, *parts]))}
    return [x for x in lines if not x.startswith(("law/", "law.")) or {x, x.partition("=")[0]} & known]


def without_effect(study: Study | type[Study], lines: Iterable[str]) -> Iterator[str]:
    """Yield the fault of each override on which a study, or every one of a class, does not depend."""
    keys = study.idle if isinstance(study, Study) else study.ignored
    effective = "sweep.over=" if study.several else "study="
    for line in lines:
        if not line.startswith(effective) and any(_sets(line, key) for key in ("sweep", *keys)):
            yield f"{line} has no effect on the study {study.name}; it must be left out."


def _sets(line: str, key: str) -> bool:
    """Return whether an override sets a key or group, or one below it; a group may be {leaf: value}."""
    name, _, value = line.lstrip("+~").partition("=")
    name = name.split("@")[0].strip().replace("/", ".")
    group, _, leaf = key.partition(".")
    within = name == group and bool(leaf) and re.search(rf"\b{leaf}\s*:", value)
    return f"{name}.".startswith(f"{key}.") or bool(within)


def help_on(verb: str) -> str:
    """Return the help of a study's verb, made from its declaration."""
    study = study_class(verb)
    rows = {name: _described(field) for name, field in declared_fields(study).items()}
    text = (each for each in paragraphs_in(study.__doc__) if not each.startswith(" "))
    return "\n".join(
        [
            f"usage: contactlab {verb} [NAME=VALUE | KEY=VALUE | GROUP=OPTION ...] [output=DIR] [-m]",
            "",
            "\n\n".join(text),
            "",
            "Options:",
            *table_of({**rows, "output": f"folder of the files; {verb}"}),
            "",
            "KEY=VALUE and GROUP=OPTION are those of a run (contactlab --help). With -m every combination of",
            "listed values, KEY=A,B or KEY=linspace(FIRST,LAST,COUNT), leaves its numbers in one dataset.",
        ]
    )


def _described(field: DeclaredField) -> str:
    """Return meaning, unit and default of an option."""
    assert field.parameter is not None
    label = f" [{field.parameter.unit}]" if field.parameter.label else ""
    default = field.default
    shown = "" if default in (None, MISSING, ()) or NoneType in field.kinds else f"; {default}".lower()
    return f"{field.parameter.meaning}{label}{shown}"


def perform_study(study: Study, setups: Setups, folder: Path) -> int:
    """Do a study, write its files, print its result and return the exit status.

    Raises:
        KeyboardInterrupt: with a sentence; finished tasks are kept.
        RefusalError: nothing can be written, or the result does not exist.
    """
    from contactlab.studies.run_state import write_log
    from contactlab.studies.study import finish, run

    try:
        if notice := study.notice(setups):
            tell(notice, sys.stderr)
        (folder / LOG).unlink(missing_ok=True)
        with terminal.progress(1.0, "tasks") as show, terminal.raising():
            result = run(study, setups, folder, show)
            files = finish(result, folder)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"Interrupted. Finished tasks are kept in '{folder}': the same command continues there."
        ) from None
    except OSError as error:
        raise unwritable(folder, error) from error
    # The code of a study of somebody else may fail in any way.
    except Exception as error:
        # An argument that is refused, or a result that physics does not have: no steady state, no orbit.
        if isinstance(error, RuntimeError | ValueError) or is_sentence(error):
            with suppress(OSError):
                folder.rmdir()
            status = INCOMPLETE if isinstance(error, RuntimeError) else REFUSED
            raise RefusalError(str(error), status) from error
        write_log(folder, error)
        text = f"{failure_of(error)} The traceback is in {folder / LOG}."
        raise RefusalError(f"The study {study.name} failed. {text}", INCOMPLETE) from error
    tell(result.text(terminal.width_of(sys.stdout)), sys.stdout)
    tell(f"Written to {folder}: {', '.join(files)}.", sys.stdout)
    return COMPLETE
