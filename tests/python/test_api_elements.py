"""Bodies of finite elements as Python sees them: cells, fields at nodes, pictures."""

import itertools

import matpoint as mp
import numpy as np
import pytest
from matpoint import plot, results

MATERIAL = mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3)


def beam(order=2, with_particles=False):
    """A beam clamped at its left side that sags under its weight."""
    bodies = [mp.Body(name="beam", method="elements", region=mp.Box(lower=(0, 0), upper=(1, 0.25)), material=MATERIAL)]
    if with_particles:
        region = mp.Box(lower=(0.5, 0.3), upper=(0.7, 0.45))
        bodies.append(mp.Body(name="block", region=region, layout=mp.PerCell(count=36), material=MATERIAL))
    return mp.Case(
        "beam",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1, 0.5), cells=(8, 4)),
        time=mp.Time(end=0.05, dt=0.005),
        solver=mp.Solver(type="implicit", basis="element", element_order=order),
        body=bodies,
        boundary=mp.Boundary(side="left", kind="fixed"),
    ).build()


@pytest.mark.parametrize(("order", "nodes", "per_cell"), [(1, 9 * 3, 4), (2, 17 * 5, 9)])
def test_nodes_and_cells_of_a_body_of_elements(order, nodes, per_cell):
    simulation = beam(order)
    body = simulation.bodies["beam"]
    assert body.cells.shape == (16, per_cell)
    start = body.node_field("position")
    assert start.shape == (nodes, 2)
    assert set(body.cells.ravel()) == set(range(nodes))
    simulation.run(until=0.05)
    np.testing.assert_allclose(body.node_field("position"), start + body.node_field("displacement"), atol=1e-15)
    held = start[:, 0] == 0
    assert np.all(body.node_field("displacement")[held] == 0) and np.all(body.node_field("velocity")[held] == 0)
    tip = np.argmax(start @ [1.0, 1.0])
    fall = body.node_field("displacement")[tip, 1]
    assert -0.51 * 9.81 * 0.05**2 < fall < -0.2 * 9.81 * 0.05**2  # nearly free for so short a time
    # The Gauss points lie between the nodes, and move with them.
    assert abs(body.position[:, 1].min() - body.node_field("position")[:, 1].min()) < 0.03
    # The greatest stress, bending at the clamp, is at the nodes of the surface.
    assert body.node_field("stress").shape == (nodes, 3, 3)
    assert body.node_field("von_mises").max() > 1.05 * body.von_mises.max()
    assert body.node_field("von_mises").min() >= 0


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("order", [1, 2])
def test_what_a_law_remembers_is_at_the_nodes_too(dim, order, tmp_path):
    # A block of metal that is bent beyond its yield stress by its own weight, at its clamp only.
    metal = mp.J2(density=1000, youngs_modulus=1e6, poissons_ratio=0.3, yield_stress=1.2e4, hardening_modulus=1e5)
    simulation = mp.Case(
        "metal",
        dim=dim,
        gravity=(0, -9.81, 0)[:dim],
        grid=mp.Grid(upper=(1, 0.5, 0.25)[:dim], cells=(8, 4, 2)[:dim]),
        time=mp.Time(end=1, dt=0.25),
        solver=mp.Solver(type="implicit", mode="static", basis="element", element_order=order),
        body=mp.Body(name="beam", method="elements", region=mp.Box(lower=(0, 0, 0)[:dim], upper=(1, 0.25, 0.25)[:dim]), material=metal),
        boundary=mp.Boundary(side="left", kind="fixed"),
    ).build()
    simulation.run(output=tmp_path / "out")
    body = simulation.bodies["beam"]
    at_points, at_nodes = np.asarray(body.field("plastic_strain")), np.asarray(body.node_field("plastic_strain"))
    assert at_points.max() > 1e-3 and (at_points == 0).sum() > len(at_points) / 3
    # Never below what no point has, and as large at the clamp, whose points are nearest.
    assert at_nodes.min() == 0 and 0.3 * at_points.max() < at_nodes.max() <= at_points.max()
    assert body.node_field("position")[np.argmax(at_nodes), 0] < 0.2
    written = mp.Results(tmp_path / "out").bodies["beam"]
    np.testing.assert_allclose(written.field("plastic_strain", -1), at_nodes, rtol=1e-6, atol=1e-12)


def test_areas_of_the_cells_are_those_of_the_body():
    body = beam().bodies["beam"]
    x = body.node_field("position")
    corners = x[body.cells[:, :4]]
    edges = [corners[:, b] - corners[:, a] for a, b in itertools.pairwise([0, 1, 2, 3, 0])]
    np.testing.assert_allclose(edges[0][:, 0] * edges[1][:, 1] - edges[0][:, 1] * edges[1][:, 0], 0.125**2, rtol=1e-12)


def test_what_particles_and_elements_do_not_have_is_said():
    simulation = beam(with_particles=True)
    particles, elements = simulation.bodies["block"], simulation.bodies["beam"]
    assert particles.cells is None and particles.node_fields == []
    with pytest.raises(mp.InputError, match='body "block" consists of particles and has no nodes of its own'):
        particles.node_field("position")
    with pytest.raises(mp.InputError, match='body "beam": mass is a field of particles and Gauss points, not of nodes'):
        elements.node_field("mass")
    with pytest.raises(mp.InputError, match='body "beam" has no field "displacment" at its nodes.*did you mean "displacement"'):
        elements.node_field("displacment")


def test_pictures_fill_the_cells(tmp_path):
    simulation = beam(with_particles=True)
    simulation.run(output=tmp_path / "out")
    assert results.open(tmp_path / "out").bodies["beam"].cells.shape == (16, 9)
    for source in (results.open(tmp_path / "out"), simulation):
        figure = plot.particles(source, "velocity")
        kinds = [type(artist).__name__ for artist in figure.axes[0].collections]
        assert kinds.count("TriMesh") == 1 and kinds.count("PathCollection") == 1
    mesh = next(a for a in figure.axes[0].collections if type(a).__name__ == "TriMesh")
    triangles = mesh._triangulation
    x, y = triangles.x[triangles.triangles], triangles.y[triangles.triangles]
    areas = 0.5 * ((x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0]))
    assert np.all(areas > 0)
    assert areas.sum() == pytest.approx(0.25, rel=1e-2)


def test_a_mesh_opens_in_pyvista():
    pytest.importorskip("pyvista")
    mesh = beam().bodies["beam"].to_pyvista()
    assert mesh.n_cells == 16 and mesh.n_points == 85
    assert mesh.compute_cell_sizes()["Area"].sum() == pytest.approx(0.25, rel=1e-6)
    assert "displacement" in mesh.point_data
