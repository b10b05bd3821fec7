"""Laws compared by the evidence of their fits.

Laws are compared by Bayes factors B = Z_1 / Z_2, by which the data change the odds of law 1 over law 2.
Evidence is of law and prior together: an even range that is ten times as wide takes ln 10 from a parameter
that the data determine. It ranks laws whether or not any is right, so odds are stated only between laws of
which the one with the larger evidence passes a posterior predictive check. Of least squares evidence is
Laplace's approximation, from which no odds follow.
"""

from collections.abc import Mapping
from math import exp, hypot, inf, isfinite, log
from typing import Final

import xarray

from contactlab.estimate import Estimate
from contactlab.studies.compare.repeats import MARGIN
from contactlab_data.inference.fit import ERRORS

LEAST: Final = log(3.0)
"""Smallest significant |ln B|."""

_STRENGTHS: Final = (
    (log(100.0), "decisive"),
    (log(30.0), "very strong"),
    (log(10.0), "strong"),
    (LEAST, "substantial"),
)


def strength(difference: float, error: float) -> str:
    """Return the word for a difference of ln Z of either sign; empty where it is not significant.

    Words of Jeffreys (1961), Theory of Probability, app. B.
    """
    size = abs(difference)
    if not size >= max(LEAST, ERRORS * error):
        return ""
    return next(word for limit, word in _STRENGTHS if size >= limit)


def misfits(fits: Mapping[str, xarray.DataTree]) -> dict[str, str]:
    """Return the laws that do not fit, by label, with p-value and share of the data in 90 % intervals."""
    result = {}
    for label, fit in fits.items():
        if (spread := fit.attrs["spread"]) > MARGIN:
            result[label] = f"no function of its inputs: its misfit differs by {100.0 * spread:.2g} %"
        elif not fit.attrs["fits"]:
            p = min(fit.attrs[name] for name in ("p_deviance", "p_succession") if name in fit.attrs)
            result[label] = f"p = {p:.3f}, {fit.attrs['coverage']:.1%} of the data in 90 % intervals"
    return result


def evidences_of(fits: Mapping[str, xarray.DataTree]) -> dict[str, Estimate]:
    """Return ln Z of the fits by label, in falling order; those without any last."""
    every = {
        label: Estimate(float(fit.attrs["log_evidence"]), float(fit.attrs["log_evidence_error"]))
        for label, fit in fits.items()
    }
    return dict(sorted(every.items(), key=lambda x: -x[1].value if isfinite(x[1].value) else inf))


def compared(fits: Mapping[str, xarray.DataTree]) -> list[str]:
    """Return which laws do not fit, then the law with the largest evidence beside each of the others."""
    (first, largest), *others = evidences_of(fits).items()
    result, failing = [], misfits(fits)
    if failing:
        head = "No fit within the noise"
        if others and len(failing) == len(fits):
            head = "No law here fits the data within the noise: evidence ranks misfits, and no odds follow"
        result.append(f"{head}: {'; '.join(f'{label} ({why})' for label, why in failing.items())}.")
    if any(fit.attrs["method"] == "least squares" for fit in fits.values()):
        return [*result, *by_misfit(fits)]
    for other, evidence in others:
        difference, error = largest.value - evidence.value, hypot(largest.error, evidence.error)
        shown = f"ln B = {Estimate(difference, error).text()}"
        if (bad := first) in failing or fits[bad := other].attrs["spread"] > MARGIN:
            result.append(
                f"{first} has a larger evidence than {other} ({shown}), from which no odds follow, as {bad} "
                "does not fit."
            )
        elif word := strength(difference, error):
            odds = f"{exp(difference):.3g}" if difference < log(1e6) else f"10^{difference / log(10.0):.0f}"
            result.append(
                f"The evidence for {first} against {other} is {word}: odds of {odds} to 1 ({shown})."
            )
        else:
            result.append(f"{first} and {other} are not distinguishable ({shown}).")
    return result


def by_misfit(fits: Mapping[str, xarray.DataTree]) -> list[str]:
    """Return the order of laws by their misfits, held out where known; of one law both."""
    misfit = {label: fit.attrs["misfit"] for label, fit in fits.items()}
    held_out = {label: fit.attrs["held_out_misfit"] for label, fit in fits.items()}
    kind, chosen = "held out", held_out
    if not all(map(isfinite, held_out.values())):
        kind, chosen = "of the fit", misfit
    shown = [f"{label} {x:.4g}" for label, x in sorted(chosen.items(), key=lambda item: item[1])]
    text = f"Root mean square of the residuals over their errors, {kind}: {', '.join(shown)}."
    return [text, *(["method=nested computes evidence, from which odds follow."] if len(fits) > 1 else [])]
