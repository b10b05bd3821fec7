"""Processes of a page: what is no longer wanted ends, a fault is a sentence, a dead process is replaced."""

import asyncio
import os
import signal
from collections.abc import Iterator
from dataclasses import replace

import psutil
import pytest

import contactlab as cl
from contactlab_explorer.pictures import approach, pictures
from contactlab_explorer.pool import FAULT, STOPPED, Pool
from contactlab_explorer.state import State

NEWTON = State(cl.build(["law=newton"]))
"""A motor that is ready within milliseconds."""

LONG = State(cl.build(["law=newton", "contact.clearance=0.1 mm", "solver.duration=1e5", "record.interval=1"]))
"""A motor without an orbit, whose run takes hours."""


@pytest.fixture(scope="module")
def pool() -> Iterator[Pool]:
    pool = Pool(1)
    yield pool
    pool.close()


def test_a_new_ticket_ends_the_work_of_the_one_before(pool: Pool) -> None:
    async def work() -> tuple[object, dict[str, object]]:
        page = pool.page()
        long = asyncio.ensure_future(pool.work(page, pool.ticket(page), approach, LONG, "newton"))
        await asyncio.sleep(3.0)
        assert not long.done()
        ticket = pool.ticket(page)
        ended = await asyncio.wait_for(long, 30.0)
        after = await pool.work(page, ticket, pictures, NEWTON, "newton")
        pool.leave(page)
        return ended, after

    ended, after = asyncio.run(work())
    assert ended == {STOPPED: True}
    assert after == pictures(NEWTON, "newton")


def test_what_is_refused_and_a_process_that_died_are_sentences(pool: Pool) -> None:
    async def work() -> list[dict[str, str]]:
        page = pool.page()
        ticket = pool.ticket(page)
        bad = replace(NEWTON, numbers={"law.restitution@newton": 2.0})
        pictured = [await pool.work(page, ticket, pictures, bad, "newton")]
        dying = asyncio.ensure_future(pool.work(page, ticket, approach, LONG, "newton"))
        await asyncio.sleep(0.5)
        for child in psutil.Process().children():
            if "spawn_main" in " ".join(child.cmdline()):
                os.kill(child.pid, signal.SIGKILL)
        pictured.append(await dying)
        pictured.append(await pool.work(page, ticket, pictures, NEWTON, "newton"))
        return pictured

    refused, died, after = asyncio.run(work())
    assert "law.restitution" in refused[FAULT]
    assert FAULT in died
    assert after == pictures(NEWTON, "newton")
