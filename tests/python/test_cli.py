"""The program from outside: what it prints, writes and returns, for good and for bad input."""

import os
import pty
import re
import resource
import select
import signal
import subprocess
import sys
import termios
import time

import h5py
import numpy as np
import pytest
import tomllib

CASE = """
title = "A block falls"
gravity = [0.0, -10.0]

[grid]
upper = [1.0, 1.0]
cells = [8, 8]

[time]
dt = 1e-4
end = 0.01

[[body]]
name = "block"
region = { type = "box", lower = [0.25, 0.5], upper = [0.75, 0.75] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
"""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "fall.toml"
    path.write_text(CASE)
    return path


def history(folder):
    return np.atleast_1d(np.genfromtxt(folder / "history.csv", delimiter=",", names=True, deletechars=""))


def manifest(folder):
    return tomllib.loads((folder / "manifest.toml").read_text())


def field_times(folder, body="block"):
    with h5py.File(folder / f"{body}.vtkhdf") as file:
        steps = file["VTKHDF/Steps"]
        count = steps.attrs["NSteps"]
        assert len(file["VTKHDF/Points"]) >= steps["PointOffsets"][count - 1]
        return steps["Values"][:count]


def assert_refused(done, *texts):
    """Exit code 2 and one line `error: ...` with all texts in it."""
    assert done.returncode == 2, done.stdout + done.stderr
    assert done.stderr.startswith("error: ") and done.stderr.count("\n") == 1, done.stderr
    for text in texts:
        assert text in done.stderr


# --- run -----------------------------------------------------------------------------------------------------------


def test_run_writes_results_and_says_where_and_what_next(matpoint, program, case, tmp_path):
    done = matpoint("run", case)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "results/fall"
    assert "results: results/fall\n" in done.stdout
    assert f"next:    {program} plot results/fall\n" in done.stdout
    assert "100 steps to t = 0.01 s" in done.stdout and "particle-updates/s" in done.stdout
    for stage in ("g2p, p2g", "gradient, stress, p2g", "grid", "output, rest", "all"):
        assert re.search(rf"^  {stage} +[\d.]+ +[\d.]+ +[\d.]+$", done.stdout, re.M), stage
    rows = history(folder)
    # 8 cells of 4 particles and 1000 kg/m^3 on 1/8 m^2; the block falls freely: 0.01 s of 10 m/s^2. Round-off of 100 steps.
    np.testing.assert_allclose(rows["mass"], 125, rtol=1e-12)
    np.testing.assert_allclose(rows["momentum_y"][-1], -125 * 10 * 0.01, rtol=1e-12)
    assert manifest(folder)["status"] == "finished"
    assert manifest(folder)["command"].endswith(f"run {case}")
    assert field_times(folder)[-1] == rows["time"][-1] == 0.01


def test_run_is_quiet_when_not_on_a_terminal(matpoint, case):
    done = matpoint("run", case)
    assert done.stderr == ""
    assert "\r" not in done.stdout and "\x1b" not in done.stdout
    percents = re.findall(r"^ *(\d+) %  t = ", done.stdout, re.M)
    assert percents == [str(10 * k) for k in range(1, 10)]


def test_run_shows_one_updating_line_on_a_terminal(program, case, tmp_path):
    try:
        parent, child = pty.openpty()
    except OSError as error:
        pytest.skip(f"this system has no terminals to give (a bare container without /dev/pts): {error}")
    termios.tcsetwinsize(child, (24, 160))  # the line is cut to the terminal
    # Without gravity nothing happens, so that only the signal can end this.
    arguments = [program, "run", case, "--set", "time.end=1e9", "--set", "gravity=[0, 0]", "--threads", "1"]
    running = subprocess.Popen(arguments, cwd=tmp_path, stdout=child, stderr=subprocess.PIPE)
    os.close(child)

    def read():
        try:
            return os.read(parent, 4096)
        except OSError:  # Linux's way to say that the other side is closed
            return b""

    shown = b""
    deadline = time.monotonic() + 60
    while shown.count(b"\r[") < 2 and time.monotonic() < deadline and running.poll() is None:
        if select.select([parent], [], [], 1)[0]:
            shown += read()
    running.terminate()
    while data := read():
        shown += data
    os.close(parent)
    running.stderr.close()
    assert running.wait(60) == 143
    assert re.search(rb"\r\[[#.]{24}\] +\d+\.\d %  t = \S+ s  step \d+  \S+ \S* ?particle-updates/s", shown), shown
    # Removed before the summary.
    assert b"\r\x1b[K" in shown and shown.index(b"stage") > shown.rindex(b"\r[")


def test_out_and_set_and_threads_are_recorded(matpoint, case, tmp_path):
    done = matpoint("run", case, "--out", "a b", "--set", "time.end=0.002", "--set", "gravity=[0, -20]", "--threads", "2")
    assert done.returncode == 0, done.stderr
    assert "plot 'a b'\n" in done.stdout
    run = manifest(tmp_path / "a b")
    assert run["threads"] == 2 and run["case"]["time"]["end"] == 0.002 and run["case"]["gravity"] == [0, -20]
    np.testing.assert_allclose(history(tmp_path / "a b")["momentum_y"][-1], -125 * 20 * 0.002, rtol=1e-12)


def test_a_manifest_s_case_runs_again_to_the_same_numbers(matpoint, case, tmp_path):
    matpoint("run", case, "--out", "a")
    resolved = matpoint("check", case).stdout
    (tmp_path / "again.toml").write_text(resolved)
    done = matpoint("run", "again.toml", "--out", "b")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a/history.csv").read_bytes() == (tmp_path / "b/history.csv").read_bytes()


def test_existing_results_are_refused_and_replaced_only_when_asked(matpoint, case, tmp_path):
    assert matpoint("run", case, "--out", "r").returncode == 0
    before = (tmp_path / "r/history.csv").read_bytes()
    assert_refused(matpoint("run", case, "--out", "r", "--set", "time.end=0.002"), "exists and is not empty", "--overwrite")
    assert (tmp_path / "r/history.csv").read_bytes() == before
    (tmp_path / "r/mine.txt").write_text("keep")
    assert matpoint("run", case, "--out", "r", "--overwrite", "--set", "time.end=0.002").returncode == 0
    assert history(tmp_path / "r")["time"][-1] == 0.002
    assert (tmp_path / "r/mine.txt").read_text() == "keep"


def test_overwrite_refuses_a_folder_that_no_run_made(matpoint, case, tmp_path):
    (tmp_path / "photos").mkdir()
    (tmp_path / "photos/cat.jpg").write_text("cat")
    assert_refused(matpoint("run", case, "--out", "photos", "--overwrite"), "no manifest.toml", "nothing in it is deleted")
    assert (tmp_path / "photos/cat.jpg").read_text() == "cat"


@pytest.mark.parametrize(
    "out, reason", [("fall.toml", "there is a file of that name"), ("fall.toml/r", "Not a directory"), ("/proc/r", "")]
)
def test_output_that_cannot_be_written_is_refused(matpoint, case, out, reason):
    assert_refused(matpoint("run", case, "--out", out), f'cannot create results folder "{out}"', reason)


def test_warnings_go_to_standard_error_and_the_run_goes_on(matpoint, case):
    done = matpoint("run", case, "--set", "solver.damping=1")
    assert done.returncode == 0
    assert done.stderr.startswith("warning: ") and '"usl"' in done.stderr


# --- runs that fail ------------------------------------------------------------------------------------------------


def test_a_lost_particle_fails_the_run_and_leaves_what_was_written(matpoint, case, tmp_path):
    done = matpoint("run", case, "--set", "time.end=1")
    assert done.returncode == 3
    assert re.match(r'error: step \d+, t = \S+ s: particle \d+ of body "block" left the grid at \(', done.stderr), done.stderr
    assert "written: history at t = " in done.stderr
    folder = tmp_path / "results/fall"
    run = manifest(folder)
    assert run["status"] == "failed" and "left the grid" in run["message"]
    # The bottom of the block is half a metre above the ground: sqrt(2 h / g), with the lowest particles a little higher.
    assert 0.3 < history(folder)["time"][-1] <= run["time"] < 0.36
    assert len(field_times(folder)) > 1


def test_a_particle_that_leaves_can_end_the_run_normally(matpoint, case, tmp_path):
    done = matpoint("run", case, "--set", "time.end=1", "--set", "grid.particles_outside=stop")
    assert done.returncode == 0, done.stderr
    assert re.search(r'particle \d+ of body "block" left the grid at ', done.stdout)
    assert "stopped" in manifest(tmp_path / "results/fall")["status"]


def test_removed_particles_are_reported(matpoint, case, tmp_path):
    done = matpoint("run", case, "--set", "time.end=0.33", "--set", "grid.particles_outside=remove")
    assert done.returncode == 0, done.stderr
    removed = history(tmp_path / "results/fall")["removed_count"][-1]
    assert removed > 0
    assert f"warning: {removed:.0f} particles left the grid and were removed, with a mass of " in done.stderr


def test_an_unstable_run_fails_with_step_time_and_particle(matpoint, case):
    done = matpoint("run", case, "--set", "time.dt=0.05", "--set", "time.end=100", "--set", "gravity=[0, -0.1]")
    assert "warning: the fixed time step dt = 0.05 s is above the stable limit" in done.stderr
    assert done.returncode == 3
    assert re.search(r"error: step \d+, t = \S+ s: .*particle \d+ of body", done.stderr), done.stderr


def test_an_implicit_step_that_fails_says_why_and_leaves_what_was_written(matpoint, case, tmp_path):
    text = CASE.replace("dt = 1e-4", "dt = 0.02")
    text = re.sub(r"\[solver\].*?\n\n", "", text, flags=re.S) + '\n[solver]\ntype = "implicit"\niterations_max = 2\nstep_cuts_max = 1\n'
    text += '\n[[boundary]]\nside = "bottom"\nkind = "fixed"\n'
    case.write_text(text)
    done = matpoint("run", case, "--set", "time.end=0.6", "--set", "output.history_every=0.02")
    assert done.returncode == 3, done.stdout + done.stderr
    assert re.match(r"error: step \d+, t = \S+ s: Newton's method failed also with the step cut to 0.01 s", done.stderr), done.stderr
    folder = tmp_path / "results/fall"
    assert manifest(folder)["status"] == "failed"
    written = history(folder)
    assert len(written["time"]) > 3, "free fall converges at once, the impact does not in two iterations"
    assert np.all(written["newton_iterations"][1:] >= 1) and np.all(np.isfinite(written["residual"]))
    assert f"written: history at t = {written['time'][-1]:g} s" in done.stderr


def test_an_automatic_step_below_dt_min_fails_the_run(matpoint, case, tmp_path):
    case.write_text(CASE.replace("dt = 1e-4", "dt_min = 0.1"))
    done = matpoint("run", case)
    assert done.returncode == 3
    assert re.match(r"error: step 1, t = 0 s: the stable time step \S+ s is below dt_min = 0.1 s; written: history at t = 0 s", done.stderr)
    assert manifest(tmp_path / "results/fall")["status"] == "failed"


def assert_readable_after_failure(folder):
    for times in (history(folder)["time"], field_times(folder)):
        assert len(times) > 1, "the limit should leave room for a few times"
        assert np.all(np.isfinite(times)) and np.all(np.diff(times) > 0)


def test_a_full_disk_fails_the_run_and_leaves_readable_files(matpoint, case, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", disk], capture_output=True).returncode:
        pytest.skip("making a small disk needs root")
    try:  # room for some times
        done = matpoint("run", case, "--out", disk / "r", "--set", "output.fields_every=1e-4", "--set", "output.history_every=1e-4")
        assert done.returncode == 3
        assert re.match(r"error: .*cannot write .*: No space left on device", done.stderr), done.stderr
        assert "written: history at t = " in done.stderr
        assert_readable_after_failure(disk / "r")
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_file_size_limit_fails_the_run_and_leaves_readable_files(matpoint, case, tmp_path):
    done = matpoint(
        "run",
        case,
        "--set",
        "output.fields_every=1e-4",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000)),
    )
    assert done.returncode == 3, done.stderr
    assert re.match(r"error: .*cannot write .*: File too large", done.stderr), done.stderr
    assert_readable_after_failure(tmp_path / "results/fall")


def test_a_standard_output_that_cannot_be_written_fails(program, tmp_path):
    with open("/dev/full", "w") as full:
        done = subprocess.run([program, "list"], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 3
    assert done.stderr.startswith("error: ") and "No space left on device" in done.stderr


def test_a_run_goes_on_to_its_end_when_nobody_can_read_what_it_says(program, case, tmp_path):
    for out, streams in (
        ("full", {"stdout": open("/dev/full", "w")}),
        ("both", {"stdout": open("/dev/full", "w"), "stderr": open("/dev/full", "w")}),
    ):
        done = subprocess.run([program, "run", case, "--out", out], cwd=tmp_path, timeout=60, **streams)
        assert done.returncode == 0 and manifest(tmp_path / out)["status"] == "finished"
    piped = subprocess.run(
        f"{program} run {case} --out piped 2>piped.err | head -1", shell=True, cwd=tmp_path, timeout=60, stdout=subprocess.PIPE
    )
    deadline = time.monotonic() + 60
    while manifest(tmp_path / "piped")["status"] == "running" and time.monotonic() < deadline:
        time.sleep(0.05)
    assert manifest(tmp_path / "piped")["status"] == "finished", piped


@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_run_at_a_step_with_everything_written(program, case, tmp_path, number, code):
    # A fixed step and an end far away: only the signal can end this, and outputs are rare, so the last ones come from it.
    arguments = [program, "run", case, "--out", "r", "--set", "time.end=1e9", "--set", "gravity=[0, 0]"]
    running = subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    folder = tmp_path / "r"
    deadline = time.monotonic() + 60
    while not (folder / "block.vtkhdf").exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.2)
    running.send_signal(number)
    stdout, stderr = running.communicate(timeout=60)
    assert running.returncode == code, stderr
    assert stderr == "" and "interrupted: " in stdout and "results: r\n" in stdout
    run = manifest(folder)
    rows = history(folder)
    assert run["status"] == "interrupted"
    assert len(rows) == 2 and rows["step"][-1] == run["steps"] > 0
    assert list(field_times(folder)) == list(rows["time"])


# --- wrong input ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments, texts",
    [
        (["run", "fall.toml", "--thread", "2"], ['unknown option "--thread"', 'did you mean "--threads"?', "matpoint run --help"]),
        (["run", "fall.toml", "--sett", "a=1"], ['unknown option "--sett"', 'did you mean "--set"?']),
        (["run", "fall.toml", "extra"], ['unexpected argument "extra"']),
        (["run"], ["CASE is required", "matpoint run --help"]),
        (["runn", "fall.toml"], ['unknown command "runn"', 'did you mean "run"?']),
        (["--nonsense"], ['unknown option "--nonsense"']),
        ([], ["subcommand is required", "matpoint --help"]),
        (["run", "fall.toml", "--threads", "two"], ["--threads = two is not allowed: give 1 to 1024, or 0"]),
        (["run", "fall.toml", "--threads", "-1"], ["--threads = -1 is not allowed"]),
        (["run", "fall.toml", "--threads", "2.5"], ["--threads = 2.5 is not allowed"]),
        (["run", "fall.toml", "--threads", "99999999999"], ["--threads = 99999999999 is not allowed"]),
        (["run", "fall.toml", "--set"], ["--set"]),
        (["run", "nowhere.toml"], ["nowhere.toml"]),
        (["run", "diks"], ["diks", 'did you mean "disks"?']),
        (["check", "nowhere.toml"], ["nowhere.toml"]),
        (["run", "fall.toml", "--set", "time.end"], ["time.end"]),
        (["run", "fall.toml", "--set", "time.ned=1"], ["--set", 'did you mean "end"?']),
        (["run", "fall.toml", "--set", "time.end=soon"], ["--set", "end", "soon"]),
        (["run", "fall.toml", "--set", "time.end=-1"], ["--set", "end = -1"]),
        (["run", "fall.toml", "--set", "body.blok.name=x"], ["blok", "block"]),
        (["list", "material"], ['no list of "material"', 'did you mean "materials"?']),
        (["explain", "neo_hooke"], ['nothing is called "neo_hooke"', 'did you mean "neo_hookean"?']),
        (["explain", "poisson_ratio"], ['did you mean "poissons_ratio"?']),
        (["plot", "nowhere"], ['"nowhere" is no results folder: there is no such folder']),
        (["verify", "--preset", "quik"], ["--preset = quik is unknown", 'did you mean "quick"?']),
        (["verify", "--list", "--preset", "all"], ["--preset = all is unknown"]),
        (["verify", "disk"], ['called "disk"', 'did you mean "disks"?']),
        (["verify", "disks", "--out", "/nowhere/verify.csv"], ['cannot write "/nowhere/verify.csv"']),
    ],
)
def test_wrong_command_lines_are_refused_in_words(matpoint, case, tmp_path, arguments, texts):
    assert_refused(matpoint(*arguments), *texts)
    assert not (tmp_path / "results").exists()


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize(
    "text, wrong, texts",
    [
        ("density = 1000", "density = -1000", ['fall.toml:17: body "block": material: density = -1000 is not allowed, it must be > 0']),
        ("gravity = [0.0, -10.0]", "gravity = [0.0, -10.0", ["fall.toml:", "not valid TOML"]),
        ("upper = [0.75, 0.75]", "upper = [0.75, 1.75]", ['fall.toml:13: body "block": particle ', "is outside the grid"]),
        ('name = "block"', 'name = "a/b"', ['fall.toml:13: body "a/b": its results cannot be named so']),
        ("[time]", '[output]\nfields = ["velocty"]\n[time]', ['output: fields: "velocty" is unknown', 'did you mean "velocity"?']),
        ("[time]", '[[probe]]\nname = "p"\nbody = "blok"\nparticle = 0\n[time]', ['fall.toml:9: probe "p": body = "blok" is unknown']),
        ("[time]", '[[probe]]\nname = "p"\nbody = "block"\nparticle = 99\n[time]', ["particle = 99 does not exist", "particles 0 to 31"]),
        (
            "[time]",
            '[[boundary]]\nregion = { type = "box", lower = [0.1, 0.1], upper = [0.11, 0.11] }\n[time]',
            ["contains no node of the grid"],
        ),
    ],
)
def test_wrong_cases_are_refused_by_run_and_check_alike(matpoint, case, tmp_path, command, text, wrong, texts):
    assert text in CASE
    case.write_text(CASE.replace(text, wrong))
    assert_refused(matpoint(command, "fall.toml"), *texts)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["fall.toml"]


def test_bench_hands_over_to_the_benchmark(matpoint):
    listed = matpoint("bench", "--list")
    assert listed.returncode == 0, listed.stderr
    assert "schemes" in listed.stdout and "landslide" in listed.stdout
    wrong = matpoint("bench", "no_such_scenario")
    assert wrong.returncode == 2 and "no_such_scenario" in wrong.stderr and "schemes" in wrong.stderr


# --- check, list, explain, version ---------------------------------------------------------------------------------


def test_check_says_sizes_steps_and_time_and_writes_nothing(matpoint, case, tmp_path):
    done = matpoint("check", case, "--set", "time.end=0.05")
    assert done.returncode == 0, done.stderr
    # 4 x 2 cells of 4 particles; quadratic B-splines have 10 x 10 control points; 0.05 s in steps of 1e-4 s.
    assert "# particles         32 (block 32)\n" in done.stdout
    assert "# nodes             121 (11 x 11), cell size 0.125 x 0.125 m\n" in done.stdout
    assert "# steps             500 to t = 0.05 s\n" in done.stdout
    assert re.search(r"^# memory +[\d.]+ [kMG]B for particles and grid, [\d.]+ [kMG]B at the most \(start, output\)$", done.stdout, re.M)
    assert re.search(r"^# estimated time +[\d.]+ s on \d+ threads?, of which [\d.]+ s for output$", done.stdout, re.M)
    # Dilational waves: c^2 = (lambda + 2 mu) / rho = E (1 - nu) / ((1 + nu) (1 - 2 nu)) / rho.
    speed = np.sqrt(1e5 * 0.7 / (1.3 * 0.4) / 1000)
    stable = float(re.search(r"^# stable time step +(\S+) s", done.stdout, re.M)[1])
    assert 0.3 * 0.125 / speed < stable <= 0.125 / speed * (1 + 1e-5)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["fall.toml"]


def test_check_prints_the_resolved_case_as_a_case(matpoint, case, tmp_path):
    first = matpoint("check", case, "--set", "solver.flip=0.9").stdout
    values = tomllib.loads(first)
    assert values["solver"]["flip"] == 0.9 and values["solver"]["stress_order"] == "musl"
    (tmp_path / "resolved.toml").write_text(first)
    second = tomllib.loads(matpoint("check", "resolved.toml").stdout)
    assert second == values


def test_check_warns_about_a_case_that_fails_at_once(matpoint, case):
    done = matpoint("check", case, "--set", "time.dt=10", "--set", "time.end=100")
    assert done.returncode == 0, done.stderr
    assert "is above the stable limit" in done.stderr
    assert "# estimated time    unknown" in done.stdout and "left the grid" in done.stderr


def test_list_has_every_kind_and_each_alone(matpoint):
    everything = matpoint("list").stdout
    for what in ("cases", "materials", "regions", "layouts", "velocities", "sections", "fields"):
        alone = matpoint("list", what)
        assert alone.returncode == 0 and alone.stdout.strip() in everything
        assert alone.stdout.count("\n") > 1, what
    for name in ("disks", "neo_hookean", "von_mises"):
        assert re.search(rf"^  {name}\b", everything, re.M), name


@pytest.mark.parametrize("what", ["cases", "materials", "regions", "layouts", "velocities", "sections"])
def test_everything_listed_can_be_explained(matpoint, what):
    names = re.findall(r"^  (\S+)", matpoint("list", what).stdout, re.M)
    assert names
    for name in names:
        done = matpoint("explain", name)
        assert done.returncode == 0 and f'"{name}": ' in done.stdout, name


def test_explain_gives_unit_default_and_range_of_each_parameter(matpoint):
    text = matpoint("explain", "neo_hookean").stdout
    assert text.startswith('material "neo_hookean": ')
    row = re.search(r"^  density +(.*)$", text, re.M)[1]
    assert re.split(r" {2,}", row)[:3] == ["number", "kg/m^3", "required"]
    row = re.search(r"^  poissons_ratio +(.*)$", text, re.M)[1]
    assert "-1" in row and "0.5" in row
    alone = matpoint("explain", "poissons_ratio").stdout
    assert 'parameter of material "neo_hookean":' in alone
    assert matpoint("explain", "neo_hookean.poissons_ratio").stdout.count("parameter of") == 1


def test_explain_a_case_shows_its_text(matpoint):
    text = matpoint("explain", "disks").stdout
    assert text.startswith('case "disks": ') and "[[body]]" in text and "matpoint run disks" in text


def test_version_and_help(matpoint):
    assert re.match(r"matpoint \d+\.\d+\.\d+ \(\S+\)\n", matpoint("--version").stdout)
    for arguments in [["--help"], *[[c, "--help"] for c in ("run", "check", "list", "explain", "plot", "verify")]]:
        done = matpoint(*arguments)
        assert done.returncode == 0 and "Usage: " in done.stdout and done.stderr == ""


# --- plot, verify --------------------------------------------------------------------------------------------------


def test_plot_draws_a_run(matpoint, case, tmp_path):
    assert matpoint("run", case, "--out=-r").returncode == 0
    done = matpoint("plot", "--field", "velocity_y", "--field", "J", "--times", "0,0.005", "--", "-r")
    assert done.returncode == 0, done.stderr
    names = ["energies.png", "momentum.png", "particles_velocity_y.png", "particles_J.png"]
    assert done.stdout.split() == [f"-r/{name}" for name in names]
    for name in names:
        assert (tmp_path / "-r" / name).read_bytes().startswith(b"\x89PNG")


def test_plot_says_what_is_wrong_with_its_python(matpoint, case, tmp_path):
    assert matpoint("run", case).returncode == 0
    done = matpoint("plot", "results/fall", env={"MATPOINT_PYTHON": "/nowhere/python"})
    assert_refused(done, 'cannot start the Python interpreter "/nowhere/python"', "environment variable MATPOINT_PYTHON", "No such file")
    (tmp_path / "matplotlib.py").write_text("raise ImportError(\"No module named 'matplotlib'\")")
    done = matpoint("plot", "results/fall", env={"PYTHONPATH": str(tmp_path)})
    assert_refused(done, "No module named 'matplotlib'", sys.executable, "set MATPOINT_PYTHON")


def test_verify_lists_its_jobs_by_preset(matpoint):
    quick, full = (matpoint("verify", "--list", "--preset", preset).stdout.splitlines() for preset in ("quick", "full"))
    assert quick and len(full) > len(quick)


# --- instruction sets ----------------------------------------------------------------------------------------------


def test_every_instruction_set_gives_the_same_numbers_to_round_off(matpoint, tmp_path):
    done = matpoint("run", "disks", "--set", "time.end=0.2", "--out", "best")
    assert done.returncode == 0, done.stderr
    names = ["avx512", "avx2", "base"]
    tried = 0
    for name in names:
        done = matpoint("run", "disks", "--set", "time.end=0.2", "--out", name, env={"MATPOINT_SIMD": name})
        if done.returncode == 2:
            assert f'MATPOINT_SIMD = "{name}" is not available on this processor' in done.stderr
            continue
        assert done.returncode == 0, done.stderr
        assert manifest(tmp_path / name)["instruction_set"] == name
        tried += 1
        best, other = history(tmp_path / "best"), history(tmp_path / name)
        # Free flight of 2000 steps: a few eps of the quantity per step, from fused products.
        for column in ("kinetic_energy", "lower.center_of_mass_x", "upper.momentum_y"):
            np.testing.assert_allclose(other[column], best[column], rtol=2000 * 10 * 2.2e-16)
    assert tried >= 1  # "base" is always there
    # The nearest name is offered, where this processor (and build) has one that is near.
    near = ['did you mean "avx'] if tried > 1 else []
    assert_refused(matpoint("run", "disks", env={"MATPOINT_SIMD": "avx3"}), 'MATPOINT_SIMD = "avx3"', "allowed: ", *near)


@pytest.mark.parametrize("stress_order", ["usl", "usf", "musl"])
def test_single_precision_follows_double_to_its_digits(matpoint, case, tmp_path, stress_order):
    for precision in ("double", "single"):
        sets = ["--set", f"solver.precision={precision}", "--set", f"solver.stress_order={stress_order}"]
        assert matpoint("run", case, "--out", precision, *sets).returncode == 0
    double, single = history(tmp_path / "double"), history(tmp_path / "single")
    # 100 steps of free fall with a few 6e-8 of the velocity each.
    np.testing.assert_allclose(single["momentum_y"], double["momentum_y"], rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(single["center_of_mass_y"], double["center_of_mass_y"], rtol=1e-5)
