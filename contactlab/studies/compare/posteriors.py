"""Posteriors of the numbers of laws, from a file of the study `fit`."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final

import xarray

from contactlab.arrays import Array
from contactlab.checks import check_declared
from contactlab.config import Setup
from contactlab.config.nesting import flat
from contactlab.results.files import digest_of_file
from contactlab.studies.compare.laws import ComparisonError


@final
@dataclass(frozen=True)
class Posteriors:
    """Samples of the numbers of laws from a file of the study `fit`, by name of the law.

    A draw gives every law the sample at the same share of its own posterior: those of different laws are
    independent.
    """

    samples: Mapping[str, Mapping[str, Array]]
    digest: str

    @classmethod
    def read(cls, path: str | Path) -> "Posteriors":
        """Read the groups of a file.

        Raises:
            ComparisonError: it is no file of the study `fit`.
        """
        file = Path(path) / "fit.nc" if Path(path).is_dir() else Path(path)
        try:
            check_declared(file)
            with xarray.open_datatree(file) as tree:
                groups = {label: fit["posterior"].to_dataset().load() for label, fit in tree.children.items()}
                if not any(data.data_vars for data in groups.values()):
                    raise ValueError("it has no posterior of a law")
        except (OSError, KeyError, ValueError) as error:
            raise ComparisonError(
                f"posterior is '{path}', which is no file of the study fit: {error}"
            ) from None
        samples = {
            str(label).partition(" ")[0]: {str(name): x.values.ravel() for name, x in data.items()}
            for label, data in groups.items()
        }
        return cls(samples, digest_of_file(file))

    def values(self, setup: Setup, share: float) -> dict[str, float]:
        """Return the numbers of a law's sample by full key; none where there is no posterior of the law."""
        known = flat(setup.configuration)
        columns = self.samples.get(setup.law.name, {})
        keys = {name if name in known else f"law.{name}": x for name, x in columns.items()}
        return {key: float(x[int(share * x.size)]) for key, x in keys.items() if key in known}
