"""Errors in the contact laws and in how the engine carries them out."""

from mutation.kinds import Mutation

RIGID = "contactlab/engine/rigid_contact.py"
COMPLIANT = "contactlab/engine/compliant_contact.py"
EVENTS = "contactlab/engine/compliant_events.py"
COLLOCATION = "contactlab/engine/collocation.py"
FORMS = ("tests/test_closed_forms.py",)
CASE_A = ("tests/test_case_a.py",)
IMPACTS = ("tests/test_impact_laws.py", "tests/test_impact_runs.py")

CONTACT = (
    Mutation(
        "friction of the slip-only law pushes",
        "contactlab/laws/lagrange_slip.py",
        "return p_n, -s * mu * p_n, SLIP",
        "return p_n, s * mu * p_n, SLIP",
        ("tests/test_laws.py",),
    ),
    Mutation(
        "mu twice in the normal impulse (misprint of eq. 51)",
        "contactlab/laws/lagrange_slip.py",
        "p_n = -normal_rate / (d_nn - s * mu * d_nt)",
        "p_n = -normal_rate / (d_nn - s * mu * mu * d_nt)",
        ("tests/test_misprints.py",),
    ),
    Mutation(
        "the sign of the slip is taken after the impact",
        "contactlab/laws/lagrange_slip.py",
        "s = 1.0 if slip > 0.0 else -1.0 if slip < 0.0 else 0.0",
        "s = -1.0 if slip > 0.0 else 1.0 if slip < 0.0 else 0.0",
        ("tests/test_laws.py",),
    ),
    Mutation(
        "stick may leave the cone by a tenth",
        "contactlab/laws/lagrange_stick.py",
        "abs(p_t) <= mu * p_n and (normal_rate",
        "abs(p_t) <= 1.1 * mu * p_n and (normal_rate",
        ("tests/test_laws.py", "tests/test_contract.py"),
    ),
    Mutation(
        "stick without the coupling of the directions",
        "contactlab/laws/lagrange_stick.py",
        "p_n = (d_nt * tangential_rate - d_tt * normal_rate) / determinant",
        "p_n = -normal_rate / d_nn",
        ("tests/test_laws.py",),
    ),
    Mutation(
        "slip reverses against the normal impulse that drives it",
        "contactlab/laws/impact_process.py",
        "else -mu if d_nt > 0.0 else mu",
        "else mu if d_nt > 0.0 else -mu",
        IMPACTS,
    ),
    Mutation(
        "restitution of a contact that lasts",
        "contactlab/laws/impact_process.py",
        "return min(max(gap_rate, normal_rate), 0.0)",
        "return min(normal_rate, 0.0)",
        IMPACTS,
    ),
    Mutation(
        "the share of the work is e in place of its square",
        "contactlab/laws/stronge.py",
        "e * sqrt(2.0 * work / second)",
        "sqrt(e) * sqrt(2.0 * work / second)",
        IMPACTS,
    ),
    Mutation(
        "a contact that is not projected ends while the gap is closed",
        RIGID,
        "if p_n <= 0.0 and (projects or gap > 0.0):",
        "if p_n <= 0.0:",
        IMPACTS,
    ),
    Mutation(
        "exponent of Hertz 4/3",
        "contactlab/laws/normal/hertz_point.py",
        "force = parameters[at] * depth * root",
        "force = parameters[at] * depth ** (4.0 / 3.0)",
        ("tests/test_laws.py",),
    ),
    Mutation(
        "half in place of two fifths in the stored energy",
        "contactlab/laws/normal/hertz_point.py",
        "0.4 * force * depth",
        "0.5 * force * depth",
        ("tests/test_laws.py",),
    ),
    Mutation(
        "the friction bound is the coefficient squared",
        "contactlab/laws/friction/cone.py",
        "parameters[at] * ratio * max(normal, 0.0)",
        "parameters[at] ** 2 * ratio * max(normal, 0.0)",
        ("tests/test_laws.py",),
    ),
    Mutation(
        "no rotor in the Delassus matrix of a step",
        RIGID,
        "tangential = t_u * plant.row_u[j] + t_th * plant.row_th[j] + plant.row_r[j]\n        mobility",
        "tangential = t_u * plant.row_u[j] + t_th * plant.row_th[j]\n        mobility",
        FORMS,
    ),
    Mutation(
        "corrector skipped (eqs. 57-59): displacements stay off the constraint",
        RIGID,
        "        q[j] -= gap / gradient *",
        "        q[j] -= 0.0 * gap / gradient *",
        ("tests/test_rigid_step.py",),
    ),
    Mutation(
        "a rigid contact is released a step late",
        RIGID,
        "s = step.real[LENGTH] * before / (before - normal) if before > 0.0 else 0.0",
        "s = step.real[LENGTH]",
        ("tests/test_case_a.py", "tests/test_contract.py"),
    ),
    Mutation(
        "a graze shorter than a step is no impact",
        RIGID,
        "while impact and gap_rate < 0.0 and p_n <= 0.0",
        "while False and impact and gap_rate < 0.0 and p_n <= 0.0",
        ("tests/test_touchdown.py", "tests/test_hidden_dips.py"),
    ),
    Mutation(
        "friction of a compliant contact pushes",
        COLLOCATION,
        "step.force[FRICTION, i] = -sign * step.force[BOUND, i]",
        "step.force[FRICTION, i] = sign * step.force[BOUND, i]",
        FORMS,
    ),
    Mutation(
        "the rotor does not answer within a step",
        COLLOCATION,
        "rotor += tables.tip_v[level, 3, i, m] *",
        "rotor += 0.0 * tables.tip_v[level, 3, i, m] *",
        ("tests/test_against_oracle.py",),
    ),
    Mutation(
        "the cone is never left",
        EVENTS,
        "happened = sticks and abs(step.force[FRICTION, i]) > ceiling",
        "happened = sticks and abs(step.force[FRICTION, i]) > 10.0 * ceiling",
        FORMS,
    ),
    Mutation(
        "slip that reverses goes on",
        EVENTS,
        "happened = rubs and not sticks and run.whole[SIGN] * step.sliding[i] < 0.0",
        "happened = False and rubs and not sticks",
        FORMS,
    ),
    Mutation(
        "slip starts along the friction that stick would have needed",
        EVENTS,
        "run.whole[SIGN] = -1 if friction > 0.0 else 1",
        "run.whole[SIGN] = 1 if friction > 0.0 else -1",
        FORMS,
    ),
    Mutation(
        "a compliant contact is released a nanometre early",
        EVENTS,
        "return contact_at(plant, step.other_q, step.other_v)[0]",
        "return contact_at(plant, step.other_q, step.other_v)[0] + 1e-9",
        FORMS,
    ),
)
