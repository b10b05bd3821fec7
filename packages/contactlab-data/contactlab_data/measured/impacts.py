"""Measured impacts: velocities of the contact before and after, and the Delassus matrix.

Signs as in `contactlab.motor.geometry`: velocities of the contact are (gap rate, slip), the gap rate is
negative on approach, and an impulse p = (p_n, p_t) makes u+ = u- + D p.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from typing import Any, Final, Self, final

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray
from scipy.special import gammaincinv

from contactlab.arrays import Array
from contactlab.checks import check_kind, check_shape
from contactlab.impacts import Impacts
from contactlab_data.measured.bodies import BodyImpacts

_SHAPES: Final[dict[str, tuple[int, ...]]] = {
    "delassus": (2, 2), "velocity_before": (2,), "velocity_after": (2,), "kinetic_energy": (), "outside": (),
    "covariance": (2, 2), "number": (), "measurement": (),
}  # fmt: skip
"""Shape of each array for one impact."""

_WHOLE: Final = ("number", "measurement")
_OPTIONAL: Final = ("covariance", "measurement")

_ROUND_OFF: Final = 1e-12
"""Error of symmetry and eigenvalues, over the largest element of a matrix."""


@final
@dataclass(frozen=True, eq=False)
class MeasuredImpacts:
    """Planar impacts that were measured, all at one kind of contact.

    Args:
        delassus: D = G M^-1 G' [1/kg], shape (impact, 2, 2), symmetric and positive definite.
        velocity_before, velocity_after: gap rate and slip [m/s], shape (impact, 2).
        kinetic_energy: of all measured coordinates before the impact, v'Mv/2 [J], shape (impact,);
            u'D^-1 u/2 where only contact velocities are known.
        outside: energy r'Mr/2 [J] of that part r of the velocity jump that no impulse at the contact
            makes, shape (impact,); zero where only contact velocities are known.
        covariance: of the error of the velocity after, including that of the velocity before [m^2/s^2], shape
            (impact, 2, 2); None where it is unknown.
        title, source, licence: of the data.
        left_out: number of impacts in the file that a flag excludes.
        number: of each impact in its file, from 1, shape (impact,), whole numbers.
        notes: sentences of the file and of its reader.
        measurement: label of the measurement that each impact repeats, shape (impact,), whole numbers; None
            where each is a measurement of its own. Impacts of one label stay in one fold of `validate`.
        bodies: the impacts in generalised coordinates; None where only contact velocities are known.
        tracks: positions, flights, and breaks with the reasons of those that are no impacts, as of
            `contactlab_data.measured.tracks`; None where velocities were measured.

    Raises:
        TypeError, ValueError: an array of another kind or shape, a matrix that is not positive definite, a
            negative energy.
    """

    delassus: Array
    velocity_before: Array
    velocity_after: Array
    kinetic_energy: Array
    outside: Array
    covariance: Array | None
    title: str
    source: str
    licence: str
    left_out: int
    number: NDArray[np.int64]
    notes: tuple[str, ...] = ()
    measurement: NDArray[np.int64] | None = None
    bodies: BodyImpacts | None = None
    tracks: xarray.Dataset | None = None

    def __post_init__(self) -> None:
        for name, shape in _SHAPES.items():
            values = getattr(self, name)
            if values is not None or name not in _OPTIONAL:
                meaning, kinds = f"(impact{', 2' * len(shape)})", "iu" if name in _WHOLE else "iuf"
                check_shape(f"The {name} of the impacts", values, (len(self), *shape), meaning, kinds)
        check_kind("The number of impacts left out", self.left_out, int)
        for name in ("delassus", "covariance"):
            if (matrices := getattr(self, name)) is None:
                continue
            off, size = np.abs(matrices[:, 0, 1] - matrices[:, 1, 0]), np.abs(matrices).max((1, 2))
            least = np.linalg.eigvalsh(matrices)[:, 0]
            # A product with the Jacobian has lost some digits.
            definite = least > _ROUND_OFF * size if name == "delassus" else least >= -1e-9 * size
            if (bad := (off > _ROUND_OFF * size) | ~definite).any():
                first = int(np.argmax(bad))
                raise ValueError(
                    f"The {name} of impact {self.number[first]} is {matrices[first].tolist()}; it must be "
                    f"symmetric and positive {'' if name == 'delassus' else 'semi'}definite."
                )
        if len(self) and not (self.kinetic_energy.min() > 0.0 and self.outside.min() >= 0.0):
            raise ValueError(
                f"The least kinetic_energy is {self.kinetic_energy.min():g} J and the least energy outside "
                f"{self.outside.min():g} J; the former must be positive and the latter not negative."
            )

    @classmethod
    def of_bodies(cls, bodies: BodyImpacts, **others: Any) -> Self:
        """Return the impacts of bodies, with the other arguments by name.

        The covariance is by default that of the bodies; sentences on odd energies are added to the notes.
        """
        before, after = bodies.contact(bodies.before), bodies.contact(bodies.after)
        delassus = bodies.delassus()
        others["notes"] = (*others.get("notes", ()), *odd_energies(before, after, delassus))
        return cls(
            delassus=delassus,
            velocity_before=before,
            velocity_after=after,
            kinetic_energy=bodies.energy(bodies.before),
            outside=bodies.outside(),
            bodies=bodies,
            **{"covariance": bodies.contact_covariance(), **others},
        )

    def __len__(self) -> int:
        return len(self.velocity_before) if isinstance(self.velocity_before, np.ndarray) else 0

    @property
    def content_digest(self) -> str:
        """SHA-256 of the numbers, 64 hexadecimal digits."""
        digest = sha256()
        arrays = (self.delassus, self.velocity_before, self.velocity_after, self.kinetic_energy)
        for array in (*arrays, self.outside, self.covariance, self.number):
            digest.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
        if self.measurement is not None:
            digest.update(b"measurement" + self.measurement.astype(np.int64).tobytes())
        return digest.hexdigest()

    @cached_property
    def before(self) -> Impacts:
        """The state before the impacts, from which laws predict the velocities after them."""
        return Impacts(self.delassus, self.velocity_before)

    def errors(self, predicted: Array, outside: Array | None = None) -> Array:
        """Return the errors of predictions relative to the motion before the impact [1], shape (impact,).

            ||v+ - v+_predicted||_M / ||v-||_M = sqrt((r' D^-1 r + 2 outside) / (2 kinetic_energy))

        with r = velocity_after - predicted, in the norm of the kinetic energy; NaN where a prediction is.

        Args:
            predicted: gap rate and slip after the impacts [m/s], shape (impact, 2).
            outside: energy of the part of the error that no impulse makes [J], shape (impact,); None is that
                of predictions by impulses at the contact as it was measured.
        """
        inside = squared_norm(self.delassus, self.velocity_after - predicted)
        beside = self.outside if outside is None else outside
        return np.asarray(np.sqrt((inside + 2.0 * beside) / (2.0 * self.kinetic_energy)))

    def part(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Self:
        """Return some of the impacts, by a mask or by indices, shape (any,)."""
        columns = {name: getattr(self, name) for name in _SHAPES}
        parts: dict[str, Any] = {name: x[chosen] for name, x in columns.items() if x is not None}
        return replace(self, bodies=self.bodies and self.bodies.part(chosen), **parts)

    @cached_property
    def _equal_rows(self) -> NDArray[np.int64]:
        """A number, from 0 in the order of first occurrence, that rows of equal measured numbers share."""
        names = [name for name in _SHAPES if name not in _WHOLE and getattr(self, name) is not None]
        columns = pandas.DataFrame(np.hstack([getattr(self, name).reshape(len(self), -1) for name in names]))
        return np.asarray(columns.groupby([*columns], sort=False).ngroup(), dtype=np.int64)

    def measurements(self) -> NDArray[np.int64]:
        """Return the number of the measurement that each impact belongs to, from 0, shape (impact,).

        Impacts belong to one measurement if their rows are equal to the last bit or have the same label.
        Numbers are in the order of first occurrence.
        """
        equal = self._equal_rows
        if self.measurement is None:
            return equal
        # Imported here: few files have labels.
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        # A graph of rows and labels: equal rows of two labels unite these.
        labels = pandas.factorize(self.measurement)[0] + len(self)
        edges = coo_array((np.ones(len(self)), (equal, labels)), shape=(2 * len(self),) * 2)
        return np.asarray(pandas.factorize(connected_components(edges, directed=False)[1][equal])[0])

    def copies_warning(self) -> str:
        """Return a sentence with the number of rows that repeat an earlier one exactly; empty without any."""
        copies = len(self) - int(self._equal_rows.max(initial=-1)) - 1
        if not copies:
            return ""
        return (
            f"{copies} of {len(self)} impacts equal an earlier one in every measured number. Each counts as "
            "independent evidence, so that intervals are too narrow if they are copies; remove the copies."
        )


def squared_norm(delassus: Array, velocity: Array) -> Array:
    """Return u' D^-1 u of velocities of the contact [J], shape (impact,)."""
    solved = np.linalg.solve(delassus, velocity[..., None])[..., 0]
    return np.asarray(np.einsum("ni,ni->n", velocity, solved))


def noise_from_outside(impacts: MeasuredImpacts, coordinates: int) -> Array:
    """Estimate the covariance of the velocity after [m^2/s^2], shape (impact, 2, 2).

    If the jump's errors are normal and isotropic in the norm of the kinetic energy, with the covariance
    s^2 M^-1, then 2 outside / s^2 has a chi-square distribution with coordinates - 2 degrees of freedom, and
    the contact's velocities the covariance s^2 D. s^2 [J] follows from the median, which outliers do not
    move. A second contact or a bending body makes it too large.

    Args:
        impacts: with the energy outside of the impulses' span.
        coordinates: number of velocities measured of each impact, 3 or more.

    Raises:
        ValueError: there are fewer coordinates, or no energy lies outside.
    """
    if coordinates < 3:
        raise ValueError(f"There are {coordinates} coordinates; there must be at least 3.")
    middle = float(np.median(2.0 * impacts.outside)) if len(impacts) else 0.0
    if not middle > 0.0:
        raise ValueError("No energy lies outside of the impulses' span; state the errors with the data.")
    return np.asarray(middle / (2.0 * gammaincinv(0.5 * (coordinates - 2), 0.5)) * impacts.delassus)


def odd_energies(before: Array, after: Array, delassus: Array) -> list[str]:
    """Return sentences on the number of impacts that gain energy, pull, or go on approaching.

    Args:
        before, after: velocities of the contact [m/s], shape (impact, 2).
        delassus: [1/kg], shape (impact, 2, 2).
    """
    impulse = np.linalg.solve(delassus, (after - before)[..., None])[..., 0]
    counts = {
        "gain energy": np.einsum("ni,ni->n", impulse, before + after) > 0.0,
        "have a normal impulse that pulls": impulse[:, 0] <= 0.0,
        "go on approaching": after[:, 0] < 0.0,
    }
    return [f"{int(odd.sum())} of {len(before)} impacts {what}." for what, odd in counts.items() if odd.any()]
