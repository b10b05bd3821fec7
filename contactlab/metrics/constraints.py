"""Plausibility of a contact: tension, action at a distance, Coulomb's cone, energy."""

from contextlib import suppress
from math import inf, sqrt
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.laws import hertz_stiffness
from contactlab.laws.base import STICK, Tangential
from contactlab.metrics.catalogue import ROUND_OFF, metric
from contactlab.metrics.run import NotApplicableError, Run, has_limits, needed, positive
from contactlab.parameter import parameters_of

ONE_STEP: Final = 1e-3
"""Tolerance for the step in which a force or a slip ends: by default a thousandth of a contact."""

OF_A_METRE: Final = hertz_stiffness(1.0, inf)
"""Stiffness K of steel bodies with a relative radius R_e of one metre [N m^-1.5]; it goes with sqrt(R_e)."""


def stiffness(run: Run) -> float:
    """Return K of N = K depth^1.5 [N m^-3/2], where the law is installed and declares one."""
    for family, owner in run.law_classes.items():
        for name, parameter in parameters_of(owner).items():
            value = run.law_parameters.get(f"{family}.{name}".removeprefix("."), 0.0)
            if parameter.units == "N m-1.5" and value > 0.0:
                return float(value)
    raise NotApplicableError


def tip_radius(run: Run) -> float:
    """Return the radius of the tip [m]: as configured, or of a spherical steel tip with the law's stiffness.

    K = 4/3 E* sqrt(R_e), R_e = [(1/r) (1/r + 1/R)]^(-1/2), solved for 1/r.
    """
    with suppress(NotApplicableError):
        return run.setting("law.tip_radius")
    radius = run.setting("rotor.radius")
    product = (OF_A_METRE / stiffness(run)) ** 4
    return 1.0 / positive(0.5 * (sqrt(1.0 / radius**2 + 4.0 * product) - 1.0 / radius))


@metric(
    "max d_max / r",
    "largest penetration over the tip's radius",
    bound=1e-2,
    reason="Hertz's half-space holds for small contacts, a/r <= 0.1; with d = a^2/r that is d/r <= 0.01",
    source="Johnson (1985), Contact Mechanics, sec. 4.2",
)
def penetration_over_radius(run: Run) -> float:
    return float(run.contacts("max_penetration").max()) / tip_radius(run)


@metric(
    "p_0 / 1.6, p_0 = (6 N_max E*^2 / (pi^3 R_e^2))^(1/3)",
    "least yield strength of both bodies at which the largest force stays elastic, steel on steel",
    "Pa",
    source="Johnson (1985), Contact Mechanics, eq. 4.24 and sec. 6.1",
)
def yield_strength_needed(run: Run) -> float:
    force = float(run.contacts("peak_normal_force").max())
    needed(np.isfinite(force) and force > 0.0)
    modulus, relative = 0.75 * OF_A_METRE, (stiffness(run) / OF_A_METRE) ** 2
    return float(np.cbrt(6.0 * force * modulus**2 / (np.pi**3 * relative**2))) / 1.6


@metric(
    "0.05 max d_max",
    "rms roughness below which the largest contact is that of smooth bodies, sigma R_e / a^2 < 0.05",
    "m",
    source="Johnson (1985), Contact Mechanics, sec. 13.5",
)
def smooth_roughness(run: Run) -> float:
    # a^2 = R_e d, where the law has Hertz's stiffness.
    needed(stiffness(run) > 0.0)
    return 0.05 * float(run.contacts("max_penetration").max())


@metric("max d_max / A_u", "largest penetration over the amplitude of the tip's normal vibration")
def penetration_over_amplitude(run: Run) -> float:
    return float(run.contacts("max_penetration").max()) / run.normal_amplitude()


def pulling(run: Run) -> list[Any]:
    """Return which of the law and its parts declare adhesion."""
    return [owner for owner in run.law_classes.values() if getattr(owner, "allows_tension", None) is True]


def changes_side(force: Array) -> NDArray[np.bool_]:
    """Return in which intervals a force begins, ends or may change its sign, by its means over them."""
    turns: NDArray[np.bool_] = np.append(force[1:] * force[:-1] <= 0.0, False)
    turns[1:] |= turns[:-1].copy()
    return turns


def cone(run: Run) -> tuple[float, float]:
    """Return the largest |F|/N [1] and the cohesion beside N [N], as the law declares them."""
    mu = run.setting("contact.friction_coefficient")
    for family in ("friction", ""):
        owner: Any = run.law_classes.get(family)
        if isinstance(owner, type) and issubclass(owner, Tangential):
            front = f"{family}." if family else ""
            own = {n.removeprefix(front): x for n, x in run.law_parameters.items() if n.startswith(front)}
            # The law of another version may have other parameters.
            with suppress(TypeError, ValueError):
                law = owner(**{**own, "friction_coefficient": mu})
                return float(law.friction_limit), float(law.friction_offset)
    # Static over kinetic coefficient; 1 where the law has none.
    named = run.law_parameters.items()
    return mu * max((x for name, x in named if name.endswith("static_ratio")), default=1.0), 0.0


@metric(
    "max(-N, 0) / (sum(p_n) / sum(t_c))",
    "largest pull over the mean normal force in contact; not applicable to laws that declare adhesion",
    bound=ONE_STEP,
    reason="dry bodies do not pull, except in the step in which a contact ends, a thousandth of it",
    source="Signorini's condition; Brogliato (2016), Nonsmooth Mechanics, ch. 5",
)
def tension(run: Run) -> float:
    needed(not pulling(run))
    pull = -float(run.series("normal_force").min())
    return max(0.0, pull) / run.contact_force()


@metric(
    "max(|N| max(g, 0)) / (A_u sum(p_n) / sum(t_c))",
    "normal force while the gap is open, over mean force in contact times amplitude; not applicable to "
    "adhesion over an open gap",
    bound=ROUND_OFF,
    reason="0 <= N, 0 <= g, N g = 0: no force but round-off where the gap is open throughout an interval",
    source="complementarity; Brogliato (2016), Nonsmooth Mechanics, ch. 5",
)
def force_at_distance(run: Run) -> float:
    # Adhesion may act over an open gap where it defines the gaps of contact.
    needed(not any(has_limits(owner) for owner in pulling(run)))
    gap, force = run.series("gap"), run.series("normal_force")
    # A contact may begin and end between two records with an open gap: throughout the interval the gap is at
    # least the mean of the two less the fastest recorded change.
    fastest = float(np.abs(np.diff(gap)).max())
    certain = np.maximum(0.5 * (gap[1:] + gap[:-1]) - fastest, 0.0)
    scale = run.contact_force() * run.normal_amplitude()
    return float((np.abs(force[1:]) * certain).max()) / scale


@metric(
    "max(|F| - mu_s (|N| + C), 0) / (sum(p_n) / sum(t_c))",
    "friction beyond its bound, over the mean normal force in contact, with the cohesion C that the law "
    "declares; intervals in which adhesion begins to pull are left out",
    bound=ROUND_OFF,
    reason="|F| <= mu_s (N + C) at every instant, and so for the means over any interval, but for round-off",
    source="Coulomb's law, paper, eqs. 43-47",
)
def cone_excess(run: Run) -> float:
    # Viscous friction is beside the cone.
    needed(not run.law_parameters.get("viscous_friction"))
    limit, offset = cone(run)
    normal, friction = run.series("normal_force"), run.series("friction_force")
    excess = np.abs(friction) - limit * ((1.0 + ROUND_OFF) * np.abs(normal) + offset)
    if pulling(run):
        # The mean of a force that changes its sign does not bound its size.
        excess = excess[~changes_side(normal)]
        needed(excess.size)
    return max(0.0, float(excess.max())) / run.contact_force()


@metric(
    "sum max(-dW_f, 0) / sum(|dW_f| + |dW_n|)",
    "positive work of friction in lasting contact, over all losses in contact",
    bound=ONE_STEP,
    reason="friction opposes slip: its work is never positive, except in the step in which the slip ends, a "
    "thousandth of a contact; impacts are judged by friction_work and contact_gain",
    source="second law of thermodynamics",
)
def friction_gain(run: Run) -> float:
    return _falls(run, "friction_loss")


@metric(
    "sum max(-dW_n, 0) / sum(|dW_f| + |dW_n|)",
    "energy generated by normal damping in lasting contact, over all losses in contact",
    bound=ONE_STEP,
    reason="a material stores and loses energy, except in the step in which a contact ends",
    source="second law of thermodynamics",
)
def normal_gain(run: Run) -> float:
    return _falls(run, "contact_loss")


def _falls(run: Run, name: str) -> float:
    """Return the sum of all decreases of a loss, over all changes of both of a contact's losses."""
    step, time = run.contact_step, run.time
    starts = np.sort(np.asarray(run.rows.get("start_time", ()), dtype=np.float64))
    since = time - np.append(starts, -np.inf)[np.searchsorted(starts, time, side="right") - 1]
    # Within a step the force of a rigid law is constant while the velocity changes its sign: work is judged
    # between records in different steps that do not divide the step of an impact.
    whole = np.flatnonzero((since >= step - 1e-9 * step) | (since <= 0.0))
    needed(whole.size > 1)
    blocks = np.floor((time[whole] - time[0]) / max(step, np.finfo(float).tiny) * (1.0 + 1e-12))
    kept = whole[np.flatnonzero(np.diff(blocks, prepend=-1.0))]
    changes = {loss: np.diff(run.series(loss)[kept]) for loss in ("friction_loss", "contact_loss")}
    scale = positive(sum(float(np.abs(change).sum()) for change in changes.values()))
    # Impacts are judged by the slip and the energy after them.
    impacts = np.searchsorted(time[kept], starts, side="right") - 1
    lasting = np.ones(kept.size - 1, dtype=bool)
    lasting[impacts[(impacts >= 0) & (impacts < lasting.size)]] = False
    return float(np.maximum(-changes[name][lasting], 0.0).sum()) / scale


@metric(
    "sum max(-W, 0) / sum(|W|)",
    "energy gained in whole contacts, over the losses of all",
    bound=ROUND_OFF,
    reason="a contact returns the energy that it stores by its end: a whole contact only loses energy",
    source="second law of thermodynamics; Stronge (2000), Impact Mechanics, ch. 3",
)
def contact_gain(run: Run) -> float:
    losses = run.contacts("energy_loss")
    return float(np.maximum(-losses, 0.0).sum()) / positive(float(np.abs(losses).sum()))


@metric(
    "sum(W_g) / sum(p_n |gdot_0|)",
    "kinetic energy that the impacts of a rigid law created, over the impulses times the approach velocities",
    bound=ROUND_OFF,
    reason="passive bodies have no more energy after an impact than before, but for round-off",
    source="Kane and Levinson (1985), Dynamics: Theory and Applications; Stronge (2000), Impact Mechanics",
)
def impact_gain(run: Run) -> float:
    gain = float(run.contacts("impact_energy_gain").sum())
    work = np.abs(run.contacts("normal_impulse") * run.contacts("approach_velocity"))
    return gain / positive(float(np.nansum(work)))


@metric(
    "max(|v|) / A_v in stick",
    "largest slip velocity while the contact sticks, over the amplitude of the tip's tangential velocity; "
    "not applicable to friction with a tangential spring",
    bound=ONE_STEP,
    reason="stick is no slip; a drift of a thousandth of the vibration's velocity moves the tip by a "
    "thousandth of its amplitude over a contact",
    source="paper, eqs. 60-66",
)
def stick_slip(run: Run) -> float:
    # The displacement of a spring in stick is recovered and is no drift.
    needed(all(getattr(owner, "exact_stick", True) for owner in run.law_classes.values()))
    stuck, slip = run.series("contact_mode") == STICK, run.series("slip_velocity")
    # The slip is the tip's own velocity less that of the rotor's surface.
    tip = slip + run.setting("rotor.radius") * run.series("rotor_velocity")
    # A record next to another mode may lie on the switch itself.
    inside = stuck[1:-1] & stuck[:-2] & stuck[2:]
    needed(inside.any())
    return float(np.abs(slip[1:-1][inside]).max()) / run.amplitude(tip)


@metric(
    "share with p_t v_0 < 0 and v_1 v_0 < 0",
    "share of touch-downs whose friction reverses the slip, beyond its own change within a record interval; "
    "a tangential compliance may reverse it, see friction_work",
    source="Routh (1891); Wang and Mason (1992), J. Appl. Mech. 59, 635",
)
def slip_reversal(run: Run) -> float:
    time, slip = run.time, run.series("slip_velocity")
    push = np.append(0.0, np.cumsum(run.series("friction_force")[1:] * run.intervals))
    starts = run.contacts("start_time")
    before = np.searchsorted(time, starts, side="right") - 1
    # The impact of a rigid law lasts a step, and a record within it has a part of its friction.
    after = np.searchsorted(time, starts + run.contact_step * (1.0 - 1e-9))
    after = np.maximum(after, before + 1)
    # Two records before the touch-down have the rate at which the slip changes without contact.
    known = (before >= 1) & (after < time.size)
    before, after = before[known], after[known]
    # Touch-downs that share an interval count as one.
    before, first = np.unique(before, return_index=True)
    after = after[first]
    rate = (slip[before] - slip[before - 1]) / (time[before] - time[before - 1])
    floor = np.abs(rate * (time[after] - time[before])) + ROUND_OFF * float(np.abs(slip).max())
    work = (push[after] - push[before]) * slip[before]
    needed(work.any())
    turned = (slip[before] * slip[after] < 0.0) & (np.abs(slip[after]) > floor)
    return float(((work < 0.0) & turned).sum()) / float((work != 0.0).sum())


@metric(
    "sum max(W_f, 0) / max(sum |W_f|, 1e-06 W_d)",
    "positive work of friction over whole contacts, over its work in all, or round-off of the drive's",
    bound=ONE_STEP,
    reason="a tangential compliance returns at most the energy that it stored: over a whole contact friction "
    "takes energy, except in the step in which the contact ends",
    source="second law of thermodynamics; Stronge (2000), Impact Mechanics, ch. 3",
)
def friction_work(run: Run) -> float:
    time, starts = run.time, run.contacts("start_time")
    ends = starts + run.contacts("duration")
    before = np.maximum(np.searchsorted(time, starts, side="right") - 1, 0)
    after = np.minimum(np.searchsorted(time, ends - 1e-9 * run.contact_step), time.size - 1)
    # Contacts that share a record interval count as one.
    first = np.flatnonzero(np.append(True, before[1:] >= after[:-1]))
    last = np.append(first[1:], before.size) - 1
    lost = run.series("friction_loss")
    work = lost[before[first]] - lost[after[last]]
    # An impact without slip has round-off of the ledger in place of friction's work.
    floor = ROUND_OFF * float(np.ptp(run.series("drive_work"))) if run.holds("drive_work") else 0.0
    return float(np.maximum(work, 0.0).sum()) / positive(max(float(np.abs(work).sum()), floor))
