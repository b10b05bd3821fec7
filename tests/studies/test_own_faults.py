"""Messages on faults of a study and a metric of one's own have their name and place."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import pytest
import xarray
from support.command_line import Elsewhere

import contactlab as cl
from contactlab.config.faults import failure_of
from contactlab.metrics.catalogue import Metric, measured
from contactlab.studies import Part, Study, Task, function_of
from contactlab.studies.study import Result, option
from contactlab.variables import Variable

FAULTY = '''
from dataclasses import dataclass
from typing import Annotated, ClassVar

import xarray

import contactlab as cl
from contactlab.studies import Study, Task
from contactlab.studies.study import option


class Typo(Study):
    """Does it fail?"""

    name = "typo"

    def tasks(self, setups):
        return [Task(key, misspelt, (key,)) for key in ("first", "second")]

    def numbers(self, data):
        return {}


def misspelt(key):
    return cl.stedy(key)


class Bare(Typo):
    name = "bare"

    def tasks(self, setups):
        return [Task("only", xarray.Dataset)]


@dataclass(frozen=True, kw_only=True)
class Plain(Typo):
    name: ClassVar[str] = "plain"
    points: int = 5


@dataclass(frozen=True, kw_only=True)
class Listed(Typo):
    name: ClassVar[str] = "listed"
    points: Annotated[tuple[float, ...], option("numbers")] = (1.0,)
'''
PLACE = f"faulty.py, line {FAULTY.splitlines().index('    return cl.stedy(key)') + 1}"
SWEPT = "-m", "typo", "law=newton", "contact.clearance=1e-6,2e-6", "output=swept"


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    """A folder with a package of faulty studies installed."""
    here = Elsewhere(tmp_path_factory.mktemp("packages"), tmp_path_factory.mktemp("here"))
    entries = {name.lower(): f"faulty:{name}" for name in ("Typo", "Bare", "Plain", "Listed")}
    here.install(here.wheel("other", "1.0", {}, {"faulty": FAULTY}, {"contactlab.studies": entries}))
    return here


def test_faults_of_a_study_are_told_by_the_command_in_a_line(elsewhere: Elsewhere) -> None:
    typo = [("typo", "law=newton", f"workers={count}", f"output=w{count}") for count in (1, 2)]
    others = [("bare", "law=newton"), ("plain", "law=newton"), ("listed", "--help")]
    results = elsewhere.commands([*typo, SWEPT, *others])
    for status, out, err in results[:3]:
        assert status == 1
        (line, *_) = [line for line in (out + err).splitlines() if "stedy" in line]
        assert "AttributeError" in line
        assert PLACE in line
        assert "Traceback" not in out + err
    for count, (_, _, err) in enumerate(results[:2], 1):
        assert "the task 'first'" in err or "the task 'second'" in err
        assert str(Path(f"w{count}") / "run.log") in err
        log = (elsewhere.folder / f"w{count}" / "run.log").read_text(encoding="utf-8")
        assert "Traceback" in log
        assert "in misspelt" in log
    assert "in misspelt" in (elsewhere.folder / "swept" / "run.log").read_text(encoding="utf-8")
    for (status, out, err), names in zip(
        results[3:], (("bare", "'only'", "Part"), ("plain", "points"), ("listed", "points")), strict=True
    ):
        assert (status, out) == (2, "")
        assert all(name in err for name in names)
        assert "Traceback" not in err


SPEED = Variable("speed", (), "rad s-1", "v", "a speed")


class Lacking(Study):
    """Does it lack its number, and raise in its figures?"""

    name = "lacking"
    quantities = (SPEED,)

    def tasks(self, setups):
        return [Task("only", empty)]

    def numbers(self, data):
        return {}

    def figures(self, data):
        data.attrs["drawn"] = data.attrs.get("drawn", 0) + 1
        return data.no_such_thing


def empty() -> Part:
    return Part(xarray.DataTree())


@dataclass(frozen=True, kw_only=True)
class Plain(Lacking):
    name: ClassVar[str] = "plain"
    points: int = 5


@dataclass(frozen=True, kw_only=True)
class Listed(Lacking):
    name: ClassVar[str] = "listed"
    points: Annotated[tuple[float, ...], option("numbers")] = (1.0,)


def test_what_the_methods_of_a_study_raise_is_what_its_result_raises() -> None:
    result = Result(Lacking(), {}, xarray.DataTree())
    with pytest.raises(AttributeError, match="no_such_thing"):
        result.plot()
    assert result.data.attrs["drawn"] == 1


def test_a_number_that_lacks_is_refused_in_a_run_as_in_a_sweep() -> None:
    for put in (Lacking().evaluate, Lacking()):
        with pytest.raises(ValueError, match=r"lacking.*speed"):
            put(cl.build())


@pytest.mark.parametrize("study", [Plain, Listed])
def test_an_option_that_no_command_can_have_is_refused(study: type[Study]) -> None:
    with pytest.raises(TypeError, match="points"):
        function_of(study)


def test_a_metric_that_raises_is_named_with_its_place() -> None:
    def rate(run: object) -> float:
        return cl.no_such_rate(run)

    with pytest.raises(AttributeError) as raised:
        measured({"rate": Metric("rate", rate, "q", "a rate", "1")}, None)
    text = failure_of(raised.value)
    assert "the metric rate" in text
    assert "test_own_faults.py" in text
