"""Errors in flight, touch-down, ledger and records."""

from mutation.kinds import Mutation

LEDGER = "contactlab/engine/ledger.py"
TOUCHDOWN = "contactlab/engine/touchdown.py"

ENGINE = (
    Mutation(
        "touch-downs are judged by the ends of a step alone",
        TOUCHDOWN,
        "    if gap_a <= 0.0 or gap_b <= 0.0:\n        return False\n",
        "    return gap_a > 0.0 and gap_b > 0.0\n",
        ("tests/test_touchdown.py",),
    ),
    Mutation(
        "the bound on the gap's curvature is a thousandth of what it must be",
        TOUCHDOWN,
        "return u_acc + lever * th_acc",
        "return 1e-3 * u_acc + 1e-3 * lever * th_acc",
        ("tests/test_hidden_dips.py", "tests/test_random_flights.py"),
    ),
    Mutation(
        "no touch-down is looked for in the first steps after a release",
        "contactlab/engine/flight.py",
        "    if run.whole[PHASE] == RELEASED:\n",
        "    if False and run.whole[PHASE] == RELEASED:\n",
        ("tests/test_close_returns.py", "tests/test_case_a.py"),
    ),
    Mutation(
        "a constant force is forgotten between nodes",
        "contactlab/engine/step.py",
        "        q += plant.constant[j] * step.integrals[2]\n",
        "",
        ("tests/test_closed_forms.py",),
    ),
    Mutation(
        "the steady state runs backwards",
        "contactlab/engine/step.py",
        "            q -= plant.steady_re[j, k] * cosine - plant.steady_im[j, k] * sine\n",
        "            q -= plant.steady_re[j, k] * cosine + plant.steady_im[j, k] * sine\n",
        ("tests/test_touchdown.py",),
    ),
    Mutation(
        "damping in the response by half",
        "contactlab/engine/oscillator.py",
        "    cd = c * d\n",
        "    cd = 0.5 * c * d\n",
        ("tests/test_oscillator.py",),
    ),
    Mutation(
        "friction loss from the force squared, always a loss",
        LEDGER,
        "out[FRICTIONAL] -= weight * friction * slip",
        "out[FRICTIONAL] += weight * abs(friction * slip)",
        ("tests/test_contract.py", "tests/test_ledger.py"),
    ),
    Mutation(
        "drive work with the wrong phase",
        LEDGER,
        "drive += in_phase * phase[0, k] - quadrature * phase[1, k]",
        "drive += in_phase * phase[0, k] + quadrature * phase[1, k]",
        ("tests/test_ledger.py",),
    ),
    Mutation(
        "the rotor's damping and the resonator's counted twice",
        LEDGER,
        "    out[DAMPING] += weight * damping\n",
        "    out[DAMPING] += 2.0 * weight * damping\n",
        ("tests/test_ledger.py",),
    ),
    Mutation(
        "a step that an event cuts is booked whole",
        "contactlab/engine/run.py",
        "    if s == step.real[LENGTH]:\n        increments_of_step",
        "    if s <= step.real[LENGTH]:\n        increments_of_step",
        ("tests/test_ledger.py",),
    ),
    Mutation(
        "stick lasts as long as contact",
        "contactlab/engine/run.py",
        "run.contact[STUCK] += s if step.whole[MODE] == STICK else 0.0",
        "run.contact[STUCK] += s",
        ("tests/test_case_a.py",),
    ),
    Mutation(
        "records are mean forces over the interval that follows",
        "contactlab/engine/readout.py",
        "        impulse[1:] = np.diff(impulse) / interval\n        impulse[:1] = 0.0",
        "        impulse[:-1] = np.diff(impulse) / interval\n        impulse[-1:] = 0.0",
        ("tests/test_ledger.py", "tests/test_contract.py"),
    ),
    Mutation(
        "the peak of a contact is that of its nodes",
        "contactlab/engine/compliant_events.py",
        "    run.contact[PEAK] = max(run.contact[PEAK], force_at(step, NORMAL, left))\n",
        "",
        ("tests/test_closed_forms.py", "tests/test_against_oracle.py"),
    ),
)
