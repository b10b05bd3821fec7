"""The page in Chromium, and the server at its port."""

import http.client
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import parse_qs, urlsplit

import psutil
import pytest
from support.command_line import Command

import contactlab as cl
from contactlab_explorer.scales import value_at

chromium = shutil.which("chromium")
in_chromium = pytest.mark.skipif(chromium is None, reason="there is no Chromium here")

READY = "[data-state=ready]"
PATIENCE = 120_000
"""Time for a page, with the compiler's, on a machine that does more [ms]."""


@contextmanager
def served(*words: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Start the command, and yield its link and its process."""
    line = [sys.executable, "-m", "contactlab", "explore", "browser=false", *words]
    environment = {
        key: value for key, value in os.environ.items() if not key.startswith(("PYTEST", "NICEGUI"))
    }
    process = subprocess.Popen(line, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        link = re.search(r"http://\S+", process.stdout.readline())
        assert link is not None
        yield link[0], process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(30)
        assert process.stdout is not None
        process.stdout.close()


@pytest.fixture(scope="module")
def link() -> Iterator[str]:
    with served("law=newton,hertz_penalty") as (url, _):
        yield url


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api")
    with api.sync_playwright() as play:
        opened = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        yield opened
        opened.close()


def opened(browser: Any, url: str, width: int = 1400, scheme: str = "light") -> Any:
    """Open a page in a session of its own, and wait until it is complete."""
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
    page = context.new_page()
    page.errors = []
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    page.outside = []
    page.on(
        "request",
        lambda r: "127.0.0.1" in r.url or r.url.startswith(("data:", "blob:")) or page.outside.append(r.url),
    )
    page.goto(url)
    page.locator(READY).wait_for(timeout=PATIENCE)
    return page


def press(page: Any, key: str, *keys: str) -> None:
    """Press keys on a slider, as a hand does."""
    thumb = page.locator(f'[data-key="{key}"] [tabindex]').first
    thumb.focus()
    for each in keys:
        page.keyboard.press(each)


def settle(page: Any) -> str:
    """Wait until all that was asked for is there, and return what is said."""
    page.wait_for_timeout(400)
    page.locator(READY).wait_for(timeout=PATIENCE)
    return str(page.locator("[role=status]").inner_text())


def number(page: Any, key: str) -> float:
    return float(page.locator(f'input[data-number="{key}"], [data-number="{key}"] input').first.input_value())


def request(link: str, path: str, **headers: str) -> tuple[int, str]:
    """Return the status of a request, and the cookie that it gives."""
    place = urlsplit(link)
    connection = http.client.HTTPConnection(str(place.hostname), place.port, timeout=30)
    try:
        connection.request("GET", path, headers=headers)
        with connection.getresponse() as response:
            return response.status, str(response.getheader("set-cookie")).partition(";")[0]
    finally:
        connection.close()


def test_the_server_is_this_machines_and_opens_by_its_link_alone(link: str) -> None:
    place = urlsplit(link)
    token = parse_qs(place.query)["token"][0]
    assert len(token) >= 32
    listening = {
        each.laddr.ip
        for each in psutil.net_connections()
        if each.status == "LISTEN" and each.laddr.port == place.port
    }
    assert listening == {"127.0.0.1"}
    status, cookie = request(link, f"/?token={token}")
    assert (status, request(link, "/", Cookie=cookie)[0]) == (303, 200)
    for headers in (
        {},
        {"Cookie": cookie, "Host": "evil.example"},
        {"Cookie": cookie, "Origin": "http://evil.example"},
    ):
        assert request(link, "/", **headers)[0] in (400, 403)
    # The socket of the page, as another origin's script would open it, and as its own does.
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
    upgrade |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
    path = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    own = f"http://{place.netloc}"
    assert request(link, path, **upgrade, Origin=own)[0] == 403
    assert request(link, path, **upgrade, Cookie=cookie, Origin="http://evil.example")[0] == 403
    assert request(link, path, **upgrade, Cookie=cookie, Origin=own)[0] == 101


@pytest.mark.parametrize(
    "word",
    [
        "law=nutton",
        "law=newton,poisson,johnson,hertz_penalty,lagrange_stick",
        "law.restitution=2",
        "see=films",
        "port=x",
    ],
)
def test_what_is_refused_is_a_sentence(command: Command, word: str) -> None:
    status, out, errors = command("explore", "browser=false", word)
    assert (status, out) == (2, "")
    assert word.partition("=")[0] in errors


def test_a_port_that_is_taken_is_refused(command: Command) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        status, _, errors = command("explore", f"port={taken.getsockname()[1]}")
    assert status == 2
    assert "port" in errors


@in_chromium
@pytest.mark.long
@pytest.mark.parametrize("view", ["motor", "path", "impact"])
def test_every_slider_moves_its_number(browser: Any, link: str, view: str) -> None:
    page = opened(browser, f"{link}&view={view}")
    collapsed = page.locator(".q-expansion-item--collapsed > .q-expansion-item__container > .q-item")
    while collapsed.count():
        collapsed.first.click()
        page.wait_for_timeout(100)
    page.wait_for_timeout(600)
    keys = [each.get_attribute("data-key") for each in page.locator("[data-key]").all()]
    assert len(keys) >= (35 if view == "motor" else 5)
    for key in keys:
        field = page.locator(f'input[data-number="{key}"], [data-number="{key}"] input').first
        before = field.input_value()
        at_end = page.locator(f'[data-key="{key}"]').first.get_attribute("aria-valuenow") == "200"
        press(page, key, "ArrowLeft" if at_end else "ArrowRight")
        page.wait_for_function(
            "([e, v]) => e.value !== v", arg=[field.element_handle(), before], timeout=PATIENCE
        )
        # A motor without contact, or without an orbit, is a sentence and no end of the page.
        press(page, key, "ArrowRight" if at_end else "ArrowLeft")
    settle(page)
    assert page.errors == []


@in_chromium
@pytest.mark.long
def test_four_laws_stand_side_by_side_and_a_fifth_is_left_out(browser: Any, link: str) -> None:
    four = "newton,hertz_penalty,lagrange_stick,friction/dahl"
    page = opened(browser, f"{link}&laws={four},poisson")
    said = settle(page)
    for law in four.split(","):
        velocity = cl.orbit(cl.build().with_(_options(law))).velocity.value
        assert f"{law}: periodic, {velocity:.5g} rad/s" in said
    assert "poisson" not in said
    assert page.outside == page.errors == []


def _options(law: str) -> dict[str, str]:
    from contactlab_explorer.state import options_of

    return options_of(law)


@in_chromium
@pytest.mark.long
@pytest.mark.parametrize("width", [400, 1400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_wider_than_the_window(browser: Any, link: str, width: int, scheme: str) -> None:
    page = opened(browser, f"{link}&laws=newton,hertz_penalty,friction/dahl", width, scheme)
    page.get_by_text("command, Python, YAML").click()
    page.wait_for_timeout(600)
    assert page.evaluate("document.documentElement.scrollWidth") == width
    assert page.locator("canvas").count() == 6


@in_chromium
@pytest.mark.long
def test_of_100_quick_changes_the_last_one_wins_and_another_session_is_as_it_was(
    browser: Any, link: str
) -> None:
    page, other = opened(browser, f"{link}&laws=newton"), opened(browser, f"{link}&laws=newton")
    before = settle(other)
    # From the middle, 100 V: 60 up and 40 down are 20 V up.
    press(page, "drive.voltage_1", *["ArrowRight"] * 60, *["ArrowLeft"] * 40)
    due = cl.build(["law=newton"]).numbers()["drive.voltage_1"]
    velocity = cl.orbit(cl.build(["law=newton", "drive.voltage_1=120"])).velocity.value
    page.get_by_text(f"{velocity:.5g} rad/s").wait_for(timeout=PATIENCE)
    # And nothing that was asked for before comes after it.
    said = settle(page)
    assert f"{velocity:.5g} rad/s" in said
    assert number(page, "drive.voltage_1") == value_at(due, 120) == 120.0
    assert settle(other) == before
    assert number(other, "drive.voltage_1") == 100.0
    # The link in the address bar is the state; the token is not in it.
    assert "token" not in page.url
    again = page.context.new_page()
    again.goto(page.url)
    again.locator(READY).wait_for(timeout=PATIENCE)
    assert settle(again) == said
    page.get_by_role("button", name="undo").click()
    page.get_by_text(before).wait_for(timeout=PATIENCE)
    assert number(page, "drive.voltage_1") == 100.0


@in_chromium
@pytest.mark.long
def test_a_refused_number_is_a_sentence_at_its_slider(browser: Any, link: str) -> None:
    page = opened(browser, f"{link}&laws=newton")
    field = page.locator(
        'input[data-number="law.restitution@newton"], [data-number="law.restitution@newton"] input'
    ).first
    field.fill("1.5")
    field.press("Enter")
    page.get_by_role("alert").filter(has_text="law.restitution").wait_for(timeout=PATIENCE)
    field.fill("0.25")
    field.press("Enter")
    velocity = cl.orbit(cl.build(["law=newton", "law.restitution=0.25"])).velocity.value
    page.get_by_text(f"{velocity:.5g} rad/s").wait_for(timeout=PATIENCE)
    assert page.get_by_role("alert").filter(has_text="law.restitution").count() == 0


@in_chromium
@pytest.mark.long
def test_a_run_and_a_figure_are_saved_by_the_browser(browser: Any, link: str, tmp_path: Any) -> None:
    page = opened(browser, f"{link}&laws=newton")
    for kind in ("run.nc", "run.png"):
        with page.expect_download(timeout=PATIENCE) as download:
            page.get_by_role("button", name=kind).click()
        download.value.save_as(tmp_path / kind)
    assert cl.load(tmp_path / "run.nc").setup == cl.build(["law=newton"])
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


@in_chromium
@pytest.mark.long
def test_a_server_that_has_ended_is_said(browser: Any) -> None:
    with served("law=newton") as (link, process):
        page = opened(browser, link)
        process.kill()
        page.get_by_text("Connection lost").wait_for(timeout=30000)
