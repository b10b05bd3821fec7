"""Make the results that pages state, docs/results/*.json, and the pages with them.

    python experiments/remake.py [SECTION ...] [--spheres FILE] [--ellipses FILE] [--joint_friction FOLDER]
        [--velocity_steps FILE] [--law_contrasts FOLDER] [--law_practice FOLDER] [--all] [--short]

Sections that are not of the present code are made, each in a process of its own, as many at once as there
are processors; each is written when it is made, so that an interrupted command goes on. A section that fails
is named and leaves the others alone. Those of measurements need their file, the ellipses that of their
authors, and `law_contrasts` and `law_practice` the folder of their run, whole or under way, one motor of
which is computed again.
`--all` makes those of the present code too. `--short` makes short forms instead: where a short form reaches
all that has changed in the code and has the digits that it had, the section is noted as checked. Exit status
1 if one is left as it was, or has other digits.
"""

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, Final

from dependencies import ROOT, Recorder, digests
from ellipses import convert
from results_store import (
    CHECKED,
    DIFFERENT,
    PRESENT,
    by_module,
    code_of,
    covers,
    put,
    read,
    same,
    seal_of,
    state_of,
    text_of,
    write,
)

NEEDS: Final = ("spheres", "ellipses", "joint_friction", "velocity_steps", "law_contrasts", "law_practice")
"""Sections that need a file or folder of measurements, or of a run, by the option of this name."""


def make(file: str, name: str, source: Path, target: Path, short: bool) -> None:
    """Make a section in this process, recording what runs, and write it to a file."""
    begun = perf_counter()
    Recorder.start()
    from sections import FILES

    section = FILES[file](name)
    brief = section.short(source)
    ran, files = Recorder.ran(), Recorder.files()
    content: dict[str, Any] = {"ran": by_module(ran), "files": files, "results": brief}
    if not short:
        with TemporaryDirectory() as folder:
            results = section.make(source, Path(folder))
        ran, files = Recorder.ran(), Recorder.files()
        content = {
            "seconds": round(perf_counter() - begun),
            "code": digests(ran, files),
            "files": files,
            "ran": by_module(ran),
            "short": content,
            "results": results,
        }
    target.write_text(text_of(content), encoding="utf-8")


def made(
    key: tuple[str, str], sources: Mapping[str, Path], short: bool, folder: Path, places: SimpleQueue[int]
) -> dict[str, Any]:
    """Make a section in another process, on one processor.

    Raises:
        RuntimeError: with the end of what the process has printed.
    """
    target = folder / f"{'_'.join(key)}.json"
    place = places.get()
    try:
        command = [sys.executable, __file__, "--one", *key, str(target), str(sources.get(key[1], ""))]
        done = subprocess.run(
            [*command, *["--short"] * short],
            capture_output=True,
            text=True,
            check=False,
            # What it does is recorded in one process: it has one processor.
            preexec_fn=partial(os.sched_setaffinity, 0, {place}),
        )
    finally:
        places.put(place)
    if done.returncode:
        raise RuntimeError("\n".join(done.stderr.splitlines()[-12:]))
    content: dict[str, Any] = json.loads(target.read_text(encoding="utf-8"))
    return content


def note(key: tuple[str, str], brief: dict[str, Any]) -> str:
    """Note what a short form under the present code says of a section; returns the state."""
    file = read(key[0])
    section = file["sections"][key[1]]
    alike = same(section["short"]["results"], brief["results"])
    for state in (CHECKED, DIFFERENT):
        section.pop(state, None)
    if alike and not covers(section):
        return state_of(section)
    section[CHECKED if alike else DIFFERENT] = seal_of(code_of(section))
    write(key[0], file)
    return state_of(section)


def work(
    waiting: Sequence[tuple[str, str]], sources: Mapping[str, Path], short: bool
) -> set[tuple[str, str]]:
    """Make sections, or their short forms; return those that are of the present code then, or checked."""
    # Compiled before: the compiler is slow where it is recorded.
    subprocess.run([sys.executable, "-m", "contactlab", "warm-up"], check=True)
    places: SimpleQueue[int] = SimpleQueue()
    processors = sorted(os.sched_getaffinity(0))
    for place in processors:
        places.put(place)
    done = set()
    with TemporaryDirectory() as folder, ThreadPoolExecutor(len(processors)) as pool:
        tasks = {pool.submit(made, key, sources, short, Path(folder), places): key for key in waiting}
        for task in as_completed(tasks):
            key = tasks[task]
            try:
                content = task.result()
            except RuntimeError as error:
                print(f"{key[1]}: failed\n{error}", flush=True)
                continue
            if short:
                state = note(key, content)
            else:
                put(*key, content)
                state = f"made in {content['seconds']} s"
            print(f"{key[1]}: {state}", flush=True)
            if not short or state in (PRESENT, CHECKED):
                done.add(key)
    return done


def main(arguments: Sequence[str] | None = None) -> int:
    """Make sections and pages, and return the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("sections", nargs="*", metavar="SECTION")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--one", nargs=4, help=argparse.SUPPRESS)
    for name in NEEDS:
        parser.add_argument(f"--{name}", type=Path)
    chosen = parser.parse_args(arguments)
    if chosen.one:
        file, name, target, source = chosen.one
        make(file, name, Path(source), Path(target), chosen.short)
        return 0
    from sections import keys

    if unknown := {*chosen.sections} - {name for _, name in keys()}:
        parser.error(
            f"{', '.join(sorted(unknown))}: no section; there are {', '.join(n for _, n in keys())}."
        )
    sources = {name: path.resolve() for name in NEEDS if (path := getattr(chosen, name)) is not None}
    stored = {
        key: section
        for key in keys()
        if not chosen.sections or key[1] in chosen.sections
        for section in [read(key[0])["sections"].get(key[1], {})]
        if chosen.all or state_of(section) != PRESENT
    }
    possible = [
        key
        for key, section in stored.items()
        if (key[1] not in NEEDS or key[1] in sources) and (not chosen.short or "ran" in section)
    ]
    # The longest first: the last ones end together.
    waiting = sorted(possible, key=lambda key: -float(stored[key].get("seconds", 1e9)))
    with TemporaryDirectory() as folder:
        if published := sources.get("ellipses"):
            sources["ellipses"] = Path(folder) / "ellipses.csv"
            convert(published, sources["ellipses"])
        done = work(waiting, sources, chosen.short)
    left = [name for file, name in stored if (file, name) not in done]
    if left:
        print(f"Left as they were, or with other digits: {', '.join(left)}.")
    # In a process of its own, which reads the files as they are now.
    pages = subprocess.run([sys.executable, ROOT / "experiments" / "results_pages.py"], check=False)
    return int(bool(left or pages.returncode))


if __name__ == "__main__":
    sys.exit(main())
