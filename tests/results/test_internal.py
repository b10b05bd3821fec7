"""What a law remembers is in its datasets: over time, contact by contact, in sweeps and in the summary."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import xarray
from support.synthetic import CONFIGURATION, synthetic_trajectory

import contactlab as cl
from contactlab.compiler.kernels import kernel
from contactlab.config import ConfigurationError
from contactlab.laws import InternalVariable, PenaltyLaw
from contactlab.results.netcdf import to_datatree, write_tree
from contactlab.trajectory import Trajectory


@dataclass(frozen=True)
class Aging(PenaltyLaw):
    """A spring that counts its contacts and forgets its stretch."""

    name = "aging"
    equation = "N = k d"
    source = "this test"
    default_contact_step = 4e-6
    internal_variables = (
        InternalVariable("count", "n", "1", "contacts so far", life="run"),
        InternalVariable("dent", "d_p", "m", "depth of the dent"),
    )

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, z, parameters):
        return -1e7 * gap, 0.0, 5e6 * gap * gap, 0.0

    @staticmethod
    @kernel
    def jump(which, event, gap, gap_rate, slip, normal, z, parameters):
        return z[which] + 1.0 if which == 0 and event == -4 else z[which]


def remembering() -> Trajectory:
    """A run of 5 ms under that law."""
    plain = synthetic_trajectory()
    series = {"internal_count": plain.time // 1e-3, "internal_dent": 1e-8 * plain.time}
    rows = plain.contacts["start_time"].size
    contacts = {"internal_count": np.arange(1.0, rows + 1.0), "internal_dent": np.full(rows, 3e-9)}
    of_both = {"series": plain.series | series, "contacts": plain.contacts | contacts}
    return replace(plain, law=Aging(), **of_both)


def test_they_survive_the_file_with_units_and_what_they_mean(tmp_path: Path) -> None:
    made = remembering()
    write_tree(to_datatree(made, CONFIGURATION), tmp_path / "run.nc")
    with xarray.open_datatree(tmp_path / "run.nc") as tree:
        for name, values in made.series.items():
            assert tree[name].values.tobytes() == values.tobytes()
        for name, values in made.contacts.items():
            assert tree["contacts"][name].values.tobytes() == values.tobytes()
        count, dent = tree["internal_count"], tree["contacts/internal_dent"]
        assert (count.dims, dent.dims) == (("time",), ("contact",))
        assert (count.attrs["units"], count.attrs["symbol"], dent.attrs["units"]) == ("1", "n", "m")


FRICTIONS = {"law/friction": ["coulomb", "mindlin"]}
BASE = ["law=composed", "solver.duration=1e-3", "record.interval=1e-5"]


def test_a_run_records_the_stretch_and_what_every_contact_left_of_it(tmp_path: Path) -> None:
    run = cl.simulate(cl.build([*BASE, "law/friction=mindlin"]))
    stretch, mode = run["internal_stretch"], run["contact_mode"]
    assert np.abs(stretch).max() > 1e-9
    assert (np.abs(stretch.values[mode.values > 0]) > 0.0).mean() > 0.9
    left = run.contacts["internal_stretch"]
    assert left.sizes == {"contact": run.contacts.sizes["contact"]}
    assert np.isfinite(left).all()
    run.save(tmp_path / "run.nc")
    assert cl.load(tmp_path / "run.nc").tree.identical(run.tree)


def test_a_sweep_keeps_them_and_has_none_where_a_law_has_none(tmp_path: Path) -> None:
    requested = {"series": ["internal_stretch"], "workers": 1}
    result = cl.sweep(FRICTIONS, base=BASE, **requested)
    run = cl.simulate(cl.build([*BASE, "law/friction=mindlin"]))
    kept = result["internal_stretch_series"]
    assert kept.attrs["units"] == "m"
    np.testing.assert_array_equal(kept.sel(friction="mindlin"), run["internal_stretch"])
    assert np.isnan(kept.sel(friction="coulomb")).all()

    cl.sweep(FRICTIONS, base=BASE, output=tmp_path, **requested)
    with xarray.open_datatree(tmp_path / "sweep.nc", decode_times=False) as tree:
        np.testing.assert_array_equal(tree["series/internal_stretch"], kept)


def test_runs_in_folders_are_collected_with_them(tmp_path: Path) -> None:
    for name in FRICTIONS["law/friction"]:
        (tmp_path / name).mkdir()
        cl.simulate(cl.build([*BASE, f"law/friction={name}"])).save(tmp_path / name / "run.nc")
    cl.collect(tmp_path, series=["internal_stretch", "gap"])
    with xarray.open_datatree(tmp_path / "sweep.nc", decode_times=False) as tree:
        kept = tree["series/internal_stretch"]
        assert kept.attrs["symbol"] == "z"
        assert np.isnan(kept.values).all(axis=-1).tolist() == [True, False]


@pytest.mark.parametrize("frictions", [["coulomb"], ["coulomb", "lugre"]])
def test_a_variable_that_no_law_of_a_sweep_has_is_refused(frictions: list[str]) -> None:
    with pytest.raises(ConfigurationError, match="internal_deflectoin"):
        cl.sweep({"law/friction": frictions}, base=BASE, series=["internal_deflectoin"])
