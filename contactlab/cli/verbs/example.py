"""Copy a script, measured impacts, or the package of a law or study, to begin from.

Without a name they are listed; nothing is overwritten.
"""

import ast
import re
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, RefusalError
from contactlab.suggestion import suggestion

GALLERY: Final = Path("docs/gallery")
PACKAGES: Final = {
    "own_law": (
        "tests/example_law",
        "contactlab.laws",
        "pip install -e {0} makes its law one of the command's: contactlab laws {1} describes it, "
        "contactlab law={1} runs it, and pytest {0} tests it against the contract of every law.",
    ),
    "own_study": (
        "tests/example_study",
        "contactlab.studies",
        "pip install -e {0} makes its study a verb of the command: contactlab {1} --help describes it, "
        "contactlab {1} does it; its metric is computed of every run.",
    ),
}
"""Packages: folder, group of the entry, what to do. In a wheel the folders lie in `contactlab/examples`."""

ONWARD: Final = {
    "force_curve": 'contactlab fit {0} law=composed law/normal=jkr law.normal.radius="20 nm" '
    'cantilever_stiffness="0.5 N/m" contact_point=free baseline=free tilt=free method=least_squares '
    "fits a law to it.",
    "loop": "contactlab drive {0} law=composed law/friction=dahl draws a law beside it.",
    "motor_measurement": "contactlab fit {0} law=newton resonator=finite_element law.restitution=0.1..0.9 "
    "contact.friction_coefficient=0.1..0.6 fits a law to it.",
    "tribometer": "contactlab drive {0} law=composed law/friction=dahl degree=1 draws a law beside it.",
}
"""What to do with data that are no impacts, by name."""

_ORDER: Final = re.compile(r"^plot_(?:\d+_)?")


class Example(NamedTuple):
    """Something to copy: name, title, file or folder, name of the copy, and what to do with it."""

    name: str
    title: str
    source: Path
    copy: str
    onward: str


def main(arguments: list[str]) -> int:
    """Print the list, or copy the named example into the current folder, and return the exit status.

    Raises:
        RefusalError: there is no such example, its copy would overwrite something or cannot be written.
    """
    operands, _ = Parser(__name__, __doc__, "[NAME]", "of the example to copy").read(arguments)
    wanted = operands[0] if operands else None
    known = {each.name: each for each in examples()}
    if wanted is None:
        width = max(map(len, known))
        print(*(f"{each.name:<{width}}  {each.title}" for each in known.values()), sep="\n")
        print("\ncontactlab example NAME copies one into the folder where you are.")
        return COMPLETE
    if wanted not in known:
        hint = suggestion(wanted, known)
        raise RefusalError(f"There is no example '{wanted}'; it must be one of {', '.join(known)}. {hint}")
    chosen = known[wanted]
    _copy(chosen.source, Path(chosen.copy))
    print(f"{chosen.copy} is here: {chosen.title}.\n{chosen.onward}")
    return COMPLETE


def names() -> list[str]:
    """Return the names of the examples, which complete the verb."""
    return [each.name for each in examples()]


def examples() -> Iterator[Example]:
    """Yield the examples: scripts and data of the gallery by their files, and the packages."""
    package = Path(__file__).resolve().parents[2]
    inside = package / "examples"
    root = inside if inside.is_dir() else package.parent
    for path in sorted((root / GALLERY).glob("*.py")):
        title = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").partition("\n")[0]
        name = _ORDER.sub("", path.stem)
        yield Example(name, title, path, f"{name}.py", f"python {name}.py runs it.")
    for path in sorted((root / GALLERY).glob("*.csv")):
        match = re.search(r"^# title: (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
        onward = ONWARD.get(path.stem, "contactlab validate {0} law=newton,poisson compares laws with it.")
        onward = onward.format(path.name)
        yield Example(path.stem, match[1] if match else "", path, path.name, onward)
    for copy, (folder, group, onward) in PACKAGES.items():
        text = (root / folder / "pyproject.toml").read_text(encoding="utf-8")
        project = tomllib.loads(text)["project"]
        entry = next(iter(project["entry-points"][group]))
        yield Example(copy, project["description"], root / folder, copy, onward.format(copy, entry))


def _copy(source: Path, target: Path) -> None:
    """Copy a file, or the files of a folder; all of it or nothing."""
    # Imported here: listing needs none of it.
    from contactlab.results.files import error_text, whole_file

    try:
        if source.is_file():
            with whole_file(target, fresh=True) as partial:
                shutil.copyfile(source, partial)
            return
        target.mkdir()
        try:
            for path in sorted(path for path in source.iterdir() if path.is_file()):
                with whole_file(target / path.name) as partial:
                    shutil.copyfile(path, partial)
        except BaseException:
            shutil.rmtree(target)
            raise
    except FileExistsError as error:
        raise RefusalError(f"'{target}' exists; the copy of an example must have a new name.") from error
    except OSError as error:
        raise RefusalError(f"The example could not be copied: {error_text(error)}", INCOMPLETE) from error
