"""An elastic sphere falls on a frictionless floor and bounces, in 3D.

Source: conservation of energy and mirror symmetry.
Expected: energy within 1 % of m g times the fall; no motion sideways.
Runs in about 1 s. The same as a case file: `matpoint run sphere`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/sphere.toml."""
    return mp.Case(
        "sphere",
        title="An elastic sphere bounces on the floor",
        source="Conservation of energy and mirror symmetry",
        dim=3,
        gravity=(0, -9.81, 0),
        grid=mp.Grid(upper=(0.6, 0.6, 0.6), cells=(12, 12, 12)),
        time=mp.Time(dt=0.0005, end=0.5),
        solver=mp.Solver(shape="linear"),
        body=[
            mp.Body(
                name="sphere",
                region=mp.Sphere(center=(0.3, 0.3, 0.3), radius=0.15),
                layout=mp.PerCell(count=8),
                material=mp.NeoHookean(density=1000, youngs_modulus=100000.0, poissons_ratio=0.3),
            ),
        ],
        boundary=[
            mp.Boundary(side="bottom", kind="slip"),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    problem = case()
    simulation = problem.build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    fall = history["mass"][0] * 9.81 * 0.15
    assert np.abs(history["transfer_loss"]).max() < 0.01 * fall
    assert np.abs(history["center_of_mass_x"] - 0.3).max() < 1e-14


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("sphere.png")
    mp.plot.energies(done.history).savefig("sphere_energies.png")
