"""A desk at which a page is followed to the letter: one shell and one Python session in one folder."""

import json
import os
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import mkstemp
from threading import Timer
from typing import Final, Self, final

from page_blocks import Block, PageError, Picture, agrees, items

LONGEST: Final = 900.0
"""Seconds that a block may take."""

_DONE: Final = "the block is done"

# As in a session, what is pasted has no file; it has as many lines before it as on the page.
_SESSION: Final = f"""
import json, sys
names = {{"__name__": "__main__"}}
for told in sys.stdin:
    line, code = json.loads(told)
    exec(compile("\\n" * line + code, "<stdin>", "exec"), names)
    print("\\n{_DONE}", flush=True)
"""


class _Program:
    """A program that receives one piece of code after the other and reports when each is done."""

    def __init__(self, command: list[str], folder: Path, environment: Mapping[str, str]) -> None:
        self._errors, self._path = mkstemp()
        self._program = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
        )

    def tell(self, label: str) -> str:
        """Return what it prints.

        Raises:
            PageError: it ended before it was done; with all that it said.
        """
        program = self._program
        assert program.stdin is not None
        assert program.stdout is not None
        watch = Timer(LONGEST, program.kill)
        watch.start()
        printed: list[str] = []
        try:
            program.stdin.write(label)
            program.stdin.flush()
            for line in program.stdout:
                if line == f"{_DONE}\n":
                    return "".join(printed)
                printed.append(line)
        finally:
            watch.cancel()
        raise PageError("".join(printed) + Path(self._path).read_text(encoding="utf-8"))

    def close(self) -> None:
        """End the program."""
        assert self._program.stdin is not None
        assert self._program.stdout is not None
        self._program.stdin.close()
        self._program.wait()
        self._program.stdout.close()
        os.close(self._errors)
        Path(self._path).unlink()


@final
class Desk:
    """A shell, and the Python session that the shell's `python` begins once a block asks for it.

    Args:
        folder: where both begin.
        environment: what the shell knows.
    """

    def __init__(self, folder: Path, environment: Mapping[str, str]) -> None:
        self._folder = folder
        # No picture opens a window.
        self._environment = {**environment, "MPLBACKEND": "Agg"}
        self._shell = _Program(["bash", "--noprofile", "--norc"], folder, self._environment)
        self._session: _Program | None = None
        self.shell("set -euo pipefail")

    def __enter__(self) -> Self:
        """Return the desk."""
        return self

    def __exit__(self, *raised: object) -> None:
        """End what was begun."""
        for each in (self._session, self._shell):
            if each is not None:
                each.close()

    def shell(self, code: str) -> str:
        """Paste into the shell, and give what is printed."""
        return self._shell.tell(f"{{\n{code}\n}} < /dev/null\nprintf '\\n%s\\n' '{_DONE}'\n")

    def python(self, code: str, line: int) -> str:
        """Paste into the Python session, and give what is printed."""
        if self._session is None:
            python = self.shell("command -v python").strip()
            command = [python, "-W", "error", "-c", _SESSION]
            self._session = _Program(command, self._folder, self._environment)
        return self._session.tell(json.dumps([line, code]) + "\n")

    def paste(self, block: Block) -> str:
        """Paste a block where it belongs, and give what is printed."""
        return self.shell(block.code) if block.language == "bash" else self.python(block.code, block.line)


def surroundings(python: Path) -> dict[str, str]:
    """Return what a shell knows in which a Python environment is active."""
    return {**os.environ, "PATH": os.pathsep.join([str(python.parent), os.environ["PATH"]])}


def follow(page: Path, folder: Path, desk: Desk) -> Iterator[tuple[Block, str]]:
    """Do in their order what a page says, look whether it comes out so, and give blocks and what they print.

    Args:
        page: in Markdown.
        folder: where the desk is.
        desk: at which it is done.

    Raises:
        PageError: a block fails or prints something else, or a picture is not there; with its line.
    """
    for each in items(page.read_text(encoding="utf-8")):
        where = f"{page.name}, line {each.line}"
        if isinstance(each, Picture):
            if not (folder / each.path).is_file():
                raise PageError(f"{where}: nothing has made {each.path}.")
            continue
        try:
            printed = desk.paste(each)
        except PageError as error:
            raise PageError(f"{where}:\n{each.code}\n{error}") from error
        if each.output is not None and not agrees(each.output, printed):
            raise PageError(f"{where}:\n{each.code}\nprinted\n\n{printed}\nand not\n\n{each.output}")
        yield each, printed
