"""A law by itself on a prescribed path: the forces that a motion brings, which it does not change.

import contactlab as cl
import numpy as np

time = np.linspace(0.0, 1e-3, 201)
rubbing = cl.Composed(friction=cl.Dahl())
loop = cl.drive(rubbing, time, gap=-1e-6, slip=1e-6 * np.sin(2e3 * np.pi * time))
loop.plot()
"""

from collections.abc import Callable
from math import factorial
from typing import Any, Final, cast

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.checks import check_shape, checked_arguments
from contactlab.engine.arguments import check_law
from contactlab.engine.equilibrium import penetrations
from contactlab.laws.base import ContactLaw, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.motor.bodies import led_body
from contactlab.motor.motor import Motor
from contactlab.motor.waveform import Waveform
from contactlab.simulation import Solution, simulate

TOLERANCE: Final = 1e-12
"""Default error of a step's impulse, over the largest force in the longest step [1]."""

EVEN: Final = 64.0
"""Longest step over the shortest piece of a path, as far as that takes no more than `MOST_STEPS`."""

MOST_STEPS: Final = 50_000
"""Longest steps of a path with pieces of many lengths."""

RECORDS: Final = 1000
"""Least number of records of a run whose interval is not given."""

DEGREE: Final = 7
"""Default degree of the spline through the samples of a path. Of a sine with 40 samples a period
viscous friction is off by 1e-7 of its largest value, by 2e-4 through a cubic one: tests/test_driving.py."""

SAME_TIME: Final = 1e-12
"""Share of a path within which two of its pieces begin at once."""

Path = Array | Waveform | float
"""Samples at the times, a waveform of one row from the first time on, or a number."""


@checked_arguments(
    time="s", gap="m", normal="N", slip="m", period="s", duration="s", record_interval="s", tolerance="1"
)
def drive(
    law: ContactLaw,
    time: Array,
    *,
    gap: Path | None = None,
    normal: Path | None = None,
    slip: Path = 0.0,
    degree: int = DEGREE,
    period: float | None = None,
    touching: bool = False,
    duration: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Solution:
    """Take a law along a prescribed path, and record its forces, internal variables and losses.

    The motion is the path's, exactly; of the work that it does

        drive_work = -int (N gdot + F v) dt = change of contact_energy + contact_loss + friction_loss

    up to `energy_residual`. Signs are those of a run: the gap is positive when open, and friction opposes
    the slip velocity. Where a path stands still set-valued friction keeps its last value, as no motion says
    another. A radius of the rotor that the law asks for is that of a plate.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> time = np.linspace(0.0, 1.0, 401)
        >>> law = cl.HertzPenalty(stiffness=1e10, friction_coefficient=0.3)
        >>> loop = cl.drive(law, time, gap=-1e-6, slip=1e-3 * np.sin(2.0 * np.pi * time))
        >>> f"{loop['friction_loss'][-1]:.9f} J"
        '0.012000000 J'

    Args:
        law: of either family.
        time: of the samples [s], increasing, shape (sample,).
        gap: of a compliant law [m].
        normal: normal force [N], positive, in place of the gap. Of a compliant law it is that of the gaps at
            which the law has these forces at rest: damping is refused where they vary, and memory along the
            normal.
        slip: displacement along the surface [m]; its rate is the slip velocity.
        degree: of the spline through the samples: 1 joins them by lines, so that velocities jump; 3, 5 or 7
            is smooth, with an error of the fourth, sixth or eighth order in the time between samples. Corners
            and jumps take 1.
        period: after which the path repeats itself [s], see `Waveform.sampled`; None is once.
        touching: whether a first gap in the neck of an adhesive law is in it, see `ModalState`.
        duration: [s]; by default from the first sample to the last, or a period.
        record_interval: [s]; by default the mean time between samples, or less for a thousand records. Forces
            are means over it, as in every run.
        tolerance: error of a step [1]; None takes 1e-12.
        progress: as of `contactlab.simulate`.

    Returns:
        A run, whose `plot` draws forces over the path.

    Raises:
        TypeError, ValueError: an argument out of range, one too many or one too few.
        LawError: the law contradicts itself, or its code raised an exception.
    """
    motor = driven_by(law, time, gap, normal, slip, degree, period, touching)
    length = (period or float(time[-1] - time[0])) if duration is None else duration
    if record_interval is None:
        record_interval = min(length / RECORDS, float(time[-1] - time[0]) / (time.size - 1))
    return simulate(
        motor,
        law,
        duration=length,
        record_interval=record_interval,
        contact_step=longest_step(motor, law),
        tolerance=TOLERANCE if tolerance is None else tolerance,
        progress=progress,
    )


def longest_step(motor: Motor, law: ContactLaw) -> float | None:
    """Return the step in contact of a compliant law [s]: no step goes beyond a piece of the path.

    Of a path with long pieces beside short ones it is short enough for both.
    """
    edges = cast(Waveform, motor.drive.waveform).pieces.x
    pieces, least = np.diff(edges), (edges[-1] - edges[0]) / MOST_STEPS
    longest = min(pieces.max(), max(EVEN * pieces.min(), least))
    return float(longest) if isinstance(law, PenaltyLaw) else None


def driven_by(
    law: ContactLaw,
    time: Array,
    gap: Path | None = None,
    normal: Path | None = None,
    slip: Path = 0.0,
    degree: int = DEGREE,
    period: float | None = None,
    touching: bool = False,
) -> Motor:
    """Return the body that takes a law along a path; arguments and errors as of `drive`."""
    check_law(law)
    compliant = isinstance(law, PenaltyLaw)
    if (gap is None) == (normal is None) or not (compliant or gap is None):
        wanted = (
            "a path of gap or of normal, and not of both" if compliant else "a path of normal, not of gap"
        )
        raise ValueError(f"{law.name} is {'compliant' if compliant else 'rigid'}; it must have {wanted}.")
    check_shape("time", time, (-1,), "one number a sample")
    first = _samples("gap", gap, time) if normal is None else _samples("normal", normal, time)
    if normal is not None and not (first > 0.0).all():
        raise ValueError(f"normal is {first.min()} N at its least; it must be positive.")
    if isinstance(law, PenaltyLaw) and normal is not None:
        varies = bool(np.ptp(first) > 0.0)
        if isinstance(law, Composed) and (
            (varies and law.damping.name != "none") or law.normal.internal_variables
        ):
            raise ValueError(
                f"The normal force of {law.name} does not follow from its gap alone; give it a path of gap"
                f"{'' if law.normal.internal_variables else ', or a constant normal force'}."
            )
        first = -penetrations(law, first)
    rows = np.stack([first, _samples("slip", slip, time)])
    path = Waveform.sampled(time - time[0], rows, degree, period)
    return led_body(_cut_at_reversals(path), compliant, touching)


def _samples(name: str, path: Path | None, time: Array) -> Array:
    """Return the values of a path at its times."""
    value: Any = path.voltage(time)[0] if isinstance(path, Waveform) else path
    samples = value + np.zeros(time.shape) if np.ndim(value) == 0 else np.asarray(value)
    check_shape(name, samples, time.shape, "one number a sample")
    return samples


def _cut_at_reversals(path: Waveform) -> Waveform:
    """Let pieces of a path end where the slip reverses, and so steps: friction may have a kink there."""
    pieces: Any = path.pieces
    turns = scipy.interpolate.PPoly(pieces.c[:, :, 1], pieces.x).derivative().roots(extrapolate=False)
    edges = np.union1d(pieces.x, turns[np.isfinite(turns)])
    edges = edges[np.append(True, np.diff(edges) > SAME_TIME * (edges[-1] - edges[0]))]
    edges[-1] = pieces.x[-1]
    powers = [pieces(edges[:-1], order) / factorial(order) for order in range(len(pieces.c) - 1, -1, -1)]
    return Waveform(scipy.interpolate.PPoly(np.stack(powers), edges), path.periodic)
