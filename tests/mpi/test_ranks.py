"""Programs that are built with PETSc (-DMATPOINT_MPI=ON), on ranks: `MATPOINT_PROGRAM=build/mpi/bin/matpoint pytest tests/mpi`.

Ranks share the linear solves of an implicit run; everything else is the first one's.
"""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = Path(os.environ["MATPOINT_PROGRAM"]).resolve()
PAGE = ROOT / "docs/large_problems.md"
# As root, and on more ranks than there are processors, mpirun starts nothing unless it is told to.
ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMP_NUM_THREADS": "1"}
MPIRUN = ["mpirun", "--oversubscribe", "--bind-to", "none"]


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE.read_text(), re.M | re.S)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "block.toml").write_text(blocks("toml")[0])
    return tmp_path


def on_ranks(folder: Path, ranks: int, *arguments: str, **options) -> subprocess.CompletedProcess[str]:
    words = [*MPIRUN, "-n", str(ranks), PROGRAM, *arguments]
    return subprocess.run(words, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=120, **options)


def history(folder: Path) -> dict[str, np.ndarray]:
    with open(folder / "history.csv") as file:
        names = [name.split(" ")[0] for name in file.readline().strip().split(",")]
    return dict(zip(names, np.loadtxt(folder / "history.csv", delimiter=",", skiprows=1, ndmin=2).T, strict=True))


SMALL = ["--set", "grid.cells=[10,5,5]"]
GAMG = [*SMALL, "--set", "solver.linear_solver=gamg"]


def test_any_number_of_ranks_finds_the_same(folder):
    found = {}
    for ranks in (1, 2, 4, 8):
        done = on_ranks(folder, ranks, "run", "block.toml", *GAMG, "--out", f"r{ranks}")
        assert done.returncode == 0, done.stderr
        assert done.stdout.count("finished:") == 1, "every rank speaks"
        found[ranks] = history(folder / f"r{ranks}")
    one = found[1]
    assert one["linear_iterations"][-1] > 0
    for ranks, several in found.items():
        assert np.array_equal(several["newton_iterations"], one["newton_iterations"]), ranks
        assert several["linear_iterations"][-1] <= 1.6 * one["linear_iterations"][-1], ranks
        for name in ("block.strain_energy", "block.gravitational_energy"):
            assert several[name] == pytest.approx(one[name], rel=1e-8), (ranks, name)


def test_a_factorisation_on_ranks_finds_what_one_in_a_process_finds(folder):
    for ranks, method in ((1, "umfpack"), (3, "mumps")):
        done = on_ranks(folder, ranks, "run", "block.toml", *SMALL, "--set", f"solver.linear_solver={method}", "--out", method)
        assert done.returncode == 0, done.stderr
    ours, reference = history(folder / "mumps"), history(folder / "umfpack")
    assert ours["block.strain_energy"] == pytest.approx(reference["block.strain_energy"], rel=1e-10)
    assert np.array_equal(ours["newton_iterations"], reference["newton_iterations"])


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["disks"], "mpirun has started 2 ranks, and the explicit solver runs in one process, on threads: start it without mpirun"),
        (["block.toml", "--set", "solver.linear_solver=cholmod"], 'linear_solver = "cholmod" works on one: use "auto", "gamg" or "mumps"'),
        (["block.toml", "--set", "solver.linear_solver=gam"], 'linear_solver: "gam" is unknown'),
        (["block.toml", *GAMG, "--set", 'solver.petsc="-ksp_tpye cg"'], "solver.petsc: nothing uses -ksp_tpye here"),
        (["nonsense.toml"], "nonsense.toml"),
        (["block.toml", "--speed", "11"], "--speed"),
    ],
)
def test_what_is_wrong_is_said_once_with_the_exit_code_of_one_process(folder, arguments, complaint):
    done = on_ranks(folder, 2, "run", *arguments)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("error: ") == 1 and complaint in done.stderr


def test_a_method_that_fails_ends_all_ranks(folder):
    done = on_ranks(folder, 2, "run", "block.toml", *GAMG, "--set", 'solver.petsc="-ksp_max_it 1"')
    assert done.returncode == 3
    assert done.stderr.count("error: ") == 1 and "gamg found no solution" in done.stderr


def test_a_rank_without_memory_ends_all(folder):
    limited = f"ulimit -v 900000; exec {PROGRAM} run block.toml --set grid.cells=[60,30,30] --out full"
    words = [*MPIRUN, "-n", "1", PROGRAM, "run", "block.toml", "--set", "grid.cells=[60,30,30]", "--out", "full"]
    words += [":", "-n", "1", "bash", "-c", limited]
    done = subprocess.run(words, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 3
    assert "error: rank 1 of 2: PETSc is probably out of memory" in done.stderr


def long_run(folder: Path, *options: str) -> subprocess.Popen:
    """On two ranks, with files; returns when there are some."""
    words = [*MPIRUN, *options, "-n", "2", PROGRAM, "run", "block.toml", "--out", "long", *SMALL]
    sets = ["--set", "time.dt=0.001", "--checkpoint-steps", "2"]
    process = subprocess.Popen([*words, *sets], cwd=folder, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60
    while len(list(folder.glob("long/checkpoints/*.h5"))) < 2:
        assert process.poll() is None and time.monotonic() < until
        time.sleep(0.05)
    return process


def ranks_of(process: subprocess.Popen) -> list[int]:
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return sorted(int(child) for child in children)


def is_running(process: int) -> bool:
    """And not dead with nobody who has asked how it went."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("victim", [0, 1])
def test_a_rank_that_is_killed_ends_all_and_the_run_goes_on_from_its_checkpoint(folder, victim):
    process = long_run(folder)
    ranks = ranks_of(process)
    assert len(ranks) == 2
    os.kill(ranks[victim], signal.SIGKILL)
    start = time.monotonic()
    assert process.wait(timeout=30) == 137
    while any(is_running(rank) for rank in ranks):
        assert time.monotonic() - start < 10
        time.sleep(0.05)
    done = on_ranks(folder, 1, "run", "--continue", "long", "--time-limit", "2")
    assert done.returncode in (0, 75), done.stderr


def test_a_signal_to_mpirun_ends_the_run_in_order(folder):
    # So long mpirun waits before it passes SIGTERM on, and again before it kills.
    process = long_run(folder, "--mca", "odls_base_sigkill_timeout", "3")
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=30) != 0
    status = subprocess.run([PROGRAM, "status", "long"], cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)
    assert "interrupted" in status.stdout, status.stdout + status.stderr


def test_python_has_the_methods(folder):
    code = """
import matpoint as mp
found = []
for method in ("gamg", "mumps", "umfpack"):
    simulation = mp.Case.from_toml("block.toml", sets=["grid.cells=[10,5,5]", f"solver.linear_solver={method}"]).build()
    simulation.run()
    found.append(simulation.bodies["block"].position)
assert abs(found[0] - found[2]).max() < 1e-9 and abs(found[1] - found[2]).max() < 1e-12
"""
    package = PROGRAM.parent.parent / "python"
    if not any(package.glob("matpoint/_core*.so")):
        pytest.fail(f"{package} has no module: configure with -DMATPOINT_PYTHON_MODULE=ON")
    environment = {**ENVIRONMENT, "PYTHONPATH": str(package)}
    for launcher in ([], [*MPIRUN, "-n", "1"]):
        done = subprocess.run([*launcher, sys.executable, "-c", code], env=environment, capture_output=True, text=True, cwd=folder)
        assert done.returncode == 0, done.stderr


def test_every_command_of_the_page_works(folder):
    for command in "".join(blocks("sh")).replace("\\\n", " ").splitlines():
        words = shlex.split(command, comments=True)
        if not words or words[0] in ("scripts/quickstart", "sudo", "cmake"):
            continue
        if words[0] == "mpirun":
            words = [*MPIRUN, *words[1:]]
        assert "matpoint" in words, f"nobody tries {command}"
        words[words.index("matpoint")] = str(PROGRAM)
        if "run" in words:
            words += ["--overwrite", *SMALL]
        done = subprocess.run(words, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, f"{command}\n{done.stderr}"
