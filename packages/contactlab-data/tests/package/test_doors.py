"""The package is installed by the entry points that anybody has, and the core says what it brings."""

from importlib.metadata import distribution

import contactlab as cl
import contactlab_data
from contactlab.packages import BROUGHT, bringing
from contactlab.studies.registry import question_of, study_class


def test_the_core_lists_the_entry_points_of_the_package() -> None:
    points = distribution("contactlab-data").entry_points
    assert {*points.names} == {*BROUGHT["contactlab-data"]}
    assert all("contactlab-data" in bringing(name) for name in points.names)


def test_names_and_verbs_are_those_of_the_entry_points() -> None:
    points = distribution("contactlab-data").entry_points
    for point in points.select(group="contactlab.names"):
        assert getattr(cl, point.name) is point.load() is getattr(contactlab_data, point.name)
        assert point.name in dir(cl)
    for point in points.select(group="contactlab.studies"):
        study = study_class(point.name)
        assert study is point.load()
        assert question_of(point.name) == " ".join((study.__doc__ or "").split("\n\n")[0].split())
