"""What no contact may do, whatever its law: pull, act at a distance, leave the cone, make energy."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from contactlab.laws.base import STICK
from contactlab.metrics.declared import has_tangential_spring
from contactlab.metrics.hertz import tip_radius
from contactlab.metrics.measure import Measure
from contactlab.metrics.metric import ROUND_OFF, Metric
from contactlab.metrics.record import Record, needed

Array = NDArray[np.float64]

ONE_STEP: Final = 1e-3
"""What the one step in which a force or a slip ends may have of the wrong sign: a step is a thousandth of
a contact at the rigid laws' default, and a compliant law's error is smaller still."""


def _penetration_over_radius(record: Record) -> float:
    return float(record.contacts("max_penetration").max()) / tip_radius(record)


def _penetration_over_amplitude(record: Record) -> float:
    return float(record.contacts("max_penetration").max()) / record.amplitude()


def _tension(record: Record) -> float:
    pull = -float(record.series("normal_force").min())
    return max(0.0, pull) / record.contact_force()


def _force_at_distance(record: Record) -> float:
    gap, force = record.series("gap"), record.series("normal_force")
    scale = record.contact_force() * record.amplitude()
    # A contact may begin and end within an interval whose two records are open: the gap that it had
    # throughout is at least the mean of the two less the fastest way the records show.
    fastest = float(np.abs(np.diff(gap)).max())
    certain = np.maximum(0.5 * (gap[1:] + gap[:-1]) - fastest, 0.0)
    return float((np.abs(force[1:]) * certain).max()) / scale


def _cone_excess(record: Record) -> float:
    limit = record.setting("contact", "friction_coefficient") * _static_ratio(record)
    normal, friction = record.series("normal_force"), record.series("friction_force")
    # A force rounds off in proportion to itself, and a rigid impact's is far above the mean.
    excess = float((np.abs(friction) - limit * (1.0 + ROUND_OFF) * np.abs(normal)).max())
    return max(0.0, excess) / record.contact_force()


def _static_ratio(record: Record) -> float:
    """Static over kinetic coefficient; one where the law knows none."""
    ratios = [
        value
        for name, value in record.law_parameters.items()
        if name.rpartition(".")[2] == "static_ratio" and isinstance(value, int | float)
    ]
    return float(max(ratios, default=1.0))


def _between_steps(record: Record) -> NDArray[np.intp]:
    """Records that do not cut the step of an impact, in different contact steps.

    Within a step a rigid law's force is constant while the velocity changes its sign: only whole
    steps have a work that a law answers for.
    """
    step, time = record.contact_step, record.time
    # A record at the end of a step may lie before it by round-off.
    slack = 1e-9 * step
    starts = np.sort(record.touch_downs())
    last = np.searchsorted(starts, time, side="right") - 1
    since = time - np.append(starts, -np.inf)[last]
    whole = np.flatnonzero((since >= step - slack) | (since <= 0.0))
    needed(whole.size > 1)
    blocks = np.floor((time[whole] - time[0]) / max(step, np.finfo(float).tiny) * (1.0 + 1e-12))
    return whole[np.flatnonzero(np.diff(blocks, prepend=-1.0))]


def _falls(record: Record, name: str) -> float:
    """Falls of a loss that should only grow, over all changes of both of a contact's losses.

    All falls together, as the largest would depend on the records and on how long the run is.
    """
    kept = _between_steps(record)
    friction = np.diff(record.series("friction_loss")[kept])
    normal = np.diff(record.series("contact_loss")[kept])
    scale = float(np.abs(friction).sum() + np.abs(normal).sum())
    needed(scale > 0.0)
    # What an impact does is judged by the slip and the energy that it leaves.
    impacts = np.searchsorted(record.time[kept], record.touch_downs(), side="right") - 1
    lasting = np.ones(kept.size - 1, dtype=bool)
    lasting[impacts[(impacts >= 0) & (impacts < lasting.size)]] = False
    changes = (friction if name == "friction_loss" else normal)[lasting]
    return float(np.maximum(-changes, 0.0).sum()) / scale


def _contact_gain(record: Record) -> float:
    losses = record.contacts("energy_loss")
    scale = float(np.abs(losses).sum())
    needed(scale > 0.0)
    return float(np.maximum(-losses, 0.0).sum()) / scale


def _stick_slip(record: Record) -> float:
    # A spring gives way while it holds; that comes back and is no drift.
    needed(not has_tangential_spring(record))
    mode, slip = record.series("contact_mode"), np.abs(record.series("slip_velocity"))
    stuck = mode == STICK
    # A record next to another mode may lie on the switch itself.
    inside = stuck[1:-1] & stuck[:-2] & stuck[2:]
    needed(bool(inside.any()))
    return float(slip[1:-1][inside].max()) / record.tangential_amplitude()


def _slip_reversal(record: Record) -> float:
    time, slip = record.time, record.series("slip_velocity")
    push = np.concatenate(
        [[0.0], np.cumsum(record.series("friction_force")[1:] * record.intervals)]
    )
    starts = record.contacts("start_time")
    before = np.searchsorted(time, starts, side="right") - 1
    # The impact of a rigid law lasts a step: a record within it would see a part of its friction.
    after = np.searchsorted(time, starts + record.contact_step * (1.0 - 1e-9))
    after = np.maximum(after, before + 1)
    # Two records before the touch-down tell how fast the slip changes by itself.
    known = (before >= 1) & (after < time.size)
    before, after = before[known], after[known]
    # Touch-downs that share an interval are seen once.
    before, first = np.unique(before, return_index=True)
    after = after[first]
    rate = (slip[before] - slip[before - 1]) / (time[before] - time[before - 1])
    floor = np.abs(rate * (time[after] - time[before])) + ROUND_OFF * float(np.abs(slip).max())
    work = (push[after] - push[before]) * slip[before]
    needed(bool(work.any()))
    turned = (slip[before] * slip[after] < 0.0) & (np.abs(slip[after]) > floor)
    return float(((work < 0.0) & turned).sum()) / float((work != 0.0).sum())


MEASURES: Final[tuple[Measure[Record], ...]] = (
    Measure(
        Metric(
            "penetration_over_radius",
            "max d_max / r",
            "1",
            "largest penetration over the tip's radius",
            "<=",
            1e-2,
            "Hertz's half-space holds while the contact is small against the bodies, a/r <= 0.1; "
            "with d = a^2/r that is d/r <= 0.01",
            "Johnson (1985), Contact Mechanics, sec. 4.2",
        ),
        _penetration_over_radius,
    ),
    Measure(
        Metric(
            "penetration_over_amplitude",
            "max d_max / A_u",
            "1",
            "largest penetration over the amplitude of the tip's normal vibration",
        ),
        _penetration_over_amplitude,
    ),
    Measure(
        Metric(
            "tension",
            "max(-N, 0) / (sum p_n / sum t_c)",
            "1",
            "largest pull over the mean normal force in contact",
            "<=",
            ONE_STEP,
            "dry bodies do not pull; only the one step in which a contact ends may, and it is a "
            "thousandth of a contact",
            "Signorini's condition; Brogliato (2016), Nonsmooth Mechanics, ch. 5",
        ),
        _tension,
    ),
    Measure(
        Metric(
            "force_at_distance",
            "max(|N| max(g, 0)) / (A_u sum p_n / sum t_c)",
            "1",
            "normal force while the gap is open, over mean force in contact times amplitude",
            "<=",
            ROUND_OFF,
            "0 <= N, 0 <= g, N g = 0: where the gap is open throughout a record interval, there is no "
            "force but round-off",
            "complementarity; Brogliato (2016), Nonsmooth Mechanics, ch. 5",
        ),
        _force_at_distance,
    ),
    Measure(
        Metric(
            "cone_excess",
            "max(|F| - mu_s |N|, 0) / (sum p_n / sum t_c)",
            "1",
            "friction beyond its bound, over the mean normal force in contact",
            "<=",
            ROUND_OFF,
            "|F| <= mu_s N at every instant, and so for the means over any interval, but for round-off",
            "Coulomb's law, paper, eqs. 43-47",
        ),
        _cone_excess,
    ),
    Measure(
        Metric(
            "friction_gain",
            "sum max(-dW_f, 0) / sum(|dW_f| + |dW_n|)",
            "1",
            "positive work of friction in lasting contact, over all losses in contact",
            "<=",
            ONE_STEP,
            "friction opposes slip, so that its work is never positive but in the one step in which "
            "the slip ends, a thousandth of a contact; the step of an impact is left to slip_reversal "
            "and contact_gain",
            "second law of thermodynamics",
        ),
        lambda record: _falls(record, "friction_loss"),
    ),
    Measure(
        Metric(
            "normal_gain",
            "sum max(-dW_n, 0) / sum(|dW_f| + |dW_n|)",
            "1",
            "energy made by normal damping in lasting contact, over all losses in contact",
            "<=",
            ONE_STEP,
            "a material may store and lose energy but not make it; only the one step in which a "
            "contact ends may show the other sign",
            "second law of thermodynamics",
        ),
        lambda record: _falls(record, "contact_loss"),
    ),
    Measure(
        Metric(
            "contact_gain",
            "sum max(-W, 0) / sum|W|",
            "1",
            "energy of contacts that as a whole give some, over the losses of all",
            "<=",
            ROUND_OFF,
            "what a contact stores is released when it ends, so that a whole one only loses; no step "
            "cuts it, and round-off is all that remains",
            "second law of thermodynamics; Stronge (2000), Impact Mechanics, ch. 3",
        ),
        _contact_gain,
    ),
    Measure(
        Metric(
            "stick_slip",
            "max|v| in stick / A_v",
            "1",
            "largest slip velocity while the contact sticks, over the amplitude of the tip's "
            "tangential velocity; not applicable to friction with a spring, which gives way",
            "<=",
            ONE_STEP,
            "stick is no slip at all; a drift of a thousandth of the vibration's velocity moves the "
            "tip by about a thousandth of its amplitude over a contact, and the projection of a "
            "first-order law at its default step leaves less than that",
            "paper, eqs. 60-66",
        ),
        _stick_slip,
    ),
    Measure(
        Metric(
            "slip_reversal",
            "touch-downs with p_t v_0 < 0 and v_1 v_0 < 0, over all with friction",
            "1",
            "share of touch-downs whose friction reverses the slip, beyond what the slip changes by "
            "itself within a record interval",
            "<=",
            5e-2,
            "friction can stop a slip, never reverse it: none may. One in twenty is left for slips "
            "that pass zero by themselves between two records",
            "Routh (1891); Wang and Mason (1992), J. Appl. Mech. 59, 635",
        ),
        _slip_reversal,
    ),
)
"""Metrics of what no contact may do."""
