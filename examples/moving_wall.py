"""A piston pushes a block of rubber along a channel: a boundary whose velocity is a function of time, on nodes that a function chooses.

Source: the balance of energy and of momentum.
Expected: what the piston has done as work is in the block as kinetic and strain energy, within 4 %, which is what linear shape functions
lose when the block flies off; the impulses add up to the block's momentum, to round-off.
Runs in about 1 s.
"""

import matpoint as mp
import numpy as np

RISE_TIME = 0.2  # [s]
SPEED = 0.5  # [m/s]


def piston_velocity(time: float) -> tuple[float, float]:
    """From rest to the full speed, smoothly [m/s]."""
    share = min(time / RISE_TIME, 1.0)
    return SPEED * share * share * (3 - 2 * share), 0.0


def case() -> mp.Case:
    """The block between frictionless walls, with the piston at its left end: it moves the nodes, as long as the block is near them."""
    return mp.Case(
        "moving_wall",
        title="A piston pushes a block",
        grid=mp.Grid(upper=(2.0, 0.4), cells=(40, 8)),
        time=mp.Time(end=0.5),
        body=mp.Body(
            name="block",
            region=mp.Box(lower=(0.2, 0.1), upper=(1.0, 0.3)),
            layout=mp.PerCell(count=4),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
        boundary=mp.Boundary(region=mp.Where(lambda x: x[:, 0] < 0.225), kind="velocity", components=["x"], velocity=piston_velocity),
    )


def run() -> mp.Simulation:
    """Runs until the block flies free."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """The balances, at all times."""
    history = simulation.history
    assert history["boundary_work"][-1] > 1.0
    stored = history["kinetic_energy"] + history["strain_energy"]
    assert np.abs(stored - history["boundary_work"]).max() < 0.04 * history["boundary_work"][-1]
    impulse = history["boundary_impulse_x"] + history["cutoff_impulse_x"]
    assert np.abs(history["momentum_x"] - impulse).max() < 1e-9 * history["momentum_x"].max()


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "velocity").savefig("moving_wall.png")
    mp.plot.energies(done.history).savefig("moving_wall_energies.png")
