"""What the Python tests share: the package from the source tree, and the program under test."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ.get("MATPOINT_PROGRAM", ROOT / "build/release/bin/matpoint"))
# The package as the build made it, beside the program; without the module only results and plots can be tested.
BUILT = PROGRAM.resolve().parent.parent / "python"
HAS_MODULE = any(BUILT.glob("matpoint/_core*.so"))
PACKAGE = BUILT if HAS_MODULE else ROOT / "python"
sys.path.insert(0, str(PACKAGE))
os.environ["PYTHONPATH"] = os.pathsep.join([str(PACKAGE), *filter(None, [os.environ.get("PYTHONPATH")])])

import matplotlib  # noqa: E402

matplotlib.use("Agg")


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Tests of the module need it: a build without it (with sanitizers) leaves them out."""
    return True if not HAS_MODULE and collection_path.name.startswith("test_api") else None


@pytest.fixture(scope="session")
def program() -> Path:
    """The program: MATPOINT_PROGRAM, or the release build of this tree."""
    assert PROGRAM.is_file(), f"{PROGRAM} does not exist: build it, or set MATPOINT_PROGRAM"
    return PROGRAM.resolve()


@pytest.fixture
def matpoint(program, tmp_path):
    """Runs the program in a fresh folder with this interpreter for plots; returns the completed process."""

    def run(*arguments, **options):
        environment = {**os.environ, "MATPOINT_PYTHON": sys.executable, **options.pop("env", {})}
        return subprocess.run(
            [program, *map(str, arguments)], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120, **options
        )

    return run
