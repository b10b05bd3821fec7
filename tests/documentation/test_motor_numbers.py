"""The numbers on the motor in the pages are those of the file of results that a script makes."""

import pytest
from support.page_numbers import results_of, text_of

RESULTS = results_of("motor")
"""Made by experiments/motor_findings.py."""

NAMES = {
    "stick": "`lagrange_stick`",
    "newton": "`newton`",
    "poisson": "`poisson`",
    "hertz": "`hertz_penalty`",
    "mindlin": "composed, `mindlin`",
}
PHASES = RESULTS["converged, by phase"]
DAMPINGS = RESULTS["converged, by damping ratio at equal free amplitude"]


@pytest.mark.parametrize("law", NAMES)
def test_the_table_over_phase(law: str) -> None:
    cells = [
        f"{table[law]['rotor_velocity']:.4f}, {1e3 * table[law]['stall_torque']:.3f}"
        for table in PHASES.values()
    ]
    assert f"| {NAMES[law]} | {' | '.join(cells)} |" in text_of("steady.md")


@pytest.mark.parametrize("damping", DAMPINGS)
def test_the_table_over_damping(damping: str) -> None:
    row = DAMPINGS[damping]
    cells = [
        "none" if row[law]["kind"] == "none"
        # A motion whose mean has an error of a hundredth has no digits to show.
        else "irregular" if row[law]["rotor_velocity_error"] > 0.01
        else f"{row[law]['rotor_velocity']:.4f}"
        for law in ("hertz", "stick", "newton", "mindlin")
    ]  # fmt: skip
    ratios = ", ".join(
        f"{ratio:.2g}" if ratio < 0.01 else f"{ratio:.3f}".rstrip("0") for ratio in row["damping_ratio"]
    )
    paper = " (paper)" if damping == "stiffness_damping=2e-5" else ""
    assert f"| `{damping}`{paper} | {ratios} | {' | '.join(cells)} |" in text_of("steady.md")


def test_the_velocities_of_the_front_page() -> None:
    page = text_of("../README.md")
    for basis, table in (("ritz", RESULTS["four shapes"]), ("finite_element", PHASES["configured"])):
        for law, name in (("stick", "lagrange_stick"), ("newton", "newton"), ("hertz", "hertz_penalty")):
            assert f"{basis} {name} {table[law]['rotor_velocity']:.4f} +- " in page


def test_how_far_the_laws_lie_apart() -> None:
    """As README says: the range of three laws over the mean of its ends."""
    apart = {}
    for phase, table in PHASES.items():
        every = sorted(table[law]["rotor_velocity"] for law in ("stick", "newton", "hertz"))
        apart[phase] = (every[-1] - every[0]) / (0.5 * abs(every[0] + every[-1]))
    assert apart["configured"] < 0.1
    assert f"at phase 0 they lie {100.0 * apart['0.0']:.0f} % apart" in text_of("../README.md")
    for name, row in DAMPINGS.items():
        speeds = {law: abs(row[law].get("rotor_velocity", 0.0)) for law in NAMES if law in row}
        slowest = name == "stiffness_damping=2e-5"
        assert (min if slowest else max)(speeds, key=speeds.__getitem__) == "hertz"


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


def test_the_tip_as_a_rod() -> None:
    rod, page = RESULTS["converged, with a rod"], text_of("steady.md")
    assert f"from 3.77 to {1e-3 * rod['natural_frequency'][1]:.2f} kHz" in page
    for law in ("hertz", "stick", "newton"):
        assert (
            f"{rod[law]['rotor_velocity']:.4f} (" in page
            or f"{rod[law]['rotor_velocity']:.4f} rad/s (" in page
        )


def test_rigid_laws_are_converged_as_the_page_says() -> None:
    for row in DAMPINGS.values():
        for law in ("stick", "newton"):
            error = row[law].get("rotor_velocity_error", 0.0)
            assert error > 0.01 or error <= 3e-4 * abs(row[law].get("rotor_velocity", 0.0))
