"""The reference of the public API: every name that `contactlab` exports, by what it is for."""

import ast
import inspect
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, Final, get_args

import contactlab
from contactlab.laws.base import Part
from contactlab.packages import bringing

CHAPTERS: Final = {
    "Runs": ("simulation", "config", "trajectory"),
    "Studies, and many runs": ("studies", "datasheet", "estimate"),
    "Steady states": ("steady_state", "settling"),
    "Impacts and measurements": ("impacts", "driving", "force_curves", "measured", "inference"),
    "Motors": ("motor", "engine.equilibrium"),
    "What laws are made of": ("laws.base", "laws.declaration", "laws.memory", "laws.registry", "parameter"),
    "Laws": ("laws",),
    "Parts of a composed law": (),
    "What is raised": (),
}
"""Modules of the package by what their names are for."""

PROVISIONAL: Final = ("Studies, and many runs", "Steady states", "Impacts and measurements")
"""Chapters whose names may still change in a minor release; those of all others are stable."""

FURTHER: Final = {
    "contactlab_data.measured.files": "files of measured impacts and series",
    "contactlab_data.measured.series": "measured series of a motor",
    "contactlab_data.inference.calibration": "numbers of laws from single quantities",
    "contactlab_data.inference.materials": "elastic constants of handbook materials",
    "contactlab_data.inference.problem": "inference problems: data, law, free numbers, noise and priors",
    "contactlab.metrics": "what is said of a run, from its numbers alone",
    "contactlab.testing": "the contract of a law, in tests of one's own",
}


@cache
def exported() -> dict[str, Any]:
    """Return what the public API exports, with what this project's other packages add, by name."""
    added = [point.name for point in entry_points(group="contactlab.names") if bringing(point.name)]
    return {name: getattr(contactlab, name) for name in sorted({*contactlab.__all__, *added})}


@cache
def chapters() -> dict[str, list[str]]:
    """Return the exported names by chapter, none left out."""
    result: dict[str, list[str]] = {chapter: [] for chapter in CHAPTERS}
    for name, item in exported().items():
        result[_chapter_of(item)].append(name)
    return result


def front_door() -> str:
    """Return a chapter for every kind of name."""
    parts = []
    for chapter, names in chapters().items():
        if not names:
            continue
        parts += [f"## {chapter}\n", "```{eval-rst}"]
        for name in names:
            parts += _directive(name, exported()[name])
        parts.append("```\n")
    return "\n".join(parts)


def tiers() -> str:
    """Return the exported names by how stable they are, as Markdown."""
    listed = {False: list[str](), True: list[str]()}
    for chapter, names in chapters().items():
        listed[chapter in PROVISIONAL] += [f"`{name}`" for name in names]
    stable, provisional = (f"{len(names)} names: {', '.join(sorted(names))}." for names in listed.values())
    return f"## Stable\n\n{stable}\n\n## Provisional\n\n{provisional}\n"


def further() -> str:
    """Return a chapter for every module beside the public API that scripts and tests import from."""
    parts = []
    for name, text in FURTHER.items():
        module = import_module(name)
        parts += [f"## `{name}`: {text}\n", "```{eval-rst}"]
        for each in sorted(getattr(module, "__all__", None) or _taken_in(module) or _made_in(module)):
            item = getattr(module, each)
            public = any(item is other for other in exported().values())
            if (inspect.isclass(item) or inspect.isfunction(item)) and not public:
                parts += _directive(each, item, name)
        parts.append("```\n")
    return "\n".join(parts)


def _taken_in(module: ModuleType) -> list[str]:
    """Return the names that a package takes in from its modules, to be had from itself."""
    inside = f"{module.__name__}."
    result = [node for node in _imports(module) if f"{node.module}".startswith(inside)]
    return [each.name for node in result for each in node.names]


def _imports(module: ModuleType) -> list[ast.ImportFrom]:
    source = Path(str(module.__file__)).read_text(encoding="utf-8")
    return [node for node in ast.parse(source).body if isinstance(node, ast.ImportFrom)]


def _passed_on(module: ModuleType) -> list[str]:
    """Return the names that a module imports for others, `from ... import NAME as NAME`."""
    return [each.name for node in _imports(module) for each in node.names if each.asname == each.name]


def _made_in(module: ModuleType) -> list[str]:
    """Return the public names that a module itself makes, and those that it passes on."""
    made = {name: getattr(item, "__module__", "") for name, item in vars(module).items()}
    own = [name for name, origin in made.items() if origin == module.__name__ and not name.startswith("_")]
    return [*own, *_passed_on(module)]


def _directive(name: str, item: Any, module: str = "contactlab") -> list[str]:
    if inspect.isclass(item):
        lines = [f".. autoclass:: {module}.{name}"]
        # What a law's kernels are called with stands at its family.
        if not (hasattr(item, "equation") and inspect.getattr_static(item, "name", None)):
            lines.append("   :members:")
    else:
        lines = [f".. autofunction:: {module}.{name}"]
    return [*lines, ""]


def _chapter_of(item: Any) -> str:
    room = getattr(item, "func", item).__module__.partition(".")[2]
    if inspect.isclass(item) and issubclass(item, Exception):
        return "What is raised"
    if inspect.isclass(item) and issubclass(item, get_args(Part)) and room != "laws.base":
        return "Parts of a composed law"
    best = {
        max((len(start) for start in rooms if f"{room}.".startswith(f"{start}.")), default=0): chapter
        for chapter, rooms in CHAPTERS.items()
    }
    if not max(best):
        raise ValueError(f"{room} is a room of no chapter; give it one in made_api.CHAPTERS.")
    return best[max(best)]
