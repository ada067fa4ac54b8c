"""The program: `python -m pyhysteron …` is `hysteron …`."""

from __future__ import annotations

import sys

from . import _pyhysteron
from ._verb import program

__all__ = ["main"]


def main() -> int:
    """Run the program with the arguments of this process; returns its exit code."""
    return _pyhysteron.run_program(sys.argv[1:], program())


if __name__ == "__main__":
    sys.exit(main())
