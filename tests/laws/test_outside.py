"""Laws of other packages: installed they are like contactlab's own, broken they harm no other."""

import pytest
import xarray
from support.command_line import EXAMPLE, Elsewhere, cases
from support.outside import BROKEN, BROKEN_PARTS, SHORT, installed, law_of

from contactlab.testing.contract import PROPERTIES

RUN = (
    "law=power_law",
    "law.exponent=2",
    "law.unit_depth=2 um",
    SHORT,
    "record.picture=false",
    "hydra.run.dir=run",
)
OWN = ("law=hertz_penalty", SHORT, "record.picture=false", "hydra.run.dir=own")
FAULTY = ("law=power_law", "law.exponent=7", "law.load=3 m")
TWICE = ("law=twice",)
LISTED, HELPED = ("laws",), ("--help",)

COMPLETIONS = {
    "law=pow": "law=power_law",
    "law=power_law law.exp": "law.exponent=",
    "law=composed law/friction=age": "law/friction=ageing law/friction=ageing_stick",
    "law=composed law/friction=ageing law.friction.str": "law.friction.strengthening=",
}
CONTRADICTIONS = {
    "contradicting": "its friction_kind is RATE_DEPENDENT, but it has no kernel of friction",
    "negative_bound": "the friction bound is -1e-06 N",
    "past_the_end": "reads parameters that there are not",
    "raising": "the law raising raised KeyError: 'kernel' (",
    "leaving": "the law leaving raised SystemExit: 0",
}
Answers = dict[tuple[str, ...], tuple[int, str, str]]
"""Exit status, output and errors by the words of a command."""

NO_RUN = ("hydra.run.dir=refused", "hydra.sweep.dir=refused")


def completing(line: str) -> tuple[str, ...]:
    return ("-sc", "query=bash", f"COMP_LINE=contactlab {line}")


def broken(name: str) -> tuple[str, ...]:
    return (f"law={name}", "contact.clearance=-1")


def contradicting(name: str) -> tuple[str, ...]:
    return (f"law={name}", *NO_RUN)


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    return installed(tmp_path_factory)


@pytest.fixture(scope="module")
def answers(elsewhere: Elsewhere) -> Answers:
    """What many commands answer, one after another, the broken laws before the sound ones."""
    lines = [
        LISTED,
        *map(completing, COMPLETIONS),
        HELPED,
        *(broken(name) for name in BROKEN if name.startswith("law_")),
        *map(contradicting, CONTRADICTIONS),
        FAULTY,
        TWICE,
        RUN,
        OWN,
    ]
    return dict(zip(lines, elsewhere.commands(lines), strict=True))


@pytest.fixture(scope="module")
def listing(answers: Answers) -> str:
    """What `contactlab laws` prints, on one line."""
    status, out, err = answers[LISTED]
    assert (status, err) == (0, "")
    return " ".join(out.split())


def test_it_is_listed_with_all_that_it_declares_and_its_origin(listing: str) -> None:
    assert "A force that grows with a power of the penetration, with Coulomb friction." in listing
    assert "parameter exponent: p, exponent, default 1.5, at least 1 and at most 4" in listing
    assert "package: example-law 1.2.3 (power_law:PowerLaw)" in listing


def test_its_parts_are_listed_with_what_they_remember(listing: str) -> None:
    assert "friction/ageing Friction that is the stronger the older a contact is" in listing
    assert "internal variable age: z [s], age of the contact, begins at 0 with every contact" in listing
    assert "package: example-law 1.2.3 (parts:Ageing)" in listing
    assert "law/normal=hertz_point, hertz_elliptic, line, linear, lining," in listing
    assert ", stiffening, default hertz_point" in listing


@pytest.mark.parametrize("line", COMPLETIONS)
def test_tab_completes_it(answers: Answers, line: str) -> None:
    status, out, _ = answers[completing(line)]
    assert status == 0
    assert out.strip() == COMPLETIONS[line]


def test_help_lists_it(answers: Answers) -> None:
    assert "power_law" in answers[HELPED][1]


def test_it_runs_and_the_run_says_so(answers: Answers, elsewhere: Elsewhere) -> None:
    status, _, err = answers[RUN]
    assert status == 0, err
    name, section = law_of(elsewhere.folder / "run/run.nc")
    assert name == "power_law"
    with xarray.open_dataset(elsewhere.folder / "run/run.nc") as root:
        assert root.attrs["law_origin"] == "example-law 1.2.3"
    assert section == {"name": "power_law", "load": 10.0, "unit_depth": 2e-6, "exponent": 2.0}


def test_its_declarations_are_the_rules_of_its_keys(answers: Answers) -> None:
    status, _, err = answers[FAULTY]
    assert status == 2
    assert "law.exponent is 7; it must be at least 1 and at most 4" in err
    assert "law.load is '3 m', whose unit 'm' cannot be converted to N" in err


@pytest.mark.parametrize(
    ("argument", "sentence"),
    [
        pytest.param("law.stiffness=1", "law.stiffness does not belong to power_law", marks=pytest.mark.long),
        ("law.lode=2", "law.lode is not a known key. Did you mean law.load?"),
    ],
)
@pytest.mark.long
def test_it_has_the_keys_that_it_declares_and_no_others(
    elsewhere: Elsewhere, argument: str, sentence: str
) -> None:
    status, _, err = elsewhere.command("law=power_law", argument)
    assert status == 2
    assert sentence in err


@pytest.mark.long
def test_a_sweep_runs_over_it_and_the_packages_own(elsewhere: Elsewhere) -> None:
    status, _, err = elsewhere.command(
        "-m", "law=power_law,hertz_penalty", SHORT, "record.picture=false", "hydra.sweep.dir=sweep"
    )
    assert status == 0, err
    runs = sorted((elsewhere.folder / "sweep").glob("*/run.nc"))
    assert [law_of(run)[0] for run in runs] == ["hertz_penalty", "power_law"]


@pytest.mark.long
def test_its_contract_holds_in_three_lines(elsewhere: Elsewhere) -> None:
    test = EXAMPLE / "test_power_law.py"
    (elsewhere.folder / test.name).write_text(test.read_text(encoding="utf-8"), encoding="utf-8")
    status, out, _ = elsewhere.python("-m", "pytest", "-q", "-p", "no:cacheprovider", test.name)
    assert status == 0, out
    assert f"{len(PROPERTIES)} passed" in out


def test_broken_laws_are_listed_with_the_reason(listing: str) -> None:
    for name, (_, reason) in (BROKEN | BROKEN_PARTS).items():
        assert f"{name}: not usable" in listing
        assert reason in listing
    assert listing.count("has the name of a law of another package") == 2
    assert "package: contactlab" in listing


@pytest.mark.parametrize("name", [name for name in BROKEN if name.startswith("law_")])
def test_a_broken_law_is_refused_in_a_sentence(answers: Answers, name: str) -> None:
    status, _, err = answers[broken(name)]
    assert status == 2
    law, clearance = err.splitlines()
    assert law.startswith(f"law.name is '{name}', which cannot run.")
    assert BROKEN[name][1] in law
    assert clearance.startswith("contact.clearance is -1 m")


METRICS = "sweep.keep=metrics"
FRICTION = "contact.friction_coefficient"


@pytest.mark.parametrize(
    "arguments",
    [
        ["law=smooth", f"{FRICTION}=0.2"],
        pytest.param(["-m", "law=smooth", f"{FRICTION}=0.1,0.2"], marks=pytest.mark.long),
        pytest.param(["-m", "law=smooth", f"{FRICTION}=0.1,0.2", METRICS], marks=pytest.mark.long),
        ["-m", "law=smooth", f"{FRICTION}=0.2", "contact.clearance=0,1e-6", METRICS],
    ],
)
@pytest.mark.long
def test_a_friction_coefficient_on_which_nothing_depends_is_refused(
    elsewhere: Elsewhere, arguments: list[str]
) -> None:
    status, _, err = elsewhere.command(*arguments)
    assert status == 2
    assert FRICTION in err


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_a_law_that_contradicts_itself_is_refused_before_anything_is_written(
    answers: Answers, elsewhere: Elsewhere, name: str
) -> None:
    status, _, err = answers[contradicting(name)]
    assert status == 2
    assert CONTRADICTIONS[name] in err
    assert not (elsewhere.folder / "refused").exists()


@pytest.mark.long
@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_a_sweep_of_a_law_that_contradicts_itself_is_refused_too(elsewhere: Elsewhere, name: str) -> None:
    status, _, err = elsewhere.command("-m", *contradicting(name))
    assert status == 2
    assert CONTRADICTIONS[name] in err
    assert not (elsewhere.folder / "refused").exists()


def test_broken_laws_harm_no_other(answers: Answers, elsewhere: Elsewhere) -> None:
    status, _, err = answers[OWN]
    assert (status, err) == (0, "")
    assert law_of(elsewhere.folder / "own/run.nc")[0] == "hertz_penalty"
    status, _, err = answers[TWICE]
    assert status == 2
    assert "law is 'twice'; it must be one of " in err


@pytest.mark.long
def test_a_parameter_without_default_has_to_be_given(elsewhere: Elsewhere) -> None:
    status, _, err = elsewhere.command("law=without_default")
    assert status == 2
    assert err.startswith("law.stiffness is missing; it must be a number that is greater than 0 N/m")
    arguments = ("law=without_default", "law.stiffness=1e7", "law.name=another")
    assert "law.name=another" in elsewhere.command(*arguments)[2]


@pytest.mark.parametrize(
    "arguments",
    cases([["--help"], ["-sc", "query=bash"], ["law=hertz"], ["law.stiffness=-1"]], [["law=hertz"]]),
)
def test_no_law_of_another_package_is_imported_to_list_the_laws(
    elsewhere: Elsewhere, arguments: list[str]
) -> None:
    code = (
        "import sys\n"
        "from contactlab.cli import main as cli\n"
        f"sys.argv = ['contactlab', *{arguments}]\n"
        "cli.main()\n"
        f"sys.exit(bool({{'power_law', 'parts', 'failing', 'various'}} & set(sys.modules)))"
    )
    status, _, err = elsewhere.python("-c", code, COMP_LINE="contactlab law/normal=")
    assert status == 0, err
