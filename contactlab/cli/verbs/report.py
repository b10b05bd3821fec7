"""Make page, figures and tables of a study anew from its dataset.

They are those that the study itself leaves.
"""

import sys
from pathlib import Path

from contactlab.cli import terminal
from contactlab.cli.arguments import Parser
from contactlab.cli.terminal import COMPLETE, RefusalError, tell, unwritable


def main(arguments: list[str]) -> int:
    """Read the file, write the others, print the result and return the exit status.

    Raises:
        RefusalError: no study left the file, or nothing can be written.
    """
    parser = Parser(__name__, __doc__, "FILE", "the dataset of a study, such as steady.nc")
    parser.option("output", "DIR", "folder of the files; FILE's own")
    (word,), options = parser.read(arguments)
    file = Path(word)
    folder = Path(options.get("output", file.parent))
    with terminal.progress(1.0, "tasks"), terminal.raising():
        # Imported here: they bring the compiler, which --help does not need.
        from contactlab.studies.reading import load
        from contactlab.studies.study import Result

        try:
            result = load(file)
            if not isinstance(result, Result):
                raise RefusalError(f"FILE is '{file}', a run; it must be the dataset of a study.")
            files = result.save(folder)
        except ValueError as error:
            raise RefusalError(f"FILE: {error}") from error
        except OSError as error:
            raise unwritable(folder, error) from error
    tell(result.text(terminal.width_of(sys.stdout)), sys.stdout)
    tell(f"Written to {folder}: {', '.join(files)}.", sys.stdout)
    return COMPLETE
