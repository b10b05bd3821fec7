"""The numbers on the page on comparison are those of the file of results that a script makes."""

from claims import results
from support.page_numbers import text_of

RESULTS = results("motor")
"""Made by experiments/motor_findings.py."""


def test_the_pair_in_two_populations() -> None:
    """Both have no order; the motors that are damped most have one."""
    page = text_of("howto/compare.md")
    for name, pair in RESULTS["stick and hertz"].items():
        times, quarters = pair["outcomes"], pair["quarters"]
        counts = " | ".join(str(times[kind]) for kind in ("greater", "less", "equal", "none"))
        damped = "; ".join(f"{each['greater']}, {each['less']}" for each in quarters)
        label = "damping ratio 0.002 to 0.2" if name == "by default" else name
        assert f"| {label} | {counts} | {pair['order']} | {damped} |" in page
        assert sum(times.values()) == 64
        assert pair["order"] == "varies"
        assert quarters[-1]["less"] <= 1
        assert "damping" in pair["factor"]
        assert pair["share"] > pair["by chance"]
        assert f"{pair['share']:.3f}" in page
        assert f"{pair['by chance']:.3f}" in page
        assert f"faster by {100.0 * pair['relative']['nominal']:.0f} %" in page


def test_the_error_rates_in_known_worlds() -> None:
    page = text_of("howto/compare.md")
    for name, world in RESULTS["known worlds"].items():
        for pairs, rates in world.items():
            row = (
                f"| {name} | {pairs} | {100.0 * rates['any wrong']:.1f} % | {100.0 * rates['known']:.0f} % |"
            )
            assert row in page
            assert rates["any wrong"] <= 0.05
