"""Small files that declare large tables."""

from pathlib import Path

import netCDF4

TABLES = {"declared.nc": "f8", "many.nc": "i1"}


def declare(path: Path, kind: str, rows: int = 2_000_000_000) -> None:
    """Write some kB that declare a table."""
    with netCDF4.Dataset(path, "w") as file:
        file.createDimension("time", rows)
        for name, unit in {"time": "s", "voltage_1": "V", "voltage_2": "V", "gap": "m"}.items():
            column = file.createVariable(name, kind, ("time",), chunksizes=(1_000_000,), zlib=True)
            column.units = unit
