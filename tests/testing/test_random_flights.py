"""No touch-down of random flights is missed, late or invented, however the work is divided."""

import csv
import importlib.util
from functools import cache, reduce
from pathlib import Path
from types import ModuleType

import pytest

from contactlab.testing.flights.randomly import KINDS, Tally, added, fly, random_flight

SCRIPT = Path(__file__).parents[2] / "experiments" / "random_flights.py"
FLIGHTS = 600


@cache
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("random_flights", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def tallies() -> dict[str, Tally]:
    return fly(0, range(FLIGHTS))


@pytest.mark.parametrize("kind", KINDS)
def test_no_touch_down_is_missed_late_or_invented(kind: str) -> None:
    tally = tallies()[kind]
    # The claim is about both: flights that touch and flights that do not.
    assert 0.2 * tally.flights < tally.touched < tally.flights
    assert (tally.missed, tally.invented, tally.late) == (0, 0, 0), tally


def test_every_kind_of_flight_comes() -> None:
    assert sum(tally.flights for tally in tallies().values()) == FLIGHTS
    assert all(tally.flights > 0.1 * FLIGHTS for tally in tallies().values())


def test_grazes_are_within_a_nanometre_of_touching() -> None:
    depths = []
    for number in range(80):
        kind, flight = random_flight(0, number)
        if kind not in ("any clearance", "resonance"):
            _, gaps = flight.minima(1e-3)
            depths.append(float(abs(gaps).min()))
    assert len(depths) > 20
    assert max(depths) < 1e-9
    assert min(depths) < 1e-12


def test_the_figures_do_not_depend_on_the_number_of_workers() -> None:
    expected = fly(3, range(250))
    for workers in (1, 2):
        assert script().measure(250, workers, 3) == expected


def test_the_script_writes_its_table_and_tells_faults_by_its_status(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # The script sets it for its workers.
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    path = tmp_path / "table.csv"
    arguments = ["--flights", "5", "--workers", "1", "--csv", str(path)]
    good = {kind: Tally(flights=1, touched=1, worst=4, largest_excess=0.0) for kind in KINDS}
    for missed in (0, 1):
        bad = good | {"graze": Tally(flights=1, touched=1, missed=missed, worst=2)}
        monkeypatch.setattr(script(), "measure", lambda *_, table=bad: table)
        assert script().main(arguments) == missed
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [row["kind"] for row in rows] == list(KINDS)
        assert [row["missed"] for row in rows if row["kind"] == "graze"] == [str(missed)]
        assert sum(int(row["missed"]) for row in rows) == missed
    assert "missed" in capsys.readouterr().out


def test_a_tally_of_two_parts_counts_both_and_names_the_worse() -> None:
    late = Tally(flights=2, touched=1, late=1, largest_error=3e-9, largest_excess=2e-9, worst=7)
    missed = Tally(flights=3, touched=2, missed=1, worst=9)
    fine = Tally(flights=4, touched=4, largest_error=1e-8, largest_excess=1e-18, worst=1)
    expected = Tally(9, 7, 1, 0, 1, 1e-8, 2e-9, 9)
    assert reduce(added, (late, missed, fine)) == expected
    assert reduce(added, (fine, missed, late)) == expected
    assert added(late, fine).worst == 7
    assert added(Tally(), fine) == fine
