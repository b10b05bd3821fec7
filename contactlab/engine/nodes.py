"""What the nodes of a step see: the motion without contact, and the answer to the forces."""

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.plant import Plant
from contactlab.engine.step import FRICTION, PUSH_TH, PUSH_U, Step, driven
from contactlab.engine.tables import NODES, Tables


@part_kernel
def free_response(plant: Plant, tables: Tables, step: Step, level: int, first: int) -> None:
    """State at the nodes of a level without contact: rates at all of them, displacements from `first` on."""
    for i in range(NODES):
        for k in range(plant.omega.size):
            cosine, sine = tables.turn_cos[level, i, k], tables.turn_sin[level, i, k]
            step.node_phase[i, 0, k] = step.phase[0, k] * cosine - step.phase[1, k] * sine
            step.node_phase[i, 1, k] = step.phase[0, k] * sine + step.phase[1, k] * cosine
        for j in range(plant.stiffness.size):
            q0 = step.free_q[j]
            v0 = step.free_v[j]
            v = tables.flow[level, i, 2, j] * q0 + tables.flow[level, i, 3, j] * v0
            v += tables.hold[level, i, 1, j] * plant.constant[j]
            q = 0.0
            for k in range(plant.omega.size):
                cosine, sine = step.node_phase[i, 0, k], step.node_phase[i, 1, k]
                steady_re, steady_im = plant.steady_re[j, k], plant.steady_im[j, k]
                q += steady_re * cosine - steady_im * sine
                v -= plant.omega[k] * (steady_re * sine + steady_im * cosine)
            step.node_v[i, j] = v
            if i >= first:
                q += tables.flow[level, i, 0, j] * q0 + tables.flow[level, i, 1, j] * v0
                step.node_q[i, j] = q + tables.hold[level, i, 0, j] * plant.constant[j]
        for p in range(plant.near.shape[0]):
            q, v = driven(plant, step, p, tables.driven[level, i, p])
            step.node_v[i, plant.near[p, 0]] += v
            if i >= first:
                step.node_q[i, plant.near[p, 0]] += q


@part_kernel
def add_collocated(plant: Plant, tables: Tables, step: Step, level: int) -> None:
    """Add the answer to the nodal forces: rates at all nodes, displacements at the last."""
    last = NODES - 1
    for m in range(NODES):
        for j in range(plant.stiffness.size):
            push = (
                plant.row_u[j] * step.force[PUSH_U, m]
                + plant.row_th[j] * step.force[PUSH_TH, m]
                + plant.row_r[j] * step.force[FRICTION, m]
            )
            for i in range(NODES):
                step.node_v[i, j] += tables.answer_v[level, i, m, j] * push
            step.node_q[last, j] += tables.answer_q[level, last, m, j] * push


@inner_kernel
def held_push(plant: Plant, step: Step, j: int) -> float:
    """Constant force of a HELD step on one coordinate."""
    return float(
        plant.row_u[j] * step.force[PUSH_U, 0]
        + plant.row_th[j] * step.force[PUSH_TH, 0]
        + plant.row_r[j] * step.force[FRICTION, 0]
    )


@inner_kernel
def add_held(plant: Plant, tables: Tables, step: Step, level: int, i: int) -> None:
    """Add the constant force's answer to the displacements at node i."""
    for j in range(plant.stiffness.size):
        step.node_q[i, j] += tables.hold[level, i, 0, j] * held_push(plant, step, j)


@inner_kernel
def add_held_rates(plant: Plant, tables: Tables, step: Step, level: int) -> None:
    """Add the constant force's answer to the rates at all nodes."""
    for j in range(plant.stiffness.size):
        push = held_push(plant, step, j)
        for i in range(NODES):
            step.node_v[i, j] += tables.hold[level, i, 1, j] * push
