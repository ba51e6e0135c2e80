"""Fields of the Python API: what is read, what may be assigned, what is refused."""

import gc

import matpoint as mp
import numpy as np
import pytest
from api_support import FALL, block


def test_what_follows_from_other_fields_is_written_on_request(tmp_path):
    dear = {"density", "principal_stress", "stress_ratio", "equivalent_strain"}
    simulation = block().build()
    simulation.run(output=tmp_path / "usual")
    written = set(mp.Results(tmp_path / "usual").bodies["block"].names)
    assert {"velocity", "stress", "von_mises", "pressure", "J"} < written and not written & dear
    assert dear < set(simulation.bodies["block"].fields)
    block(output=mp.Output(fields=sorted(dear))).build().run(output=tmp_path / "asked")
    asked = mp.Results(tmp_path / "asked").bodies["block"]
    assert dear <= set(asked.names)
    np.testing.assert_allclose(asked.field("density", -1), simulation.bodies["block"].field("density"), rtol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_fields_have_their_shapes_and_values(dim):
    simulation = block(dim).build()
    simulation.step(5)
    body = simulation.bodies["block"]
    n = len(body)
    assert n == 8**dim
    shapes = {
        "principal_stress": (n, 3),
        "position": (n, dim),
        "velocity": (n, dim),
        "stress": (n, 3, 3),
        "deformation_gradient": (n, 3, 3),
    }
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
    principal = np.linalg.eigvalsh(stress)
    np.testing.assert_allclose(body.field("principal_stress"), principal, atol=1e-9 * np.abs(principal).max())
    ratio = np.where(pressure > 0, body.von_mises / np.where(pressure > 0, pressure, 1), 0)
    np.testing.assert_allclose(body.field("stress_ratio"), ratio, rtol=1e-9)
    F = np.asarray(body.deformation_gradient)
    e = np.log(np.linalg.eigvalsh(F @ np.transpose(F, (0, 2, 1)))) / 2
    e -= e.mean(axis=1, keepdims=True)
    np.testing.assert_allclose(body.field("equivalent_strain"), np.sqrt(2 / 3 * np.sum(e**2, axis=1)), rtol=1e-9)
    np.testing.assert_allclose(body.field("density"), np.asarray(body.mass) / np.asarray(body.volume), rtol=1e-12)


@pytest.mark.parametrize(
    ("dim", "solver"),
    [
        (2, {}),
        (3, {}),
        (2, {"precision": "single"}),
        (2, {"type": "implicit"}),
        (3, {"type": "implicit"}),
    ],
)
def test_displacement_counts_from_the_start_also_after_a_restart(dim, solver, tmp_path):
    case = block(dim, solver=mp.Solver(**solver), output=mp.Output(fields=["displacement", "velocity"]), time=mp.Time(dt=1e-3, end=0.1))
    simulation = case.build()
    body = simulation.bodies["block"]
    start = np.array(body.position)
    assert np.abs(body.displacement).max() <= (1e-7 if "precision" in solver else 0)
    simulation.step(20)
    u = np.array(body.displacement)
    np.testing.assert_allclose(u, body.position - start, atol=2e-7 if "precision" in solver else 1e-15)
    assert u[:, 1].max() < -1e-3
    simulation.save(tmp_path / "state.h5")
    again = mp.load(tmp_path / "state.h5")
    np.testing.assert_array_equal(again.bodies["block"].displacement, u)
    again.step(3)
    simulation.step(3)
    np.testing.assert_array_equal(again.bodies["block"].displacement, body.displacement)
    # Written, and read back.
    case.build().run(output=tmp_path / "r")
    written = mp.Results(tmp_path / "r").bodies["block"]
    assert written.names == ["displacement", "velocity"]
    last = written.field("displacement", -1)[:, :dim]
    np.testing.assert_allclose(last, written.positions(-1)[:, :dim] - start, atol=1e-6)


def test_displacement_goes_on_across_periodic_sides_and_is_that_of_bodies_that_keep_their_place():
    body = {
        "name": "block",
        "region": mp.Box(lower=[0.25, 0.25], upper=[0.75, 0.75]),
        "layout": mp.PerCell(count=4),
        "velocity": [40.0, 0.0],
        "material": mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
    }
    grid = mp.Grid(upper=[1.0, 1.0], cells=[8, 8], periodic=["x"])
    asked = mp.Output(fields=["displacement"])
    moving = block(grid=grid, body=mp.Body(**body), gravity=[0, 0], output=asked, time=mp.Time(dt=1e-3, end=1)).build()
    moving.step(60)
    displacement = moving.bodies["block"].displacement
    np.testing.assert_allclose(displacement, np.broadcast_to([2.4, 0], displacement.shape), atol=1e-12)
    assert np.abs(moving.bodies["block"].position).max() <= 1
    # A body in its reference configuration has it anyway.
    kept = block(body=mp.Body(**{**body, "velocity": [4.0, 0.0], "formulation": "total"})).build().bodies["block"]
    assert "displacement" in kept.fields and not kept.displacement.any()


def test_displacement_is_asked_for_where_a_body_does_not_keep_it():
    body = block().build().bodies["block"]
    assert "displacement" not in body.fields
    with pytest.raises(mp.InputError, match="output.fields"):
        _ = body.displacement
    kept = block(output=mp.Output(fields=["displacement"])).build().bodies["block"]
    with pytest.raises(mp.InputError, match="assign position"):
        kept.displacement = np.zeros_like(kept.position)


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
    # Splines give a linear function up to the sides; GIMP's domains end there.
    simulation = block(gravity=[0, 0], solver=mp.Solver(shape="bspline2")).build()
    body = simulation.bodies["block"]
    target = np.random.default_rng(1).uniform(0.0, 1.0, body.position.shape)
    target[0] = [1.0, 0.0]  # on the far side
    simulation.step()
    body.position = target
    # One on lines of the grid is kept off them by a billionth of a cell.
    target[0] += [-1.25e-10, 1.25e-10]
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
        assert 0.1 - 2e-9 * 0.1 / cells < body.position[0, 0] <= 0.1  # a billionth of a cell inside
        body.position[1] = [0.0, 0.5]  # assigns all others as they are
        simulation.step()
        assert len(body) == len(body.position)


@pytest.mark.parametrize(("shape", "span"), [("linear", 1), ("bspline2", 2), ("bspline3", 3), ("gimp", 3), ("cpdi", 3)])
def test_a_boundary_at_one_image_of_a_periodic_side_holds_at_both(shape, span):
    for lower, upper in ((0.95, 1.0), (0.0, 0.05)):
        case = block(
            gravity=[0, 0],
            grid=mp.Grid(upper=(1, 1), cells=(10, 10), periodic=["x"]),
            time=mp.Time(end=0.05),
            solver=mp.Solver(shape=shape),
            boundary=mp.Boundary(region=mp.Box(lower=(lower, 0), upper=(upper, 1)), kind="fixed"),
        )
        case.body[0].region = mp.Box(lower=(0, 0.2), upper=(1, 0.8))
        case.body[0].velocity = mp.UniformVelocity(value=[1.0, 0.0])
        simulation = case.build()
        simulation.run()
        history = simulation.history
        expected = history["momentum_x"][0] + history["boundary_impulse_x"] + history["cutoff_impulse_x"]
        np.testing.assert_allclose(history["momentum_x"], expected, atol=1e-9 * history["momentum_x"][0])
        nodes = simulation.grid.velocity.reshape(10 + span, 10 + span, 2)
        np.testing.assert_array_equal(nodes[:, :span], nodes[:, 10:])
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


@pytest.mark.parametrize("material", ["neo_hookean", "copper_linear", "snow_dry", "viscoelastic"])
def test_an_assigned_stress_is_what_the_particles_have(material):
    """A law that flows remembers the strain, another one gets the F that holds the stress."""
    laws = {
        "neo_hookean": mp.NeoHookean(density=1000, youngs_modulus=1e6, poissons_ratio=0.3),
        "viscoelastic": mp.Viscoelastic(density=1000, bulk_modulus=1e6, shear_modulus=1e5, modulus_1=1e5, time_1=1),
    }
    made = mp.Body(
        name="block",
        region=mp.Box(lower=[0.25, 0.25], upper=[0.75, 0.75]),
        layout=mp.PerCell(count=4),
        material=laws.get(material, material),
    )
    simulation = block(gravity=[0, 0], body=made).build()
    body = simulation.bodies["block"]
    stress = np.array([[-900.0, 50, 0], [50, -1000, 0], [0, 0, -950]])
    body.stress = stress
    in_plane = np.asarray(body.stress)[:, :2, :2]
    np.testing.assert_allclose(in_plane, np.broadcast_to(stress[:2, :2], in_plane.shape), atol=1e-3)
    if material in ("copper_linear", "snow_dry"):
        np.testing.assert_array_equal(body.J, 1)
        np.testing.assert_allclose(np.asarray(body.stress)[:, 2, 2], -950, atol=1e-3)
    else:
        assert (body.J < 1).all()


@pytest.mark.parametrize(
    "name, value, text",
    [
        ("stress", np.triu(np.ones((3, 3))), "stress is not symmetric"),
        ("stress", 1e12 * np.eye(3), "stress of particle row 0: no elastic stretch carries the stress"),
        ("pressure", 0.0, "assign stress, which the material is brought to, or deformation_gradient"),
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
    simulation = block(grid=mp.Grid(upper=(1, 2), cells=(4, 16)), solver=mp.Solver(shape="linear")).build()
    simulation.step()
    grid = simulation.grid
    assert grid.shape == (17, 5) and grid.position.shape == (85, 2) and grid.node_count == 85
    np.testing.assert_array_equal(grid.position[1], [0.25, 0])
    mass = grid.mass.reshape(grid.shape)
    assert mass[4, 2] > 0 and mass[16].max() == 0
    np.testing.assert_allclose(grid.mass.sum(), 250, rtol=1e-12)
