"""A controller holds a falling block at a height: callbacks read the simulation, a body force acts on it.

Source: a proportional-derivative controller with the weight fed forward.
Expected: the block comes to rest at y = 0.6 m, within 1 mm, 2 s after it was dropped from 0.4 m.
Runs in about 2 s.
"""

import matpoint as mp
import numpy as np

TARGET = 0.6  # [m]
STIFFNESS, DAMPING = 25.0, 10.0  # [1/s^2], [1/s]: critically damped


class Thruster:
    """Keeps the acceleration [m/s^2] that the controller asks for; the body force of the case."""

    def __init__(self) -> None:
        self.acceleration = 0.0

    def __call__(self, positions: np.ndarray, time: float) -> np.ndarray:
        return np.broadcast_to([0.0, self.acceleration], positions.shape)


def case(thruster: Thruster) -> mp.Case:
    """A block in free space, under gravity and the thruster."""
    return mp.Case(
        "controller",
        title="A controlled block",
        gravity=(0, -9.81),
        body_force=thruster,
        grid=mp.Grid(upper=(1, 1), cells=(20, 20)),
        time=mp.Time(end=2.0),
        body=mp.Body(
            name="block",
            region=mp.Box(lower=(0.4, 0.3), upper=(0.6, 0.5)),
            layout=mp.PerCell(count=4),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
    )


def run() -> mp.Simulation:
    """Runs with the controller called every 5 ms."""
    thruster = Thruster()
    simulation = case(thruster).build()

    @simulation.every(time=0.005)
    def control(now: mp.Simulation) -> None:
        block = now.bodies["block"]
        height, speed = block.position[:, 1].mean(), block.velocity[:, 1].mean()
        thruster.acceleration = 9.81 + STIFFNESS * (TARGET - height) - DAMPING * speed

    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Where the block is, and the balance of energy with the work of the thruster."""
    history = simulation.history
    assert abs(history["center_of_mass_y"][0] - 0.4) < 1e-12
    assert abs(history["center_of_mass_y"][-1] - TARGET) < 1e-3
    gained = history["gravitational_energy"][-1] - history["gravitational_energy"][0]
    assert abs(history["body_force_work"][-1] - gained) < 0.02 * gained


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.energies(done.history).savefig("controller.png")
