"""A rigid contact that closes and for which its law has no impulse, in a sentence."""

from contactlab.engine.run import CRITICAL_FRICTION, FRICTION_LIMIT, TIME, Run


def inconsistency(run: Run) -> str:
    """Sentences on a rigid contact that closes and for which the law has no impulse."""
    time = float(run.real[TIME])
    friction, critical = run.real[FRICTION_LIMIT], run.real[CRITICAL_FRICTION]
    if friction < critical:
        return (
            f"The run ends at {time:.6g} s: the contact closes, and the law has no normal impulse that "
            "stops it. Check the law: an approach must be answered."
        )
    return (
        f"The run ends at {time:.6g} s in Painleve's paradox: the friction coefficient {friction:.6g} is "
        f"not below the critical {critical:.6g}, d_nn/|d_nt| of the contact there, so that the friction of "
        "its slip presses the bodies together more than the normal impulse parts them, and the law has no "
        "impulse that stops the approach. Lower the friction coefficient, or take a law that may stick or "
        "a compliant one."
    )
