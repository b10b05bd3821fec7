"""The public functions of `import contactlab`, and the result of a run."""

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import yaml
from support.synthetic import CONFIGURATION, synthetic_trajectory

import contactlab as cl
from contactlab.laws import LAWS, PARTS
from contactlab.results.netcdf import to_datatree
from contactlab.trajectory import Ending


def motor() -> cl.Motor:
    return cl.Motor(cl.RitzResonator().modes, cl.Drive.two_mode(100.0, 100.0, 3210.0))


def law() -> cl.ContactLaw:
    return cl.HertzPenalty(stiffness=1e10, friction_coefficient=0.3)


@pytest.fixture(scope="module")
def solution() -> cl.Solution:
    """Half a millisecond of the paper's motor."""
    return cl.simulate(motor(), law(), duration=5e-4)


def test_every_name_is_there() -> None:
    laws = {made for name in dir(cl) if isinstance(made := getattr(cl, name), type)}
    named = {law.name for law in laws if issubclass(law, cl.ContactLaw) and hasattr(law, "name")}
    assert named == set(LAWS)
    assert {part for family in PARTS.values() for part in family.values()} <= laws


def test_every_declared_name_resolves_and_no_other() -> None:
    stub = ast.parse(Path(cl.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    declared = {alias.name: node.module for node in imports for alias in node.names}
    assert len(declared) > 100
    assert {*declared} == {*cl.__all__} <= {*dir(cl)}
    for name, module in declared.items():
        assert getattr(cl, name) is getattr(import_module(str(module)), name)
    with pytest.raises(AttributeError, match="simulat"):
        cl.simulat  # type: ignore[attr-defined]  # noqa: B018


def test_quantities_have_their_names_and_units(solution: cl.Solution) -> None:
    assert solution["gap"].attrs["units"] == "m"
    assert solution["gap"].dims == ("time",)
    assert solution["time"][-1] == 5e-4
    assert solution.contacts["normal_impulse"].attrs["units"] == "N s"
    assert solution.contacts["normal_impulse"].sum() > 0.0
    assert solution.to_xarray()["gap"].identical(solution["gap"])


def test_a_quantity_that_does_not_exist_is_refused(solution: cl.Solution) -> None:
    with pytest.raises(KeyError, match="speed"):
        solution["speed"]


def test_a_solution_is_a_mapping_of_names_to_quantities(solution: cl.Solution) -> None:
    assert len(solution) == len(list(solution)) == len(solution.items())
    assert {"gap", "time"} <= solution.keys()
    assert "gasp" not in solution
    assert solution.get("gasp") is None
    assert all(quantity.identical(solution[name]) for name, quantity in solution.items())
    assert solution == solution
    assert {solution: 1}[solution] == 1


def test_a_part_of_a_solution_is_selected_by_its_times(solution: cl.Solution) -> None:
    time = solution["time"].values
    part = solution.sel(time=slice(time[3], time[7]))
    assert np.array_equal(part["gap"], solution["gap"][3:8])
    assert solution.sel(time=time[4] * (1 + 1e-9), method="nearest")["gap"] == solution["gap"][4]
    with pytest.raises(KeyError, match="speed"):
        solution.sel(speed=1.0)


def test_a_solution_has_its_ending(solution: cl.Solution) -> None:
    assert (solution.ending, solution.message, solution.complete) == (Ending.COMPLETE, "", True)
    cut = synthetic_trajectory(ending=Ending.DIVERGED, message="The gap is <no> number.")
    result = cl.Solution(to_datatree(cut, CONFIGURATION))
    assert (result.ending, result.complete) == (Ending.DIVERGED, False)
    assert result.message == "The gap is <no> number."
    assert "The gap is <no> number." in repr(result)
    assert "The gap is &lt;no&gt; number." in result._repr_html_()


def test_what_is_saved_is_loaded(solution: cl.Solution, tmp_path: Path) -> None:
    solution.save(tmp_path / "run.nc")
    result = cl.load(tmp_path / "run.nc")
    assert result.to_xarray().identical(solution.to_xarray())
    assert repr(result) == repr(solution)
    assert result.state.keys() == solution.state.keys()
    # The numbers of a motor that was made in Python do not determine it.
    assert result.setup is None
    assert list(tmp_path.iterdir()) == [tmp_path / "run.nc"]
    with pytest.raises(OSError, match="nowhere"):
        solution.save(tmp_path / "nowhere" / "run.nc")


def test_a_run_from_python_records_the_numbers_of_its_motor_and_law(solution: cl.Solution) -> None:
    configuration = yaml.safe_load(solution.to_xarray().attrs["configuration"])
    assert configuration["law"] == {"name": "hertz_penalty", **law().describe()}
    assert configuration["contact"] == {
        "tip_length": 19e-3, "clearance": 1e-6, "angle": 0.0, "friction_coefficient": 0.3,
    }  # fmt: skip
    assert configuration["rotor"]["radius"] == 25e-3
    assert configuration["drive"] == {"frequency": 3210.0}
    assert configuration["record"] == {"interval": 1e-6}
    assert configuration["solver"]["duration"] == 5e-4


LENGTHS = [1e-6 * records for records in (137, 250, 613)]
"""Of the parts of a run of a millisecond, which is cut in free flight and in contact [s]."""


# Of every law the contract claims that its state goes on.
@pytest.mark.parametrize("name", ["hertz_penalty", "lagrange_stick", "archard", "lagrange_ageing"])
def test_a_run_in_parts_is_the_run_that_was_never_cut(name: str, tmp_path: Path) -> None:
    setup = cl.build([f"law={name}", "solver.duration=1 ms", "record.interval=1 us"])
    whole = cl.simulate(setup)
    assert whole.contacts.sizes["contact"] > 1
    parts = [cl.simulate(setup, duration=LENGTHS[0])]
    for duration in LENGTHS[1:]:
        parts[-1].save(tmp_path / "run.nc")
        loaded = cl.load(tmp_path / "run.nc")
        parts.append(cl.simulate(start=parts[-1], duration=duration))
        again = cl.simulate(start=loaded, duration=duration)
        assert again.to_xarray().identical(parts[-1].to_xarray())
    # What a part begins with is what the one before ends with.
    trees = [part.to_xarray().to_dataset() for part in parts]
    trees[1:] = [tree.isel(time=slice(1, None)) for tree in trees[1:]]
    for quantity, values in whole.to_xarray().to_dataset().data_vars.items():
        if "time" in values.dims:
            joined = np.concatenate([tree[quantity].values for tree in trees])
            assert joined.tobytes() == values.values.tobytes(), quantity


def test_another_law_may_go_on_where_one_ended() -> None:
    first = cl.simulate(motor(), law(), duration=2e-4)
    second = cl.simulate(motor(), cl.law("newton"), duration=2e-4, start=first)
    assert second["time"].values[[0, -1]] == pytest.approx([2e-4, 4e-4])
    assert float(second["gap"][0]) == pytest.approx(float(first["gap"][-1]), rel=1e-12)
    assert second.to_xarray().attrs["law"] == "newton"


WRONG: list[tuple[Callable[[], object], type[Exception], str]] = [
    (lambda: cl.simulate(motor(), "newton", duration=1e-3), TypeError, "law"),  # type: ignore[arg-type]
    (lambda: cl.simulate(motor(), cl.Newton, duration=1e-3), TypeError, "law"),  # type: ignore[arg-type]
    (lambda: cl.simulate(motor(), duration=1e-3), TypeError, "law"),
    (lambda: cl.simulate(cl.RitzResonator(), law(), duration=1e-3), TypeError, "motor"),  # type: ignore[arg-type]
    (lambda: cl.simulate(), TypeError, "motor"),
    (lambda: cl.simulate(motor(), law()), ValueError, "duration"),
    (lambda: cl.simulate(motor(), law(), duration=-1.0), ValueError, "duration"),
    (lambda: cl.simulate(motor(), law(), duration=1e-3, start={"time": 0.0}), TypeError, "start"),  # type: ignore[arg-type]
    (lambda: cl.simulate(cl.build([]), law()), ValueError, "law"),
    (
        lambda: cl.simulate(start=cl.Solution(to_datatree(synthetic_trajectory(), CONFIGURATION))),
        ValueError,
        "state",
    ),
    (lambda: cl.load("nowhere.nc"), ValueError, "nowhere.nc"),
]


@pytest.mark.parametrize(("call", "error", "key"), WRONG)
def test_wrong_arguments_are_refused(call: Callable[[], object], error: type[Exception], key: str) -> None:
    with pytest.raises(error, match=key):
        call()


def test_a_dataset_that_is_no_run_is_refused(solution: cl.Solution, tmp_path: Path) -> None:
    tree = solution.to_xarray().copy()
    del tree.attrs["ending"]
    tree.to_netcdf(tmp_path / "other.nc")
    with pytest.raises(ValueError, match="ending"):
        cl.load(tmp_path / "other.nc")
