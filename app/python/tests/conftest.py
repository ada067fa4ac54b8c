"""What several tests use: the embedded robot, and the program that was built."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyhysteron as ph
import pytest
from numpy.typing import NDArray


@pytest.fixture(scope="session")
def scene() -> ph.Scene:
    return ph.Scene.embedded()


@pytest.fixture
def twin(scene: ph.Scene) -> ph.Twin:
    return ph.Twin(scene)


@pytest.fixture(scope="session")
def strokes() -> NDArray[np.float64]:
    """Half a second of strokes (50, 4) [m]: two tendons across, in turn."""
    turn = np.linspace(0.0, np.pi, 50)
    out = np.zeros((50, 4))
    out[:, 0], out[:, 1] = 2e-3 * np.sin(turn), 1e-3 * np.sin(2.0 * turn)
    out[:, 2], out[:, 3] = -out[:, 0], -out[:, 1]
    return out


@pytest.fixture(scope="session")
def program() -> list[str]:
    """The program of the same sources, where PYHYSTERON_PROGRAM names it; else that in the wheel."""
    named = os.environ.get("PYHYSTERON_PROGRAM")
    return [named] if named else [sys.executable, "-m", "pyhysteron"]


@pytest.fixture
def run_program(program: list[str], tmp_path: Path):  # type: ignore[no-untyped-def]
    """Runs the program in an empty folder."""

    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        words = [*program, *map(str, arguments)]
        return subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)

    return run
