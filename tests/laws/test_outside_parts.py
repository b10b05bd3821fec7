"""Parts of other packages in composed laws: they run, are swept, and are refused where they are broken."""

import pytest
import xarray
from support.command_line import EXAMPLE, Elsewhere
from support.outside import SHORT, installed, law_of

from contactlab.testing.contract import PROPERTIES

pytestmark = pytest.mark.long

AGEING = {"name": "ageing", "strengthening": 0.2, "half_age": 1e-5, "distance": 1e-7, "velocity": 1e-3}

PARTS = ("law=composed", "law/normal=stiffening", "law/friction=ageing")


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    return installed(tmp_path_factory)


def test_its_parts_run_in_a_composed_law_and_the_run_says_whose_they_are(elsewhere: Elsewhere) -> None:
    keys = ("law.friction.distance=0.2 um", "law.normal.unit_depth=2e-6", "record.picture=false")
    status, _, err = elsewhere.command(*PARTS, *keys, SHORT, "hydra.run.dir=parts")
    assert status == 0, err
    path = elsewhere.folder / "parts/run.nc"
    name, section = law_of(path)
    assert name == "composed"
    assert section["friction"] == AGEING | {"distance": 2e-7}
    assert section["normal"] == {"name": "stiffening", "stiffness": 5e6, "unit_depth": 2e-6}
    with xarray.open_dataset(path) as root:
        whole, *parts = root.attrs["law_origin"].split(", ")
    assert whole.startswith("contactlab ")
    assert parts == ["normal of example-law 1.2.3", "friction of example-law 1.2.3"]


def test_declarations_of_its_parts_are_the_rules_of_their_keys(elsewhere: Elsewhere) -> None:
    faults = ("law.friction.distance=0", "law.normal.unit_depth=3 N")
    status, _, err = elsewhere.command(*PARTS, *faults)
    assert status == 2
    assert "law.friction.distance is 0 m; it must be greater than 0 m" in err
    assert "law.normal.unit_depth is '3 N', whose unit 'N' cannot be converted to m" in err


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


def test_the_contract_of_its_parts_holds_in_three_lines(elsewhere: Elsewhere) -> None:
    test = EXAMPLE / "test_parts.py"
    (elsewhere.folder / test.name).write_text(test.read_text(encoding="utf-8"), encoding="utf-8")
    status, out, _ = elsewhere.python("-m", "pytest", "-q", "-p", "no:cacheprovider", test.name)
    assert status == 0, out
    assert f"{len(PROPERTIES)} passed" in out


def test_a_broken_part_is_refused_in_a_sentence(elsewhere: Elsewhere) -> None:
    broken = ("law/normal=part_of_a_module_that_fails", "law/damping=part_that_is_a_law")
    status, _, err = elsewhere.command("law=composed", *broken)
    assert status == 2
    normal, damping = err.splitlines()
    assert normal.startswith("law.normal.name is 'part_of_a_module_that_fails', which cannot run. The normal")
    assert "is no subclass of contactlab.laws.Damping. Mend that package" in damping
