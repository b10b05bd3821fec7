"""README's two commands, that bring the first figure and the tests, taken apart into steps."""

import re
from collections.abc import Iterator

FIGURE = ("environment", "install", "first run")
GREEN = (*FIGURE, "install for tests", "tests")
"""The steps that are waited for until the first figure is there, and until the tests are green."""


def commands_of(readme: str) -> tuple[str, str]:
    """The commands of README that make the environment, and that run the tests.

    Raises:
        ValueError: there is none in an indented or fenced block.
    """
    fenced, lines = False, []
    for line in readme.splitlines():
        if line.startswith("```"):
            fenced = not fenced and line.startswith("```bash")
        elif fenced or line.startswith("    "):
            lines.append(line.strip())
    result = [
        next((line for line in lines if re.search(word, line)), "") for word in (r"-m venv", r"\bpytest$")
    ]
    if not all(result):
        raise ValueError("README has no command that makes an environment, or none that runs the tests.")
    return result[0], result[1]


def steps_of(readme: str, tests: bool) -> Iterator[tuple[str, str]]:
    """Return the steps of both commands: name and commands, with those that set up the shell.

    The second run comes at the end of the first command.
    """
    first, second = commands_of(readme)
    kept = ""
    for of_tests, command in ((False, first), *(((True, second),) if tests else ())):
        for part in command.split(" && "):
            if part.startswith((". ", "source ")):
                kept += f"{part} && "
                continue
            if part.startswith("pip "):
                yield "install for tests" if of_tests else "install", kept + part
            elif of_tests:
                yield "tests", kept + part
            elif "-m venv" in part:
                yield "environment", kept + part
            else:
                yield "first run", kept + part
                yield "second run", kept + part
