"""Numbers on the motor that README, steady.md, paper.md and the page on comparison state, in one file.

    python experiments/motor_findings.py [FILE]

Settled velocities under laws on two bases, over phase and damping; the paired comparison of the default
motor; and a synthetic world, in which one law is true, with the rule of pairs beside the older rule on the
same draws. It takes about half an hour on two cores.
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
from contactlab.inference.paired import EQUAL, GREATER, INCONCLUSIVE, LESS, VERDICTS, looks_up_to, orders
from contactlab.metrics.convergence import FINER, control_of
from contactlab.processes import processors
from contactlab.results.provenance import versions
from contactlab.steady_state import BrokenOffError, NotSettledError
from contactlab.studies.compare_draws import configuration_of, drawn, factors_of
from contactlab.studies.compare_observables import observed
from contactlab.studies.compare_pairs import CLEAR, MARGIN
from contactlab.studies.compare_runs import run_of_setup

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

POOL: Final = 256
REPETITIONS: Final = 200
STIFFER: Final = 1.02
"""Factor of the stiffness of a law that is hardly another one."""


def settled(overrides: list[str], names: tuple[str, ...] = ("rotor_velocity",)) -> dict[str, Any]:
    """Return kind and quantities of a settled motor at the finest of three steps, with numerical errors."""
    setup = cl.build(overrides)
    control = control_of(setup.law)
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


def pool_of(laws: Mapping[str, cl.Setup]) -> np.ndarray:
    """Return settled velocities over draws that serve all laws, shape (law, draw)."""
    factors = factors_of([run_of_setup(name, setup) for name, setup in laws.items()], {})
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


def world(laws: Mapping[str, cl.Setup], errors: Mapping[str, float]) -> dict[str, Any]:
    """Return how often the rule of pairs, and the older one, are wrong in a motor that was not drawn.

    In each repetition one motor of the pool is the real one, where one law holds and others do not. The order
    of two laws that the draws state is wrong if the real motor has the other one, or none.
    """
    pool, names = pool_of(laws), list(laws)
    nominal = np.array([velocity_of(dict(setup.configuration)) for setup in laws.values()])
    rng = np.random.default_rng(0)
    result: dict[str, Any] = {}
    for a, b in combinations(range(len(names)), 2):
        numerical = errors[names[a]] + errors[names[b]]
        apart = pool[a] - pool[b]
        size = np.maximum(np.abs(pool[a]), np.abs(pool[b]))
        signs = np.where(np.abs(apart) <= np.maximum(CLEAR * numerical, MARGIN * size), 0.0, np.sign(apart))
        signs[~np.isfinite(apart)] = np.nan
        counts = {
            n: dict.fromkeys(("right", "wrong", "inconclusive", "old right", "old wrong"), 0)
            for n in (16, 32, 64)
        }
        for _ in range(REPETITIONS):
            chosen = rng.permutation(np.flatnonzero(np.isfinite(signs)))
            true, rest = signs[chosen[0]], chosen[1:]
            for n, count in counts.items():
                verdict = sequential(signs[rest[:n]], n)
                claim = {GREATER: 1.0, LESS: -1.0, EQUAL: 0.0}.get(verdict)
                count["inconclusive" if claim is None else "right" if claim == true else "wrong"] += 1
                moved = np.abs(pool[[a, b]][:, rest[:n]] - nominal[[a, b], None]).max()
                if abs(nominal[a] - nominal[b]) > max(moved, CLEAR * numerical):
                    old = np.sign(nominal[a] - nominal[b])
                    count["old right" if old == true else "old wrong"] += 1
        shares = {str(x): float(np.nanmean(signs == x)) for x in (1, -1, 0)}
        result[f"{names[a]} less {names[b]}"] = {
            "signs": shares,
            "draws": {str(n): c for n, c in counts.items()},
        }
    return result


def sequential(signs: np.ndarray, most: int) -> int:
    """Return the verdict of looks at growing draws."""
    looks = looks_up_to(most)
    for look in looks:
        verdict = int(orders(signs[None, :look], len(looks)).verdict[0])
        if verdict != INCONCLUSIVE:
            break
    return verdict


def main() -> None:
    """Compute everything and write the file."""
    file = Path(sys.argv[1]) if sys.argv[1:] else RESULTS
    three = ("stick", "newton", "hertz")
    results: dict[str, Any] = {"versions": versions()}

    def add(name: str, value: Any) -> None:
        results[name] = value
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(results, indent=1, allow_nan=True) + "\n")
        print(name, json.dumps(value)[:400], flush=True)

    both = ("rotor_velocity", "stall_torque")
    add("four shapes", table(three, [], both))
    phases = {}
    for phase in PHASES:
        key = [] if phase is None else [f"drive.phase={phase}"]
        phases["configured" if phase is None else str(phase)] = table(LAWS, [*CONVERGED, *key], both)
    add("converged, by phase", phases)
    dampings = {}
    for damping in DAMPING:
        overrides = at_equal_amplitude(damping)
        dampings[damping] = {
            "overrides": overrides,
            "damping_ratio": cl.build(overrides).motor.modes.damping_ratio[:2].tolist(),
            **table([law for law in LAWS if law != "poisson"], overrides, ("rotor_velocity",)),
        }
    add("converged, by damping ratio at equal free amplitude", dampings)
    pair = [cl.build([f"law={law}"]) for law in ("lagrange_stick", "hertz_penalty")]
    compared = cl.compare(pair, samples=64, starts=1, workers=processors(), observe=["rotor_velocity"])
    add("stick less hertz", difference(compared, "lagrange_stick", "hertz_penalty"))
    setups = {law: cl.build([*CONVERGED, *LAWS[law]]) for law in ("stick", "newton", "poisson", "hertz")}
    stiffness = setups["hertz"].configuration["law"]["stiffness"]
    setups["stiffer"] = cl.build([*CONVERGED, *LAWS["hertz"], f"law.stiffness={STIFFER * stiffness!r}"])
    errors = {
        law: phases["configured"].get(law, phases["configured"]["hertz"])["rotor_velocity_error"]
        for law in setups
    }
    add("synthetic world", world(setups, errors))


if __name__ == "__main__":
    main()
