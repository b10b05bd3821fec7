"""Resonators of files: natural frequencies, damping, shapes at the contact and couplings, mode by mode.

    frequency, damping_ratio   Hz, 1; or modal `stiffness` [N/m] and `damping` [N s/m], 0 is a rigid body
    uy                         1, displacement of the contact point towards the rotor
    ux                         1, displacement of the contact point along the rotor's surface; or
    rotation                   rad/m, of a rigid tip, whose end moves by -contact.tip_length times it along x
    coupling_1, coupling_2 ... N/V, modal force per voltage of each electrode
    modal_mass                 kg, of the shapes as they stand; 1 where the column is absent
    capacitance_1_1 ...        F, a number each, with the modes at rest; symmetric, zero where absent
    loss_tangent               1, a number
    point_NAME                 1, displacement of another point, which runs record by that name
    residual_uu, residual_ur, residual_rr   m/N, 1/N, rad/(N m): what the modes that are left out yield to a
                               force along y and a moment at the tip; numbers, together with the next two
    tip_mass, tip_inertia      kg, kg m2, of the rigid tip, which an impact meets; see `add_residual_modes`

x points along the surface, y from the structure to the rotor, and a rotation turns x to y. CSV has a header
with units, a row a mode, and numbers as comments `# capacitance_1_1: 2.3 nF`; netCDF has a variable each.
"""

import re
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Annotated, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.checks import Checked, checked_arguments
from contactlab.motor import NormalModes, add_residual_modes
from contactlab.motor.table import MeasurementError, Table, read_table, write_csv
from contactlab.parameter import Parameter
from contactlab.variables import POINT

_FILE: Final = Parameter("", "1", "CSV or netCDF file of the modes")
_DIGEST: Final = Parameter("", "1", "digest of the file", hint="null takes the file as it is.")
_MODES: Final = Parameter("", "1", "modes that are taken, the lowest", at_least=1, hint="null takes all.")

_PAIRS: Final = (("frequency", "damping_ratio"), ("stiffness", "damping"))
_UNITS: Final = {
    "frequency": "Hz",
    "damping_ratio": "1",
    "stiffness": "N m-1",
    "damping": "N s m-1",
    "uy": "1",
    "ux": "1",
    "rotation": "rad m-1",
    "modal_mass": "kg",
    "loss_tangent": "1",
}
_RESIDUAL: Final = {
    "residual_uu": "m N-1",
    "residual_ur": "N-1",
    "residual_rr": "rad N-1 m-1",
    "tip_mass": "kg",
    "tip_inertia": "kg m2",
}


@final
@dataclass(frozen=True)
class ModalFile(Checked):
    """A resonator by its modes, see the module."""

    file: Annotated[str, _FILE]
    digest: Annotated[str | None, _DIGEST] = None
    modes: Annotated[int | None, _MODES] = None


@checked_arguments(tip_length="m")
def read_modes(path: str | Path, tip_length: float, most: int | None = None) -> NormalModes:
    """Return the modes of a file, by rising frequency.

    Args:
        path: CSV or netCDF, see the module.
        tip_length: of the contact's geometry [m]: the engine's slope is rotation, or -ux / tip_length.
        most: number of modes that are taken; None is all.

    Raises:
        OSError: the file cannot be read.
        MeasurementError: a column is missing, unknown, beside another form of it, or has an impossible value.
    """
    return modes_of(read_table(Path(path)), tip_length, most)


def modes_of(table: Table, tip_length: float, most: int | None = None) -> NormalModes:
    """Return the modes of a table, see `read_modes`."""
    electrodes = _electrodes(table)
    couplings = [f"coupling_{e}" for e in range(1, electrodes + 1)]
    capacitances = [f"capacitance_{i + 1}_{j + 1}" for i, j in np.ndindex(electrodes, electrodes)]
    points = [name for name in table.names if name.startswith(POINT) and name.isidentifier()]
    table.check_names([*_UNITS, *_RESIDUAL, *couplings, *capacitances, *points])
    rate, loss = _either(table, "frequency", "stiffness"), _either(table, "damping_ratio", "damping")
    if (rate, loss) not in _PAIRS:
        pairs = " or ".join(" and ".join(pair) for pair in _PAIRS)
        raise MeasurementError(f"'{loss}' stands beside '{rate}'; there must be {pairs}.")
    mass = _column(table, "modal_mass") if "modal_mass" in table.names else np.ones(len(table.places))
    _refuse_not(table, "modal_mass", mass > 0.0, "positive")
    values, losses = _column(table, rate), _column(table, loss)
    for name, column in ((rate, values), (loss, losses)):
        _refuse_not(table, name, column >= 0.0, "at least 0")
    if loss == "damping_ratio" and losses.min() >= 1.0:
        raise MeasurementError(
            f"damping_ratio is {losses.min():g} or more in every mode, so that none vibrates; one must be "
            "below 1, which is critical. 3 % is 0.03."
        )
    if rate == "frequency":
        omega = 2.0 * np.pi * values
        stiffness, damping = omega**2, 2.0 * losses * omega
    else:
        stiffness, damping = values / mass, losses / mass
    along = _either(table, "ux", "rotation")
    slope = _column(table, along) / (-tip_length if along == "ux" else 1.0)
    root = np.sqrt(mass)
    coupling = np.stack([_column(table, name, "N V-1") for name in couplings], axis=1)
    order = np.argsort(stiffness, kind="stable")[:most]
    modes = NormalModes(
        stiffness=stiffness[order],
        damping=damping[order],
        coupling=(coupling / root[:, None])[order],
        tip_displacement=(_column(table, "uy") / root)[order],
        tip_slope=(slope / root)[order],
        capacitance=_capacitance(table, electrodes),
        loss_tangent=float(_column(table, "loss_tangent")[0]) if "loss_tangent" in table.names else 0.0,
        points={name.removeprefix(POINT): (_column(table, name, "1") / root)[order] for name in points},
    )
    return _with_residual(modes, table) if {*_RESIDUAL} & {*table.names} else modes


def _with_residual(modes: NormalModes, table: Table) -> NormalModes:
    """Return the modes with those that carry the residual flexibility and the inverse mass."""
    uu, ur, rr, mass, inertia = (float(_column(table, name, unit)[0]) for name, unit in _RESIDUAL.items())
    if "rotation" not in table.names:
        raise MeasurementError(
            "'residual_rr' is of a rotation; the shapes must have 'rotation' in place of 'ux'."
        )
    return add_residual_modes(modes, np.diag([mass, inertia]), np.array([[uu, ur], [ur, rr]]))


@checked_arguments()
def write_modes(modes: NormalModes, path: str | Path) -> None:
    """Write modes to a file that `resonator=modal` reads to the same bits, netCDF by its suffix .nc, or CSV.

    >>> import contactlab as cl
    >>> cl.write_modes(cl.RitzResonator().modes, "modes.csv")
    >>> cl.build(["resonator=modal", "resonator.file=modes.csv"]).motor.modes.natural_frequency[:2].round(1)
    array([3210.1, 5460.7])
    """
    if modes.rotor_displacement is not None:
        raise ValueError("The modes have a rotor_displacement; they must be those of the resonator alone.")
    # Imported here: reading needs none.
    import xarray

    columns = {"stiffness": modes.stiffness, "damping": modes.damping, "uy": modes.tip_displacement}
    columns |= {"rotation": modes.tip_slope}
    units = dict(_UNITS)
    for e, values in enumerate(modes.coupling.T, 1):
        columns[f"coupling_{e}"], units[f"coupling_{e}"] = values, "N V-1"
    columns |= {f"{POINT}{name}": values for name, values in modes.points.items()}
    data = {name: ("mode", values, {"units": units.get(name, "1")}) for name, values in columns.items()}
    numbers = {"loss_tangent": ((), modes.loss_tangent, {"units": "1"})}
    if modes.capacitance is not None:
        for (i, j), value in np.ndenumerate(modes.capacitance):
            numbers[f"capacitance_{i + 1}_{j + 1}"] = ((), value, {"units": "F"})
    made, path = xarray.Dataset(data | numbers), Path(path)
    if path.suffix == ".nc":
        made.to_netcdf(path, engine="netcdf4")
    else:
        write_csv(made, path)


def _electrodes(table: Table) -> int:
    """Return the number of electrodes, whose couplings must be counted from 1 without a gap."""
    numbers = {int(match[1]) for name in table.names if (match := re.fullmatch(r"coupling_(\d+)", name))}
    electrodes = next(n for n in count(1) if n not in numbers) - 1
    if not electrodes or len(numbers) > electrodes:
        raise MeasurementError(
            f"'coupling_{electrodes + 1}' is missing; every electrode must have its coupling."
        )
    return electrodes


def _either(table: Table, *names: str) -> str:
    """Return which of two columns is there; there must be one."""
    there = [name for name in names if name in table.names]
    if len(there) != 1:
        how = "are both there" if there else "are missing"
        raise MeasurementError(f"'{names[0]}' and '{names[1]}' {how}; there must be one of them.")
    return there[0]


def _column(table: Table, name: str, units: str = "") -> Array:
    if name not in table.names:
        raise MeasurementError(f"'{name}' is missing; there must be a column of it.")
    return table.numbers(name, units or _UNITS[name])


def _refuse_not(table: Table, name: str, good: NDArray[np.bool_], range_: str) -> None:
    if not good.all():
        raise MeasurementError(f"{name} in {table.places[int(np.argmin(good))]} must be {range_}.")


def _capacitance(table: Table, electrodes: int) -> Array | None:
    """Return the capacitances [F]; None where the file has none."""
    matrix, known = np.zeros((electrodes, electrodes)), False
    for i, j in np.ndindex(matrix.shape):
        name = f"capacitance_{i + 1}_{j + 1}"
        if name in table.names:
            matrix[i, j], known = table.numbers(name, "F")[0], True
            if f"capacitance_{j + 1}_{i + 1}" not in table.names:
                matrix[j, i] = matrix[i, j]
        elif i == j and any(each.startswith("capacitance_") for each in table.names):
            raise MeasurementError(
                f"'{name}' is missing; every electrode must have its capacitance, or none."
            )
    return matrix if known else None
