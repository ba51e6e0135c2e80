"""The Python API: cases, running, memory, the program, pictures."""

import copy
import os
import signal
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import matpoint as mp
import numpy as np
import pytest
from api_support import FALL, block


@pytest.mark.parametrize("name", mp.shipped_cases())
def test_every_shipped_case_survives_the_round_trip_through_toml(name, tmp_path):
    case = mp.Case.from_toml(name)
    case.to_toml(tmp_path / f"{name}.toml")
    again = mp.Case.from_toml(tmp_path / f"{name}.toml")
    assert again == case and again.resolved() == case.resolved()


def test_file_keywords_and_program_give_the_same_bits(matpoint, tmp_path):
    case = block(boundary=mp.Boundary(side="bottom", kind="slip"), time=mp.Time(end=0.3))
    case.to_toml(tmp_path / "block.toml")
    case.build().run(output=tmp_path / "python")
    mp.Case.from_toml(tmp_path / "block.toml").build().run(output=tmp_path / "toml")
    assert matpoint("run", "block.toml", "--out", "program").returncode == 0
    written = [(tmp_path / folder / "history.csv").read_bytes() for folder in ("python", "toml", "program")]
    assert written[0] == written[1] == written[2]
    assert len(written[0]) > 10_000


def test_sections_are_attributes():
    case = block()
    case.solver.stress_order = "usf"
    case.grid.cells = (4, 4)
    assert case.resolved()["solver"]["stress_order"] == "usf"
    assert case.build().grid.shape == (7, 7)  # GIMP has a node beyond each side
    changed = case.copy()
    changed.grid.cells = (2, 2)
    changed.body[0].material.density = 1.0
    assert case.grid.cells == (4, 4) and case.body[0].material.density == 1000


def test_check_tells_what_a_run_would_be():
    report = block().check()
    assert report.particles == {"block": 64} and report.nodes == 121
    assert (report.dt, report.steps) == (1e-3, 20)
    assert 10_000 < report.memory < 10_000_000
    assert any("blow up" in text for text in block(time=mp.Time(dt=1.0, end=2.0)).check().warnings)


@pytest.mark.parametrize(
    "change, text",
    [
        ({"grid": mp.Grid(upper=(1, 1))}, "grid: cells is missing"),
        ({"grid": {"upper": [1, 1], "cels": [8, 8]}}, 'unknown key "cels".*did you mean "cells"'),
        ({"body": []}, "the case has no body"),
        ({"gravity": "down"}, "gravity must be an array of 2 numbers"),
        ({"gravity": [0, object()]}, r"gravity\[1\]: .*object.* is no value of a case"),
        ({"body_force": 3}, "body_force = 3 must be a function"),
        (
            {"boundary": mp.Boundary(region=mp.Where(lambda x: x[:, 0] > 5), kind="fixed")},
            "boundary 1: region: .* chooses none of the 121 nodes",
        ),
        (
            {"boundary": mp.Boundary(region=mp.Where(lambda x: x[:, 1] - 0.1), kind="fixed")},
            "gave float64 numbers; it must give truth values",
        ),
        ({"boundary": mp.Boundary(region=mp.Where(lambda x: True), kind="fixed")}, r"predicate gave an array of shape \(\) for 121"),
        ({"boundary": mp.Boundary(region=mp.Where(lambda x: x[:, 0] < 1), kind="slip")}, 'kind = "slip" needs a region with one surface'),
        ({"boundary": mp.Boundary(side="left", kind="velocity", velocity=lambda t: 1.0)}, "it must give 2 finite numbers"),
        ({"body_force": lambda x: np.zeros((3, 2))}, r"gave the shape \(3, 2\) for positions of shape \(121, 2\)"),
        ({"body_force": lambda x: np.nan * x}, "not finite"),
    ],
)
def test_wrong_input_is_an_input_error_that_names_the_place(change, text):
    with pytest.raises(mp.InputError, match=text):
        block(**change).build()


@pytest.mark.parametrize(
    "layout, text",
    [
        (mp.Points(positions=np.zeros((3, 3)), volumes=1.0), r"positions have the shape \(3, 3\).*must be \(n, 2\)"),
        (mp.Points(positions=np.full((3, 2), 0.5), volumes=[1.0, 2.0]), "volumes has 2 numbers for 3 positions"),
        (mp.Points(positions=np.full((3, 2), 0.5), volumes=-1.0), "volumes: -1 is not allowed"),
        (mp.Points(positions=np.full((1, 2), 7.0), volumes=1.0), "outside the grid"),
    ],
)
def test_wrong_points_are_refused(layout, text):
    body = mp.Body(name="p", layout=layout, material=mp.NeoHookean(density=1, youngs_modulus=1, poissons_ratio=0))
    with pytest.raises(mp.InputError, match=text):
        block(body=body).build()


def test_wrong_names_offer_the_right_one():
    with pytest.raises(mp.InputError, match='Disk: unknown parameter "centre".*did you mean "center"'):
        mp.Disk(centre=(0, 0), radius=1)
    with pytest.raises(mp.InputError, match='Case: unknown section "bodies"'):
        mp.Case(bodies=[])
    with pytest.raises(mp.InputError, match="no shipped case"):
        mp.Case.from_toml("discs")
    with pytest.raises(mp.InputError, match=':2: .*unknown key "grvity"'):
        path = Path("case.toml").absolute()
        try:
            path.write_text("dim = 2\ngrvity = [0, 0]\n")
            mp.Case.from_toml(path)
        finally:
            path.unlink()


def test_a_function_has_no_place_in_a_case_file():
    with pytest.raises(mp.InputError, match=r"boundary\[0\].velocity = .*<lambda> is a Python function"):
        block(boundary=mp.Boundary(side="left", kind="velocity", velocity=lambda t: (0, 0))).to_toml()


def test_looking_at_a_case_does_not_change_it_and_copies_are_independent():
    positions = np.full((3, 2), 0.5)
    a = block(body=mp.Body(name="p", layout=mp.Points(positions=positions, volumes=1e-3), material=block().body[0].material))
    b = a.copy()
    assert a == b and a.solver == {} and a == b and a == copy.copy(a) and a == copy.deepcopy(a)
    b.body[0].layout.positions += 0.1
    assert a != b and a.body[0].layout.positions.max() == 0.5
    assert a.resolved()["body"][0]["layout"] == "3 points from an array"
    functions = block(boundary=mp.Boundary(region=mp.Where(lambda x: x[:, 0] < 1), kind="velocity", velocity=lambda t: (0, 0)))
    said = functions.resolved()["boundary"][0]
    assert "chosen by Where" in said["region"] and "the function" in said["velocity"]
    assert copy.copy(a.build()).time == 0


@pytest.mark.parametrize("wrong", [{"body": None}, {"body": "x"}, {"boundary": None}, {"probe": [1]}])
def test_lists_of_sections_hold_sections(wrong):
    with pytest.raises(mp.InputError, match="is not allowed: give one"):
        block(**wrong)


def test_run_in_pieces_and_history():
    whole, pieces = block().build(), block().build()
    assert whole.run() == "finished"
    pieces.run(until=0.01)
    assert abs(pieces.time - 0.01) < 1e-12 and pieces.step_count == 10
    pieces.run()
    np.testing.assert_array_equal(whole.bodies["block"].position, pieces.bodies["block"].position)
    history = whole.history
    assert history["time"][0] == 0 and abs(history["time"][-1] - 0.02) < 1e-12
    np.testing.assert_allclose(history["momentum_y"], 250 * FALL * history["time"], rtol=1e-12, atol=1e-12)
    assert history.units["momentum_y"] == "N s"
    with pytest.raises(KeyError, match="did you mean"):
        history["momentm_y"]


def test_record_adds_the_present_state():
    simulation = block().build()
    simulation.step(3)
    simulation.record()
    simulation.record()
    assert list(simulation.history["step"]) == [3]


def test_history_as_a_table():
    pandas = pytest.importorskip("pandas")
    simulation = block().build()
    simulation.run()
    frame = simulation.history.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.index.name == "time" and len(frame) == len(simulation.history["time"])


def test_wrong_arguments_of_run_step_and_every():
    simulation = block().build()
    for until in (-1.0, 0.0, float("nan"), float("inf")):
        with pytest.raises(mp.InputError, match="until"):
            simulation.run(until=until)
    with pytest.raises(mp.InputError, match="count = -1"):
        simulation.step(-1)
    with pytest.raises(mp.InputError, match="steps = 0"):
        simulation.every(print, steps=0)
    with pytest.raises(mp.InputError, match="both"):
        simulation.every(print, steps=1, time=1.0)
    with pytest.raises(mp.InputError, match="set_threads: -2"):
        mp.set_threads(-2)


def test_results_folder_may_be_given_once_and_is_not_overwritten_by_accident(tmp_path):
    simulation = block().build()
    simulation.run(until=0.01, output=tmp_path / "r")
    simulation.run()
    results = mp.results.open(tmp_path / "r")
    assert results.manifest["status"] == "finished" and abs(results.history["time"][-1] - 0.02) < 1e-12
    with pytest.raises(mp.InputError, match="first run"):
        simulation.run(until=0.05, output=tmp_path / "s")
    with pytest.raises(mp.InputError, match="not empty|overwrite"):
        block().build().run(output=tmp_path / "r")
    block().build().run(output=tmp_path / "r", overwrite=True)


def test_solver_error_leaves_the_files_and_says_what_is_written(tmp_path):
    fast = {**block().body[0], "velocity": mp.UniformVelocity(value=[60.0, 0.0])}
    simulation = block(body=fast).build()
    with pytest.raises(mp.SolverError, match="left the grid.*; written: history at t = "):
        simulation.run(output=tmp_path / "r")
    results = mp.results.open(tmp_path / "r")
    assert results.manifest["status"] == "failed" and len(results.history["time"]) >= 2


@pytest.mark.parametrize("count", [1, 2])
def test_the_same_bits_for_any_number_of_threads(count):
    mp.set_threads(count)
    try:
        simulation = mp.Case.from_toml("dam", ["time.end=0.002"]).build()
        simulation.run()
    finally:
        mp.set_threads(0)
    assert mp.threads() >= 1
    values = np.asarray(simulation.bodies["water"].velocity)
    if count == 1:
        test_the_same_bits_for_any_number_of_threads.values = values
    else:
        np.testing.assert_array_equal(values, test_the_same_bits_for_any_number_of_threads.values)


def test_other_python_threads_go_on_while_a_run_goes_on():
    simulation = block(time=mp.Time(dt=1e-5, end=1.0), gravity=[0, 0]).build()
    count = 0
    done = threading.Event()

    def work():
        nonlocal count
        while not done.is_set():
            count += 1
            done.wait(0.001)

    thread = threading.Thread(target=work)
    thread.start()
    simulation.run(until=0.3)
    during = count
    done.set()
    thread.join()
    assert during > 20


def test_ctrl_c_ends_the_run_with_everything_written(tmp_path):
    script = textwrap.dedent(
        f"""
        import matpoint as mp
        simulation = mp.Case.from_toml("poiseuille", ["time.end=3000", "output.history_every=0.1"]).build()
        simulation.every(lambda now: print("running", flush=True) if now.step_count == 100 else None, steps=100)
        try:
            simulation.run(output={str(tmp_path / "r")!r})
        except KeyboardInterrupt:
            print("interrupted at", simulation.step_count)
        """
    )
    # A test runner in the background ignores SIGINT, and so would its children.
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    )
    try:
        assert process.stdout.readline() == "running\n"
        process.send_signal(signal.SIGINT)
        output = process.communicate(timeout=30)[0]
    finally:
        process.kill()
    assert output.startswith("interrupted at") and process.returncode == 0
    results = mp.results.open(tmp_path / "r")
    assert results.manifest["status"] == "interrupted"
    assert results.history["step"][-1] == int(output.split()[-1]) == results.manifest["steps"]


def test_memory_does_not_grow_over_a_thousand_builds():
    def resident():
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    case = block(body_force=lambda x: 0 * x, boundary=mp.Boundary(region=mp.Where(lambda x: x[:, 1] < 0.1), kind="fixed"))
    for round_ in range(1000):
        simulation = case.build()
        simulation.every(lambda now: None, steps=10)
        simulation.step(2)
        np.asarray(simulation.bodies["block"].velocity)
        if round_ == 300:
            before = resident()
    assert resident() - before < 4e6  # a single simulation kept would be 40 kB each: 28 MB


def test_the_package_is_the_program(tmp_path):
    def run(*words):
        return subprocess.run([sys.executable, "-m", "matpoint", *words], cwd=tmp_path, capture_output=True, text=True)

    assert run("--version").stdout.startswith(f"matpoint {mp.__version__}")
    assert run("run", "disks", "--set", "time.end=0.01").returncode == 0
    assert run("plot", "results/disks").returncode == 0
    wrong = run("run", "discs")
    assert wrong.returncode == 2 and "did you mean" in wrong.stderr


def test_everything_shows_itself_in_a_notebook(tmp_path):
    simulation = mp.Case.from_toml("disks").build()
    simulation.run(until=0.1, output=tmp_path / "r")
    png = b"\x89PNG"
    for shown in (simulation, simulation.history, mp.results.open(tmp_path / "r")):
        assert shown._repr_png_().startswith(png)
    for shown in (simulation.case, simulation.case.check()):
        assert "lower" in shown._repr_html_()
    assert "disks" in repr(simulation) and "632" not in repr(simulation.bodies["lower"])


def test_pictures_of_a_simulation(tmp_path):
    simulation = mp.Case.from_toml("sphere").build()
    simulation.run(until=0.1, output=tmp_path / "r")
    results = mp.results.open(tmp_path / "r")
    for source in (simulation, results):
        axes = mp.plot.profile(source, "velocity_y", along="x").axes[0]
        drawn = axes.lines[0].get_xydata()
        expected = np.stack([simulation.bodies["sphere"].position[:, 0], simulation.bodies["sphere"].velocity[:, 1]], axis=1)
        np.testing.assert_allclose(drawn, expected, rtol=1e-5)
        assert axes.get_ylabel() == "velocity_y [m/s]"
    with pytest.raises(mp.ResultsError, match="along"):
        mp.plot.profile(simulation, "velocity_y", along="w")
    with pytest.raises(mp.ResultsError, match="did you mean"):
        mp.plot.particles(simulation, "presure")
    with pytest.raises(mp.ResultsError, match=r"\.gif or \.mp4"):
        mp.plot.animate(results, "pressure", tmp_path / "a.avi")


def test_hand_over_to_pyvista(tmp_path):
    pytest.importorskip("pyvista")
    simulation = mp.Case.from_toml("disks").build()
    simulation.run(until=0.05, output=tmp_path / "r")
    live = simulation.bodies["lower"].to_pyvista()
    stored = mp.plot.to_pyvista(mp.results.open(tmp_path / "r").bodies["lower"])
    np.testing.assert_allclose(live.points[:, :2], simulation.bodies["lower"].position, rtol=1e-6)
    np.testing.assert_allclose(stored.points, live.points, rtol=1e-6)
    np.testing.assert_allclose(stored["stress"], live["stress"], rtol=1e-5, atol=1e-3)
