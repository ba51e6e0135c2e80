"""The Python API: cases, simulations, fields, functions, callbacks, errors."""

import copy
import gc
import os
import signal
import subprocess
import sys
import textwrap
import threading
import weakref
from pathlib import Path

import matpoint as mp
import numpy as np
import pytest

FALL = -9.81


def block(dim=2, **changes) -> mp.Case:
    """A block of rubber in free fall; changes replace sections."""
    sections = {
        "dim": dim,
        "gravity": [0, FALL, 0][:dim],
        "grid": mp.Grid(upper=[1.0] * dim, cells=[8] * dim),
        "time": mp.Time(dt=1e-3, end=0.02),
        "body": mp.Body(
            name="block",
            region=mp.Box(lower=[0.25] * dim, upper=[0.75] * dim),
            layout=mp.PerCell(count=2**dim),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
    }
    return mp.Case("block", **{**sections, **changes})


def same_bits(a: mp.Simulation, b: mp.Simulation) -> bool:
    return list(a.history) == list(b.history) and all(np.array_equal(a.history[k], b.history[k], equal_nan=True) for k in a.history)


# --- cases ---------------------------------------------------------------------------------------------------------------


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
    assert case.build().grid.shape == (5, 5)
    changed = case.copy()
    changed.grid.cells = (2, 2)
    changed.body[0].material.density = 1.0
    assert case.grid.cells == (4, 4) and case.body[0].material.density == 1000


def test_check_tells_what_a_run_would_be():
    report = block().check()
    assert report.particles == {"block": 64} and report.nodes == 81
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
            "boundary 1: region: .* chooses none of the 81 nodes",
        ),
        (
            {"boundary": mp.Boundary(region=mp.Where(lambda x: x[:, 1] - 0.1), kind="fixed")},
            "gave float64 numbers; it must give truth values",
        ),
        ({"boundary": mp.Boundary(region=mp.Where(lambda x: True), kind="fixed")}, r"predicate gave an array of shape \(\) for 81"),
        ({"boundary": mp.Boundary(region=mp.Where(lambda x: x[:, 0] < 1), kind="slip")}, 'kind = "slip" needs a region with one surface'),
        ({"boundary": mp.Boundary(side="left", kind="velocity", velocity=lambda t: 1.0)}, "it must give 2 finite numbers"),
        ({"body_force": lambda x: np.zeros((3, 2))}, r"gave the shape \(3, 2\) for positions of shape \(81, 2\)"),
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
    with pytest.raises(mp.InputError, match="cannot be copied"):
        copy.copy(a.build())


@pytest.mark.parametrize("wrong", [{"body": None}, {"body": "x"}, {"boundary": None}, {"probe": [1]}])
def test_lists_of_sections_hold_sections(wrong):
    with pytest.raises(mp.InputError, match="is not allowed: give one"):
        block(**wrong)


# --- fields --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dim", [2, 3])
def test_fields_have_their_shapes_and_values(dim):
    simulation = block(dim).build()
    simulation.step(5)
    body = simulation.bodies["block"]
    n = len(body)
    assert n == 8**dim
    shapes = {"position": (n, dim), "velocity": (n, dim), "stress": (n, 3, 3), "deformation_gradient": (n, 3, 3)}
    for name in body.fields:
        assert body.field(name).shape == shapes.get(name, (n,)), name
    np.testing.assert_allclose(body.velocity[:, 1], 5e-3 * FALL, rtol=1e-12)
    np.testing.assert_allclose(body.deformation_gradient, np.broadcast_to(np.eye(3), (n, 3, 3)), atol=1e-13)
    np.testing.assert_array_equal(body.id, np.arange(n))
    np.testing.assert_allclose(np.sum(body.mass), 1000 * 0.5**dim, rtol=1e-13)


def test_stress_is_symmetric_and_agrees_with_its_invariants():
    simulation = mp.Case.from_toml("sphere").build()
    simulation.run(until=0.25)
    body = simulation.bodies["sphere"]
    stress = body.stress
    np.testing.assert_array_equal(stress, np.transpose(stress, (0, 2, 1)))
    pressure = -np.trace(stress, axis1=1, axis2=2) / 3
    np.testing.assert_allclose(body.pressure, pressure, atol=1e-9 * np.abs(pressure).max())
    deviator = stress + pressure[:, None, None] * np.eye(3)
    np.testing.assert_allclose(body.von_mises, np.sqrt(1.5 * np.sum(deviator**2, axis=(1, 2))), rtol=1e-9)
    assert np.abs(stress[:, 0, 1]).max() > 0 and np.abs(stress[:, 1, 2]).max() > 0


def test_an_array_is_a_snapshot_that_outlives_the_simulation():
    simulation = block().build()
    before = simulation.bodies["block"].velocity
    copy = np.array(before)
    simulation.step(5)
    np.testing.assert_array_equal(before, copy)
    grid = simulation.grid.velocity
    del simulation
    gc.collect()
    np.testing.assert_array_equal(before, copy)
    assert np.isfinite(grid).all()
    with pytest.raises(mp.InputError, match="simulation does not exist any more"):
        before[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        np.add(before, 1.0, out=before)


def test_assigning_a_part_assigns_that_part_only():
    simulation = block().build()
    body = simulation.bodies["block"]
    old = body.velocity
    simulation.step(3)
    old[:2] = [7.0, 8.0]  # an old snapshot: the other particles keep what they have now
    np.testing.assert_array_equal(body.velocity[:2], [[7.0, 8.0]] * 2)
    np.testing.assert_allclose(body.velocity[2:, 1], 3e-3 * FALL, rtol=1e-12)
    body.velocity[:, 0] += 1.0
    body.velocity *= 2.0
    np.testing.assert_allclose(body.velocity[:3], [[16, 16], [16, 16], [2, 6e-3 * FALL]], rtol=1e-12)
    free = body.velocity.copy()
    free[0] = 99.0
    zeros = np.zeros_like(body.velocity)
    zeros[1] = 1.0
    assert body.velocity.max() < 99 and zeros.sum() == 2
    assert type(body.velocity + 1) is np.ndarray and type(body.velocity[0]) is np.ndarray


@pytest.mark.parametrize("order", ["usl", "usf", "musl"])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_an_assigned_velocity_is_what_the_next_step_starts_from(order, precision):
    a = block(gravity=[0, 0], solver=mp.Solver(stress_order=order, precision=precision)).build()
    a.step(2)
    a.bodies["block"].velocity = [0.5, -0.25]
    start = a.bodies["block"].position
    a.step(4)
    tolerance = 1e-12 if precision == "double" else 1e-5
    np.testing.assert_allclose(a.bodies["block"].position, start + 4e-3 * np.array([0.5, -0.25]), rtol=tolerance)
    np.testing.assert_allclose(np.sum(a.grid.mass), 250, rtol=tolerance)


def test_assigned_state_equals_a_start_with_it():
    velocity = [0.3, -0.1]
    body = dict(block().body[0])
    started = block(body={**body, "velocity": mp.UniformVelocity(value=velocity)}).build()
    assigned = block().build()
    assigned.bodies["block"].velocity = velocity
    started.run()
    assigned.run()
    np.testing.assert_array_equal(started.bodies["block"].position, assigned.bodies["block"].position)
    np.testing.assert_allclose(assigned.history["transfer_loss"], started.history["transfer_loss"], atol=1e-9)


def test_assigned_positions_move_the_particles_to_other_cells():
    simulation = block(gravity=[0, 0]).build()
    body = simulation.bodies["block"]
    target = np.random.default_rng(1).uniform(0.0, 1.0, body.position.shape)
    target[0] = [1.0, 0.0]  # on the far side
    simulation.step()
    body.position = target
    np.testing.assert_allclose(body.position, target, atol=1e-15)
    np.testing.assert_array_equal(body.id, np.arange(len(body)))
    simulation.step()
    center = (simulation.grid.mass @ simulation.grid.position) / 250
    np.testing.assert_allclose(center, target.mean(axis=0), rtol=1e-12)


def test_positions_on_the_far_side_stay_inside_where_division_rounds_up():
    for cells in (49, 75):
        simulation = block(
            gravity=[0, 0],
            grid=mp.Grid(upper=(0.1, 1), cells=(cells, 8)),
            body=mp.Body(
                name="block",
                region=mp.Box(lower=(0.02, 0.25), upper=(0.08, 0.75)),
                layout=mp.PerCell(count=4),
                material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
            ),
        ).build()
        body = simulation.bodies["block"]
        body.position[0] = [0.1, 0.5]
        assert body.position[0, 0] == 0.1
        body.position[1] = [0.0, 0.5]  # assigns all others as they are
        simulation.step()
        assert len(body) == len(body.position)


def test_a_boundary_at_one_image_of_a_periodic_side_holds_at_both():
    for lower, upper in ((0.95, 1.0), (0.0, 0.05)):
        case = block(
            gravity=[0, 0],
            grid=mp.Grid(upper=(1, 1), cells=(10, 10), periodic=["x"]),
            time=mp.Time(end=0.05),
            boundary=mp.Boundary(region=mp.Box(lower=(lower, 0), upper=(upper, 1)), kind="fixed"),
        )
        case.body[0].region = mp.Box(lower=(0, 0.2), upper=(1, 0.8))
        case.body[0].velocity = mp.UniformVelocity(value=[1.0, 0.0])
        simulation = case.build()
        simulation.run()
        history = simulation.history
        expected = history["momentum_x"][0] + history["boundary_impulse_x"] + history["cutoff_impulse_x"]
        np.testing.assert_allclose(history["momentum_x"], expected, atol=1e-9 * history["momentum_x"][0])
        nodes = simulation.grid.velocity.reshape(11, 11, 2)
        np.testing.assert_array_equal(nodes[:, 0], nodes[:, -1])
        assert history["boundary_impulse_x"][-1] < -1


def test_an_assigned_deformation_gives_its_stress_and_energy():
    simulation = block(gravity=[0, 0]).build()
    F = np.array([[1.1, 0.05, 0], [0, 0.95, 0], [0, 0, 1]])
    simulation.bodies["block"].deformation_gradient = F
    E, nu = 1e5, 0.3
    lam, mu, J = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu)), np.linalg.det(F)
    tau = mu * (F @ F.T - np.eye(3)) + lam * np.log(J) * np.eye(3)
    np.testing.assert_allclose(simulation.bodies["block"].stress[5], tau / J, rtol=1e-12)
    simulation.run()
    history = simulation.history
    energy = 0.5 * mu * (np.sum(F * F) - 3 - 2 * np.log(J)) + 0.5 * lam * np.log(J) ** 2
    assert abs(history["strain_energy"][0] / (0.25 * energy) - 1) < 1e-12
    assert history["kinetic_energy"][-1] > 0.1 * history["strain_energy"][0]
    assert np.abs(history["transfer_loss"]).max() < 0.2 * history["strain_energy"][0]


@pytest.mark.parametrize(
    "name, value, text",
    [
        ("stress", 0.0, "stress cannot be assigned: the stress follows from the deformation"),
        ("pressure", 0.0, "assign deformation_gradient"),
        ("mass", 1.0, "particles keep their mass"),
        ("id", 1.0, "particles keep their numbers"),
        ("velocty", 1.0, 'no field "velocty".*did you mean "velocity"'),
        ("velocity", np.nan, "velocity of particle row 0 is not finite"),
        ("velocity", np.zeros(3), r"velocity has the shape \(64, 2\); an array of shape \(3,\) does not fit"),
        ("position", 2.0, "position of particle row 0 is outside of the grid: x = 2, allowed: 0 to 1"),
        ("deformation_gradient", -np.eye(3), "determinant -1, it must be > 0"),
        ("deformation_gradient", 2 * np.eye(3), r"deformation_gradient\[2\]\[2\] .* in plane strain it is 1"),
    ],
)
def test_what_cannot_be_assigned_is_refused_with_the_reason_and_nothing_changes(name, value, text):
    simulation = block().build()
    simulation.step()
    body = simulation.bodies["block"]
    before = {field: np.array(body.field(field)) for field in body.fields}
    with pytest.raises(mp.InputError, match=text):
        setattr(body, name, value)
    for field, values in before.items():
        np.testing.assert_array_equal(body.field(field), values)


def test_grid_fields_are_numbered_x_fastest():
    simulation = block(grid=mp.Grid(upper=(1, 2), cells=(4, 16))).build()
    simulation.step()
    grid = simulation.grid
    assert grid.shape == (17, 5) and grid.position.shape == (85, 2) and grid.node_count == 85
    np.testing.assert_array_equal(grid.position[1], [0.25, 0])
    mass = grid.mass.reshape(grid.shape)
    assert mass[4, 2] > 0 and mass[16].max() == 0
    np.testing.assert_allclose(grid.mass.sum(), 250, rtol=1e-12)


# --- running -------------------------------------------------------------------------------------------------------------


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


# --- functions and callbacks ---------------------------------------------------------------------------------------------


def test_callbacks_come_every_so_many_steps_or_seconds_and_may_stop_the_run():
    simulation = block().build()
    steps, times = [], []
    simulation.every(lambda now: steps.append(now.step_count), steps=6)

    @simulation.every(time=0.005)
    def watch(now):
        times.append(now.time)
        return len(times) < 4

    assert simulation.run() == "stopped"
    assert steps == [0, 6, 12]
    np.testing.assert_allclose(times, [0, 0.005, 0.01, 0.015], atol=1e-12)


def test_watching_a_run_does_not_change_it():
    watched, alone = block(time=mp.Time(end=0.2)).build(), block(time=mp.Time(end=0.2)).build()
    watched.every(lambda now: np.array(now.bodies["block"].stress), time=0.0037)
    watched.run()
    alone.run()
    assert same_bits(watched, alone)


def test_numpy_truth_values_of_callbacks_count_and_callbacks_may_add_callbacks():
    simulation = block().build()
    added = []

    @simulation.every(steps=5)
    def first(now):
        now.every(lambda later: added.append(later.step_count), steps=100)
        return np.bool_(now.step_count < 10)

    assert simulation.run() == "stopped" and simulation.step_count == 10
    assert added == [0]


def test_a_run_leaves_no_room_for_others():
    simulation = block(gravity=[0, 0], time=mp.Time(dt=1e-5, end=10.0)).build()
    told = []

    def other():
        for attempt in (lambda: simulation.bodies["block"].velocity, lambda: simulation.step(), lambda: simulation.history):
            try:
                attempt()
            except mp.InputError as error:
                told.append(str(error))
        told.append(repr(simulation))

    @simulation.every(steps=2000)
    def check(now):
        with pytest.raises(mp.InputError, match="the simulation is running"):
            now.run()
        with pytest.raises(mp.InputError, match="the simulation is running"):
            now.step()
        now.bodies["block"].velocity = np.array(now.bodies["block"].velocity)
        return now.time < 0.2

    thread = threading.Timer(0.05, other)
    thread.start()
    simulation.run()
    thread.join()
    assert len(told) == 4 and all("in the middle of a step" in text or "is running" in text for text in told[:3]), told


def test_a_function_that_fails_in_a_step_ends_the_simulation():
    fails = False

    def law(F):
        if fails:
            raise ValueError("told by the law")
        return 0 * F

    case = block()
    case.body[0].material = mp.FunctionLaw(law, density=1000, wave_speed=10.0)
    simulation = case.build()
    simulation.step(3)
    fails = True
    with pytest.raises(ValueError, match="told by the law"):
        simulation.step()
    assert simulation.bodies["block"].position.min() > 0.2
    with pytest.raises(mp.SolverError, match="broke off in the middle of step 4"):
        simulation.step()


def test_a_particle_that_left_ends_the_simulation_there():
    fast = {**block().body[0], "velocity": mp.UniformVelocity(value=[60.0, 0.0])}
    simulation = block(body=fast, grid=mp.Grid(upper=(1, 1), cells=(8, 8), particles_outside="stop")).build()
    assert simulation.run() == "stopped (a particle left the grid)"
    steps = simulation.step_count
    assert simulation.run() == "stopped (a particle left the grid)" and simulation.step_count == steps
    with pytest.raises(mp.SolverError, match="has left the grid"):
        simulation.step()


def test_an_exception_of_a_callback_arrives_unchanged_and_the_files_are_intact(tmp_path):
    class Mine(Exception):
        pass

    simulation = block().build()
    error = Mine("told by the test")

    @simulation.every(steps=5)
    def fail(now):
        if now.step_count == 10:
            raise error

    with pytest.raises(Mine) as caught:
        simulation.run(output=tmp_path / "r")
    assert caught.value is error
    results = mp.results.open(tmp_path / "r")
    assert results.manifest["status"] == "failed" and "told by the test" in results.manifest["message"]
    assert results.history["step"][-1] == 9 or results.history["step"][-1] == 10
    simulation._callbacks.clear()


def test_callbacks_that_know_the_simulation_do_not_keep_it_alive():
    simulation = block().build()

    def watch(now, known=(simulation,)):
        return known[0].time

    simulation.every(watch, steps=5)
    simulation.run()
    reference = weakref.ref(simulation)
    del simulation, watch
    gc.collect()
    assert reference() is None


def test_a_predicate_chooses_the_nodes_of_a_boundary():
    side = block(boundary=mp.Boundary(side="bottom", kind="fixed"), time=mp.Time(dt=1e-3, end=0.4))
    where = side.copy()
    where.boundary = mp.Boundary(region=mp.Where(lambda x: x[:, 1] < 1e-9), kind="fixed")
    each = side.copy()
    each.boundary = mp.Boundary(region=mp.Where(lambda x: x[1] < 1e-9, each=True), kind="fixed")
    simulations = [case.build() for case in (side, where, each)]
    for simulation in simulations:
        simulation.run()
    assert same_bits(simulations[0], simulations[1]) and same_bits(simulations[0], simulations[2])
    assert simulations[0].history["boundary_impulse_y"][-1] > 0


def test_a_predicate_fills_a_body():
    disk = {**block().body[0], "region": mp.Disk(center=(0.5, 0.5), radius=0.23)}
    where = mp.Where(lambda x: np.hypot(x[:, 0] - 0.5, x[:, 1] - 0.5) <= 0.23, lower=(0.2, 0.2), upper=(0.8, 0.8))
    a, b = block(body=disk).build(), block(body={**disk, "region": where}).build()
    np.testing.assert_array_equal(a.bodies["block"].position, b.bodies["block"].position)
    with pytest.raises(mp.InputError, match="needs lower and upper"):
        block(body={**disk, "region": mp.Where(where.predicate)}).build()


def test_points_with_a_velocity_function():
    positions = np.random.default_rng(2).uniform(0.3, 0.7, (200, 2))
    volumes = np.random.default_rng(3).uniform(1e-4, 2e-4, 200)
    body = mp.Body(
        name="cloud",
        layout=mp.Points(positions=positions, volumes=volumes),
        velocity=lambda x: np.stack([-x[:, 1], x[:, 0]], axis=1),
        material=mp.NeoHookean(density=1000, youngs_modulus=1e4, poissons_ratio=0.3),
    )
    simulation = block(body=body, gravity=[0, 0]).build()
    cloud = simulation.bodies["cloud"]
    np.testing.assert_allclose(cloud.position, positions, atol=1e-15)
    np.testing.assert_allclose(cloud.mass, 1000 * volumes, rtol=1e-15)
    np.testing.assert_allclose(cloud.velocity[:, 0], -positions[:, 1], rtol=1e-12)
    simulation.run()
    total = (1000 * volumes) @ np.stack([-positions[:, 1], positions[:, 0]], axis=1)
    np.testing.assert_allclose(simulation.history["momentum_x"], total[0], rtol=1e-10)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_uniform_body_force_is_gravity(dim):
    heavy = block(dim)
    forced = block(dim, gravity=[0] * dim, body_force=lambda x: np.eye(dim)[1] * FALL)
    a, b = heavy.build(), forced.build()
    a.run()
    b.run()
    np.testing.assert_allclose(a.bodies["block"].velocity, b.bodies["block"].velocity, rtol=1e-12, atol=1e-15)
    history = b.history
    np.testing.assert_allclose(history["body_force_impulse_y"], history["momentum_y"], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(history["body_force_work"], history["kinetic_energy"], rtol=1e-11, atol=1e-9)


def test_a_body_force_of_position_and_time():
    # A linear field in x, switched on at 0.01 s: the centre of mass feels its value there.
    case = block(gravity=[0, 0], body_force=lambda x, t: np.stack([x[:, 0] * (t > 0.0095), 0 * x[:, 0]], axis=1))
    simulation = case.build()
    simulation.run()
    history = simulation.history
    assert np.abs(history["momentum_x"][history["time"] < 0.0101]).max() == 0
    np.testing.assert_allclose(history["momentum_x"][-1], 250 * 0.5 * 0.01, rtol=2e-5)
    assert np.abs(history["transfer_loss"]).max() < 1e-3 * history["kinetic_energy"][-1]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("order", ["usl", "usf", "musl"])
def test_a_law_in_python_agrees_with_the_same_law_of_the_core(dim, order):
    E, nu = 1e5, 0.3
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))

    def neo_hookean(F):
        J = np.linalg.det(F)
        return mu * (F @ F.transpose(0, 2, 1) - np.eye(3)) + lam * np.log(J)[:, None, None] * np.eye(3)

    core = block(dim, boundary=mp.Boundary(side="bottom", kind="fixed"), solver=mp.Solver(stress_order=order))
    core.body[0].velocity = mp.UniformVelocity(value=[0.0, -20.0, 0.0][:dim])
    python = core.copy()
    python.body[0].material = mp.FunctionLaw(neo_hookean, density=1000, wave_speed=13.0)
    a, b = core.build(), python.build()
    a.run()
    b.run()
    scale = np.abs(a.bodies["block"].stress).max()
    assert scale > 1e3
    np.testing.assert_allclose(a.bodies["block"].velocity, b.bodies["block"].velocity, atol=1e-9)
    np.testing.assert_allclose(a.bodies["block"].stress, b.bodies["block"].stress, atol=1e-9 * scale)


def test_a_law_in_python_remembers_its_history():
    # A law whose history counts its calls: all particles are called once per step, whatever cells they are in.
    def counting(F, L, dt, history):
        return 0 * F, history + [[1.0, dt]]

    seen = []

    def watching(F, L, dt, history):
        seen.append(history.copy())
        return counting(F, L, dt, history)

    case = block(gravity=[0, 0])
    case.body[0].velocity = mp.UniformVelocity(value=[10.0, 5.0])
    case.body[0].material = mp.FunctionLaw(watching, density=1000, wave_speed=1.0, history_size=2)
    simulation = case.build()
    simulation.step(19)
    moved = np.floor(simulation.bodies["block"].position[0] * 8) - np.floor(np.array([0.25 + 1 / 32] * 2) * 8)
    assert moved.max() >= 1
    seen.clear()
    simulation.step()
    last = np.concatenate(seen)
    assert len(last) == 64 and (last[:, 0] == 19).all()
    np.testing.assert_allclose(last[:, 1], 19e-3, rtol=1e-12)


def test_errors_of_a_law_in_python_arrive_unchanged():
    def fails(F):
        raise ZeroDivisionError("in the law")

    case = block()
    case.body[0].material = mp.FunctionLaw(fails, density=1000, wave_speed=10.0)
    with pytest.raises(ZeroDivisionError, match="in the law"):  # the stress of the start is asked for
        case.build()
    case.body[0].material = mp.FunctionLaw(lambda F: F[0], density=1000, wave_speed=10.0)
    with pytest.raises(mp.InputError, match=r"stresses of shape \(3, 3\), it must be"):
        case.build()
    for wrong in ({"density": 0}, {"wave_speed": -1}, {"kinematic_viscosity": -1}, {"history_size": -1}):
        case.body[0].material = mp.FunctionLaw(fails, **{"density": 1.0, "wave_speed": 1.0, **wrong})
        with pytest.raises(mp.InputError, match=f"function law: {next(iter(wrong))}"):
            case.build()


def test_a_boundary_velocity_of_time_does_the_work_that_the_block_gets():
    case = block(
        gravity=[0, 0],
        time=mp.Time(end=0.2),
        boundary=mp.Boundary(
            region=mp.Where(lambda x: x[:, 0] < 0.26), kind="velocity", components=["x"], velocity=lambda t: (np.sin(20 * t), 0)
        ),
    )
    simulation = case.build()
    simulation.run()
    history = simulation.history
    stored = history["kinetic_energy"] + history["strain_energy"]
    assert history["boundary_work"].max() > 0
    np.testing.assert_allclose(stored + history["transfer_loss"], history["boundary_work"], atol=1e-9 * history["boundary_work"].max())


# --- memory, program, pictures -------------------------------------------------------------------------------------------


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
