"""Short runs of several laws in one motor, as the command leaves them."""

from pathlib import Path

from support.conf_files import altered

from contactlab.config import build
from contactlab.engine import simulate
from contactlab.results import netcdf

LAWS = ("lagrange_slip", "lagrange_stick", "hertz_penalty")

SHORT: dict[str, object] = {"solver.duration": 2e-3, "record.interval": 1e-6}


def leave(folder: Path, law: str, **changes: object) -> Path:
    """A run folder; two underscores in a key stand for its dot."""
    keys = {key.replace("__", "."): value for key, value in changes.items()}
    setup = build(altered(SHORT | keys, law=law))
    trajectory = simulate(
        setup.motor,
        setup.law,
        duration=setup.duration,
        record_interval=setup.record_interval,
        contact_step=setup.contact_step,
        tolerance=setup.tolerance,
    )
    folder.mkdir(parents=True, exist_ok=True)
    netcdf.write_tree(netcdf.to_datatree(trajectory, setup.configuration), folder / "run.nc")
    return folder


def leave_all(folder: Path) -> Path:
    """A folder of the paper's three laws, as a sweep leaves it."""
    for number, law in enumerate(LAWS):
        leave(folder / f"{number}_law={law}", law)
    return folder
