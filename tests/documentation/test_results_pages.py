"""Pages state the numbers of docs/results, and say so where these are not of the present code."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import claims
import dependencies
import listed_numbers
import pytest
import recorded_numbers
import remake
import results_pages
import results_store
from dependencies import ROOT, Recorder, digests
from motor_findings import DAMPED, PHASE, ROD
from results_pages import Page
from results_store import CHECKED, DIFFERENT, EDITED, OLDER, PRESENT, by_module, sealed, state_of

import contactlab as cl
from contactlab.engine.binding import functions_of

STEADY = "docs/steady.md"
DAMPING = recorded_numbers.DAMPING

Edit = Callable[[str, str, str], None]


@pytest.fixture
def fresh():
    recorded_numbers.results.cache_clear()
    results_pages.states.cache_clear()
    yield
    recorded_numbers.results.cache_clear()
    results_pages.states.cache_clear()


@pytest.fixture
def stored(fresh: None, monkeypatch: pytest.MonkeyPatch) -> Callable[[str, dict[str, Any]], None]:
    """Return a function that replaces a file of results."""

    def replace(name: str, content: dict[str, Any]) -> None:
        def read(other: str) -> dict[str, Any]:
            return content if other == name else results_store.read(other)

        monkeypatch.setattr(recorded_numbers, "read", read)
        monkeypatch.setattr(results_pages, "read", read)

    return replace


@pytest.fixture
def edited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Edit]:
    """Return a function that puts a changed source in the place of one, as far as digests go."""
    original = dependencies.parsed

    def edit(file: str, old: str, new: str) -> None:
        source = (ROOT / file).read_text(encoding="utf-8")
        assert old in source
        changed = tmp_path / Path(file).name
        changed.write_text(source.replace(old, new, 1), encoding="utf-8")
        mutant = original.__wrapped__(changed)
        monkeypatch.setattr(
            dependencies, "parsed", lambda path: mutant if path == ROOT / file else original(path)
        )
        forget()

    yield edit
    forget()


def forget() -> None:
    """Forget what is known of the sources."""
    results_store._code_of.cache_clear()
    dependencies.counting_with.cache_clear()


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """Return a copy of the sources."""
    for folder in ("conf", "contactlab", "experiments"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def section(*ran: str) -> dict[str, Any]:
    """Return a section that some definitions made, and a short form that the first of them makes."""
    short = {"ran": by_module(ran[:1]), "files": [], "results": {"v": 1.0}}
    return sealed(
        {"code": digests(ran, []), "ran": by_module(ran), "files": [], "short": short, "results": {"v": 2.0}}
    )


def test_the_pages_are_those_of_the_results(capsys: pytest.CaptureFixture[str]) -> None:
    assert results_pages.main(["--check"]) == 0, capsys.readouterr().out


LAWS, IMPACT = "contactlab/laws", "contactlab/laws/impact"
MUTANTS: dict[str, tuple[str, str, str, str, str]] = {
    "newton": (f"{IMPACT}/newton.py", "approach + restitution * ", "approach + 1.001 * restitution * ",
               "newton", "poisson"),
    "poisson": (f"{IMPACT}/process.py", "else (1.0 + e) * p_n", "else (1.001 + e) * p_n",
                "poisson", "newton"),
    "lagrange_slip": (f"{LAWS}/lagrange.py", "return slip_impulse(approach, s, ",
                      "return slip_impulse(1.001 * approach, s, ", "lagrange_slip", "newton"),
    "lagrange_stick": (f"{LAWS}/lagrange.py", "<= friction_coeff", "<= 1.001 * friction_coeff",
                       "lagrange_stick", "lagrange_slip"),
    "hertz": (f"{LAWS}/normal/elastic.py", "force = stiff", "force = 1.001 * stiff",
              "hertz_penalty", "composed normal=linear"),
    "flores": (f"{LAWS}/damping.py", "factor = loss_number / ", "factor = 1.001 * loss_number / ",
               "composed damping=flores", "composed damping=tsuji"),
    "mindlin": (f"{LAWS}/friction/mindlin.py", "0.5 * tangential", "0.501 * tangential",
                "composed friction=mindlin", "composed friction=coulomb"),
    "angle": ("contactlab/motor/geometry.py", "cos(self.angle), sin", "cos(self.angle + 0.001), sin",
              "contactlab.motor.geometry:ContactGeometry.numbers", "contactlab.motor.drive:Drive"),
    "bearing": ("contactlab/motor/bearing.py", "-bearing.preload / root", "-1.001 * bearing.preload / root",
                "contactlab.motor.bearing:on_bearing", "contactlab.motor.motor:Motor"),
    "start time": ("contactlab/studies/characterise/transients.py", "= 0.9", "= 0.901",
                   "contactlab.studies.characterise.transients:start_time",
                   "contactlab.studies.characterise.transients:stop_time"),
    "calibration": ("packages/contactlab-data/contactlab_data/inference/calibration.py", "float(met[1][0])",
                    "1.001 * float(met[1][0])",
                    "contactlab_data.inference.calibration:calibrated",
                    "contactlab_data.inference.calibration:identify"),
    "metrics": ("contactlab/metrics/response.py", "return float(run.contacts(\"normal_impulse\").mean())",
                "return 1.001 * float(run.contacts(\"normal_impulse\").mean())",
                "contactlab.metrics.response:mean_impulse", "contactlab.metrics.response:rotor_velocity"),
}  # fmt: skip
"""File, text, mutant of 1e-3, a law or a definition that reaches it, and one that does not."""

SLIPS = {
    *("fig7_constrained_trajectories", "fig8_rotor_velocity", "fig9_normal_force", "impact_step_study"),
    "default motor",
}
STICKS = {"fig8_rotor_velocity", "fig10_sticking", "impact_step_study"}
OF_NEWTON = {PHASE, DAMPED, ROD, "default motor", "populations", "impact_mass"}
OF_HERTZ = {*SLIPS, *OF_NEWTON, "basis_convergence", "first run"}
USED: dict[str, set[str]] = {
    "newton": OF_NEWTON,
    "poisson": {PHASE},
    "lagrange_slip": {*SLIPS, "fig10_sticking", "table2_friction_signs"},
    # Newton's impact is the plastic one, to another rebound.
    "lagrange_stick": {*STICKS, *OF_NEWTON},
    "hertz": OF_HERTZ,
    "mindlin": {PHASE, DAMPED, "default motor"},
    # Whatever touches a rotor.
    "angle": {*OF_HERTZ, "fig10_sticking", "table2_friction_signs"},
    "start time": {"fig8_rotor_velocity"},
}
"""Sections that use what a mutant changes, of `JUDGED`."""

JUDGED = USED["angle"] | {
    *("table1_placement", "fig3_mode_curvature", "fig4_trajectories", "identify_table1", "optimum_placement"),
    *("modes", "known worlds", "known factors"),
}


def ran(name: str, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return a definition, or what runs where a law is bound."""
    if ":" in name:
        return [name]
    monkeypatch.setattr(Recorder, "_codes", set())
    law, *parts = name.split()
    before = sys.gettrace()
    sys.settrace(Recorder._called)
    try:
        functions_of(cl.law(law, **dict(part.split("=") for part in parts)))
    finally:
        sys.settrace(before)
    return Recorder.ran()


@pytest.mark.parametrize("mutant", MUTANTS)
def test_a_mutant_turns_what_reaches_it_and_nothing_else(
    mutant: str, edited: Edit, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, old, new, user, other = MUTANTS[mutant]
    used, unused = section(*ran(user, monkeypatch)), section(*ran(other, monkeypatch))
    edited(file, old, new)
    assert state_of(used) == OLDER
    assert state_of(unused) == PRESENT


def test_mutants_turn_the_sections_that_use_them_and_no_other(edited: Edit) -> None:
    stored = {
        name: each
        for file in recorded_numbers.FILES
        for name, each in results_store.read(file)["sections"].items()
        if name in JUDGED
    }
    before = {name: results_store.code_of(each) for name, each in stored.items()}
    turned: dict[str, set[str]] = {}
    for mutant, (file, old, new, *_) in MUTANTS.items():
        edited(file, old, new)
        turned[mutant] = {
            name for name, each in stored.items() if results_store.code_of(each) != before[name]
        }
    assert turned == {mutant: USED.get(mutant, set()) for mutant in MUTANTS}


def test_a_kernel_that_python_evaluates_is_recorded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Recorder, "_codes", set())
    before = sys.gettrace()
    sys.settrace(Recorder._called)
    try:
        cl.HertzPoint(1e10).evaluate("elastic", depth=1e-6)
    finally:
        sys.settrace(before)
    assert "contactlab.laws.normal.elastic:hertz_elastic" in Recorder.ran()


def test_a_module_that_moves_turns_nothing_until_it_changes(copied: Path) -> None:
    used = section("contactlab.laws.lagrange:LagrangeSlip.impact", "contactlab.laws.lagrange:LagrangeSlip")
    own = copied / "contactlab" / "paper" / "lagrange.py"
    own.parent.mkdir()
    (copied / "contactlab" / "laws" / "lagrange.py").rename(own)
    for path in copied.rglob("*.py"):
        source = path.read_text(encoding="utf-8")
        path.write_text(source.replace("contactlab.laws.lagrange ", "contactlab.paper.lagrange "), "utf-8")
    assert state_of(used, copied) == PRESENT
    own.write_text(own.read_text(encoding="utf-8").replace("mu * d_nt", "1.001 * mu * d_nt"), "utf-8")
    dependencies.parsed.cache_clear()
    forget()
    assert state_of(used, copied) == OLDER


def test_a_comment_and_a_docstring_turn_nothing(edited: Edit) -> None:
    used = section("contactlab.laws.impact.newton:Newton")
    edited("contactlab/laws/impact/newton.py", '    """', '    # A comment.\n    """Another docstring. ')
    assert state_of(used) == PRESENT


def test_what_an_exception_says_turns_nothing(edited: Edit) -> None:
    used = section("contactlab.checks:check_records")
    edited("contactlab/checks.py", "Records do not", 'Records"\n            f"of {interval} s do not')
    assert state_of(used) == PRESENT
    edited("contactlab/checks.py", "raise ValueError(\n            f", "raise TypeError(\n            f")
    assert state_of(used) == OLDER


def test_another_import_is_another_code(edited: Edit) -> None:
    used = section("contactlab.motor.geometry:ContactGeometry.numbers")
    edited("contactlab/motor/geometry.py", "from math import cos", "from cmath import cos")
    assert state_of(used) == OLDER


def test_a_short_form_checks_what_it_reaches_alone(edited: Edit) -> None:
    newton, poisson = (
        "contactlab.laws.impact.newton:newton_impulse",
        "contactlab.laws.impact.process:Poisson.impact",
    )
    both, of_poisson = section(newton, poisson), section(poisson, newton)
    edited(*MUTANTS["poisson"][:3])
    assert state_of(both) == state_of(of_poisson) == OLDER
    assert not results_store.covers(both)
    assert results_store.covers(of_poisson)


@pytest.mark.parametrize(
    ("digits", "state"), [(1.0, CHECKED), (1.001, DIFFERENT)], ids=["the same digits", "others"]
)
def test_what_a_short_form_says_is_noted(
    digits: float, state: str, edited: Edit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(results_store, "FOLDER", tmp_path)
    used = section("contactlab.laws.impact.process:Poisson.impact")
    results_store.write("motor", {"sections": {"some": used}})
    edited(*MUTANTS["poisson"][:3])
    assert remake.note(("motor", "some"), {"results": {"v": digits}}) == state
    edited(*MUTANTS["newton"][:3])
    assert state_of(results_store.read("motor")["sections"]["some"]) == PRESENT


@pytest.mark.long
def test_a_short_form_under_a_mutant_has_other_digits(
    copied: Path, edited: Edit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key, made, results = ("motor", "modes"), tmp_path / "made.json", tmp_path / "results"
    file, old, new = "contactlab/motor/ritz.py", "self.tip_mass * np", "1.001 * self.tip_mass * np"
    source = (copied / file).read_text(encoding="utf-8")
    (copied / file).write_text(source.replace(old, new, 1), encoding="utf-8")
    subprocess.run(
        [sys.executable, copied / "experiments" / "remake.py", "--one", *key, made, "", "--short"],
        env=os.environ | {"PYTHONPATH": str(copied)},
        cwd=copied,
        check=True,
    )
    results.mkdir()
    shutil.copy(results_store.FOLDER / f"{key[0]}.json", results)
    monkeypatch.setattr(results_store, "FOLDER", results)
    edited(file, old, new)
    assert remake.note(key, json.loads(made.read_text(encoding="utf-8"))) == DIFFERENT


def test_a_number_changed_by_hand_is_seen(
    stored: Callable[[str, dict[str, Any]], None], capsys: pytest.CaptureFixture[str]
) -> None:
    changed = deepcopy(results_store.read("motor"))
    changed["sections"]["modes"]["results"]["converged"]["damping_ratio"][0] *= 1.3
    assert state_of(changed["sections"]["modes"]) == EDITED
    stored("motor", changed)
    old = {page: (ROOT / page).read_bytes() for page in claims.PAGES}
    assert results_pages.main([]) == 1
    assert "motor: modes" in capsys.readouterr().out
    assert old == {page: (ROOT / page).read_bytes() for page in claims.PAGES}


def test_a_page_says_whose_results_are_not_of_the_present_code(
    stored: Callable[[str, dict[str, Any]], None], edited: Edit
) -> None:
    content = deepcopy(results_store.read("motor"))
    name, file = recorded_numbers.PHASE, "contactlab/laws/impact/process.py"
    content["sections"][name] |= section("contactlab.laws.impact.process:Poisson.impact") | {
        "results": content["sections"][name]["results"]
    }
    content["sections"][name] = sealed(content["sections"][name])
    stored("motor", content)
    edited(file, *MUTANTS["poisson"][1:3])
    for page, uses in ((STEADY, True), ("docs/published_motor.md", False)):
        there = Page(page)
        assert [*there.fill()] == []
        age = there.text.partition("<!-- age of the results -->")[2]
        assert (f"`{name}`" in age) == uses


def test_a_changed_number_changes_tables_and_sentences_together(
    stored: Callable[[str, dict[str, Any]], None],
) -> None:
    changed = deepcopy(results_store.read("motor"))
    changed["sections"][DAMPING]["results"]["stiffness_damping=2e-5"]["hertz"]["rotor_velocity"] = -1.5
    stored("motor", changed)
    page = Page(STEADY)
    assert [*page.fill()] == []
    assert "| `stiffness_damping=2e-5` (paper) | 0.135, 0.237 | -1.5000 |" in page.text
    assert "is the slowest of the four" in page.old
    assert "is the slowest of the four" not in page.text
    assert "is not the slowest of the four" in page.text


def test_what_errors_blur_is_inconclusive(stored: Callable[[str, dict[str, Any]], None]) -> None:
    changed = deepcopy(results_store.read("motor"))
    changed["sections"][DAMPING]["results"]["damping_ratio=0.01"]["stick"]["rotor_velocity_error"] = 1.0
    stored("motor", changed)
    page = Page(STEADY)
    assert [*page.fill()] == []
    assert "is open within the errors" in " ".join(page.text.split())


BARE = (
    "the first mode has 2291 Hz, a contact lasts 12 us at a peak of 31 N, the start takes 88 ms",
    "Hertz is the fastest in 61 of 64 motors, 2.4 times as fast, with a Q of 900 and a misfit of 12 errors",
    "the current is 31 mA, the pressure 674 MPa, the tip moves by 3.1 um, the loss is 12.7 uJ",
    "a record takes 380 bytes and a file 12 MB",
    "the torque is 3.7 N m, 4.1 mN m, 6.6 mW or 1.43 rad/s and 13 rpm, it takes 12 % or 12% less",
    "every second motor, or half of them, changes its order; two thirds of all laws agree, 0.43 of the time",
    "| `hertz_penalty` | 2.1911 | 3.016 ± 0.003 | 9.93e9 | 16 |",
)


@pytest.mark.parametrize("name", claims.PAGES)
def test_a_number_without_a_claim_is_refused_on_every_page(name: str) -> None:
    page = Page(name)
    assert [*page.bare()] == []
    page.text = "\n\n".join((page.text, *BARE))
    assert len([*page.bare()]) == 4 + 4 + 4 + 2 + 7 + 4 + 3


def test_a_number_that_is_gone_leaves_the_list() -> None:
    page = Page(STEADY)
    page.text = page.text.replace("within 20 %", "nearby")
    assert [*page.bare()] == [f"{STEADY}: '20 %' stands there no more"]


@pytest.mark.parametrize(
    ("origin", "sound", "wrong"),
    [
        ("shown", ["1 um", "12 %", "7 s"], ["1.2 um", "13 %", "7 ms"]),
        ("code", [{"20 ms": "key('solver.duration')"}], [{"21 ms": "key('solver.duration')"}]),
        (
            "code",
            [{"95 %": "constant('contactlab.studies.compare.bootstrap:LEVEL')"}],
            [{"96 %": "constant('contactlab.studies.compare.bootstrap:LEVEL')"}],
        ),
        ("cited", {"Hertz (1881)": ["3 mm"]}, {"Hertz (1882)": ["3 mm"]}),
        ("unwatched", [], ["3 mm"]),
    ],
)
def test_an_origin_of_a_number_is_checked(
    origin: str, sound: object, wrong: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = "contactlab contact.clearance=1e-6 law.loss=0.12 'solver.duration=7 s'"
    text = f"After Hertz (1881).\n\n```bash\n{command}\n```\n"
    for listed, faults in ((sound, 0), (wrong, len(wrong) if isinstance(wrong, list) else 1)):
        monkeypatch.setattr(
            listed_numbers, "listed", lambda own=listed: {"page.md": {origin: own} if own else {}}
        )
        assert len([*listed_numbers.faults("page.md", text)]) == faults


@pytest.mark.parametrize(
    ("text", "number", "same"),
    [
        ("-1.39 rad/s", -1.3938, True),
        ("-1.39 rad/s", -1.396, False),
        ("20 ms", 0.02, True),
        ("20 ms", 0.0201, False),
        ("1.01 GPa", 1.01327e9, True),
        ("36.4 g", 0.0364, True),
        ("1 kg", 1.0, True),
        ("0.01 %", 1e-4, True),
        ("100,000 of the", 1e5, True),
        ("15 of the", 16.0, False),
    ],
)
def test_a_number_of_a_page_is_compared_to_its_digits(text: str, number: float, same: bool) -> None:
    assert listed_numbers.Literal(text).is_of(number) == same


def test_times_in_a_text_are_no_digits_of_a_result() -> None:
    finding = "2 of 3 agree; it takes 57.9 ms, 1.15 times as much as a run of 3 rad/s"
    assert results_store.same(finding, finding.replace("57.9", "90").replace("1.15", "0.7"))
    assert not results_store.same(finding, finding.replace("3 rad/s", "4 rad/s"))
