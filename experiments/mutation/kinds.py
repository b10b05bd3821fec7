"""What a mutation is."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Mutation:
    """One error put into one file.

    Args:
        name: the error in words.
        file: below the project's root; a folder is searched for the file that has the text.
        old, new: text that stands exactly once in the file, and what it becomes.
        tests: the test files that are asked first.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    def find(self, project: Path) -> Path:
        """The file in a project."""
        place = project / self.file
        files = sorted(place.rglob("*.py")) if place.is_dir() else [place]
        having = [file for file in files if self.old in file.read_text(encoding="utf-8")]
        if len(having) != 1:
            raise ValueError(
                f"'{self.name}': its text stands in {len(having)} files of {self.file}; it must stand in "
                "one. Bring the mutation up to date."
            )
        return having[0]

    def apply(self, source: str) -> str:
        """The file with the error in it.

        Raises:
            ValueError: the old text does not stand exactly once.
        """
        count = source.count(self.old)
        if count != 1:
            raise ValueError(
                f"'{self.name}': its text stands {count} times in {self.file}; it must stand once. "
                "Bring the mutation up to date with the file."
            )
        return source.replace(self.old, self.new)
