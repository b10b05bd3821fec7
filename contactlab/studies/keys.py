"""The options of studies as keys of a configuration: the section `study` of a command or a sweep's cell."""

from collections.abc import Mapping
from typing import Any, Final

from contactlab.config.faults import raise_faults
from contactlab.config.groups import Keys, Options, Section, keys_of, named
from contactlab.config.schema import KEYS, Examination
from contactlab.parameter import DeclaredField
from contactlab.studies.registry import studies, study_class
from contactlab.studies.study import Study

STUDIES: Final = Section(
    Options(lambda: sorted(studies()), lambda name: named("name", name, keys_of(study_class(name)))), "name"
)
"""Every study, and its options."""

WITH_STUDY: Final[Keys] = {**KEYS, "study": STUDIES}
"""The keys of a run, and of the study that is put to it."""


def study_in(section: Mapping[str, Any]) -> Study:
    """Return the study that a section describes, `{"name": "steady", "brake": 2e-3}`; texts become data here.

    Raises:
        ConfigurationError: with every fault.
    """
    name = str(section.get("name"))
    declared = keys_of(study_class(name)) if name in studies() else {}
    usual = {key: field.default for key, field in declared.items() if isinstance(field, DeclaredField)}
    examined = Examination({"study": {**usual, **section}}, {"study": STUDIES})
    raise_faults(examined.faults)
    options = dict(examined.values["study"])
    return study_class(options.pop("name"))(**options)
