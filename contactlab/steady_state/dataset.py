"""What datasets of steady states have in common: their attributes, and enumerated quantities."""

from collections.abc import Sequence

import numpy as np
import yaml

from contactlab.config import Setup
from contactlab.results.netcdf import REFERENCES
from contactlab.results.provenance import code_attributes


def attributes_of(setup: Setup) -> dict[str, object]:
    """Return the global attributes of a dataset about a setup: law, configuration and code."""
    return {
        "references": f"{REFERENCES} Contact law: {setup.law.source}.",
        "law": setup.law.name,
        "configuration": yaml.safe_dump(setup.configuration, sort_keys=False, allow_unicode=True),
        **code_attributes(),
    }


def flags(meaning: str, names: Sequence[str], first: int = 0) -> dict[str, object]:
    """Return the CF attributes of an enumerated quantity whose values begin with `first`."""
    values = np.arange(first, first + len(names), dtype=np.int8)
    return {"long_name": meaning, "flag_values": values, "flag_meanings": " ".join(names)}
