"""Make docs/plausibility.md from the declarations of the metrics.

    python docs/tools/metric_page.py [--output DIR]

A test makes the text again and compares, so that the page cannot go stale.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
# Where Sphinx has its extensions.
sys.path.insert(0, str(DOCS / "extensions"))
import equations  # noqa: E402
import page_tables  # noqa: E402

from contactlab.metrics import METRICS, SENSITIVITIES, STEP_METRICS, Metric  # noqa: E402

PAGE = "plausibility.md"

OPENING = """\
# Plausibility

<!-- Made by docs/tools/metric_page.py from the metrics themselves. Do not edit. -->

What `contactlab.metrics` and `contactlab compare` judge a contact law by, from recorded numbers alone.
A threshold comes with its reason; a metric without one is reported. Metrics that need quantities missing from
a dataset are reported as not applicable.
"""

TABLES = {
    "One run (`assess`)": METRICS,
    "A hierarchy of contact steps or tolerances (`assess_steps`)": STEP_METRICS,
    "A run and its variants (`assess_variants`)": SENSITIVITIES,
}


def page() -> str:
    """The text of the page."""
    parts = [OPENING]
    for heading, metrics in TABLES.items():
        parts.append(f"## {heading}\n")
        parts += [entry(metric) for metric in metrics.values()]
    return "\n".join(parts)


def entry(metric: Metric) -> str:
    """What the page says of one metric."""
    unit = f" ({label})" if (label := page_tables.unit(metric.units)) else ""
    lines = [f"### `{metric.key}`", "", f"{metric.meaning[0].upper()}{metric.meaning[1:]}{unit}.", ""]
    lines += [f"$$\n{line}\n$$\n" for line in equations.lines(metric.symbol)]
    if metric.threshold:
        lines += [f"* must be {metric.threshold}: {metric.reason}."]
        lines += [f"* beyond it: {metric.conclusion}."]
    if metric.source:
        lines += [f"* source: {metric.source}"]
    return "\n".join([*lines, ""])


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the page; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=DOCS)
    folder: Path = parser.parse_args(arguments).output
    (folder / PAGE).write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
