"""Compute the tables of docs/validation.md anew: python tools/validation.py."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from validated.page import write

if __name__ == "__main__":
    write()
