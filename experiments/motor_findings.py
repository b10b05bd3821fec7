"""Numbers on the motor that README, steady.md, paper.md and the page on comparison state, in one file.

    python experiments/motor_findings.py [SECTION ...]

Settled velocities under laws on two bases, over phase and damping; the paired comparison of the default
motor; and a synthetic world, in which one law is true, with the rule of pairs beside the older rule on the
same draws. It takes about twenty minutes on two cores.
"""

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from itertools import combinations
from pathlib import Path
from typing import Any, Final

import numpy as np
from joblib import Parallel, delayed

import contactlab as cl
from contactlab.inference.paired import (
    AGREED,
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    VARIES,
    VERDICTS,
    looks_up_to,
    orders,
)
from contactlab.metrics.convergence import FINER, control_of
from contactlab.processes import processors
from contactlab.results.provenance import versions
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.studies.compare.draws import Distribution, configuration_of, drawn, factors_of, observed
from contactlab.studies.compare.laws import run_of_setup
from contactlab.studies.compare.pairs import CLEAR, MARGIN

RESULTS: Final = Path(__file__).resolve().parents[1] / "docs" / "results" / "motor.json"

LAWS: Final = {
    "stick": ["law=lagrange_stick"],
    "newton": ["law=newton"],
    "poisson": ["law=poisson"],
    "hertz": ["law=hertz_penalty"],
    "mindlin": ["law=composed", "law/friction=mindlin"],
}
CONVERGED: Final = ["resonator=finite_element"]
PHASES: Final = (None, 0.0, 0.524)
"""Phases of the first tone [rad]; None is the configured one."""

DAMPING: Final = (
    *(f"stiffness_damping={beta}" for beta in ("2e-5", "6e-6", "2e-6", "2e-7")),
    *(f"damping_ratio={ratio}" for ratio in ("0.05", "0.01", "0.002")),
)
"""The paper's damping per stiffness, and less; damping ratios of all modes."""

BOTH: Final = ("rotor_velocity", "stall_torque")
POOL: Final = 256
REPETITIONS: Final = 200
OUTCOMES: Final = (
    "right",
    "wrong",
    "varies",
    "inconclusive",
    "false",
    "older rule right",
    "older rule wrong",
)
PRIORS: Final[dict[str, dict[str, Distribution]]] = {
    "usual": {},
    "phase -0.6 +- 0.15": {"drive.phase": cl.Estimate(-0.6, 0.15)},
    "phase -0.6 to 0": {"drive.phase": (-0.6, 0.0)},
}
"""What is uncertain beside friction, stiffness, clearance, basis and start."""

STIFFER: Final = 1.02
"""Factor of the stiffness of a law that is hardly another one."""


def settled(overrides: list[str], names: tuple[str, ...] = ("rotor_velocity",)) -> dict[str, Any]:
    """Return kind and quantities of a settled motor at the finest of three steps, with numerical errors."""
    setup = cl.build(overrides)
    control = control_of(setup)
    steps = []
    for divisor in FINER[control]:
        key = f"solver.{control}={getattr(setup, control) / divisor!r}"
        try:
            kind, numbers = observed(cl.build([*overrides, key]), names)
        except (BrokenOffError, NotSettledError) as error:
            return {"kind": "none", "reason": str(error)}
        steps.append(numbers)
    result: dict[str, Any] = {"kind": kind}
    for name in names:
        values = [step[name].value for step in steps]
        result[name] = values[-1]
        result[f"{name}_error"] = abs(values[-1] - values[-2]) + steps[-1][name].error
    return result


def free_amplitude(overrides: list[str]) -> tuple[float, float]:
    """Return the normal and the tangential amplitude of the free tip, of the tones one by one [m]."""
    motor = cl.build(overrides).motor
    modes, rate = motor.modes, motor.drive.angular_frequency
    response = modes.coupling @ motor.drive.phasors
    tones = response / (modes.stiffness[:, None] - rate**2 + 1j * modes.damping[:, None] * rate)
    normal = np.abs(modes.tip_displacement @ tones)
    tangential = motor.geometry.tip_length * np.abs(modes.tip_slope @ tones)
    return float(normal.max()), float(tangential.max())


def at_equal_amplitude(damping: str) -> list[str]:
    """Return a damping and the voltages with which the free tip moves as with the paper's."""
    damped = [*CONVERGED, f"resonator.{damping}"]
    wanted, there = free_amplitude(CONVERGED), free_amplitude(damped)
    drive = cl.build(CONVERGED).configuration["drive"]
    # The first tone bends the beam to the rotor, the second turns its middle, or the other way round.
    voltages = [drive[f"voltage_{n}"] * wanted[n - 1] / there[n - 1] for n in (1, 2)]
    return [*damped, *(f"drive.voltage_{n}={x!r}" for n, x in enumerate(voltages, 1))]


def every(cases: Mapping[str, Callable[[], Any]]) -> dict[str, Any]:
    """Return the results of all cases, worked at by all processors."""
    results = Parallel(n_jobs=processors())(delayed(case)() for case in cases.values())
    return dict(zip(cases, results, strict=True))


def table(names: Iterable[str], overrides: list[str], quantities: tuple[str, ...]) -> dict[str, Any]:
    """Return the settled motor under laws."""
    return every({law: delayed_call(settled, [*overrides, *LAWS[law]], quantities) for law in names})


def delayed_call(function: Callable[..., Any], *arguments: Any) -> Callable[[], Any]:
    """Return a call without arguments that other processes can receive."""
    from functools import partial

    return partial(function, *arguments)


def difference(result: cl.Result, a: str, b: str) -> dict[str, Any]:
    """Return the paired difference of two laws in the settled velocity."""
    here = result.data.to_dataset().sel(quantity="rotor_velocity", law=a, other_law=b).isel(cell=0)
    shares = dict(zip(here["sign"].values.tolist(), here["sign_share"].values.tolist(), strict=True))
    return {
        "draws": int(result.data.sizes["draw"]),
        "order": VERDICTS[int(here["order"])],
        "bases": [
            {"mean": float(mean), "deviation": float(deviation)}
            for mean, deviation in zip(here["basis_mean"].values, here["basis_deviation"].values, strict=True)
        ],
        "shares": shares,
        "numerical_error": float(here["difference_error"]),
    }


def pool_of(laws: Mapping[str, cl.Setup], priors: Mapping[str, Distribution]) -> np.ndarray:
    """Return settled velocities over draws that serve all laws, shape (law, draw)."""
    factors = factors_of([run_of_setup(name, setup) for name, setup in laws.items()], priors)
    draws = drawn(factors, POOL)
    cases = {
        f"{name} {i}": delayed_call(velocity_of, configuration_of(setup, factors, draw))
        for i, draw in enumerate(draws)
        for name, setup in laws.items()
    }
    return np.reshape([*every(cases).values()], (POOL, len(laws))).T


def velocity_of(configuration: dict[str, Any]) -> float:
    """Return the settled velocity of a motor; NaN where there is none."""
    try:
        return observed(cl.build(configuration), ("rotor_velocity",))[1]["rotor_velocity"].value
    except (BrokenOffError, NotSettledError):
        return float("nan")


def world(
    laws: Mapping[str, cl.Setup], errors: Mapping[str, float], priors: Mapping[str, Distribution]
) -> dict[str, Any]:
    """Return how often the rule of pairs, and the older one, are wrong, by pair of laws and number of draws.

    In each repetition one motor of the pool is the real one, where one law holds and others do not. A claim
    of an order is false if it does not hold in `AGREED` of the pool; it is wrong in the real motor if that
    has the other order, or none.
    """
    pool, names = pool_of(laws, priors), list(laws)
    nominal = np.array([velocity_of(dict(setup.configuration)) for setup in laws.values()])
    rng = np.random.default_rng(0)
    result: dict[str, Any] = {}
    for a, b in combinations(range(len(names)), 2):
        numerical = errors[names[a]] + errors[names[b]]
        apart, size = pool[a] - pool[b], np.maximum(np.abs(pool[a]), np.abs(pool[b]))
        signs = np.where(np.abs(apart) <= np.maximum(CLEAR * numerical, MARGIN * size), 0.0, np.sign(apart))
        signs[~np.isfinite(apart)] = np.nan
        shares = {sign: float((signs == sign).sum() / np.isfinite(signs).sum()) for sign in (1.0, -1.0, 0.0)}
        counts = {str(n): dict.fromkeys(OUTCOMES, 0) for n in (16, 32, 64)}
        for _ in range(REPETITIONS):
            chosen = rng.permutation(np.flatnonzero(np.isfinite(signs)))
            true, rest = signs[chosen[0]], chosen[1:]
            for n, count in counts.items():
                some = rest[: int(n)]
                verdict = sequential(signs[some], int(n))
                claim = {GREATER: 1.0, LESS: -1.0, EQUAL: 0.0}.get(verdict)
                if claim is None:
                    count["varies" if verdict == VARIES else "inconclusive"] += 1
                    count["false"] += int(verdict == VARIES and max(shares.values()) >= AGREED)
                else:
                    count["right" if claim == true else "wrong"] += 1
                    count["false"] += int(shares[claim] < AGREED)
                moved = np.abs(pool[[a, b]][:, some] - nominal[[a, b], None]).max()
                if abs(nominal[a] - nominal[b]) > max(moved, CLEAR * numerical):
                    old = np.sign(nominal[a] - nominal[b])
                    count["older rule right" if old == true else "older rule wrong"] += 1
        signed = {name: shares[sign] for name, sign in (("+", 1.0), ("-", -1.0), ("0", 0.0))}
        result[f"{names[a]} less {names[b]}"] = {"shares": signed, "draws": counts}
    return result


def sequential(signs: np.ndarray, most: int) -> int:
    """Return the verdict of looks at growing draws."""
    looks = looks_up_to(most)
    for look in looks:
        verdict = int(orders(signs[None, :look], len(looks)).verdict[0])
        if verdict != INCONCLUSIVE:
            break
    return verdict


def four_shapes() -> dict[str, Any]:
    """Return three laws on the paper's basis."""
    return table(("stick", "newton", "hertz"), [], BOTH)


def by_phase() -> dict[str, Any]:
    """Return laws on the converged beam over the phase of the drive."""
    keys = {"configured" if phase is None else str(phase): phase for phase in PHASES}
    return {
        name: table(LAWS, [*CONVERGED, *([] if phase is None else [f"drive.phase={phase}"])], BOTH)
        for name, phase in keys.items()
    }


def by_damping() -> dict[str, Any]:
    """Return laws on the converged beam over damping, at equal free amplitude of the tip."""
    result = {}
    for damping in DAMPING:
        overrides = at_equal_amplitude(damping)
        result[damping] = {
            "overrides": overrides,
            "damping_ratio": cl.build(overrides).motor.modes.damping_ratio[:2].tolist(),
            **table([law for law in LAWS if law != "poisson"], overrides, ("rotor_velocity",)),
        }
    return result


def with_rod() -> dict[str, Any]:
    """Return laws on the converged beam whose tip is a rod that bends."""
    overrides = [*CONVERGED, "resonator.rod_length=19 mm"]
    frequencies = cl.build(overrides).motor.modes.natural_frequency[:3].tolist()
    return {"natural_frequency": frequencies, **table(("stick", "newton", "hertz"), overrides, BOTH)}


def pair_on_both_bases() -> dict[str, Any]:
    """Return the paired comparison of the default motor."""
    pair = [cl.build([f"law={law}"]) for law in ("lagrange_stick", "hertz_penalty")]
    result = cl.compare(pair, samples=64, starts=1, workers=processors(), observe=["rotor_velocity"])
    return difference(result, "lagrange_stick", "hertz_penalty")


def synthetic_world() -> dict[str, Any]:
    """Return error rates of the rules on the converged beam, under several priors."""
    setups = {law: cl.build([*CONVERGED, *LAWS[law]]) for law in ("stick", "newton", "poisson", "hertz")}
    stiffness = setups["hertz"].configuration["law"]["stiffness"]
    setups["stiffer"] = cl.build([*CONVERGED, *LAWS["hertz"], f"law.stiffness={STIFFER * stiffness!r}"])
    here = table([law for law in LAWS if law in setups], CONVERGED, ("rotor_velocity",))
    errors = {law: here.get(law, here["hertz"])["rotor_velocity_error"] for law in setups}
    return {name: world(setups, errors, priors) for name, priors in PRIORS.items()}


SECTIONS: Final[dict[str, Callable[[], dict[str, Any]]]] = {
    "four shapes": four_shapes,
    "converged, by phase": by_phase,
    "converged, by damping ratio at equal free amplitude": by_damping,
    "converged, with a rod": with_rod,
    "stick less hertz": pair_on_both_bases,
    "synthetic world": synthetic_world,
}


def main() -> None:
    """Compute the sections that are named, or all, and write the file."""
    results = json.loads(RESULTS.read_text()) if RESULTS.is_file() else {}
    for name in sys.argv[1:] or SECTIONS:
        results[name] = SECTIONS[name]()
        results["versions"] = versions()
        RESULTS.parent.mkdir(parents=True, exist_ok=True)
        RESULTS.write_text(json.dumps(results, indent=1) + "\n")
        print(name, flush=True)


if __name__ == "__main__":
    main()
