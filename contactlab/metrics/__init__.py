"""Metrics of a run, with thresholds and reasons, from the recorded numbers alone.

The catalogues keep the order of the modules that are imported here, and of the functions in them.
"""

from contactlab.metrics import balances, constraints, response
from contactlab.metrics.catalogue import (
    FAIL,
    INVARIANTS,
    METRICS,
    NOT_APPLICABLE,
    PASS,
    REPORTED,
    SENSITIVITIES,
    STEP_METRICS,
    VERDICTS,
    Metric,
    add_others,
    assess,
    brief,
    metric,
)
from contactlab.metrics.convergence import assess_steps, assess_variants
from contactlab.metrics.run import NotApplicableError, Run, is_complete, needed, read_run

add_others()
