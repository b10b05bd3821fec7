"""A platform's wheel, with the machine code of all kernels in it: `CONTACTLAB_COMPILE=1 pip wheel .`."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ASKED = os.environ.get("CONTACTLAB_COMPILE") == "1"


class CompiledCode(BuildHookInterface):  # type: ignore[type-arg]
    """Puts machine code for any processor of this kind into a wheel, where the environment asks for it."""

    folder: Path | None = None

    def dependencies(self) -> list[str]:
        """Return what compiling takes: all that contactlab needs."""
        return self.metadata.core.dependencies if ASKED else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and add the code to the wheel."""
        if not ASKED or version == "editable":
            return
        sys.path.insert(0, self.root)
        from contactlab.compiler.shipped import PROCESSOR, packed

        self.folder = Path(tempfile.mkdtemp(prefix="contactlab-"))
        environment = os.environ | PROCESSOR | {"NUMBA_CACHE_DIR": str(self.folder)}
        command = [sys.executable, "-m", "contactlab", "warm-up"]
        subprocess.run(command, cwd=self.root, env=environment, check=True)
        files = {str(folder): f"contactlab/compiled/{name}" for folder, name in packed(self.folder)}
        build_data["force_include"] |= files
        build_data |= {"pure_python": False, "infer_tag": True}

    def finalize(self, *_: Any) -> None:
        """Remove what the wheel now has."""
        if self.folder:
            shutil.rmtree(self.folder)
