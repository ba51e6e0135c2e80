"""Functions and callbacks in the Python API: boundaries, loads, laws, and who may touch a simulation when."""

import gc
import threading
import weakref

import matpoint as mp
import numpy as np
import pytest
from api_support import FALL, block, same_bits


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
    side = block(boundary=mp.Boundary(name="floor", side="bottom", kind="fixed"), time=mp.Time(dt=1e-3, end=0.4))
    where = side.copy()
    where.boundary = mp.Boundary(name="floor", region=mp.Where(lambda x: x[:, 1] < 1e-9), kind="fixed")
    each = side.copy()
    each.boundary = mp.Boundary(name="floor", region=mp.Where(lambda x: x[1] < 1e-9, each=True), kind="fixed")
    simulations = [case.build() for case in (side, where, each)]
    for simulation in simulations:
        simulation.run()
    assert same_bits(simulations[0], simulations[1]) and same_bits(simulations[0], simulations[2])
    assert simulations[0].history["boundary_impulse_y"][-1] > 0


@pytest.mark.parametrize("shape", ["bspline2", "bspline3", "gimp", "cpdi"])
def test_nodes_are_chosen_by_their_places_also_with_wider_shapes(shape):
    by_function, by_region = block(solver=mp.Solver(shape=shape)), block(solver=mp.Solver(shape=shape))
    by_function.boundary = mp.Boundary(region=mp.Where(lambda x: x[:, 1] < 0.3), kind="fixed")
    by_region.boundary = mp.Boundary(region=mp.Box(lower=(-1, -1), upper=(2, 0.3 - 1e-9)), kind="fixed")
    ran = [problem.build() for problem in (by_function, by_region)]
    for simulation in ran:
        simulation.run()
        assert simulation.grid.position.shape == (simulation.grid.node_count, 2)
        assert np.prod(simulation.grid.shape) == simulation.grid.node_count
    assert same_bits(*ran)


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


NUMERICS = {
    "default": ({}, {}),
    "linear": ({"shape": "linear", "transfer": "flip", "mass_cutoff_relative": 1e-3}, {}),
    "bspline2_fbar": ({"shape": "bspline2", "transfer": "apic"}, {"fbar": True}),
    "bspline3_fmpm": ({"shape": "bspline3", "transfer": "fmpm"}, {}),
    "cpdi": ({"shape": "cpdi", "transfer": "tpic"}, {}),
    "around_an_axis": ({"shape": "gimp"}, {"fbar": True}),
    "total": ({"shape": "gimp", "transfer": "flip"}, {"formulation": "total", "fbar": True}),
}
ORDERS = [(name, order) for name in NUMERICS for order in ("usl", "usf", "musl") if (name, order) != ("cpdi", "usf")]


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("name", "order"), ORDERS)
def test_a_law_in_python_agrees_with_the_same_law_of_the_core(dim, name, order):
    if name == "around_an_axis" and dim == 3:
        return  # there is none
    numerics, body = NUMERICS[name]
    E, nu = 1e5, 0.3
    lam, mu = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))

    def neo_hookean(F):
        J = np.linalg.det(F)
        return mu * (F @ F.transpose(0, 2, 1) - np.eye(3)) + lam * np.log(J)[:, None, None] * np.eye(3)

    core = block(dim, boundary=mp.Boundary(side="bottom", kind="fixed"), solver=mp.Solver(stress_order=order, **numerics))
    core.body[0].velocity = mp.UniformVelocity(value=[0.0, -20.0, 0.0][:dim])
    if name == "total":  # on its grid it does not meet the floor
        core.body[0].velocity = mp.LinearVelocity(center=[0.5] * dim, gradient=np.diag([8.0, -6.0, 4.0][:dim]).tolist())
    for key, value in body.items():
        setattr(core.body[0], key, value)
    core.grid.axisymmetric = name == "around_an_axis"
    python = core.copy()
    python.body[0].material = mp.FunctionLaw(neo_hookean, density=1000, wave_speed=13.0)
    a, b = core.build(), python.build()
    a.run()
    b.run()
    scale = np.abs(a.bodies["block"].stress).max()
    assert scale > 1e3
    np.testing.assert_allclose(a.bodies["block"].velocity, b.bodies["block"].velocity, atol=1e-9)
    np.testing.assert_allclose(a.bodies["block"].stress, b.bodies["block"].stress, atol=1e-9 * scale)


@pytest.mark.parametrize("threads", [1, 3])
def test_a_law_in_python_is_called_once_in_a_step_with_its_particles_in_order(threads):
    calls = []

    def law(F, L, dt, history):
        calls.append((F.copy(), L.copy(), history.copy()))
        return 1e4 * (F - np.eye(3) + (F - np.eye(3)).transpose(0, 2, 1)), history + np.arange(len(F))[:, None]

    case = block(boundary=mp.Boundary(side="bottom", kind="fixed"), time=mp.Time(dt=1e-3, end=1))
    case.grid.particles_outside = "remove"
    case.body[0].velocity = mp.UniformVelocity(value=[30.0, -10.0])  # some leave the grid
    case.body[0].material = mp.FunctionLaw(law, density=1000, wave_speed=10.0, history=["sum"])
    simulation = case.build()
    usual = mp.threads()
    mp.set_threads(threads)
    try:
        calls.clear()  # of the check before the run
        before = simulation.bodies["block"].deformation_gradient
        for step in range(1, 26):
            simulation.step()
            assert len(calls) == step
            F, L, _ = calls[-1]
            body = simulation.bodies["block"]
            if len(F) == len(body.field("id")):  # nothing was removed in this step
                np.testing.assert_array_equal(F, body.deformation_gradient)
                if len(before) == len(F):
                    np.testing.assert_allclose(F, before + 1e-3 * L @ before, atol=1e-14)
            before = body.deformation_gradient
            if step == 3:
                np.testing.assert_array_equal(body.field("sum"), 3.0 * body.field("id"))
    finally:
        mp.set_threads(usual)
    assert len(simulation.bodies["block"].field("id")) < len(calls[0][0]), "none has left the grid"


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


@pytest.mark.parametrize("precision", ["double", "single"])
def test_what_a_law_in_python_remembers_is_a_field_by_its_name(precision, tmp_path):
    # A rubber that breaks for good where it was stretched: the last two numbers have names, the first has none.
    def rubber(F, L, dt, history):
        stretch = np.linalg.norm(F, axis=(1, 2))
        greatest = np.maximum(history[:, 1], stretch)
        damage = np.clip((greatest - np.sqrt(3)) / 0.5, 0, 0.9)
        tau = 1e4 * (1 - damage)[:, None, None] * (F @ F.transpose(0, 2, 1) - np.eye(3))
        return tau, np.stack([history[:, 0] + 1, greatest, damage], axis=1)

    case = block(boundary=mp.Boundary(side="bottom", kind="fixed"), solver=mp.Solver(precision=precision), time=mp.Time(end=0.2))
    case.body[0].velocity = mp.UniformVelocity(value=[0.0, -6.0])
    case.body[0].material = mp.FunctionLaw(rubber, density=1000, wave_speed=10.0, history=["greatest", "damage"], history_size=3)
    simulation = case.build()
    simulation.run(output=tmp_path / "out")
    body = simulation.bodies["block"]
    damage, greatest = body.field("damage"), body.field("greatest")
    assert damage.max() > 0.01 and (damage == 0).any() and len(np.unique(greatest)) > 5
    digits = 1e-12 if precision == "double" else 1e-6
    np.testing.assert_allclose(damage, np.clip((greatest - np.sqrt(3)) / 0.5, 0, 0.9), atol=digits)
    np.testing.assert_allclose(mp.Results(tmp_path / "out").bodies["block"].field("damage", -1), damage, atol=1e-7)

    for names, message in (
        (["velocity"], "has the name of another field of particles"),
        (["a b"], 'has the name "a b"; names are letters'),
        (["a", "a"], 'has the name "a" twice'),
        (["a", "b", "c", "d"], "has 4 names for 3 numbers"),
    ):
        case.body[0].material = mp.FunctionLaw(rubber, density=1000, wave_speed=10.0, history=names, history_size=3)
        with pytest.raises(mp.InputError, match=message):
            case.build()
    assert mp.FunctionLaw(rubber, density=1000, wave_speed=10.0, history="damage").history_size == 1
    for wrong in ({"history": 5}, {"history": [1]}, {"history_size": "x"}, {"history_size": 2.5}, {"density": "x"}, {"wave_speed": None}):
        with pytest.raises(mp.InputError, match=f"function law: {next(iter(wrong))} = .* is not allowed, it must be "):
            mp.FunctionLaw(rubber, **{"density": 1000, "wave_speed": 10.0, **wrong})


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
