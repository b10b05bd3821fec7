"""The moments of a contact of some extent: against the tilt of the tip, and against its spin on the rotor.

A moment M_t against the tilt, th less the angle a by which the tangent has turned, da/dt = v_T / |d|, acts on
the tip as M_t - M_t/|d| along the tangent, and not on the rotor: the pressure is normal to it. A moment M_s
against the spin thdot - Omega turns tip and rotor against each other.
"""

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.kinematics import contact_at, tip_motion
from contactlab.engine.memory import recall_start
from contactlab.engine.state import START, Law, Memory, Run, fit, value_at


@inner_kernel
def moments_at(
    run: Run, law: Law, memory: Memory | None, gap: float, normal: float
) -> tuple[float, float, float]:
    """Return the moments against tilt and spin [N m] and what they store [J]; of what is recalled."""
    if memory is None or run.state.moments == 0:
        return 0.0, 0.0, 0.0
    tilting, spinning, stored = memory.moment(gap, normal, law.parameters)
    return tilting, spinning, stored


@part_kernel
def first_moments(run: Run, law: Law, memory: Memory | None, gap: float, normal: float) -> None:
    """Take the moments at the start of a step, which is recalled."""
    if memory is None or run.state.moments == 0:
        return
    moments = moments_at(run, law, memory, gap, normal)
    run.step.first_tilting, run.step.first_spinning = moments[0], moments[1]


@part_kernel
def set_moments(run: Run, law: Law, memory: Memory | None, i: int, gap: float, normal: float) -> float:
    """Set the moments at node i, see `moments_at`; returns their change as a force on the rotor [N]."""
    if memory is None or run.state.moments == 0:
        return 0.0
    step = run.step
    tilting, spinning, _ = moments_at(run, law, memory, gap, normal)
    change = abs(tilting - step.tilting.node[i]) + abs(spinning - step.spinning.node[i])
    step.tilting.node[i], step.spinning.node[i] = tilting, spinning
    return float(change / run.plant.geometry.radius)


@part_kernel
def push_moments(run: Run, memory: Memory | None, i: int) -> None:
    """Add the moments of node i to its generalised forces."""
    if memory is None or run.state.moments == 0:
        return
    step, radius = run.step, run.plant.geometry.radius
    tilting, spinning = step.tilting.node[i], step.spinning.node[i]
    # What moves the tip along the rotor turns the tangent, too.
    along = tilting / (radius + step.gap[i])
    step.push_u.node[i] -= along * step.t_u[i]
    step.push_th.node[i] += tilting + spinning - along * step.t_th[i]
    # The rotor's row carries forces at its radius.
    step.push_r.node[i] += spinning / radius


@part_kernel
def fit_moments(run: Run, memory: Memory | None) -> None:
    """Lay the polynomials of the moments through their nodes."""
    if memory is None or run.state.moments == 0:
        return
    fit(run.propagator.rule, run.step.tilting)
    fit(run.propagator.rule, run.step.spinning)


@part_kernel
def missed_moments(run: Run, memory: Memory | None) -> float:
    """Return what the moments' polynomials miss of them at the step's start, as a force on the rotor [N]."""
    if memory is None or run.state.moments == 0:
        return 0.0
    step = run.step
    tilting = abs(step.tilting.coefficient[0] - step.first_tilting)
    spinning = abs(step.spinning.coefficient[0] - step.first_spinning)
    return float(max(tilting, spinning) / run.plant.geometry.radius)


@part_kernel
def moment_power(run: Run, memory: Memory | None, place: int, x: float) -> float:
    """Return the power of the moments at a place of the step, at x = s/h [W]."""
    if memory is None or run.state.moments == 0:
        return 0.0
    _, _, _, th_rate, rotor = tip_motion(run.plant, place)
    gap, _, slip, _, _, _, _ = contact_at(run.plant, place)
    radius = run.plant.geometry.radius
    tilt_rate = th_rate - (slip - rotor) / (radius + gap)
    power = value_at(run.step.tilting, x) * tilt_rate
    return float(power + value_at(run.step.spinning, x) * (th_rate + rotor / radius))


@inner_kernel
def press(run: Run, law: Law, memory: Memory | None) -> None:
    """Count what a contact that is pressed together at the start stores as brought along."""
    if memory is None:
        return
    state = run.state
    recall_start(run, law)
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    normal, _, _, pressed, _ = law.force(gap, rate, slip, state.impact_speed, law.parameters)
    turned = moments_at(run, law, memory, gap, normal)[2]
    state.total.contact_loss += pressed
    state.total.friction_loss += turned
    state.contact.energy_loss += pressed + turned
