"""`contactlab verify` tells every claim and its verdict, and its exit status is the verdict on all."""

from collections.abc import Callable, Iterator

import pytest
from support.command_line import Command

from contactlab.testing import Claim, at_most, close

GROUPS = "contactlab.cli.verbs.verify.all_claims"


@pytest.mark.long
def test_the_contract_of_every_installed_law_holds(command: Command) -> None:
    status, out, _ = command("verify")
    assert status == 0
    rows = out.splitlines()
    assert sum(row.endswith("holds") for row in rows) > 150
    # What the law that always slips declares to break is broken, and shown.
    assert sum(row.endswith("broken, as declared") for row in rows) >= 5
    assert "0 fail" in rows[-1]


@pytest.mark.parametrize(
    ("claim", "status", "text"),
    [
        (close("a true one", 1.0, 1.0, 1e-9), 0, "1 hold"),
        (close("a false one", 1.1, 1.0, 1e-9), 1, "Failed: a false one: 1.1"),
        (close("not a number", float("nan"), 1.0, 1.0), 1, "1 fail"),
        (at_most("a broken one", 2.0, 1.0).excused("it says so"), 0, "1 are broken"),
        (at_most("a kept one", 0.0, 1.0).excused("it says so"), 1, "HOLDS, declared broken"),
    ],
)
def test_the_exit_status_is_the_verdict(
    claim: Claim, status: int, text: str, monkeypatch: pytest.MonkeyPatch, command: Command
) -> None:
    def groups() -> Iterator[tuple[str, Callable[[], list[Claim]]]]:
        yield "One claim", lambda: [claim]

    monkeypatch.setattr(GROUPS, groups)
    result, out, _ = command("verify")
    assert result == status
    assert text in out
