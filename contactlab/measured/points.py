"""Operating points of a settled motor, from CSV or netCDF: velocity over load, frequency or any other key.

    rotor_velocity          rad/s, of the settled motor
    rotor_velocity_error    standard deviation of its error; optional
    rotor.load_torque ...   full keys of the motor's configuration, each with its unit

A load that brakes has the sign of the rotation.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any, Final, final

from contactlab.arrays import Array
from contactlab.measured.series import ERROR
from contactlab.motor.table import MeasurementError, Table

VELOCITY: Final = "rotor_velocity"
FEWEST: Final = 2
"""Smallest number of points."""


@final
@dataclass(frozen=True, eq=False)
class MeasuredPoints:
    """Operating points of a settled motor.

    Args:
        table: of the file, whose other columns are keys of the configuration.
        values: `rotor_velocity` [rad/s], shape (point,).
        errors: its standard deviation, positive, shape (point,), where the file states it.
        attributes: texts of the file.
        digest: of the file.
    """

    table: Table
    values: Mapping[str, Array]
    errors: Mapping[str, Array]
    attributes: Mapping[str, Any]
    digest: str = ""
    configuration: Mapping[str, Any] = field(default_factory=dict)

    @property
    def keys(self) -> list[str]:
        """Full keys by which the points differ."""
        return [name for name in self.table.names if name not in (VELOCITY, VELOCITY + ERROR)]

    @property
    def content_digest(self) -> str:
        """SHA-256 of the numbers, 64 hexadecimal digits."""
        every = [(str(name), x.values.tolist()) for name, x in self.table.data.variables.items()]
        return sha256(repr([every, *(x.tolist() for x in self.errors.values())]).encode()).hexdigest()


def points_of_table(table: Table, digest: str) -> MeasuredPoints:
    """Return the operating points of a table.

    Raises:
        MeasurementError: there are too few, no key, or an error that is not positive.
    """
    velocity, errors = table.numbers(VELOCITY, "rad s-1"), {}
    if velocity.size < FEWEST:
        raise MeasurementError(f"it has {velocity.size} operating points; there must be at least {FEWEST}.")
    if (name := VELOCITY + ERROR) in table.names:
        errors[VELOCITY] = table.numbers(name, "rad s-1")
        if not errors[VELOCITY].min() > 0.0:
            raise MeasurementError(f"{name} is {errors[VELOCITY].min():g}; it must be greater than 0.")
    result = MeasuredPoints(table, {VELOCITY: velocity}, errors, table.texts, digest)
    for key in result.keys:
        if "." not in key or key.startswith("law."):
            raise MeasurementError(
                f"'{key}' is no key of a motor; columns must be {VELOCITY}, {VELOCITY}{ERROR} and full keys, "
                "such as rotor.load_torque."
            )
    if not result.keys:
        raise MeasurementError(
            "it has no key by which the points differ, such as rotor.load_torque; it must."
        )
    return result
