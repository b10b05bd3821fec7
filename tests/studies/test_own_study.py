"""A study in a package of its own: verb, help, sweep, page and table; spread and resumed."""

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import xarray
from support.command_line import Elsewhere

STUDY = Path(__file__).parents[1] / "example_study"
SHORT = ("solver.duration=2e-3", "law=newton")
Results = dict[tuple[str, ...], tuple[int, str, str]]
"""Exit status, output and errors by the arguments of a command."""


WHOLE = ("gain", *SHORT, "points=6", "output=whole")
HELP, FAULTY = ("gain", "--help"), ("gain", "points=1", "output=refused")
SWEPT = ("-m", "gain", *SHORT, "drive.phase=linspace(-1,1,2)", "points=2,3", "output=swept")
RATES = ("-m", "contact.clearance=1e-6,2e-6", *SHORT, "sweep.keep=metrics", "hydra.sweep.dir=rates")

WRONG = {
    "broken": "raise KeyError('no')",
    "taken": "from contactlab.metrics import metric\n"
    "contact_count = metric('n', 'm', key='contact_count')(max)",
}
"""Modules of metrics: one fails on import, one takes a name."""


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Elsewhere:
    """A folder with the package of the study installed, and one with faulty metrics."""
    here = Elsewhere(tmp_path_factory.mktemp("packages"), tmp_path_factory.mktemp("here"))
    groups: dict[str, dict[str, str]]
    groups = tomllib.loads((STUDY / "pyproject.toml").read_text())["project"]["entry-points"]
    modules = {path.stem: path.read_text() for path in STUDY.glob("*.py")}
    metrics = {"contactlab.metrics": {"broken": "broken:rate", "contact_count": "taken:contact_count"}}
    here.install(
        here.wheel("example-study", "1.0", {}, modules, groups),
        here.wheel("other", "1.0", {}, WRONG, metrics),
    )
    return here


@pytest.fixture(scope="module")
def results(elsewhere: Elsewhere) -> Results:
    """Results of commands, one after another in one process."""
    lines = [WHOLE, HELP, FAULTY, SWEPT, RATES]
    return dict(zip(lines, elsewhere.commands(lines), strict=True))


@pytest.fixture(scope="module")
def whole(elsewhere: Elsewhere, results: Results) -> Path:
    """The files of a study that nothing interrupted."""
    assert results[WHOLE][0] == 0, results[WHOLE][2]
    return elsewhere.folder / "whole"


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


@pytest.mark.long
def test_the_verb_leaves_dataset_page_figure_and_table(whole: Path) -> None:
    assert {*bytes_of(whole)} == {
        "gain.nc", "gain.png", "gain.pdf", "report.html", "velocities.csv", "velocities.tex"
    }  # fmt: skip
    with xarray.open_dataset(whole / "gain.nc") as data:
        assert data.sizes == {"share": 6}
    assert (whole / "velocities.csv").read_text().splitlines()[0] == "share,velocity (rad/s)"


def test_help_lists_the_options_and_a_faulty_one_is_refused_by_its_key(
    elsewhere: Elsewhere, results: Results
) -> None:
    status, out, _ = results[HELP]
    assert status == 0
    assert "points" in out
    assert "number of voltages" in out
    status, out, err = results[FAULTY]
    assert (status, out) == (2, "")
    assert "study.points" in err
    assert not (elsewhere.folder / "refused").exists()


def test_it_can_be_swept_over_configuration_and_its_own_options(
    elsewhere: Elsewhere, results: Results
) -> None:
    assert results[SWEPT][0] == 0, results[SWEPT][2]
    with xarray.open_dataset(elsewhere.folder / "swept" / "sweep.nc") as data:
        assert dict(data.sizes) == {"phase": 2, "points": 2}
        assert data["slope"].attrs["units"] == "rad s-1"
        assert data["slope"].notnull().all()
        assert data["slope_error"].notnull().all()


def test_its_metric_is_one_of_every_sweep_and_faulty_ones_are_left_out(
    elsewhere: Elsewhere, results: Results
) -> None:
    status, _, err = results[RATES]
    assert status == 0, err
    with xarray.open_dataset(elsewhere.folder / "rates" / "sweep.nc") as data:
        assert data["contact_rate"].attrs["units"] == "s-1"
        assert (data["contact_rate"] * 2e-3 == data["contact_count"]).all()
        assert (data["contact_count"] > 0).all()
    messages = "".join(errors for _, _, errors in results.values())
    assert "broken" in messages
    assert "contact_count" in messages
    assert "Traceback" not in messages


def test_its_metric_is_imported_first_without_a_warning(elsewhere: Elsewhere) -> None:
    code = "import contact_rate, contactlab.metrics as m; assert 'contact_rate' in m.METRICS"
    status, _, err = elsewhere.python("-c", code)
    assert status == 0, err
    assert "broken" in err
    assert "contact_rate" not in err


@pytest.mark.long
def test_workers_leave_the_same_bytes(elsewhere: Elsewhere, whole: Path) -> None:
    assert elsewhere.command("gain", *SHORT, "points=6", "workers=2", "output=spread")[0] == 0
    assert bytes_of(elsewhere.folder / "spread") == bytes_of(whole)


def begun(elsewhere: Elsewhere, name: str, largest_file: int | None = None) -> "subprocess.Popen[bytes]":
    """Begin or continue the study in a process of its own, which may write files of some bytes at most."""
    script = "from contactlab.cli.main import main; import sys; sys.exit(main())"
    if largest_file is not None:
        script = f"import resource as r; r.setrlimit(r.RLIMIT_FSIZE, ({largest_file},) * 2); {script}"
    paths = os.pathsep.join([str(elsewhere.packages), str(Path(__file__).parents[2])])
    return subprocess.Popen(
        [sys.executable, "-c", script, "gain", *SHORT, "points=6", f"output={name}"],
        cwd=elsewhere.folder,
        env=os.environ | {"PYTHONPATH": paths},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


@pytest.mark.long
def test_a_study_that_cannot_write_leaves_no_part_of_a_file_and_continues(
    elsewhere: Elsewhere, whole: Path
) -> None:
    name, largest_file = "limited", 20_000
    assert begun(elsewhere, name, largest_file).wait() == 1
    written = bytes_of(elsewhere.folder / name)
    assert written
    assert all(len(content) <= largest_file for content in written.values())
    assert not any(path.endswith((".png", ".html")) for path in written)
    assert begun(elsewhere, name).wait() == 0
    assert bytes_of(elsewhere.folder / name) == bytes_of(whole)


@pytest.mark.long
def test_two_processes_in_a_folder_leave_the_same_bytes(elsewhere: Elsewhere, whole: Path) -> None:
    both = [begun(elsewhere, "shared"), begun(elsewhere, "shared")]
    assert [process.wait() for process in both] == [0, 0]
    assert bytes_of(elsewhere.folder / "shared") == bytes_of(whole)


@pytest.mark.long
@pytest.mark.parametrize("at", [3, 6])
def test_tasks_that_another_process_removes_are_done_again(
    elsewhere: Elsewhere, whole: Path, at: int
) -> None:
    """It ended the same study while this one did a task, or before it combined them."""
    script = """
import json, shutil, sys
from pathlib import Path
import contactlab as cl
from contactlab.studies.study import run, finish
from gain import Gain

folder, at = Path(sys.argv[1]), int(sys.argv[2])
removed = []

def remove(done, total):
    if done == at and not removed:
        removed.append(done)
        shutil.rmtree(folder / "tasks")

finish(run(Gain(points=6), {"": cl.build(json.loads(sys.argv[3]))}, folder, remove), folder)
"""
    status, _, err = elsewhere.python("-c", script, f"removed-{at}", str(at), json.dumps(SHORT))
    assert status == 0, err
    assert bytes_of(elsewhere.folder / f"removed-{at}") == bytes_of(whole)


def test_finished_tasks_are_not_done_again_and_damaged_ones_are(elsewhere: Elsewhere, whole: Path) -> None:
    script = """
import json, sys
from pathlib import Path
import contactlab as cl
from contactlab.studies.study import run, finish
from gain import Gain

calls = []
setup = cl.build(json.loads(sys.argv[1]))
folder = Path("resumed")
done = []
first = run(Gain(points=6), {"": setup}, folder, lambda n, of: done.append(n))
files = sorted(folder.glob("tasks/*.nc"))
files[0].write_bytes(files[0].read_bytes()[:-1] + b"?")
files[1].unlink()
again = []
second = run(Gain(points=6), {"": setup}, folder, lambda n, of: again.append(n))
assert done == [0, 1, 2, 3, 4, 5, 6], done
assert again == [4, 5, 6], again
assert second.data.identical(first.data)
other = []
another = cl.build([*json.loads(sys.argv[1]), "drive.phase=0.1"])
run(Gain(points=6), {"": another}, folder, lambda n, of: other.append(n))
assert other[0] == 0
finish(second, folder)
"""
    status, _, err = elsewhere.python("-c", script, json.dumps(SHORT))
    assert status == 0, err
    assert bytes_of(elsewhere.folder / "resumed") == bytes_of(whole)


EDITED_MEANWHILE = """
import sys
from pathlib import Path
import contactlab as cl
from contactlab.studies.study import run

file, folder = Path(sys.argv[1]), Path(sys.argv[2])
sys.path.insert(0, str(file.parent))
import edited_study

def edit(done, total):
    if done == 0:
        file.write_text(file.read_text().replace("number / 12.0", "number / 6.0"))

setups = {"": cl.build(["law=newton", "solver.duration=2e-4"])}
try:
    run(edited_study.Slow(workers=2), setups, folder, edit)
except cl.WorkerError as error:
    print(error, error.__cause__)
"""


@pytest.mark.long
def test_a_worker_that_loads_other_code_than_the_process_that_keeps_its_parts_is_refused(
    elsewhere: Elsewhere, tmp_path: Path
) -> None:
    file = tmp_path / "edited_study.py"
    file.write_text((STUDY.parent / "support" / "slow_study.py").read_text())
    status, out, err = elsewhere.python(
        "-c", EDITED_MEANWHILE, str(file), str(tmp_path / "parts"), PYTHONPATH=str(tmp_path)
    )
    assert status == 0, err
    assert "edited_study" in out
    assert "Traceback" not in out
    assert not [*(tmp_path / "parts").rglob("*.nc")]
