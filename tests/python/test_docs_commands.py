"""Every command and code block of the README and of the docs runs, in order; what takes minutes runs for one step.

Blocks that other tests run whole: the tutorials (test_api_docs.py), the case file page (test_docs.py), the page on
large problems, for which a program with PETSc is built (tests/mpi).
"""

import copy
import math
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import HAS_MODULE, ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
# What sets the machine up, which is what runs these tests, and what takes an hour.
NOT_HERE = {
    "scripts/quickstart",
    "scripts/quickstart --mpi",
    "scripts/test",
    "sudo apt-get install python3-dev && pip install .",
    "sudo apt-get install python3-dev",
    "git clone <the repository> matpoint && cd matpoint",
    "python3 -m venv ~/mpm && . ~/mpm/bin/activate",
    "pip install .",
    "cmake --build --preset dev && build/dev/test_material",
}
COMMANDS_TESTED_ELSEWHERE = {"docs/states.md", "docs/large_problems.md"}
TESTED_ELSEWHERE = COMMANDS_TESTED_ELSEWHERE | {
    "docs/tutorial.md",
    "docs/tutorial_implicit.md",
    "docs/tutorial_coupling.md",
    "docs/case_file.md",
}


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.M | re.S)


def commands(page: Path) -> list[str]:
    lines = "".join(blocks(page, "sh")).replace("\\\n", " ").splitlines()
    return [command for line in lines if (command := re.sub(r"\s+#.*", "", line).strip())]


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


def test_every_kind_of_block_is_run_by_some_test():
    for page in PAGES:
        kinds = set(re.findall(r"^```(\S+)$", page.read_text(), re.M)) - {"{toctree}", "{eval-rst}"}
        assert kinds <= {"sh", "toml", "python", "cpp"}, f"{name(page)}: who runs a block of {kinds}?"
        if "cpp" in kinds:
            assert name(page) in {"docs/add_a_material.md", "docs/architecture.md"}, name(page)
        if "python" in kinds:
            assert name(page) in TESTED_ELSEWHERE | {"README.md", "docs/python.md", "docs/opening_results.md"}, name(page)
        if "toml" in kinds:
            tested = {"README.md", "docs/coupling.md", "docs/add_a_material.md", "docs/implicit.md"}
            assert name(page) in TESTED_ELSEWHERE | tested, name(page)


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)], ids=name)
def test_every_command_works(matpoint, tmp_path, page):
    for number, file in enumerate(blocks(page, "toml")):
        (tmp_path / ("sag.toml" if number == 0 else f"{number}.toml")).write_text(file)
    for command in commands(page):
        if command in NOT_HERE or name(page) in COMMANDS_TESTED_ELSEWHERE:
            continue
        words = shlex.split(command)
        assert words[0] == "matpoint", f"{name(page)}: nobody tries {command}"
        if words[1] == "run":
            words += ["--overwrite"]
            if "sag" not in words[2]:  # the page's own file, which is small
                checked = matpoint("check", *words[2:-1])
                assert checked.returncode == 0, f"{name(page)}: {command}\n{checked.stderr}"
                step = re.search(r"# time step +(\S+) s", checked.stdout)[1]
                words += ["--set", f"time.end={float(step) * 1.5}"]
        if words[1] == "verify":
            words += ["--list"]
        if words[1] == "bench":
            words += ["tiny", "--repetitions", "1"]
        if words[1] == "plot" and "--times" in words:
            words = words[: words.index("--times")]  # times that the short run has not
        done = matpoint(*words[1:])
        assert done.returncode == 0, f"{name(page)}: {command}\n{done.stderr}"


SHORT_DAM = """
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [20, 20]
[time]
end = 2
[[body]]
name = "water"
region = { type = "box", lower = [0, 0], upper = [0.3, 0.4] }
layout = { type = "per_cell", count = 4 }
material = { type = "newtonian_fluid", density = 1000, pressure_scale = 2000 }
"""
WALLS = "".join(f'[[boundary]]\nside = "{side}"\nkind = "slip"\n' for side in ("left", "right", "bottom", "top"))


def test_the_page_on_states_works(matpoint, tmp_path):
    (tmp_path / "dam").write_text(SHORT_DAM.replace("end = 2", "end = 0.4") + WALLS)
    first, queue = blocks(ROOT / "docs/states.md", "sh")
    for command in [re.sub(r"\s+#.*", "", line).strip() for line in first.splitlines()]:
        done = matpoint(*shlex.split(command)[1:])
        assert done.returncode == 0, f"{command}\n{done.stderr}"
    assert (tmp_path / "results/tilted/manifest.toml").exists()


def test_a_run_under_a_queue_is_requeued_until_it_has_finished(program, tmp_path):
    """The script of the page with a queue that sends SIGTERM soon, as far as a script sees one."""
    (tmp_path / "dam").write_text(SHORT_DAM.replace("end = 2", "end = 60") + WALLS)
    script = tmp_path / "job.sh"
    script.write_text(blocks(ROOT / "docs/states.md", "sh")[1])
    tools = tmp_path / "bin"
    tools.mkdir()
    (tools / "srun").write_text('#!/bin/sh\n"$@" & job=$!\n(sleep 0.3; kill -TERM $job 2>/dev/null) &\nwait $job\n')
    (tools / "scontrol").write_text(f'#!/bin/sh\necho "$@" >> {tmp_path}/requeued\n')
    (tools / "matpoint").symlink_to(program)
    for tool in ("srun", "scontrol"):
        (tools / tool).chmod(0o755)
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}", "SLURM_JOB_ID": "17"}
    codes = []
    while not codes or codes[-1] != 0:
        done = subprocess.run(["sh", script], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60)
        codes.append(done.returncode)
        assert codes[-1] in (0, 143) and len(codes) < 60, done.stderr
    assert codes.count(143) >= 1, "it was faster than the queue"
    assert (tmp_path / "requeued").read_text() == "requeue 17\n" * codes.count(143)
    assert 'status = "finished"' in (tmp_path / "results/dam/manifest.toml").read_text()


def test_the_first_case_of_the_readme_has_no_warning(matpoint, tmp_path):
    (tmp_path / "ball.toml").write_text(blocks(ROOT / "README.md", "toml")[0])
    done = matpoint("run", "ball.toml")
    assert done.returncode == 0 and done.stderr.count("warning") == 0, done.stderr
    assert (tmp_path / "results/ball/manifest.toml").read_text().count("good = true") >= 4


def test_the_plate_of_the_coupling_page_is_read(matpoint, tmp_path):
    grid = (
        "[grid]\nlower = [-2, -3.2]\nupper = [22, 5]\ncells = [30, 41]\nlines_y = ["
        + ", ".join(str(round(-3.2 + 0.2 * k, 10)) for k in range(42))
        + ']\n[time]\nend = 0.01\ndt = 0.01\n[solver]\ntype = "implicit"\nbasis = "element"\n'
    )
    (tmp_path / "plate.toml").write_text(
        grid + blocks(ROOT / "docs/coupling.md", "toml")[0] + '[[boundary]]\nside = "left"\nkind = "fixed"\n'
    )
    done = matpoint("check", "plate.toml")
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not HAS_MODULE, reason="the build has no Python module")
def test_the_python_of_the_readme_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(blocks(ROOT / "README.md", "python")[0], names)  # noqa: S102
    assert names["velocity"].shape == (316, 2)


@pytest.mark.skipif(not HAS_MODULE, reason="the build has no Python module")
def test_the_python_page_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    import matpoint as mp
    import numpy as np

    case, run, states, state, laboratory, functions, callback, plots = blocks(ROOT / "docs/python.md", "python")
    names = {}
    exec(case, names)  # noqa: S102
    assert (tmp_path / "ball.toml").exists()
    exec(run.replace("simulation.run(output=", "simulation = case.build(); simulation.run(output="), names)  # noqa: S102
    exec(state, names)  # noqa: S102
    names.update(copy=copy, finer=names["case"].build())
    exec(states, names)  # noqa: S102
    exec(laboratory, names)  # noqa: S102
    assert names["twin"].time == names["simulation"].time > names["finer"].time == 0
    array = np.array([[0.5, 0.5], [0.6, 0.5]])
    parts = {"mp": mp, "np": np, "math": math, "array": array, "stress": lambda F: F - np.eye(3)}
    for line in functions.splitlines():
        exec(line.replace("..., ", "").replace("x, t: ...", "x, t: 0 * x"), parts)  # noqa: S102
    names["simulation"] = names["case"].build()
    exec(callback, names)  # noqa: S102
    end = names["simulation"].run()
    assert names["simulation"].time <= 1.0 + 1e-2, end
    shown = []
    monkeypatch.setattr("pyvista.DataSet.plot", lambda *_, **words: shown.append(words), raising=False)
    monkeypatch.setattr("pyvista.PolyData.plot", lambda *_, **words: shown.append(words), raising=False)
    exec(plots, names)  # noqa: S102
    assert shown and (tmp_path / "ball.gif").stat().st_size > 1000


def test_results_open_as_the_page_says(matpoint, tmp_path, monkeypatch):
    assert matpoint("run", "disks", "--set", 'output.formats=["vtkhdf", "vtu"]').returncode == 0
    monkeypatch.chdir(tmp_path)
    paraview, pyvista, vtk = blocks(ROOT / "docs/opening_results.md", "python")
    compile(paraview, "paraview", "exec")  # ParaView brings an interpreter of its own
    exec(vtk, {})  # noqa: S102
    pytest.importorskip("pyvista")
    exec(pyvista, {})  # noqa: S102
    assert (tmp_path / "disks.png").stat().st_size > 10_000


def test_the_page_on_materials_compiles_as_printed(tmp_path):
    """All headers and the list of laws, over the tree's own, through everything that runs over all laws."""
    page = ROOT / "docs/add_a_material.md"
    header, laws, damaged, metal = blocks(page, "cpp")
    tuple_of_tree = re.search(r"ShippedLaws = std::tuple<(.*?)>", (ROOT / "src/material/laws.hpp").read_text(), re.S)[1]
    assert f"tuple<{tuple_of_tree}, MyRubber>".split() == re.search(r"tuple<.*?>", laws, re.S)[0].split()
    over = tmp_path / "material"
    shutil.copytree(ROOT / "src/material", over)
    (over / "my_rubber.hpp").write_text(header)
    (over / "damaged_neo_hookean.hpp").write_text(damaged)
    (over / "perfect_metal.hpp").write_text(metal)
    text = (over / "laws.hpp").read_text()
    text = text.replace(
        "#include <tuple>\n",
        '#include <tuple>\n\n#include "material/damaged_neo_hookean.hpp"\n#include "material/my_rubber.hpp"\n'
        '#include "material/perfect_metal.hpp"',
    )
    (over / "laws.hpp").write_text(
        text.replace(f"tuple<{tuple_of_tree}>", f"tuple<{tuple_of_tree}, MyRubber, DamagedNeoHookean, PerfectMetal>")
    )
    compiler = os.environ.get("CXX", "c++")
    for source in ("registry.cpp", "tangent.cpp"):
        words = ["-std=c++20", "-fsyntax-only", "-DFMT_SHARED", f"-I{tmp_path}", f"-I{ROOT / 'src'}", "-isystem", "/usr/include/eigen3"]
        done = subprocess.run([compiler, *words, str(over / source)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-3000:]


def test_a_law_of_a_folder_outside_of_the_tree_is_taken(tmp_path):
    """What CMake makes of MATPOINT_EXTRA_LAWS, and that it compiles; wrong lists are refused."""
    header, *_ = blocks(ROOT / "docs/add_a_material.md", "cpp")
    mine = tmp_path / "my folder"
    mine.mkdir()
    law = mine / "my_rubber.hpp"
    law.write_text(header)
    (mine / "hencky.hpp").write_text(header)

    def configure(*laws):
        words = ["cmake", "-S", ROOT, "-B", tmp_path / "build", "-G", "Ninja", "-DMATPOINT_TESTS=OFF", "-DMATPOINT_BENCH=OFF"]
        return subprocess.run([*words, "-DMATPOINT_EXTRA_LAWS=" + ";".join(map(str, laws))], capture_output=True, text=True)

    for wrong, text in (
        (mine / "hencky.hpp", 'there is a law "hencky" already'),
        (mine / "none.hpp", "is no header"),
        ("a.hpp", "is no header"),
    ):
        done = configure(wrong)
        assert done.returncode != 0 and text in " ".join(done.stderr.split()), done.stderr
    done = configure(law)
    assert done.returncode == 0, done.stderr
    assert f'#include "{law}"' in (tmp_path / "build/laws/extra_laws.hpp").read_text()
    compiler = os.environ.get("CXX", "c++")
    made = tmp_path / "build/laws"
    for source in (made / "my_rubber_base.cpp", made / "my_rubber_tangent.cpp", ROOT / "src/material/registry.cpp"):
        words = ["-std=c++20", "-fsyntax-only", "-DFMT_SHARED", f"-I{made}", f"-I{ROOT / 'src'}", "-isystem", "/usr/include/eigen3"]
        done = subprocess.run([compiler, *words, str(source)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-3000:]


def test_bodies_that_touch_in_the_implicit_solver_run(matpoint, tmp_path):
    body = """
[[body]]
name = "{}"
region = {{ type = "box", lower = [0.25, {}], upper = [0.75, {}] }}
layout = {{ type = "per_cell", count = 4 }}
material = {{ type = "neo_hookean", density = 1000, youngs_modulus = 1e6, poissons_ratio = 0.3 }}
"""
    (tmp_path / "blocks.toml").write_text(
        "gravity = [0, -9.81]\n[grid]\nupper = [1, 1]\ncells = [8, 8]\n[time]\nend = 0.02\ndt = 0.01\n"
        + blocks(ROOT / "docs/implicit.md", "toml")[0]
        + body.format("low", 0, 0.25)
        + body.format("high", 0.25, 0.5)
        + '[[boundary]]\nside = "bottom"\nkind = "fixed"\n'
    )
    done = matpoint("run", "blocks.toml")
    assert done.returncode == 0, done.stderr
    assert "stick" not in done.stdout + done.stderr
