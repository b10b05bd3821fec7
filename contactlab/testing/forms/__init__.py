"""Every closed form that the engine is held to; each is a function that yields claims."""

from contactlab.testing.forms import compositions, impacts, oscillations, rubbing

CLOSED_FORMS = (*impacts.CLAIMS, *oscillations.CLAIMS, *rubbing.CLAIMS, *compositions.CLAIMS)
