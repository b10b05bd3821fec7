"""Laws and parts of other packages: installed they are like contactlab's own, broken they harm no other."""

import re
from functools import partial
from pathlib import Path

import pytest
import xarray
import yaml
from support.command_line import EXAMPLE, Elsewhere

SHORT = "solver.duration=0.2 ms"

long = partial(pytest.param, marks=pytest.mark.long)

BROKEN = {
    "law_of_a_module_that_is_not_there": ("nowhere:Law", "ModuleNotFoundError"),
    "law_of_a_module_that_fails": ("failing:Law", "ZeroDivisionError: division by zero"),
    "law_that_is_not_there": ("various:Missing", "AttributeError"),
    "law_that_is_a_number": ("various:NUMBER", "is no subclass of"),
    "law_of_another_name": ("various:Misnamed", "calls itself 'another'"),
    "law_without_kernel": ("various:Abstract", "lacks force"),
    "law_that_is_no_dataclass": ("various:Plain", "is no dataclass"),
    "law_that_is_undeclared": ("various:Undeclared", "field stiffness without a declaration"),
    "hertz_penalty": ("various:Thief", "takes the name of one of contactlab's own"),
    "two words": ("various:TwoWords", "it must be one word"),
}

BROKEN_PARTS = {
    "normal/part_of_a_module_that_fails": ("failing:Part", "ZeroDivisionError: division by zero"),
    "damping/part_that_is_a_law": ("various:Smooth", "is no subclass of contactlab.laws.Damping"),
    "friction/part_of_another_name": ("various:Grip", "calls itself 'grip'"),
    "friction/coulomb": ("various:Grip", "takes the name of one of contactlab's own"),
}

VARIOUS = """
from dataclasses import dataclass
from typing import Annotated
from contactlab.laws import Friction, HertzPenalty, PenaltyLaw
from contactlab.parameter import Parameter
NUMBER = 1
class Law(PenaltyLaw):
    equation = "N = k d"
    source = "a test"
    default_contact_step = 4e-6
@dataclass(frozen=True)
class Misnamed(Law):
    name = "another"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -parameters[0] * gap, 0.0, 0.5 * parameters[0] * gap * gap, 0.0
@dataclass(frozen=True)
class Abstract(Law):
    name = "law_without_kernel"
class Plain(Law):
    name = "law_that_is_no_dataclass"
    force = Misnamed.force
@dataclass(frozen=True)
class Undeclared(Misnamed):
    name = "law_that_is_undeclared"
    stiffness: float = 1.0
@dataclass(frozen=True)
class Smooth(Misnamed):
    name = "smooth"
    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)] = 1e7
@dataclass(frozen=True)
class Contradicting(Smooth):
    name = "contradicting"
    friction_kind = 2
@dataclass(frozen=True)
class NegativeBound(Smooth):
    name = "negative_bound"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -1e7 * gap, 1e6 * gap, 5e6 * gap * gap, 0.0
@dataclass(frozen=True)
class PastTheEnd(Smooth):
    name = "past_the_end"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -1e7 * gap, -parameters[1] * gap, 5e6 * gap * gap, 0.0
@dataclass(frozen=True)
class Raising(Smooth):
    name = "raising"
    @property
    def force(self):
        return {}["kernel"]
@dataclass(frozen=True)
class Leaving(Smooth):
    name = "leaving"
    @staticmethod
    def force(gap, gap_rate, slip, impact_speed, parameters):
        raise SystemExit(0)
@dataclass(frozen=True)
class WithoutDefault(Misnamed):
    name = "without_default"
    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)]
@dataclass(frozen=True)
class Grip(Friction):
    name = "grip"
    equation = "|F| <= mu N"
    source = "a test"
@dataclass(frozen=True, kw_only=True)
class Grainy(Grip):
    name = "grainy"
    grain: Annotated[float, Parameter("r", "m", "size of a grain", above=0.0)]
"""


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    """Three packages: the example, a broken one, and one that has the name of a law of the second."""
    made = Elsewhere(tmp_path_factory.mktemp("packages"), tmp_path_factory.mktemp("elsewhere"))
    made.install_example()
    entries = {name: entry for name, (entry, _) in BROKEN.items()}
    classes = ("Smooth", "Contradicting", "NegativeBound", "PastTheEnd", "Raising", "Leaving")
    entries |= {re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower(): f"various:{name}" for name in classes}
    more = {"without_default": "various:WithoutDefault", "twice": "various:Law"}
    modules = {"various": VARIOUS, "failing": "1 / 0"}
    parts = {"contactlab.laws.friction": {"grainy": "various:Grainy"}}
    for title, (entry, _) in BROKEN_PARTS.items():
        family, _, name = title.partition("/")
        parts.setdefault(f"contactlab.laws.{family}", {})[name] = entry
    made.install("broken-laws", "0.1", entries | more, modules, parts)
    made.install("other-laws", "0.2", {"twice": "various:Law"}, {})
    return made


def law_of(run: Path) -> tuple[str, dict[str, object]]:
    """The law's name and its section, as a run recorded them."""
    with xarray.open_dataset(run) as root:
        return root.attrs["law"], yaml.safe_load(root.attrs["configuration"])["law"]


@pytest.fixture(scope="module")
def listing(elsewhere: Elsewhere) -> str:
    """What `contactlab laws` prints, on one line."""
    status, out, err = elsewhere.command("laws")
    assert (status, err) == (0, "")
    return " ".join(out.split())


def test_it_is_listed_with_all_that_it_declares_and_its_origin(listing: str) -> None:
    out = listing
    assert "A force that grows with a power of the penetration, with Coulomb friction." in out
    assert "parameter exponent: p, exponent, default 1.5, at least 1 and at most 4" in out
    assert "package: example-law 1.2.3 (power_law:PowerLaw)" in out


@pytest.mark.parametrize(
    ("line", "completion"),
    [
        pytest.param("law=pow", "law=power_law", marks=pytest.mark.long),
        ("law=power_law law.exp", "law.exponent="),
        ("law=composed law/friction=age", "law/friction=ageing law/friction=ageing_stick"),
        pytest.param(
            "law=composed law/friction=ageing law.friction.str",
            "law.friction.strengthening=",
            marks=pytest.mark.long,
        ),
    ],
)
def test_tab_completes_it_and_help_lists_it(elsewhere: Elsewhere, line: str, completion: str) -> None:
    status, out, _ = elsewhere.command("-sc", "query=bash", COMP_LINE=f"contactlab {line}")
    assert status == 0
    assert out.strip() == completion
    assert "power_law" in elsewhere.command("--help")[1]


def test_it_runs_and_the_run_says_so(elsewhere: Elsewhere) -> None:
    arguments = ("law=power_law", "law.exponent=2", "law.depth=2 um", SHORT, "hydra.run.dir=run")
    status, _, err = elsewhere.command(*arguments)
    assert status == 0, err
    name, section = law_of(elsewhere.folder / "run/run.nc")
    assert name == "power_law"
    with xarray.open_dataset(elsewhere.folder / "run/run.nc") as root:
        assert root.attrs["law_origin"] == "example-law 1.2.3"
    assert section == {"name": "power_law", "load": 10.0, "depth": 2e-6, "exponent": 2.0}


def test_its_declarations_are_the_rules_of_its_keys(elsewhere: Elsewhere) -> None:
    status, _, err = elsewhere.command("law=power_law", "law.exponent=7", "law.load=3 m")
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
    assert "24 passed" in out


AGEING = {"name": "ageing", "strengthening": 0.2, "half_age": 1e-5, "distance": 1e-7, "velocity": 1e-3}

PARTS = ("law=composed", "law/normal=stiffening", "law/friction=ageing")


def test_its_parts_are_listed_with_what_they_remember(listing: str) -> None:
    assert "friction/ageing Friction that is the stronger the older a contact is" in listing
    assert "internal variable age: z [s], age of the contact, begins at 0 with every contact" in listing
    assert "package: example-law 1.2.3 (parts:Ageing)" in listing
    assert "law/normal=hertz_point, hertz_elliptic, line, linear, lining," in listing
    assert ", stiffening, default hertz_point" in listing


@pytest.mark.long
def test_its_parts_run_in_a_composed_law_and_the_run_says_whose_they_are(elsewhere: Elsewhere) -> None:
    keys = ("law.friction.distance=0.2 um", "law.normal.depth=2e-6", "record.picture=false")
    status, _, err = elsewhere.command(*PARTS, *keys, SHORT, "hydra.run.dir=parts")
    assert status == 0, err
    path = elsewhere.folder / "parts/run.nc"
    name, section = law_of(path)
    assert name == "composed"
    assert section["friction"] == AGEING | {"distance": 2e-7}
    assert section["normal"] == {"name": "stiffening", "stiffness": 5e6, "depth": 2e-6}
    with xarray.open_dataset(path) as root:
        whole, *parts = root.attrs["law_origin"].split(", ")
    assert whole.startswith("contactlab ")
    assert parts == ["normal of example-law 1.2.3", "friction of example-law 1.2.3"]


@pytest.mark.long
def test_declarations_of_its_parts_are_the_rules_of_their_keys(elsewhere: Elsewhere) -> None:
    faults = ("law.friction.distance=0", "law.normal.depth=3 N")
    status, _, err = elsewhere.command(*PARTS, *faults)
    assert status == 2
    assert "law.friction.distance is 0 m; it must be greater than 0 m" in err
    assert "law.normal.depth is '3 N', whose unit 'N' cannot be converted to m" in err


@pytest.mark.long
def test_a_script_makes_and_sweeps_its_parts_by_name(elsewhere: Elsewhere) -> None:
    code = """
import contactlab as cl
law = cl.law("composed", friction="ageing", normal="stiffening")
assert law.friction.describe()["distance"] == 1e-7
swept = {"law/friction": ["ageing", "coulomb"]}
runs = cl.sweep(swept, base=["law=composed"], duration=1e-4, metrics=["rotor_velocity"], workers=1)
print(*runs["status"].values)
for name in ("agein", "grainy"):
    try:
        cl.law("composed", friction=name)
    except (TypeError, ValueError) as error:
        print(error)
"""
    status, out, err = elsewhere.python("-c", code)
    assert status == 0, err
    swept, refused, lacking = out.splitlines()
    assert swept == "0 0"
    assert refused.startswith("There is no friction 'agein'; it must be one of ageing, ageing_stick,")
    assert lacking == "The friction grainy lacks grain; without default it must be given."


@pytest.mark.long
def test_the_contract_of_its_parts_holds_in_three_lines(elsewhere: Elsewhere) -> None:
    test = EXAMPLE / "test_parts.py"
    (elsewhere.folder / test.name).write_text(test.read_text(encoding="utf-8"), encoding="utf-8")
    status, out, _ = elsewhere.python("-m", "pytest", "-q", "-p", "no:cacheprovider", test.name)
    assert status == 0, out
    assert "24 passed" in out


def test_broken_laws_are_listed_with_the_reason(listing: str) -> None:
    words = listing
    for name, (_, reason) in (BROKEN | BROKEN_PARTS).items():
        assert f"{name}: not usable" in words
        assert reason in words
    assert words.count("has the name of a law of another package") == 2
    assert "package: contactlab" in words


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("law_that_is_undeclared", "law_of_a_module_that_fails") else long(name)
        for name in BROKEN
        if name.startswith("law_")
    ],
)
def test_a_broken_law_is_refused_in_a_sentence(elsewhere: Elsewhere, name: str) -> None:
    status, _, err = elsewhere.command(f"law={name}", "contact.clearance=-1")
    assert status == 2
    law, clearance = err.splitlines()
    assert law.startswith(f"law.name is '{name}', which cannot run.")
    assert BROKEN[name][1] in law
    assert clearance.startswith("contact.clearance is -1 m")


@pytest.mark.long
def test_a_broken_part_is_refused_in_a_sentence(elsewhere: Elsewhere) -> None:
    broken = ("law/normal=part_of_a_module_that_fails", "law/damping=part_that_is_a_law")
    status, _, err = elsewhere.command("law=composed", *broken)
    assert status == 2
    normal, damping = err.splitlines()
    assert normal.startswith("law.normal.name is 'part_of_a_module_that_fails', which cannot run. The normal")
    assert "is no subclass of contactlab.laws.Damping. Mend that package" in damping


METRICS = "sweep.keep=metrics"
FRICTION = "contact.friction_coefficient"
IDLE = f"{FRICTION} is set, but law=smooth has no friction coefficient of that name"


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
    assert err == f"{IDLE}; it must be left out. Set the keys of the law, or choose another one.\n"


@pytest.mark.long
def test_a_law_without_it_is_told_of_where_laws_are_compared_over_friction(elsewhere: Elsewhere) -> None:
    arguments = ("-m", "law=smooth,hertz_penalty", f"{FRICTION}=0.1,0.2", SHORT, "record.picture=false")
    status, _, err = elsewhere.command(*arguments, "hydra.sweep.dir=friction")
    assert status == 0, err
    assert err.count(IDLE) == 1
    assert len(list((elsewhere.folder / "friction").glob("*/run.nc"))) == 4
    status, _, err = elsewhere.command(*arguments, METRICS, "hydra.sweep.dir=numbers")
    assert status == 0, err
    assert err.count(IDLE) == 1
    status, _, err = elsewhere.command("law=smooth", SHORT, "hydra.run.dir=smooth")
    assert (status, err) == (0, "")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("contradicting", "its friction_kind is RATE_DEPENDENT, but it has no kernel of friction"),
        long("negative_bound", "the friction bound is -1e-06 N"),
        long("past_the_end", "reads parameters that there are not"),
        long("raising", "the law raising raised KeyError: 'kernel' ("),
        ("leaving", "the law leaving raised SystemExit: 0"),
    ],
)
@pytest.mark.parametrize("verb", [(), pytest.param(("-m",), marks=pytest.mark.long)], ids=["run", "sweep"])
def test_a_law_that_contradicts_itself_is_refused_before_anything_is_written(
    elsewhere: Elsewhere, name: str, words: str, verb: tuple[str, ...]
) -> None:
    places = ("hydra.run.dir=refused", "hydra.sweep.dir=refused")
    status, _, err = elsewhere.command(*verb, f"law={name}", *places)
    assert status == 2
    assert words in err
    assert not (elsewhere.folder / "refused").exists()


def test_broken_laws_harm_no_other(elsewhere: Elsewhere) -> None:
    status, _, err = elsewhere.command("law=hertz_penalty", SHORT, "hydra.run.dir=own")
    assert (status, err) == (0, "")
    assert law_of(elsewhere.folder / "own/run.nc")[0] == "hertz_penalty"
    status, _, err = elsewhere.command("law=twice")
    assert status == 2
    assert "law is 'twice'; it must be one of " in err


@pytest.mark.long
def test_a_parameter_without_default_has_to_be_given(elsewhere: Elsewhere) -> None:
    status, _, err = elsewhere.command("law=without_default")
    assert status == 2
    assert err.startswith("law.stiffness is missing; it must be a number that is greater than 0 N/m")
    arguments = ("law=without_default", "law.stiffness=1e7", "law.name=another")
    assert "law.name=another would hand the parameters of" in elsewhere.command(*arguments)[2]


@pytest.mark.parametrize(
    "arguments", [long(["--help"]), long(["-sc", "query=bash"]), ["law=hertz"], long(["law.stiffness=-1"])]
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
