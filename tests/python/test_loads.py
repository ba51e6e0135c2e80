"""Loads on particles, from Python: classes, regions by functions, results, checkpoints, messages."""

import matpoint as mp
import numpy as np
import pytest


def block(**sections):
    """A block that flies."""
    return mp.Case(
        "block",
        **{
            "grid": mp.Grid(upper=(1, 1), cell_size=0.1),
            "time": mp.Time(end=0.02),
            "body": mp.Body(
                name="block",
                region=mp.Box(lower=(0.3, 0.3), upper=(0.7, 0.5)),
                layout=mp.PerCell(count=4),
                material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
            ),
            **sections,
        },
    )


@pytest.mark.parametrize("solver", [{}, {"type": "implicit"}])
def test_a_load_is_chosen_by_a_function_and_seen_in_the_results(solver, tmp_path):
    loads = [
        mp.Load(name="gas", body="block", kind="pressure", pressure=500, side="bottom", region=mp.Where(lambda x: x[:, 0] < 0.5)),
        mp.Load(body="block", kind="force", force=(3, 0), times=np.array([0, 0.01]), factors=[0, 1]),
    ]
    case = block(load=loads, solver=solver, **({"time": mp.Time(end=0.02, dt=0.001)} if solver else {}))
    assert case.resolved()["load"][0]["region"].startswith("chosen by Where")
    simulation = case.build()
    simulation.run()
    gas, pull = simulation.boundaries["gas"], simulation.boundaries["load_2"]
    assert abs(gas.force[1] - 500 * 0.2) < 3
    assert np.allclose(pull.force, (3, 0))
    momentum = simulation.bodies["block"].mass @ simulation.bodies["block"].velocity
    assert np.allclose(momentum, gas.impulse + pull.impulse, rtol=0, atol=1e-9)
    assert simulation.history["gas.work"][-1] > 0
    assert np.isclose(simulation.history["load_2.impulse_x"][-1], pull.impulse[0])


def test_a_case_with_loads_is_a_case_file(tmp_path):
    case = block(
        load=mp.Load(body="block", kind="traction", traction=(1, 2), side="left"),
        base_acceleration=np.array([[0, 0], [1, 0]]),
        base_acceleration_times=[0, 1],
    )
    assert "[[load]]" in case.to_toml(tmp_path / "block.toml")
    assert mp.Case.from_toml(tmp_path / "block.toml").resolved() == case.resolved()


def test_the_ground_shakes():
    case = block(base_acceleration=[[0, 0], [100, 0]], base_acceleration_times=[0, 0.02], time=mp.Time(end=0.02, dt=1e-4))
    simulation = case.build()
    simulation.run()
    velocity = simulation.bodies["block"].velocity
    assert np.allclose(velocity[:, 0], -1, atol=0.01)


def test_a_state_goes_on_with_its_loads(tmp_path):
    case = block(load=mp.Load(body="block", kind="pressure", pressure=500, side="top"))
    whole = case.build()
    whole.run(until=0.01)
    whole.save(tmp_path / "state.h5")
    whole.run()
    other = mp.load(tmp_path / "state.h5")
    other.run()
    assert np.array_equal(whole.bodies["block"].position, other.bodies["block"].position)
    assert other.boundaries["load_1"].work == whole.boundaries["load_1"].work


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ({"kind": "pressure", "pressure": 1}, "body is missing"),
        ({"body": "block", "kind": "pressure"}, 'kind = "pressure" needs pressure'),
        ({"body": "blok", "kind": "pressure", "pressure": 1}, 'did you mean "block"'),
        ({"body": "block", "kind": "pressure", "pressure": 1, "side": "up"}, 'side: "up" is unknown'),
        ({"body": "block", "kind": "presure", "pressure": 1}, 'did you mean "pressure"'),
        (
            {"body": "block", "kind": "pressure", "pressure": 1, "region": mp.Where(lambda x: x[:, 0] > 5)},
            'no face of the free surface of body "block" has its middle in the region',
        ),
    ],
)
def test_what_is_wrong_with_a_load_is_said(load, message):
    with pytest.raises(mp.InputError, match=message):
        block(load=load).build()
