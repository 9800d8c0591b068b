"""Put the code of kernels into a wheel where STRAINWAVE_KERNELS=1, as `tools/release.py` builds it."""

import os
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

KERNELS = Path("build/kernels.xz")  # by tools/kernels.py, with the Python that builds


class Kernels(BuildHookInterface):
    """The hook of the wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the file, and the tag of this Python, whose bytecode the code belongs to."""
        if version != "editable" and os.environ.get("STRAINWAVE_KERNELS") == "1":
            if not (Path(self.root) / KERNELS).is_file():
                raise FileNotFoundError(f"{KERNELS} is missing; run tools/kernels.py first")
            build_data["force_include"][str(KERNELS)] = "strainwave/compile/kernels.xz"
            python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
            build_data["tag"] = f"{python}-{python}-manylinux_2_17_x86_64"
