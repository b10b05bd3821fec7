"""How far a run is from the steady state of its motor: a property of the run's length, not of its law."""

from contactlab.metrics.catalogue import SETTLED, UNSETTLED, metric
from contactlab.metrics.run import Run
from contactlab.settling.verdict import SHARE


@metric(
    "(|Omega_n - Omega_inf| + error) / max(|Omega_inf|, ripple, swing / 100)",
    "largest share by which the mean rotor velocity at the end of a run may be off its steady one",
    bound=SHARE,
    words=(SETTLED, UNSETTLED),
    reason="laws differ by some per cent in what a motor does when it has settled: what the start has left "
    "must be less. It is the run that is too short, and no fault of its law; where the velocity is less than "
    "its own ripple or a hundredth of what it has changed by, those are the scale",
    source="`contactlab.settling`",
)
def unsettled_share(run: Run) -> float:
    return run.settling.share


@metric(
    "Omega_inf",
    "mean rotor velocity of the steady state, from the exponential approach of the means of whole drive "
    "periods in the last half of the run",
    "rad s-1",
    source="Seber and Wild (2003), Nonlinear Regression, sec. 5.3",
)
def settled_velocity(run: Run) -> float:
    return run.settling.velocity


@metric(
    "error of Omega_inf",
    "error of the estimated velocity of the steady state, to 95 %: of its scatter, of the window and of the "
    "curvature, distance^2 / (2 swing)",
    "rad s-1",
    source="Seber and Wild (2003), Nonlinear Regression, sec. 5.3",
)
def settled_velocity_error(run: Run) -> float:
    return run.settling.error


@metric(
    "|Omega_n - Omega_n-1|", "change of the mean rotor velocity from a drive period to the next", "rad s-1"
)
def velocity_drift(run: Run) -> float:
    return abs(run.settling.drift)


@metric(
    "|P_n - P_n-1| / P_n, P = sum p_n of a period",
    "relative change of the contacts' normal impulse from a period to the next",
)
def impulse_drift(run: Run) -> float:
    return run.settling.impulse_drift
