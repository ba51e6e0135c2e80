"""Rigid tools, from Python: classes, results, pictures, states, messages."""

import matpoint as mp
import numpy as np
import pytest
from matpoint.outlines import tool_lines


def case(dim=2, **tool):
    """A block that falls on a tool."""
    box = mp.Box(lower=(0.3,) * dim, upper=(0.7,) * dim)
    return mp.Case(
        "block",
        dim=dim,
        gravity=(0, -10, 0)[:dim],
        grid=mp.Grid(upper=(1,) * dim, cell_size=0.1),
        time=mp.Time(end=0.1),
        body=mp.Body(
            name="block",
            region=box,
            layout=mp.PerCell(count=2**dim),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
        tool=mp.Tool(
            **{"name": "plate", "shape": mp.Box(lower=(0, 0.1, 0)[:dim], upper=(1, 0.28, 1)[:dim]), "friction": 0.3, **tool},
        ),
    )


@pytest.mark.parametrize("dim", [2, 3])
def test_a_tool_is_in_results_and_pictures(dim, tmp_path):
    turn = {"angular_velocity": 0.5} if dim == 2 else {"angular_velocity": (0, 0, 0.5)}
    simulation = case(dim, velocity=(0, 0.1, 0)[:dim], **turn).build()
    simulation.run(output=tmp_path / "results")
    plate = simulation.boundaries["plate"]
    assert plate.impulse[1] > 0 and plate.force.shape == (dim,)
    history = simulation.history
    angle = history["plate.turn" if dim == 2 else "plate.turn_z"][-1]
    assert np.isclose(angle, 0.05, rtol=1e-9) and np.isclose(history["plate.position_y"][-1], 0.2, atol=1e-9)
    results = mp.results.open(tmp_path / "results")
    lines = tool_lines(results.case, results.history, 0.1, 2.0)
    corners = np.concatenate(lines)
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    assert np.allclose(middle[:2], (0.5, 0.2), atol=1e-6)
    edge = lines[0][1] - lines[0][0]
    assert np.isclose(np.arctan2(edge[1], edge[0]), 0.05, atol=1e-3)
    assert len(mp.plot.particles(results, "velocity").axes) > 1
    assert len(mp.plot.particles(simulation, "velocity").axes) > 1


@pytest.mark.parametrize(
    "shape",
    [
        {"type": "disk", "center": [0.5, 0.1], "radius": 0.1},
        {"type": "polygon", "vertices": [[0.1, 0], [0.9, 0], [0.5, 0.2]]},
        {"type": "half_space", "point": [0, 0.2], "normal": [0, 1]},
        {
            "type": "union",
            "of": [{"type": "disk", "center": [0.3, 0.1], "radius": 0.1}, {"type": "disk", "center": [0.7, 0.1], "radius": 0.1}],
        },
    ],
)
def test_each_shape_runs_and_has_an_outline(shape):
    made = case(shape=shape)
    made.build().run(until=0.01)
    lines = tool_lines(made.resolved(), {}, 0.0, 2.0)
    assert lines and all(line.shape[1] == 2 for line in lines)


def test_what_moves_freely_goes_on_from_a_state(tmp_path):
    simulation = case(density=300, hinge=(0, 0.2), spring=1e4).build()
    simulation.run(until=0.05)
    simulation.save(tmp_path / "state.h5")
    simulation.run()
    other = mp.load(tmp_path / "state.h5")
    other.run()
    assert np.array_equal(simulation.bodies["block"].position, other.bodies["block"].position)
    assert simulation.history["plate.turn"][-1] == other.history["plate.turn"][-1] != 0


def test_what_is_wrong_with_a_tool_is_said():
    with pytest.raises(mp.InputError, match='particle 0 of body "block" at .* is in it'):
        case(shape=mp.Box(lower=(0, 0.1), upper=(1, 0.4))).build()
    with pytest.raises(mp.InputError, match="hinge is for what moves freely"):
        case(hinge=(0, 0)).build()
    with pytest.raises(mp.InputError, match="the surface of this shape is not known"):
        plate = mp.Box(lower=(0, 0.1), upper=(1, 0.28))
        case(shape=mp.Difference(of=[plate, mp.Disk(center=(0.5, 0.2), radius=0.05)])).build()
