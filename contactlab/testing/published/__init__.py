"""What is published of each law, as claims: a module a law or part, named by the law's own word.

    contactlab/testing/published/jkr.py

        def pull_off(work: float = 0.5, radius: float = 5e-3) -> Claims:
            '''A sphere comes off at 3/2 pi w R (Johnson, Kendall and Roberts 1971, eq. 20).'''
            yield close("jkr: pull-off force", found, expected, 1e-9, "N")

Nothing is registered: every public function of such a module that is annotated with `Claims` is run by the
tests and by `contactlab verify`; the first claim of the first one stands in docs/law_table.md. Where parts
of two families have one word the module has the family's before it, as `damping_linear`.
"""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Final

from contactlab.testing import closed_forms as closed
from contactlab.testing.claim import Claim, Proof, proofs_of

SHARED: Final[Mapping[str, tuple[Proof, ...]]] = {
    "hertz_penalty": (closed.hertz_impact, closed.oblique_impacts),
    "lagrange_stick": (closed.oblique_impacts, closed.modal_impacts, closed.stops),
    "lagrange_slip": (closed.oblique_impacts, closed.modal_impacts),
    **dict.fromkeys(
        ("newton", "poisson", "stronge", "moreau_jean"),
        (closed.modal_impacts, closed.oblique_impacts, closed.bouncing_ball),
    ),
    "hertz_point": (closed.hertz_impact, closed.achieved_restitution),
    "normal_linear": (closed.bilinear_oscillator, closed.achieved_restitution),
    "damping_linear": (closed.dashpot_impacts, closed.achieved_restitution),
    **dict.fromkeys(("hunt_crossley", "lankarani_nikravesh", "flores"), (closed.achieved_restitution,)),
    "coulomb": (closed.belt_stick_slip, closed.stops, closed.friction_oscillator),
    "regularised": (closed.regularised_creep,),
    "mindlin": (closed.spring_and_slider,),
    "lugre": (closed.bristles,),
}
"""Closed forms that several laws share, by law or part."""


@cache
def published() -> dict[str, dict[str, Proof]]:
    """Return the proofs of every module here by its name, and by that of the function."""
    names = sorted(result.name for result in iter_modules(__path__))
    return {name: proofs_of(import_module(f"{__name__}.{name}")) for name in names}


def published_of(name: str, family: str = "") -> tuple[Proof, ...]:
    """Return the proofs of a law, or of a part of a family, its own first; none where there is none."""
    own: list[Proof] = []
    for known in (f"{family}_{name}", name):
        own += published().get(known, {}).values()
        own += SHARED.get(known, ())
    return tuple(own)


def headline(name: str, family: str = "") -> Claim | None:
    """Return the first claim that names a law, or else the first of its first proof; None without any."""
    proofs = published_of(name, family)
    claims = list(proofs[0]()) if proofs else []
    return next((claim for claim in claims if name in claim.statement), claims[0] if claims else None)
