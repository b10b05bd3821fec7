"""Measured impacts as an inference problem: a law, or a baseline, predicts the velocities after them.

The residual of the velocity after an impact has the covariance

    C + s^2 (u' D^-1 u) D

of the stated error C and an isotropic term in the norm of the kinetic energy, relative to the approach u: the
error of the law as `contactlab_data.measured` defines errors, s being its size.

Where the geometry of planar bodies is free besides, the law predicts the impulses of the contact with that
geometry. The residual stays that of the measured velocities, in the mass matrix and the Jacobian of the data:
a change of the norm or of the directions makes no error smaller.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, log, log1p
from typing import ClassVar, Final, Self, final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiler.kernels import kernel
from contactlab.config import ConfigurationError
from contactlab.laws import ContactLaw, Newton, PenaltyLaw
from contactlab.laws.composed import label_of
from contactlab.parameter import Parameter, positive
from contactlab_data.inference.free_parameters import FreeParameter, free_parameters, with_values
from contactlab_data.inference.problem import (
    LARGEST,
    LOG_TWO_PI,
    LOWEST,
    Problem,
    student_factor,
    student_shrinkage,
)
from contactlab_data.measured.floors import best_impulses, with_constant_impulse
from contactlab_data.measured.impacts import MeasuredImpacts, squared_norm

DISCREPANCY: Final = "discrepancy"
"""Name of the model discrepancy, which includes the noise where none is stated."""

SMOOTH: Final = 0.01
"""Error [1] below which the loss is quadratic: less than a camera resolves."""

ROUGH_TOLERANCE: Final = 1e-4
"""Tolerance of integrated impacts in cross-validation, well below the error of measurements."""

STEP: Final = 3e-4
"""Step of finite differences in the unit cube for impacts integrated to the default tolerance."""

_FLAT: Final = 1e-15
"""Determinant of a covariance over the square of its trace below which it has but one direction."""

Ranges = Mapping[str, tuple[float, float] | None]
"""Free fields of a law, each with its range or None for the declared one."""


@final
@dataclass(frozen=True)
class LawPredictor:
    """A contact law, rigid or compliant, that predicts velocities after impacts.

    Args:
        law: with the values of what is not free.
        free: free parameters.
        label: name in tables.
        baseline: whether it is a reference.
        tolerance: of integrated impacts [1]; None is the default of `contactlab.impact`.
        idle: names of fixed numbers that have no effect on the impacts.
    """

    law: ContactLaw
    free: tuple[FreeParameter, ...]
    label: str
    baseline: bool = False
    tolerance: float | None = ROUGH_TOLERANCE
    idle: tuple[str, ...] = ()

    @classmethod
    def of(cls, law: ContactLaw, ranges: Ranges | None = None) -> Self:
        """Return the predictor of a law; ranges as of `free_parameters`.

        Raises:
            ValueError: the law has no such number, or does not admit a range.
        """
        return cls(law, free_parameters(law, ranges), label_of(law))

    @property
    def integrated(self) -> bool:
        """Whether every impact is integrated, which is slow."""
        return isinstance(self.law, PenaltyLaw)

    @property
    def step(self) -> float | None:
        """Step of finite differences in the unit cube; None for predictions exact to round-off."""
        if not self.integrated:
            return None
        return STEP if self.tolerance is None else self.tolerance**0.5

    def velocities_after(self, values: Array, impacts: MeasuredImpacts) -> Array:
        """Return gap rate and slip after the impacts [m/s], shape (impact, 2); NaN without a prediction.

        Args:
            values: of the free parameters [SI], shape (parameter,).
            impacts: of which only the state before is used.
        """
        try:
            law = with_values(self.law, self.free, values)
        except ValueError:
            return np.full_like(impacts.velocity_before, np.nan)
        return impacts.before.velocities_after(law, self.tolerance if self.integrated else None)

    @property
    def fixed(self) -> Mapping[str, float]:
        """Values of the parameters that are not free, by name, SI."""
        names = {item.field or item.name for item in self.free}
        return {name: value for name, value in self.law.describe().items() if name not in names}


def frictionless() -> LawPredictor:
    """Return Newton's impact without friction, its restitution free: a baseline."""
    law = Newton(friction_coefficient=0.0)
    return LawPredictor(law, free_parameters(law, {"restitution": None}), "frictionless", baseline=True)


@final
@dataclass(frozen=True)
class ConstantImpulse:
    """An impulse that is equal in all impacts, its tangential component against the slip: a baseline."""

    free: tuple[FreeParameter, ...]
    label: str = "constant impulse"
    baseline: ClassVar[bool] = True
    integrated: ClassVar[bool] = False
    step: ClassVar[float | None] = None
    idle: ClassVar[tuple[str, ...]] = ()
    fixed: ClassVar[Mapping[str, float]] = {}

    @classmethod
    def of(cls, impacts: MeasuredImpacts) -> "ConstantImpulse":
        """Return the baseline with ranges up to the largest impulse of these impacts."""
        normal, tangential = map(float, np.abs(best_impulses(impacts)).max(axis=0))
        p_n, p_t = Parameter("p_n", "N s", "normal impulse"), Parameter("p_t", "N s", "tangential impulse")
        pushing = FreeParameter("normal_impulse", 0.0, normal, False, p_n)
        rubbing = FreeParameter("tangential_impulse", -tangential, tangential, False, p_t)
        return cls((pushing, rubbing))

    def velocities_after(self, values: Array, impacts: MeasuredImpacts) -> Array:
        """Return gap rate and slip after the impacts [m/s], shape (impact, 2)."""
        return with_constant_impulse(impacts, values)


ImpactPredictor = LawPredictor | ConstantImpulse


@final
@dataclass(frozen=True, eq=False)
class ImpactProblem(Problem):
    """Impacts under one predictor; see `Problem`.

    Args:
        measured: the impacts.
        predictor: law or baseline.
        discrepancy: whether the law may be wrong by an amount that is free; it includes noise not stated.
        degrees_of_freedom: of Student-t residuals; infinite is the normal distribution, None is free.
        corrections: free numbers of the data, named as in `contactlab_data.measured.bodies.CORRECTIONS`.

    Raises:
        ConfigurationError: there are corrections, and no planar bodies.
    """

    measured: MeasuredImpacts
    predictor: ImpactPredictor
    discrepancy: bool = False
    degrees_of_freedom: float | None = inf
    corrections: tuple[FreeParameter, ...] = ()

    def __post_init__(self) -> None:
        if self.corrections and (self.measured.bodies is None or self.measured.bodies.rotation is None):
            names = ", ".join(item.name for item in self.corrections)
            raise ConfigurationError(
                f"{names} cannot be free: the impacts are not those of a planar body with one angle."
            )

    @property
    def law(self) -> str:
        """Name of the law."""
        return self.predictor.law.name if isinstance(self.predictor, LawPredictor) else self.predictor.label

    @property
    def parameters(self) -> tuple[FreeParameter, ...]:
        """The free parameters of the predictor, then those of the data."""
        return *self.predictor.free, *self.corrections

    @cached_property
    def nuisances(self) -> tuple[FreeParameter, ...]:
        """Discrepancy and degrees of freedom where they are free."""
        size = positive("s", "1", "error in the norm of the kinetic energy, over the approach")
        discrepancy = [FreeParameter(DISCREPANCY, LOWEST, LARGEST, True, size)] if self.discrepancy else []
        return (*discrepancy, *self.free_tails)

    @cached_property
    def data(self) -> xarray.Dataset:
        """The velocities after the impacts."""
        velocities = ("impact", "direction"), self.measured.velocity_after, {"units": "m s-1"}
        coordinates = {"impact": self.measured.number.astype(float), "direction": ["normal", "tangential"]}
        return xarray.Dataset({"velocity_after": velocities}, coordinates)

    @property
    def step(self) -> float | None:
        """Step of the predictor."""
        return self.predictor.step

    @cached_property
    def _scale(self) -> Array:
        return squared_norm(self.measured.delassus, self.measured.velocity_before)

    @cached_property
    def _covariance(self) -> Array:
        stated = self.measured.covariance
        return np.zeros_like(self.measured.delassus) if stated is None else stated

    def part(self, chosen: NDArray[np.int64]) -> Self:
        """Return the problem of some of the impacts."""
        return replace(self, measured=self.measured.part(chosen))

    def velocities_after(self, values: Array) -> Array:
        """Return gap rate and slip after the impacts [m/s], shape (impact, 2); NaN without a prediction."""
        return self.prediction(values)[0]

    def prediction(self, values: Array) -> tuple[Array, Array]:
        """Return the velocities after the impacts, and the energy of their error that no impulse makes [J].

        Impacts that do not approach with another geometry have no impulse.
        """
        own, bodies = len(self.predictor.free), self.measured.bodies
        if not self.corrections or bodies is None:
            return self.predictor.velocities_after(values[:own], self.measured), self.measured.outside
        numbers = zip(self.corrections, values[own:], strict=False)
        changed = bodies.corrected(**{item.field: float(x) for item, x in numbers})
        before, delassus = changed.contact(changed.before), changed.delassus()
        approaching = before[:, 0] < 0.0
        jump = np.zeros_like(before)
        moved = replace(self.measured, delassus=delassus, velocity_before=before, bodies=None)
        reached = self.predictor.velocities_after(values[:own], moved.part(approaching))
        jump[approaching] = reached - before[approaching]
        impulses = np.linalg.solve(delassus, jump[..., None])[..., 0]
        after = changed.after_impulses(np.asarray(impulses, dtype=np.float64))
        missed = np.where(np.isfinite(after), bodies.after - after, bodies.after - bodies.before)
        return bodies.contact(after), bodies.outside_of(missed)

    def predict(self, values: Array) -> dict[str, Array] | None:
        """Return the velocities after the impacts; None if any lacks a prediction."""
        after = self.velocities_after(values)
        return {"velocity_after": after} if np.isfinite(after).all() else None

    def residuals(self, values: Array) -> Array:
        """Return errors in the norm of the kinetic energy, or over the stated ones; shape (2 impacts,)."""
        after, unstated = self.velocities_after(values), self.measured.covariance is None
        missed = self.measured.velocity_after - after
        if not np.isfinite(after).all():
            missed = np.full_like(missed, np.nan)
        # An error that leaves out a direction cannot be divided by.
        whole = np.linalg.det(self._covariance) > _FLAT * np.trace(self._covariance, axis1=1, axis2=2) ** 2
        stated = self.value(values, DISCREPANCY, 1.0 if unstated else 0.0)
        size = np.where(whole, stated, max(stated, LOWEST))
        covariance = self._covariance + (size**2 * self._scale)[:, None, None] * self.measured.delassus
        white = np.linalg.solve(np.linalg.cholesky(covariance), missed[..., None])[..., 0]
        square = np.einsum("ni,ni->n", white, white)
        return (white * student_shrinkage(square, self.tails(values), 2)[:, None]).ravel()

    def error_residuals(self, values: Array) -> Array:
        """Return residuals whose squares sum to the errors, smoothed near zero; shape (3 impacts,).

            f = w/(w'w + c^2)^(1/4),  f'f = e^2/sqrt(e^2 + c^2)

        with the error e of `MeasuredImpacts.errors`, w'w = e^2 and c = `SMOOTH`; the third component of w is
        the part of the velocity jump outside of the impulses' span. Without a prediction the velocity is
        taken as unchanged.
        """
        measured, (after, outside) = self.measured, self.prediction(values)
        after = np.where(np.isfinite(after), after, measured.velocity_before)
        root = np.linalg.cholesky(measured.delassus)
        missed = np.linalg.solve(root, (measured.velocity_after - after)[..., None])[..., 0]
        whole = np.column_stack([missed, np.sqrt(2.0 * np.maximum(outside, 0.0))])
        whole /= np.sqrt(2.0 * measured.kinetic_energy)[:, None]
        square = np.einsum("ni,ni->n", whole, whole)
        return np.asarray((whole / (square + SMOOTH**2)[:, None] ** 0.25).ravel())

    def log_densities(
        self, predicted: Mapping[str, Array], values: Array, observed: Mapping[str, Array] | None = None
    ) -> dict[str, Array]:
        """Return the log density of each impact."""
        after = self.measured.velocity_after if observed is None else observed["velocity_after"]
        missed = after - predicted["velocity_after"]
        size, tails = self.value(values, DISCREPANCY, 0.0), self.tails(values)
        terms = np.empty(len(missed))
        impact_log_densities(
            missed, self._covariance, self.measured.delassus, self._scale, size, tails, terms
        )
        return {"velocity_after": terms}

    def replicate(
        self, predicted: Mapping[str, Array], values: Array, draws: np.random.Generator
    ) -> dict[str, Array]:
        """Draw velocities after the impacts with discrepancy and noise."""
        size, tails = self.value(values, DISCREPANCY, 0.0), self.tails(values)
        covariance = self._covariance + size**2 * self._scale[:, None, None] * self.measured.delassus
        noise = np.linalg.cholesky(covariance) @ draws.standard_normal((len(self.measured), 2, 1))
        factor = student_factor(draws, tails, len(self.measured))[:, None]
        return {"velocity_after": predicted["velocity_after"] + factor * noise[..., 0]}


@kernel
def impact_log_densities(
    residuals: Array,
    covariance: Array,
    delassus: Array,
    scale: Array,
    spread: float,
    degrees_of_freedom: float,
    terms: Array,
) -> None:
    """Write the log density of each impact's residual into `terms`; -inf where it has no variance.

    Args:
        residuals: measured minus predicted velocity after the impact [m/s], shape (impact, 2).
        covariance: of the stated error [m^2/s^2], shape (impact, 2, 2), zero where none is stated.
        delassus: [1/kg], shape (impact, 2, 2).
        scale: u' D^-1 u of the approach [J], shape (impact,).
        spread: s [1].
        degrees_of_freedom: of a bivariate Student-t distribution; infinite is the normal one.
        terms: shape (impact,).
    """
    for i in range(residuals.shape[0]):
        size = spread * spread * scale[i]
        a = covariance[i, 0, 0] + size * delassus[i, 0, 0]
        b = covariance[i, 0, 1] + size * delassus[i, 0, 1]
        c = covariance[i, 1, 1] + size * delassus[i, 1, 1]
        determinant = a * c - b * b
        if not (a > 0.0 and determinant > 0.0):
            terms[i] = -inf
            continue
        x, y = residuals[i, 0], residuals[i, 1]
        distance = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant
        if degrees_of_freedom < inf:
            # The gamma functions of the density in two dimensions leave 1/(2 pi).
            power = 0.5 * degrees_of_freedom + 1.0
            distance = 2.0 * power * log1p(distance / degrees_of_freedom)
        terms[i] = -LOG_TWO_PI - 0.5 * (log(determinant) + distance)
