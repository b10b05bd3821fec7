"""A result that was written is read back: its file alone gives numbers, tables, findings and figures."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.command_line import Command, cases
from support.results import assert_read_again, files

import contactlab as cl
from contactlab.studies.drive import Driven


def path_in(folder: Path) -> Path:
    time = np.linspace(0.0, 1e-3, 51)
    rows = np.column_stack([time, 1e-6 * np.sin(2e3 * np.pi * time), np.full(time.size, 10.0)])
    header = "time [s],slip [m],normal [N]"
    np.savetxt(folder / "path.csv", rows, delimiter=",", header=header, comments="")
    return folder / "path.csv"


STUDIES: dict[str, Callable[[Path], cl.Result]] = {
    "steady": lambda folder: cl.steady(
        cl.build(), load=np.float64(1e-4), longest=np.int64(300), output=folder
    ),
    "branch": lambda folder: cl.branch(cl.build(), "contact.clearance", 1e-6, 1.02e-6, output=folder),
    "basins": lambda folder: cl.basins(
        cl.build(), {"rotor_velocity": np.array([-3.0, 0.0]), "drive_phase": np.array([0.0])}, output=folder
    ),
    "characterise": lambda folder: cl.characterise(cl.build(), output=folder),
    "compare": lambda folder: cl.compare(
        [cl.build([f"law={law}", "solver.duration=5e-4"]) for law in ("newton", "hertz_penalty")],
        output=folder,
        refine=False,
    ),
    "drive": lambda folder: Driven(data=path_in(folder.parent))(
        {law: cl.build([f"law={law}"]) for law in ("newton", "hertz_penalty")}, output=folder
    ),
}


@pytest.mark.parametrize("name", cases(STUDIES, ("branch", "basins")))
def test_the_file_alone_gives_the_result_and_the_same_files(name: str, tmp_path: Path) -> None:
    assert_read_again(STUDIES[name], name, tmp_path)


@pytest.mark.long
def test_the_kind_of_a_motion_and_its_options_are_known_from_its_file_and_the_page_is_made_anew(
    command: Command, tmp_path: Path
) -> None:
    made = STUDIES["steady"](tmp_path / "made")
    again = cl.load(tmp_path / "made" / "steady.nc")
    assert isinstance(again, cl.Result)
    assert again.kind == made.kind == "periodic"
    assert again.velocity == made.velocity
    # An option may be a number of NumPy.
    assert again.study.options == made.study.options
    with pytest.raises(AttributeError):
        _ = again.velocty
    page = (tmp_path / "made" / "report.html").read_bytes()
    assert command("report", "made/steady.nc", "output=again")[0] == 0
    assert files(tmp_path / "again") == files(tmp_path / "made")
    (tmp_path / "made" / "report.html").unlink()
    assert command("report", "made/steady.nc")[0] == 0
    assert (tmp_path / "made" / "report.html").read_bytes() == page


def test_what_is_no_study_has_no_page(command: Command, tmp_path: Path) -> None:
    cl.simulate(cl.build(), duration=1e-4).save(tmp_path / "run.nc")
    (tmp_path / "text.nc").write_text("no dataset")
    for name in ("run.nc", "text.nc", "absent.nc"):
        status, _, errors = command("report", name)
        assert status == 2
        assert name in errors
        assert "Traceback" not in errors
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    "overrides",
    [
        [],
        ["law=newton", "contact.clearance=0.5 um"],
        ["law=composed", "law/normal=prony", "law/friction=iwan", "law.normal.first_time=2e-5"],
        ["resonator=finite_element", "piezoceramic=pz26_datasheet", "drive.voltage_1=3 V"],
        ["contact.preload=2", "solver.changes=['0.6 ms; rotor.damping=4e-7']"],
    ],
)
def test_a_setup_is_shown_as_what_makes_it(overrides: list[str]) -> None:
    setup = cl.build(overrides)
    text = repr(setup)
    assert eval(text, {"contactlab": cl}).configuration == setup.configuration
    assert text.count("=") <= 2 * len(overrides) + 1
    changed = setup.with_("rotor.inertia=1e-6")
    assert eval(repr(changed), {"contactlab": cl}).configuration == changed.configuration
