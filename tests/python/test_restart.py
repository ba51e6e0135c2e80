"""Runs that are cut off and go on: from the program and from Python, with the bits of a run that was never cut off."""

import copy
import csv
import os
import pickle
import shutil
import signal
import subprocess
import time

import fuzz
import h5py
import numpy as np
import pytest
import tomllib

CASE = """
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 0.3
[[body]]
name = "block"
region = { type = "box", lower = [0.3, 0.1], upper = [0.6, 0.3] }
layout = { type = "per_cell", count = 4 }
velocity = { type = "uniform", value = [0.5, 0] }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
contact = "friction"
friction = 0.3
[[probe]]
name = "corner"
body = "block"
nearest = [0.6, 0.3]
[output]
formats = ["vtkhdf", "vtu"]
"""
IMPLICIT = CASE.replace("end = 0.3", "end = 0.1\ndt = 0.004") + '[solver]\ntype = "implicit"\n'


def content(folder):
    """All that a run has written, but what differs between any two runs."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if name.startswith(("checkpoints", "vtkhdf", "manifest", ".lock")) or path.is_dir():
            continue
        if path.suffix == ".csv":
            rows = list(csv.reader(path.open()))
            kept = [k for k, column in enumerate(rows[0]) if column != "step_seconds"]
            found[name] = [[row[k] for k in kept] for row in rows]
        elif path.suffix == ".vtkhdf":
            with h5py.File(path) as file:
                names = []
                file.visit(names.append)
                found[name] = {key: file[key][...].tobytes() for key in names if isinstance(file[key], h5py.Dataset)}
        else:
            found[name] = path.read_bytes()
    return found


@pytest.fixture(params=[CASE, IMPLICIT], ids=["explicit", "implicit"])
def case(request, tmp_path):
    (tmp_path / "block.toml").write_text(request.param)
    return "block.toml"


def killed(program, folder, arguments, number, when):
    """Starts a run and sends it a signal when `when` says so."""
    running = subprocess.Popen([program, *arguments], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 60
    while not when() and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.002)
    running.send_signal(number)
    return running.wait(timeout=60), running.stderr.read()


@pytest.mark.parametrize("number, code", [(signal.SIGKILL, -9), (signal.SIGTERM, 143)])
def test_a_killed_run_goes_on_as_if_nothing_had_been(program, matpoint, case, tmp_path, number, code):
    options = ["--checkpoint-steps", "7"]
    end = ["--set", "output.history_every=0.0015", "--set", "output.fields_every=0.006"]
    assert matpoint("run", case, "--out", "whole", *options, *end).returncode == 0
    first = tmp_path / "cut/checkpoints"
    words = ["run", case, "--out", "cut", "--overwrite", *options, *end]
    for _ in range(10):
        ended = killed(program, tmp_path, words, number, lambda: first.exists() and any(first.glob("*.h5")))
        if ended[0] != 0:  # else the run was faster than the signal
            break
        shutil.rmtree(tmp_path / "cut")
    assert ended == (code, "")
    assert ("dead" if number == signal.SIGKILL else "interrupted") in matpoint("status", "cut").stdout
    if number == signal.SIGKILL:
        lock = (tmp_path / "cut/.lock").read_text()
        (tmp_path / "cut/.lock").write_text("17 elsewhere 2026-01-01T00:00:00Z\n")
        assert "unknown: process 17 on elsewhere wrote last at 20" in matpoint("status", "cut").stdout
        (tmp_path / "cut/.lock").write_text(lock)
    done = matpoint("run", "--continue", "cut", *options)
    assert done.returncode == 0, done.stderr
    assert content(tmp_path / "cut") == content(tmp_path / "whole")
    assert "finished" in matpoint("status", "cut").stdout
    again = matpoint("run", "--continue", "cut")
    assert again.returncode == 0 and "has finished already" in again.stdout


def test_the_time_limit_has_its_own_exit_code_and_leaves_a_checkpoint(matpoint, case, tmp_path):
    assert matpoint("run", case, "--out", "whole").returncode == 0
    parts = 1
    done = matpoint("run", case, "--out", "cut", "--time-limit", "0.01")
    while done.returncode == 75:
        assert "next:" in done.stdout and "run --continue cut" in done.stdout
        parts += 1
        assert parts < 1000
        done = matpoint("run", "--continue", "cut", "--time-limit", str(0.02 * parts))
    assert done.returncode == 0 and parts > 1, done.stderr
    assert content(tmp_path / "cut") == content(tmp_path / "whole")


def test_a_run_without_checkpoint_begins_again(program, matpoint, case, tmp_path):
    assert matpoint("run", case, "--out", "whole").returncode == 0
    long = ["--set", "time.end=1e9"]
    folder = tmp_path / "cut"
    killed(program, tmp_path, ["run", case, "--out", "cut", *long], signal.SIGKILL, lambda: (folder / "block.vtkhdf").exists())
    text = (folder / "manifest.toml").read_text()
    (folder / "manifest.toml").write_text(
        text.replace(next(line for line in text.splitlines() if line.startswith("end = ")), tomllib_end(case, tmp_path))
    )
    done = matpoint("run", "--continue", "cut")
    assert done.returncode == 0 and "the run begins again" in done.stdout, done.stderr
    assert content(folder)["history.csv"][0] == content(tmp_path / "whole")["history.csv"][0]


def tomllib_end(case, folder):
    return f"end = {tomllib.loads((folder / case).read_text())['time']['end']}"


def test_sigusr1_writes_a_checkpoint_and_goes_on(program, matpoint, case, tmp_path):
    folder = tmp_path / "r"
    running = subprocess.Popen([program, "run", case, "--out", "r", "--set", "time.end=1e9"], cwd=tmp_path, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while not (folder / "block.vtkhdf").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    # The handler is there before the first fields are.
    running.send_signal(signal.SIGUSR1)
    while not list(folder.glob("checkpoints/*.h5")) and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    assert running.poll() is None and len(list(folder.glob("checkpoints/*.h5"))) == 1
    status = matpoint("status", "r").stdout
    assert f"running: process {running.pid} on " in status and "checkpoint: r/checkpoints/step_" in status
    second = matpoint("run", case, "--out", "r", "--overwrite")
    assert second.returncode == 2 and "is in use: process" in second.stderr
    running.kill()
    running.wait()


def refusal_of_changed_state(matpoint, case, tmp_path, name, change):
    """What is said of a state with another data set of its body; sealed anew, so that it is not the checksum that refuses it."""
    assert matpoint("run", case, "--out", "r", "--checkpoint-steps", "5").returncode == 0
    state = tmp_path / "state.h5"
    state.write_bytes(sorted((tmp_path / "r/checkpoints").glob("*.h5"))[-1].read_bytes())
    with h5py.File(state, "r+") as file:
        place = next(f"simulation/solver/body/{body}/{name}" for body in file["simulation/solver/body"])
        values = change(file[place][()])
        del file[place]
        file[place] = values
    state.write_bytes(fuzz.sealed(state.read_bytes()))
    refused = matpoint("run", "--from", "state.h5", "--out", "new")
    assert refused.returncode == 2 and refused.stderr.count("\n") == 1, refused.stderr
    return refused.stderr


@pytest.mark.parametrize("wrong", ["twice", "beyond", "short"])
def test_a_state_whose_numbers_do_not_fit_together_is_refused(matpoint, case, tmp_path, wrong):
    name, change = {
        "twice": ("id", lambda ids: np.where(np.arange(len(ids)) == 3, ids[4], ids)),
        "beyond": ("id", lambda ids: np.where(np.arange(len(ids)) == 3, 10**6, ids)),
        "short": ("velocity", lambda values: values[:-1]),
    }[wrong]
    said = refusal_of_changed_state(matpoint, case, tmp_path, name, change)
    assert f"/{name} " in said and ("each particle has its own" in said or "and ids ascend" in said or " numbers, " in said), said


def test_displacement_of_a_state_that_does_not_have_it_is_refused_and_may_be_left_out(matpoint, case, tmp_path):
    kept = ("--set", 'output.fields=["displacement"]')
    for out, words in (("without", ()), ("with", kept)):
        assert matpoint("run", case, "--out", out, "--checkpoint-steps", "5", *words).returncode == 0
    refused = matpoint("run", "--from", "without", "--out", "new", *kept)
    assert refused.returncode == 2 and "did not remember where particles started" in refused.stderr, refused.stderr
    for words in (kept, ("--set", 'output.fields=["velocity"]')):
        done = matpoint("run", "--from", "with", "--out", "new", "--overwrite", *words)
        assert done.returncode == 0, done.stderr


def test_a_count_that_is_not_that_of_the_cells_is_refused(matpoint, tmp_path):
    (tmp_path / "block.toml").write_text(CASE)
    said = refusal_of_changed_state(matpoint, "block.toml", tmp_path, "count", lambda count: count + 1)
    assert "/count is" in said and "and the cells have" in said, said


def test_a_damaged_checkpoint_is_passed_over(matpoint, case, tmp_path):
    assert matpoint("run", case, "--out", "whole", "--checkpoint-steps", "5").returncode == 0
    shutil.copytree(tmp_path / "whole", tmp_path / "cut")
    manifest = tmp_path / "cut/manifest.toml"
    manifest.write_text(manifest.read_text().replace('status = "finished"', 'status = "running"'))
    first, last = sorted((tmp_path / "cut/checkpoints").glob("*.h5"))
    data = bytearray(last.read_bytes())
    data[len(data) // 2] ^= 1
    last.write_bytes(data)
    done = matpoint("run", "--continue", "cut")
    assert done.returncode == 0 and done.stderr.count("warning: ") >= 1 and "the one before it is taken" in done.stderr
    assert str(first.name) in done.stdout
    assert content(tmp_path / "cut") == content(tmp_path / "whole")
    for path in (first, last):
        path.write_bytes(b"nothing")
    refused = matpoint("run", "--from", "cut", "--out", "new")
    assert refused.returncode == 2 and refused.stderr.count("error: ") == 1


def test_a_new_run_starts_from_a_state_with_other_loads(matpoint, case, tmp_path):
    assert matpoint("run", case, "--out", "first", "--checkpoint-time", "0.05").returncode == 0
    state = sorted((tmp_path / "first/checkpoints").glob("*.h5"))[0]
    with h5py.File(state) as file:
        start = float(file["simulation/time"][0])
    end = tomllib.loads((tmp_path / case).read_text())["time"]["end"]
    changes = ["--set", "gravity=[0, 9.81]", "--set", f"time.end={start + end}", "--set", "body.block.material.youngs_modulus=2e5"]
    done = matpoint("run", "--from", str(state), *changes, "--out", "second")
    assert done.returncode == 0, done.stderr
    rows = np.genfromtxt(tmp_path / "second/history.csv", delimiter=",", names=True, deletechars="")
    assert rows["time"][0] == start and rows["step"][0] == 0 and rows["transfer_loss"][0] == pytest.approx(0, abs=1e-9)
    assert rows["momentum_y"][-1] > rows["momentum_y"][0], "it falls upwards"
    # The same case from the same state: the same motion, with books of its own.
    whole = np.genfromtxt(tmp_path / "first/history.csv", delimiter=",", names=True, deletechars="")
    same = matpoint("run", "--from", str(state), "--out", "third")
    assert same.returncode == 0, same.stderr
    third = np.genfromtxt(tmp_path / "third/history.csv", delimiter=",", names=True, deletechars="")
    assert third["time"][-1] == whole["time"][-1]
    assert third["center_of_mass_x"][-1] == pytest.approx(whole["center_of_mass_x"][-1], abs=1e-9)
    for change, text in [
        ("grid.cells=[20, 20]", "grid.cells"),
        ("body.block.material.density=900", "body.block.material.density cannot be changed from 1000 to 900"),
        ("body.block.layout.count=9", "body.block.layout"),
        ("body.block.name=other", "cannot be changed"),
    ]:
        refused = matpoint("run", "--from", str(state), "--set", change, "--out", "no")
        assert refused.returncode == 2 and text in refused.stderr and refused.stderr.count("\n") == 1, refused.stderr
        assert not (tmp_path / "no").exists()


@pytest.mark.parametrize(
    "arguments, texts",
    [
        (["run", "--continue", "nowhere"], ['"nowhere" is no results folder: it has no manifest.toml']),
        (["run", "--from", "nowhere"], ['there is no state "nowhere"']),
        (["run", "block.toml", "--continue", "nowhere"], ["CASE, --continue and --from exclude each other"]),
        (["run", "--continue", "nowhere", "--set", "time.end=2"], ["--set is not for --continue"]),
        (["run", "--continue", "nowhere", "--out", "x"], ["--out and --overwrite are not for --continue"]),
        (["run", "block.toml", "--time-limit", "soon"], ["--time-limit = soon is not allowed: give a number of seconds > 0"]),
        (["run", "block.toml", "--checkpoint-steps", "0"], ["checkpoint_steps = 0"]),
        (["run", "block.toml", "--checkpoint-wall", "-1"], ["checkpoint_wall = -1"]),
        (["status", "nowhere"], ['"nowhere" is no results folder']),
    ],
)
def test_wrong_words_are_refused_in_one_line(matpoint, case, arguments, texts):
    done = matpoint(*arguments)
    assert done.returncode == 2 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1, done.stderr
    for text in texts:
        assert text in done.stderr


# --- Python --------------------------------------------------------------------------------------------------------

mp = pytest.importorskip("matpoint")
pytest.importorskip("matpoint._core")


@pytest.fixture
def half(case, tmp_path):
    """A simulation in the middle of its run."""
    simulation = mp.Case.from_toml(tmp_path / case).build()
    simulation.run(until=0.04)
    return simulation


def end_of(simulation):
    simulation.run()
    body = simulation.bodies["block"]
    history = {name: simulation.history[name] for name in simulation.history if name != "step_seconds"}
    return [np.asarray(body.position), np.asarray(body.stress), *history.values()]


def assert_same(a, b):
    assert len(a) == len(b)
    for one, other in zip(a, b, strict=True):
        assert np.array_equal(one, other, equal_nan=True)


def test_saved_and_loaded_copied_and_pickled_go_on_the_same(half, tmp_path):
    half.save(tmp_path / "half.h5")
    twins = [mp.load(tmp_path / "half.h5"), copy.copy(half), copy.deepcopy(half), pickle.loads(pickle.dumps(half))]
    for twin in twins:
        assert twin.time == half.time and twin.step_count == half.step_count
    expected = end_of(half)
    for twin in twins:
        assert_same(end_of(twin), expected)


def test_a_results_folder_is_loaded_from_its_last_checkpoint(matpoint, case, tmp_path):
    assert matpoint("run", case, "--checkpoint-steps", "3", "--out", "r").returncode == 0
    loaded = mp.load(tmp_path / "r")
    with h5py.File(sorted((tmp_path / "r/checkpoints").glob("*.h5"))[-1]) as file:
        assert loaded.time == file["simulation/time"][0]


def test_another_case_is_refused_with_the_difference(half, tmp_path):
    half.save(tmp_path / "half.h5")
    other = half.case
    other.gravity = (0, -1.62)
    with pytest.raises(mp.InputError, match=r"is the state of another case: gravity is \[0, -9.81\] there and \[0, -1.62\] here"):
        mp.load(tmp_path / "half.h5", other)
    with pytest.raises(mp.InputError, match="there is no state"):
        mp.load(tmp_path / "none.h5")
    (tmp_path / "no.h5").write_bytes(b"no")
    with pytest.raises(mp.InputError, match="is no state of matpoint"):
        mp.load(tmp_path / "no.h5")


def push(positions):
    return np.tile([1.0, 0.0], (len(positions), 1))


def test_functions_are_given_again(case, tmp_path):
    given = mp.Case.from_toml(tmp_path / case)
    given.body_force = push
    simulation = given.build()
    simulation.run(until=0.04)
    simulation.save(tmp_path / "half.h5")
    with pytest.raises(mp.InputError, match=r"has functions that no file can hold \(body_force\).*mp.load\(path, case\)"):
        mp.load(tmp_path / "half.h5")
    with pytest.raises(mp.InputError, match=r"another case: body_force is .a function of position. there and not given here"):
        mp.load(tmp_path / "half.h5", mp.Case.from_toml(tmp_path / case))
    twins = [mp.load(tmp_path / "half.h5", given), copy.copy(simulation)]
    twins.append(pickle.loads(pickle.dumps(simulation)))
    expected = end_of(simulation)
    for twin in twins:
        assert_same(end_of(twin), expected)
    given.body_force = lambda x: 0 * x
    with pytest.raises(mp.InputError, match=r"body_force = .*lambda.* cannot be pickled: .*; define it at the top of a module"):
        pickle.dumps(given.build())


def test_a_state_is_taken_into_a_finer_grid():
    def ball(cells):
        return mp.Case(
            gravity=(0, -9.81),
            grid=mp.Grid(upper=(1, 1), cells=(cells, cells)),
            time=mp.Time(end=0.2),
            body=mp.Body(
                name="ball",
                region=mp.Disk(center=(0.5, 0.6), radius=0.15),
                layout=mp.Lattice(divisions=16),
                material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
            ),
        ).build()

    coarse, fine = ball(20), ball(30)
    coarse.run(until=0.1)
    fine.set_state(coarse)
    for field in ("position", "velocity", "deformation_gradient"):
        assert np.allclose(getattr(fine.bodies["ball"], field), getattr(coarse.bodies["ball"], field), atol=1e-9)
    fine.run(until=0.05)
    other = mp.Case.from_toml("disks").build()
    with pytest.raises(mp.InputError, match="set_state: no body of"):
        other.set_state(coarse)


def test_bits_do_not_depend_on_the_instruction_set(program, case, tmp_path):
    """Saved with the widest one, continued with AVX2."""
    run = lambda simd, *words: subprocess.run(  # noqa: E731
        [program, "run", *words], cwd=tmp_path, env={**os.environ, "MATPOINT_SIMD": simd}, capture_output=True, text=True, timeout=60
    )
    for simd, out in (("avx2", "narrow"), ("avx512", "wide")):
        done = run(simd, case, "--out", out)
        if f'MATPOINT_SIMD = "{simd}" is not available on this processor' in done.stderr:
            pytest.skip(f"this processor has no {simd}")
        assert done.returncode == 0, done.stderr
    assert content(tmp_path / "narrow") == content(tmp_path / "wide")
    # A step with each, and the rest: such a time has passed after every step.
    step = ("--time-limit", "1e-9")
    assert run("avx512", case, "--out", "cut", *step).returncode == 75
    for simd in ("avx2", "avx512", "avx2", "avx512"):
        assert run(simd, "--continue", "cut", *step).returncode == 75
    assert run("avx2", "--continue", "cut").returncode == 0
    assert content(tmp_path / "cut") == content(tmp_path / "wide")
