"""The tutorial followed to the letter from nothing but a clone: install, then every block.

    python docs/tools/follow_tutorial.py [--python PYTHON] [--output DIR]

A clone, an environment of its own and an empty folder are made below the output. What each block takes is
told, in seconds on the clock and of the processor.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "extensions"))

from page_desk import Desk, PageError, follow  # noqa: E402

INSTALL = re.compile(r"^```bash\n(python3 -m venv .*?)^```", re.DOTALL | re.MULTILINE)


def processor_time() -> float:
    """Return the processor time of all that has ended here [s]."""
    spent = os.times()
    return spent.children_user + spent.children_system


def main() -> int:
    """Install, follow and tell the time; the exit status is 1 where the page is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "--python", type=Path, default=Path(sys.executable), help="that makes the environment"
    )
    parser.add_argument("--output", type=Path, default=Path("outputs/follow_tutorial"))
    options = parser.parse_args()
    folder = options.output.resolve()
    folder.mkdir(parents=True)
    (folder / "empty").mkdir()
    (folder / "bin").mkdir()
    (folder / "bin" / "python3").symlink_to(options.python.resolve())
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(folder / "clone")], check=True)
    page = folder / "clone" / "docs" / "tutorial.md"
    result = INSTALL.search(page.read_text(encoding="utf-8"))
    assert result is not None
    environment = {"HOME": str(folder), "PATH": f"{folder / 'bin'}:{os.defpath}", "LANG": "C.UTF-8"}
    began = last = perf_counter()
    try:
        with Desk(folder / "empty", environment) as desk:
            desk.shell(f"cd {folder / 'clone'}\n{result[1]}cd {folder / 'empty'}")
            print(f"{perf_counter() - last:6.1f} s  install")
            last = perf_counter()
            for block, _ in follow(page, folder / "empty", desk):
                print(f"{perf_counter() - last:6.1f} s  line {block.line}", flush=True)
                last = perf_counter()
    except PageError as error:
        print(error)
        return 1
    print(f"{perf_counter() - began:.0f} s in all, {processor_time():.0f} s of the processor.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
