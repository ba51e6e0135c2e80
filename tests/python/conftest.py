"""What the Python tests share: the package from the source tree, and the program under test."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))


@pytest.fixture(scope="session")
def program() -> Path:
    """The program: MATPOINT_PROGRAM, or the release build of this tree."""
    path = Path(os.environ.get("MATPOINT_PROGRAM", ROOT / "build/release/bin/matpoint"))
    assert path.is_file(), f"{path} does not exist: build it, or set MATPOINT_PROGRAM"
    return path.resolve()


@pytest.fixture
def matpoint(program, tmp_path):
    """Runs the program in a fresh folder with this interpreter for plots; returns the completed process."""

    def run(*arguments, **options):
        environment = {**os.environ, "MATPOINT_PYTHON": sys.executable, **options.pop("env", {})}
        return subprocess.run(
            [program, *map(str, arguments)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120, **options
        )

    return run
