"""Errors in the parts of composed laws and in friction that remembers."""

from mutation.kinds import Mutation

FRICTION = "contactlab/laws/friction"
DAMPING = "contactlab/laws/damping"
STATE = "contactlab/engine/state_friction.py"
COMPOSED = ("tests/test_composed.py",)
FORMS = ("tests/test_closed_forms.py",)
INTAKE = ("tests/test_intake.py",)

PARTS = (
    Mutation(
        "Mindlin's force stays while the contact unloads",
        f"{FRICTION}/mindlin.py",
        "growth = max(stiffness_rate, 0.0) / stiffness",
        "growth = stiffness_rate / stiffness",
        COMPOSED,
    ),
    Mutation(
        "a spring keeps its stretch from contact to contact",
        "contactlab/engine/contacts.py",
        "    step.real[MEMORY] = 0.0\n",
        "",
        ("tests/test_memory.py",),
    ),
    Mutation(
        "a step forgets what the friction remembers",
        "contactlab/engine/run.py",
        "step.real[MEMORY] = memory_at(step, s / step.real[LENGTH])",
        "step.real[MEMORY] = 0.0",
        FORMS,
    ),
    Mutation(
        "the spring of a slider that slips carries nine tenths of the bound",
        STATE,
        "step.memory[i] = sign * bound / stiffness if stiffness > 0.0 else 0.0",
        "step.memory[i] = 0.9 * sign * bound / stiffness if stiffness > 0.0 else 0.0",
        FORMS,
    ),
    Mutation(
        "what a mirror leaves is turned with the slip",
        STATE,
        "slip >= 0.0 or step.whole[PARITY] == EVEN",
        "slip >= 0.0",
        INTAKE,
    ),
    Mutation(
        "the friction of a composed law reads the damping's last coefficient first",
        "contactlab/laws/composed.py",
        "normal + damping + 2 * len(GUARD)",
        "normal + damping + len(GUARD)",
        INTAKE,
    ),
    Mutation(
        "what a spring holds is booked as lost",
        "contactlab/engine/run.py",
        "    row[12 + FRICTIONAL] -= held\n",
        "",
        ("tests/test_memory.py",),
    ),
    Mutation(
        "the approach is not remembered",
        "contactlab/engine/contacts.py",
        "step.real[CLOSING] = max(-rate, 0.0)",
        "step.real[CLOSING] = 0.0",
        FORMS,
    ),
    Mutation(
        "the nominal restitution in place of the achieved one",
        f"{DAMPING}/hysteresis.py",
        "    e = restitution\n",
        "    e = restitution\n    return 1.5 * (1.0 - e)\n",
        FORMS,
    ),
    Mutation(
        "a dashpot that pulls",
        f"{DAMPING}/linear.py",
        "return float(max(elastic + parameters[at] * closing_rate, 0.0))",
        "return float(elastic + parameters[at] * closing_rate)",
        FORMS,
    ),
    Mutation(
        "bristles that slip does not drag",
        f"{FRICTION}/lugre.py",
        "rate = slip - sigma * abs(slip) * memory / drag if drag > 0.0 else 0.0",
        "rate = slip",
        FORMS,
    ),
    Mutation(
        "an elliptic contact as if it were round",
        "contactlab/laws/normal/hertz_elliptic.py",
        "shape**-1.5",
        "1.0",
        COMPOSED,
    ),
)
"""Ten."""
