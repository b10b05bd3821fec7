"""What a law remembers is in its datasets: over time, contact by contact and in the summary."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray
from support.synthetic import CONFIGURATION, synthetic_trajectory

import contactlab as cl
from contactlab.compiler.kernels import kernel
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


def test_a_run_records_the_stretch_and_what_every_contact_left_of_it(tmp_path: Path) -> None:
    of_friction = ["law=composed", "law/friction=mindlin", "solver.duration=1e-3", "record.interval=1e-5"]
    run = cl.simulate(cl.build(of_friction))
    stretch, mode = run["internal_stretch"], run["contact_mode"]
    assert np.abs(stretch).max() > 1e-9
    assert (np.abs(stretch.values[mode.values > 0]) > 0.0).mean() > 0.9
    left = run.contacts["internal_stretch"]
    assert left.sizes == {"contact": run.contacts.sizes["contact"]}
    assert np.isfinite(left).all()
    run.save(tmp_path / "run.nc")
    assert cl.load(tmp_path / "run.nc").tree.identical(run.tree)
