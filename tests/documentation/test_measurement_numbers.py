"""Every number that the page on measurements states is that of its file of results.

A claim is a sentence of the page with places for numbers, and the keys of these in the results.
"""

import measurement_results
import pytest
from support.page_numbers import DOCS, results_of, stated, text_of

SPRING, CONE = "laws/hertz_point + flores + mindlin/error", "laws/hertz_point + flores + coulomb/error"
CASES = ("as measured", "inertia", "arms", "tilt and inertia")


def of(case: str, law: str) -> str:
    """Return the key of a law's error with some numbers of the geometry free."""
    return f"geometry/{case}/laws/{law}/error"


def gain(case: str) -> str:
    """Return the key of what `mindlin` gains over Poisson's law."""
    return f"geometry/{case}/mindlin before poisson/gain"


def fitted(case: str, name: str) -> str:
    """Return the key of a number of the geometry under Poisson's law."""
    return f"geometry/{case}/laws/poisson/parameters/data.{name}"


ELLIPSES = [
    ("{:.0f} impacts carry one of the authors' quality flags; {:.0f} remain", "left out", "impacts"),
    ("a prediction of no change scores {:.2f}", "error without change"),
    ("approach at {:.1f} to {:.1f} m/s", "approach/least", "approach/greatest"),
    ("up to {:.0f} degrees from the normal", "largest incidence"),
    (
        "Without friction the error is {:.4f}, with one impulse for all impacts {:.4f}",
        "laws/frictionless/error",
        "laws/constant impulse/error",
    ),
    (
        "Poisson's law has {:.4f}, Stronge's {:.4f}, Newton's {:.4f}",
        *(f"laws/{law}/error" for law in ("poisson", "stronge", "newton")),
    ),
    (
        "less than Newton's by {:.4f} as measured, {:.4f} with the inertia free, {:.4f} with the arms and "
        "{:.4f} with tilt and inertia",
        *(f"{of(case, 'newton')} - {of(case, 'poisson')}" for case in CASES),
    ),
    (
        "from {:.3f} at {:.2f} m/s to {:.3f} at {:.2f} m/s",
        "over slip/0/ratio",
        "over slip/0/slip",
        "over slip/7/ratio",
        "over slip/7/slip",
    ),
    (
        "a tangential spring (`mindlin`) has {:.4f}, {:.4f} less than the same normal force with Coulomb's "
        "cone",
        SPRING,
        f"{CONE} - {SPRING}",
    ),
    (
        "The spring is {:.1f} times as stiff as the normal one",
        "laws/hertz_point + flores + mindlin/parameters/friction.stiffness_ratio",
    ),
    (
        "Coulomb's cone leaves {:.4f}, a spring {:.4f} at a ratio of 1 and {:.4f} at 4, a patch with "
        "microslip {:.4f} and {:.4f}",
        *(
            f"stiffness ratio/{name}"
            for name in ("coulomb", "mindlin 1", "mindlin 4", "microslip 1", "microslip 4")
        ),
    ),
    (
        "With offsets of {:.1f} mm and {:.1f} mm of the normal and the tangential arm Poisson's rigid law "
        "has {:.4f}",
        fitted("arms", "normal_arm") + " * 1000",
        fitted("arms", "tangential_arm") + " * 1000",
        of("arms", "poisson"),
    ),
    ("what `mindlin` gains over it falls from {:.4f} to {:.4f}", gain("as measured"), gain("arms")),
    (
        "A tilt of {:.3f} rad and {:.2f} times the inertia leave {:.4f} and a gain of {:.4f}",
        fitted("tilt and inertia", "tilt"),
        fitted("tilt and inertia", "inertia"),
        of("tilt and inertia", "poisson"),
        gain("tilt and inertia"),
    ),
    (
        "With {:.2f} times the inertia alone Poisson's law has {:.4f} and the gain is {:.4f}",
        fitted("inertia", "inertia"),
        of("inertia", "poisson"),
        gain("inertia"),
    ),
    (
        "Of {:.0f} pairs of laws {:.0f} are distinct after the correction, {:.0f} by their own intervals",
        "pairs/all",
        "pairs/distinct",
        "pairs/distinct alone",
    ),
    (
        "No law explains {:.0f} impacts; noise alone may account for {:.0f} of them",
        "unexplained/observed",
        "unexplained/by noise",
    ),
    (
        "have a correlation of {:.2f}, and the half-width of its interval is {:.4f}, with blocks of 10 "
        "impacts {:.4f}, of 50 {:.4f}",
        "correlation of neighbours",
        "half-width/1",
        "half-width/10",
        "half-width/50",
    ),
    ("The best impulse of each impact leaves {:.4f}", "laws/best impulse/error"),
    (
        "the least error in the table is that of `mindlin` with it, {:.4f}",
        of("inertia", "hertz_point + flores + mindlin"),
    ),
]


def sphere(law: str, name: str = "all") -> str:
    """Return the key of a number of the spheres."""
    return f"laws/{law}/{name}"


SPHERES = [
    ("kappa = 4 G*/E* = {:.3f}", "stiffness_ratio"),
    ("Any curve that is free at 8 incidences misses by {:.2f} errors", sphere("any curve")),
    ("differ in their incidences by {:.1f} degrees (standard deviation)", "scatter_of_incidence"),
    ("{:.1f} errors of digitisation for `coulomb`", sphere("coulomb")),
    (
        "`mindlin` falls to {:.3f} at {:.1f} degrees and misses by {:.1f} errors",
        sphere("mindlin", "lowest"),
        sphere("mindlin", "at"),
        sphere("mindlin"),
    ),
    (
        "`microslip` falls to {:.3f} at {:.1f} degrees and misses by {:.2f} errors, by {:.2f} with both axes",
        sphere("microslip", "lowest"),
        sphere("microslip", "at"),
        sphere("microslip"),
        sphere("microslip", "both axes"),
    ),
    ("a foundation of 200 springs misses by {:.2f}", sphere("200 springs")),
    (
        "`elasto_plastic` goes from {:.1f} to {:.1f} by that",
        sphere("elasto_plastic"),
        sphere("elasto_plastic", "mean stiffness"),
    ),
    ("`iwan` misses by {:.1f} or {:.1f}", sphere("iwan"), sphere("iwan", "mean stiffness")),
]

CLAIMS = [
    *(("measurements.md", "measurements", "ellipses/", claim) for claim in ELLIPSES),
    *(("measurements.md", "measurements", "spheres/", claim) for claim in SPHERES),
]
"""Page, results, what begins every key, and sentence with keys."""


@pytest.mark.parametrize(("page", "name", "before", "claim"), CLAIMS)
def test_a_page_states_the_numbers_of_its_results(
    page: str, name: str, before: str, claim: tuple[str, ...]
) -> None:
    text, *keys = claim
    assert stated(
        text, results_of(name), *(before + key.replace(" - ", f" - {before}") for key in keys)
    ) in text_of(page)


def test_the_tables_of_measurements_are_those_of_the_results() -> None:
    page = (DOCS / "measurements.md").read_text(encoding="utf-8")
    assert measurement_results.page_with(page, results_of("measurements")) == page
