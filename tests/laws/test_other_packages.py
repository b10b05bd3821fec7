"""Laws and parts of other packages: installed they are like contactlab's own, broken they harm no other."""

import pytest
import xarray
from support.command_line import EXAMPLE, Elsewhere
from support.outside import BROKEN, BROKEN_PARTS, SHORT, installed, law_of

from contactlab.testing.contract import PROPERTIES

QUIET = (SHORT, "record.picture=false")
RUN = ("law=power_law", "law.exponent=2", "law.unit_depth=2 um", *QUIET, "hydra.run.dir=run")
OWN = ("law=hertz_penalty", *QUIET, "hydra.run.dir=own")
PARTS = (
    *("law=composed", "law/normal=stiffening", "law/friction=ageing", "law.friction.distance=0.2 um"),
    *(*QUIET, "hydra.run.dir=parts"),
)
FAULTY = ("law=power_law", "law.exponent=7", "law.load=3 m")
FAULTY_PARTS = ("law=composed", "law/normal=part_of_a_module_that_fails", "law/damping=part_that_is_a_law")
TWICE, LISTED = ("law=twice",), ("laws",)
COMPLETIONS = {
    "law=pow": "law=power_law",
    "law=power_law law.exp": "law.exponent=",
    "law=composed law/friction=age": "law/friction=ageing law/friction=ageing_stick",
}
CONTRADICTIONS = {
    "contradicting": "friction_kind",
    "negative_bound": "friction bound",
    "past_the_end": "parameters",
    "raising": "KeyError",
    "leaving": "SystemExit",
}
Results = dict[tuple[str, ...], tuple[int, str, str]]
"""Exit status, output and errors by the arguments of a command."""


def completing(line: str) -> tuple[str, ...]:
    return ("-sc", "query=bash", f"COMP_LINE=contactlab {line}")


def refused(name: str) -> tuple[str, ...]:
    return (f"law={name}", "hydra.run.dir=refused", "hydra.sweep.dir=refused")


WITH_KEY = (next(f"law={name}" for name in BROKEN if name.startswith("law_")), "law.height=1")


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    return installed(tmp_path_factory)


@pytest.fixture(scope="module")
def results(elsewhere: Elsewhere) -> Results:
    """Results of many commands, one after another, the broken laws before the sound ones."""
    broken = [
        refused(name) for name in (*BROKEN, *CONTRADICTIONS) if name.isidentifier() and name not in OWN[0]
    ]
    lines = [
        LISTED,
        *map(completing, COMPLETIONS),
        *broken,
        WITH_KEY,
        FAULTY,
        FAULTY_PARTS,
        TWICE,
        RUN,
        PARTS,
        OWN,
    ]
    return dict(zip(lines, elsewhere.commands(lines), strict=True))


@pytest.mark.long
def test_the_listing_has_sound_ones_with_their_package_and_broken_ones_with_the_reason(
    results: Results,
) -> None:
    status, out, err = results[LISTED]
    assert (status, err) == (0, "")
    listing = " ".join(out.split())
    for owner in ("power_law:PowerLaw", "parts:Ageing"):
        assert f"package: example-law 1.2.3 ({owner})" in listing
    for name, (_, reason) in (BROKEN | BROKEN_PARTS).items():
        assert f"{name}: not usable" in listing
        assert reason in listing


@pytest.mark.parametrize("line", COMPLETIONS)
def test_tab_completes_it(results: Results, line: str) -> None:
    status, out, _ = results[completing(line)]
    assert (status, out.strip()) == (0, COMPLETIONS[line])


def test_it_runs_and_the_run_records_its_origin(results: Results, elsewhere: Elsewhere) -> None:
    assert results[RUN][0] == 0, results[RUN][2]
    path = elsewhere.folder / "run/run.nc"
    section = {"name": "power_law", "load": 10.0, "unit_depth": 2e-6, "exponent": 2.0}
    assert law_of(path) == ("power_law", section)
    with xarray.open_dataset(path) as root:
        assert root.attrs["law_origin"] == "example-law 1.2.3"


def test_its_parts_run_in_a_composed_law_and_the_run_records_their_origin(
    results: Results, elsewhere: Elsewhere
) -> None:
    assert results[PARTS][0] == 0, results[PARTS][2]
    path = elsewhere.folder / "parts/run.nc"
    name, section = law_of(path)
    assert (name, section["friction"]["distance"], section["normal"]["name"]) == (
        "composed",
        2e-7,
        "stiffening",
    )
    with xarray.open_dataset(path) as root:
        _, *parts = root.attrs["law_origin"].split(", ")
    assert parts == ["normal of example-law 1.2.3", "friction of example-law 1.2.3"]


def test_its_declarations_are_the_rules_of_its_keys(results: Results) -> None:
    status, _, err = results[FAULTY]
    assert status == 2
    assert "law.exponent" in err
    assert "law.load" in err


@pytest.mark.parametrize("name", [name for name in BROKEN if name.startswith("law_")])
def test_a_broken_law_is_refused_with_its_reason(results: Results, name: str) -> None:
    status, _, err = results[refused(name)]
    assert status == 2
    assert "law.name" in err
    assert BROKEN[name][1] in err


def test_a_key_of_a_broken_law_is_refused_with_the_reason_of_the_law(results: Results) -> None:
    status, _, err = results[WITH_KEY]
    assert status == 2
    assert BROKEN[WITH_KEY[0].removeprefix("law=")][1] in err


def test_broken_parts_and_ambiguous_names_are_refused(results: Results) -> None:
    status, _, err = results[FAULTY_PARTS]
    assert status == 2
    assert "law.normal.name" in err
    assert "law.damping.name" in err
    assert results[TWICE][0] == 2


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_a_law_that_contradicts_itself_is_refused_before_anything_is_written(
    results: Results, elsewhere: Elsewhere, name: str
) -> None:
    status, _, err = results[refused(name)]
    assert status == 2
    assert CONTRADICTIONS[name] in err
    assert not (elsewhere.folder / "refused").exists()


def test_broken_laws_harm_no_other(results: Results, elsewhere: Elsewhere) -> None:
    assert results[OWN][::2] == (0, "")
    assert law_of(elsewhere.folder / "own/run.nc")[0] == "hertz_penalty"


@pytest.mark.long
def test_a_sweep_runs_over_it_and_the_packages_own(elsewhere: Elsewhere) -> None:
    text = ("law=power_law,hertz_penalty", *QUIET, "hydra.sweep.dir=sweep")
    status, _, err = elsewhere.command("-m", *text)
    assert status == 0, err
    runs = sorted((elsewhere.folder / "sweep").glob("*/run.nc"))
    assert [law_of(run)[0] for run in runs] == ["hertz_penalty", "power_law"]


@pytest.mark.long
def test_their_contracts_hold_in_three_lines_each(elsewhere: Elsewhere) -> None:
    names = "test_power_law.py", "test_parts.py"
    for name in names:
        (elsewhere.folder / name).write_text((EXAMPLE / name).read_text(encoding="utf-8"), encoding="utf-8")
    status, out, _ = elsewhere.python("-m", "pytest", "-q", "-p", "no:cacheprovider", *names)
    assert status == 0, out
    assert f"{2 * len(PROPERTIES)} passed" in out


@pytest.mark.long
def test_a_friction_coefficient_on_which_nothing_depends_is_refused(elsewhere: Elsewhere) -> None:
    key = "contact.friction_coefficient"
    status, _, err = elsewhere.command("-m", "law=smooth", f"{key}=0.1,0.2")
    assert status == 2
    assert key in err


@pytest.mark.long
def test_a_parameter_without_default_has_to_be_given(elsewhere: Elsewhere) -> None:
    status, _, err = elsewhere.command("law=without_default")
    assert status == 2
    assert "law.stiffness" in err


@pytest.mark.parametrize("argument", ["--help", "law=hertz"])
def test_no_law_of_another_package_is_imported_to_list_the_laws(elsewhere: Elsewhere, argument: str) -> None:
    code = (
        "import sys\n"
        "from contactlab.cli import main as cli\n"
        f"sys.argv = ['contactlab', {argument!r}]\n"
        "cli.main()\n"
        "sys.exit(bool({'power_law', 'parts', 'failing', 'various'} & set(sys.modules)))"
    )
    status, _, err = elsewhere.python("-c", code)
    assert status == 0, err
